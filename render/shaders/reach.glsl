// How much light reaches a point that is seen at `at` (pixels) and `depth`: x of the key light, y
// of the light from all around.
#if SOFT == 1
layout(binding = 4) uniform sampler2D seen;  // see seen.frag

vec2 light_reaching(vec2 at, float depth, vec3 p, vec3 n)
{
    // soften.frag moved everything by half a square of 2 x 2 pixels.
    vec2 place = (at - 1.5) * 0.5, first = floor(place), part = place - first;
    ivec2 last = textureSize(seen, 0) - 1;
    float pixel = 2.0 * length(down.xyz) / depth;
    // What 1 / depth is elsewhere on the plane of the point: on a floor seen at a slant, the rows
    // above and below belong to it as well.
    float through = dot(n, p - eye.xyz);
    bool slant = abs(through) > 1e-3 * depth;
    vec2 face = facing(n);
    vec3 sum = vec3(0.0);
    float low = 1.0, high = 0.0, sharpest = WIDEST, sharpest_near = WIDEST;
    for (int k = 0; k < 4; ++k) {
        ivec2 step_to = ivec2(k & 1, k >> 1);
        vec4 there = texelFetch(seen, clamp(ivec2(first) + step_to, ivec2(0), last), 0);
        vec2 near = mix(1.0 - part, part, vec2(step_to));
        // What is at another depth or faces elsewhere counts where nothing else is near, and nowhere
        // else: a pixel beside an edge may lie right on one of the other side.
        vec2 from = 2.0 * (first + vec2(step_to)) + 0.5;  // where its depth was seen
        float q = slant ? dot(n, ray_at(from)) / through : 1.0 / depth;
        float off = (there.z - q) / pixel, off_sq = off * off;
        float alike = (1e-4 + smoothstep(0.3, 0.8, facing_alike(face, seen_facing(there.w)))) / (1.0 + off_sq * off_sq);
        sum += vec3(there.xy, 1.0) * alike * (near.x * near.y + 1e-2);
        bool here = alike > 0.3;
        low = here ? min(low, there.x) : low;
        high = here ? max(high, there.x) : high;
        float half_width = seen_half_width(there.w);
        if (half_width >= 0.0) sharpest_near = min(sharpest_near, half_width);
        if (half_width >= 0.0 && here) sharpest = min(sharpest, half_width);
    }
    vec2 reach = sum.xy / sum.z;
#if IN_SHADOW == 1
    // Where the four do not agree, a sharp shadow's edge runs between them, and where none is of this
    // place, they know nothing of its light: it is found right here.
    float edge = smoothstep(0.02, 0.1, high - low) * (1.0 - smoothstep(4.0, 8.0, sharpest));
    const bool glass = GLASS == 1;
    if (glass) edge = 0.0;  // shadow.frag's squares of texels would show there
    if (low > high) edge = 1.0, sharpest = sharpest_near < WIDEST ? sharpest_near : 0.0;
    float half_width = max(sharpest * depth * length(down.xyz), 1.2 * light.w);
    bool wanted = edge > 0.0 && to_light.w > 0.0 && dot(n, to_light.xyz) > 0.0;
    Mapped mapped = mapped_to(p, n);
    // Beside the map is nothing that casts a shadow, as in seen.frag.
    bool mapped_here = wanted && on_map(mapped.at);
    float lit = glass && mapped_here ? lit_phases(mapped, half_width, vec2(1.0, 0.0))
                      : lit_places(mapped, half_width, vec2(1.0, 0.0), 16 / SAMPLES, mapped_here);
    if (wanted) reach.x = mix(reach.x, mapped_here ? lit : 1.0, edge);
#endif
#if FAR == 1
    reach.x *= far_share(p, n);
#endif
    return reach;
}
#else
vec2 light_reaching(vec2 at, float depth, vec3 p, vec3 n) { return vec2(lit_share(p, n), 1.0); }
#endif
