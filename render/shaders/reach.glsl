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
    }
    return sum.xy / sum.z;
}
#else
vec2 light_reaching(vec2 at, float depth, vec3 p, vec3 n) { return vec2(lit_share(p, n), 1.0); }
#endif
