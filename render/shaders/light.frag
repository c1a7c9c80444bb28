// Second pass: light for every pixel, from what the first pass found there.
layout(binding = 0) uniform usampler2D pixels;
layout(binding = 1) uniform sampler2D depths;
layout(binding = 4) uniform sampler2D occlusion;

layout(location = 0) out vec4 colour;

layout(location = 0) uniform int linear_out;  // 1: for more passes to come; 0: for the eye

vec3 unpack_normal(uint bits)
{
    vec2 o = vec2(bits & 16383u, bits >> 14 & 16383u) / 16383.0 * 2.0 - 1.0;
    vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    return normalize(n);
}

vec3 linear_from_srgb(vec3 c)
{
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}

// The light that comes to the eye through one sample.
vec3 light_of(uvec2 pixel, float depth01, vec3 ray, float open)
{
    float depth = corner.w / (1.0 + depth01 * (corner.w - eye.w) / eye.w);
    float t;
    if (floor_hit(ray, depth01 > 0.0 ? depth : 1e30, t)) return floor_light(ray, t, open);
    if (depth01 <= 0.0) return backdrop(ray);

    Material m;
    m.colour = linear_from_srgb(unpackUnorm4x8(pixel.x).rgb);
    if (pixel.y >> 31 == 0u) return m.colour;
    m.rough = float(pixel.x >> 24) / 255.0;
    m.metal = float(pixel.y >> 28 & 7u) / 7.0;
    vec3 n = unpack_normal(pixel.y);
    vec3 p = eye.xyz + depth * ray;
    return shade(m, n, -normalize(ray), lit_share(p, n), open);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    float open = 1.0;
    if (backdrop_horizon.w > 0.0) {
        open = texture(occlusion, gl_FragCoord.xy / vec2(textureSize(pixels, 0)) * floor_colour.w).r;
    }
#if SAMPLES == 1
    vec3 ray = corner.xyz + (gl_FragCoord.x * across.xyz + gl_FragCoord.y * down.xyz) / floor_colour.w;
    vec3 sum = light_of(texelFetch(pixels, at, 0).xy, texelFetch(depths, at, 0).x, ray, open);
    colour = linear_out == 1 ? vec4(sum, 1.0)
                             : vec4(srgb(tone_map(sum)) + dither(at) / 255.0, 1.0);
#else
    // Four samples a pixel. Where they agree one is lit for all.
    uvec2 pixel[4];
    float depth[4];
    for (int k = 0; k < 4; ++k) {
        ivec2 from = 2 * at + ivec2(k & 1, k >> 1);
        pixel[k] = texelFetch(pixels, from, 0).xy;
        depth[k] = texelFetch(depths, from, 0).x;
    }
    float least = min(min(depth[0], depth[1]), min(depth[2], depth[3]));
    float most = max(max(depth[0], depth[1]), max(depth[2], depth[3]));
    bool even = most - least <= 0.02 * most;
    for (int k = 1; k < 4; ++k) {
        even = even && pixel[k].x == pixel[0].x;
        ivec2 a = ivec2(pixel[k].y & 16383u, pixel[k].y >> 14 & 16383u);
        ivec2 b = ivec2(pixel[0].y & 16383u, pixel[0].y >> 14 & 16383u);
        even = even && all(lessThan(abs(a - b), ivec2(1200)));
    }
    vec3 sum = vec3(0.0);
    int count = even ? 1 : 4;
    for (int k = 0; k < count; ++k) {
        vec2 offset = even ? vec2(0.5) : vec2(k & 1, k >> 1) * 0.5 + 0.25;
        vec2 where = vec2(at) + offset;
        vec3 ray = corner.xyz + where.x * across.xyz + where.y * down.xyz;
        float d = even ? 0.25 * (depth[0] + depth[1] + depth[2] + depth[3]) : depth[k];
        sum += tone_map(light_of(pixel[k], d, ray, open));
    }
    sum /= float(count);
    colour = vec4(srgb(sum) + dither(at) / 255.0, 1.0);
#endif
}
