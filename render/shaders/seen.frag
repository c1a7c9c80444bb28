// How much light reaches what is seen, in every second pixel of every second row: the share of a
// wide key light, and the share of the light from all around.
//   Fernando, Percentage-closer soft shadows, SIGGRAPH sketches 2005: first the mean distance of
//   what is in between, then a disc as wide as the penumbra at that distance (penumbra.glsl);
//   Jimenez et al., Practical real-time strategies for accurate indirect occlusion, SIGGRAPH
//   courses 2016: the horizons in a slice through the eye's ray, and all that they hide, weighed by
//   its cosine; Therrien, Levesque, Gilet, Screen space indirect lighting with visibility bitmask,
//   The Visual Computer 2023: things are not thicker than they look.
// The discs are turned by one of 16 angles in each square of 4 x 4 pixels, the slices by one of 64
// in 8 x 8, and soften.frag takes the mean over such squares: nothing of the turns is left, and
// nothing is random.
layout(location = 0) out vec4 seen_here;  // key, all around, 1 / depth, seen_code()

layout(binding = 5) uniform sampler2D shadow_depths;

const int BLOCKERS = 12, SHADOWS = 16, STEPS_AROUND = 5;
// Stage units: how far the floor keeps light from things (it sends light itself, which `bounce` is),
// and how thick things are behind what is seen of them.
const float FLOOR_AROUND = 0.4, THICK = 0.3;
const float FLAT = 0.03;  // cosine, by which what is smooth may rise above its tangent plane

// `half_width`: that of the penumbra, stage units; 0 where nothing is in between.
float soft_key(vec3 p, vec3 n, vec2 turn, out float half_width)
{
    float nl = dot(n, to_light.xyz), texel = light.w;
    Mapped m = mapped_to(p, n);
    bool beside = any(lessThan(m.at, vec2(0.0))) || any(greaterThan(m.at, vec2(1.0)));
    float farthest = min(soft.x * m.ahead / soft.y, 0.06);
    // Of clear things, what covers a square of 4 x 4 texels is to be told.
    const bool glass = GLASS == 1;
    float least = glass ? 4.0 * texel : 1.2 * texel;
    vec2 search = max(vec2(farthest), glass ? 4.0 * texel : 1.5 * texel) / m.span;
    float found = 0.0, sum = 0.0;
    int tries = beside || nl <= 0.0 ? 0 : BLOCKERS;
    vec2 direction = turn;
    for (int i = 0; i < tries; ++i) {
        // Closer together in the middle: what is thin and right before the point is not missed.
        vec2 by = direction * ((float(i) + 0.5) / float(BLOCKERS)) * search;
        direction = turned(direction);
        float depth = textureLod(shadow_depths, m.at + by, 0.0).x;
        float between = m.ahead + dot(m.steep, by) - depth;
        if (between > 0.0 && depth < 1.0) {
            found += 1.0;
            sum += between;
        }
    }
    half_width = found > 0.0 ? clamp(soft.x * sum / found / soft.y, least, 0.06) : 0.0;
    // What faces away is dark, as what lies beside it is.
    if (glass && !beside && nl > 0.0) {
        half_width = max(half_width, least);
        return lit_phases(m, half_width, turn);
    }
    float lit = lit_places(m, half_width, turn, SHADOWS, found > 0.0);
    return found > 0.0 || nl <= 0.0 ? lit : 1.0;
}

// 0 where nothing is seen.
float depth_at(ivec2 pixel, vec3 ray)
{
    float stored = texelFetch(depths, pixel, 0).x;
    float depth = stored > 0.0 ? view_depth(stored) : 1e30;
    if (sky.w > 0.0 && ray.y < 0.0) depth = min(depth, floor_depth(ray));
    return depth < 1e29 ? depth : 0.0;
}

// The share of the light from all around that is seen in a slice through the eye's ray, on one side
// of it, where all is hidden that lies beyond an angle from the ray, whose cosine is `c`. `g`: cosine
// and sine of the angle of the normal's part in the slice, towards that side.
//   integral of cos(angle - normal's) sin(angle) = (sin^2 g.x + (angle - sin cos) g.y) / 2
// in which angle - sin cos = pi / 2 - asin(c) - c sqrt(1 - c^2) is a polynomial to within 0.008.
float open_below(float c, vec2 g)
{
    float c_sq = c * c;
    float curve = c * (1.9949 + c_sq * (-0.2883 - 0.1359 * c_sq));
    return 0.5 * ((1.0 - c_sq) * g.x + (1.5707963 - curve) * g.y);
}

// Of a slice along `turn` (a direction in the picture), as if all others were like it. Each place
// looked at hides what lies between it and as far behind it as things are taken to be thick; what is
// nearer in the picture and hides more counts first. `phase` 0..1: how far out of their ranges of
// distance the places lie.
float around(vec3 p, vec3 n, vec3 ray, float depth, vec2 at, vec2 turn, float phase)
{
    float reach = soft.w, samples = floor_colour.w, per_sample = 1.0 / samples;
    float pixel = depth * length(down.xyz);
    float wide = min(reach / pixel, 0.5 * down.w);
    vec3 beside = max(max(drawn_low.xyz - p, p - drawn_high.xyz), 0.0);
    bool none = soft.z == 0.0 || wide < 1.0 || dot(beside, beside) > reach * reach;
    int tries = none ? 0 : STEPS_AROUND;
    vec3 v = -normalize(ray), t = turn.x * across.xyz + turn.y * down.xyz;
    t = normalize(t - dot(t, v) * v);
    vec2 g = vec2(dot(n, v), dot(n, t));
    float part = length(g);
    g /= max(part, 1e-6);
    ivec2 last = ivec2(vec2(across.w, down.w) * samples) - 1;
    // 1 / depth of what is stored, and of the floor, for each unit of a ray's y.
    vec3 inverse = vec3(eye.w, corner.w - eye.w, 0.0) / (corner.w * eye.w);
    if (sky.w > 0.0 && eye.y > bounce.w) inverse.z = 1.0 / (bounce.w - eye.y);
    float hidden = 0.0;
    for (int side = 0; side < 2; ++side) {
        float low = max(-g.y, -1.0) + FLAT, top = open_below(low, g);
        for (int i = 0; i < tries; ++i) {
            float far = (float(i) + phase) / float(STEPS_AROUND);
            vec2 there = at + turn * (1.0 + float(i) + far * far * wide);
            ivec2 from = clamp(ivec2(there * samples), ivec2(0), last);
            vec3 to = ray_at((vec2(from) + 0.5) * per_sample);
            float thing = inverse.x + inverse.y * texelFetch(depths, from, 0).x, level = inverse.z * to.y;
            vec3 w = eye.xyz + to / max(thing, level) - p;
            float far_sq = dot(w, w) + 1e-10, up = dot(w, v);
            float within = level > thing ? FLOOR_AROUND : reach;
            float near = far_sq / (within * within);
            near = max(1.0 - near * near, 0.0);
            vec2 c = vec2(up, up - THICK) * inversesqrt(vec2(far_sq, max(far_sq + THICK * (THICK - 2.0 * up), 1e-6)));
            c = max(low + (c - low) * near, low);
            float front = open_below(c.x, g);
            hidden += max(min(top, open_below(c.y, g)) - front, 0.0);
            top = min(top, front);
        }
        turn = -turn;
        g.y = -g.y;
    }
    // One slice may hide all, and a face of a few pixels finds few others to share with.
    return clamp(1.0 - soft.z * part * hidden, 0.25, 1.0);
}

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 at = vec2(2 * here) + 0.5;
    ivec2 from = min(ivec2(at * floor_colour.w), textureSize(depths, 0) - 1);
    vec3 ray = ray_at(at);
    float depth = depth_at(from, ray);
    float stored = texelFetch(depths, from, 0).x;
    bool on_floor = stored <= 0.0 || view_depth(stored) > depth;
    vec3 n = on_floor ? vec3(0.0, 1.0, 0.0) : stored_normal(texelFetch(pixels, from, 0).xy);
    if (depth <= 0.0) {
        seen_here = vec4(1.0, 1.0, 0.0, 0.0);
        return;
    }
    int order = (here.x & 1) * 2 + ((here.x ^ here.y) & 1) + 4 * ((here.x >> 1 & 1) * 2 + ((here.x ^ here.y) >> 1 & 1));
    float angle = 6.2831853 * (float(order) + drawn_low.w) / 16.0;
    vec2 turn = vec2(cos(angle), sin(angle));
    // Evenly spread along each row and each column of eight.
    int finer = 8 * (3 * here.x + here.y & 7) + (here.y & 1) * 4 + (here.y & 2) + (here.y >> 2 & 1);
    float half_angle = 3.1415927 * (float(finer) + drawn_low.w) / 64.0;
    vec2 half_turn = vec2(cos(half_angle), sin(half_angle));
    float phase = fract(float(finer) * 0.61803399 + drawn_low.w);
    vec3 p = eye.xyz + depth * ray;
    float half_width = 0.0;
    float key = to_light.w > 0.0 ? soft_key(p, n, turn, half_width) : 1.0;
    float pixels_wide = half_width > 0.0 ? half_width / (depth * length(down.xyz)) : -1.0;
    seen_here = vec4(key, around(p, n, ray, depth, at, half_turn, phase), 1.0 / depth, seen_code(facing(n), pixels_wide));
}
