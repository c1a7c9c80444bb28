// How much light reaches what is seen, in every second pixel of every second row: the share of a
// wide key light, and the share of the light from all around.
//   Fernando, Percentage-closer soft shadows, SIGGRAPH sketches 2005: first the mean distance of
//   what is in between, then a disc as wide as the penumbra at that distance (penumbra.glsl);
//   McGuire, Mara, Luebke, Scalable ambient obscurance, HPG 2012: points around in the picture.
// The discs are turned by one of 16 angles in each square of 4 x 4 pixels, and soften.frag takes
// the mean over such a square: nothing of the turns is left, and nothing is random.
layout(location = 0) out vec4 seen_here;  // key, all around, 1 / depth, seen_code()

layout(binding = 5) uniform sampler2D shadow_depths;

const int BLOCKERS = 12, SHADOWS = 16, AROUND = 14;

// `half_width`: that of the penumbra, stage units; 0 where nothing is in between.
float soft_key(vec3 p, vec3 n, vec2 turn, out float half_width)
{
    float nl = dot(n, to_light.xyz), texel = light.w;
    Mapped m = mapped_to(p, n);
    bool beside = any(lessThan(m.at, vec2(0.0))) || any(greaterThan(m.at, vec2(1.0)));
    float farthest = min(soft.x * m.ahead / soft.y, 0.06);
    // Of clear things, what covers a square of 4 x 4 texels is to be told.
    bool glass = backdrop_horizon.w == 1.0;
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

float around(vec3 p, vec3 n, float depth, vec2 at, vec2 turn)
{
    float reach = soft.w, samples = floor_colour.w;
    float pixel = depth * length(down.xyz);
    float wide = min(reach / pixel, 0.3 * down.w);
    reach = min(reach, wide * pixel);
    vec3 beside = max(max(drawn_low.xyz - p, p - drawn_high.xyz), 0.0);
    int tries = wide < 1.0 || dot(beside, beside) > reach * reach ? 0 : AROUND;
    ivec2 last = ivec2(vec2(across.w, down.w) * samples) - 1;
    float sum = 0.0;
    vec2 direction = turn;
    for (int i = 0; i < tries; ++i) {
        vec2 there = at + direction * ((float(i) + 0.5) / float(AROUND)) * wide;
        direction = turned(direction);
        ivec2 from = clamp(ivec2(there * samples), ivec2(0), last);
        vec3 ray = ray_at((vec2(from) + 0.5) / samples);
        vec3 v = eye.xyz + depth_at(from, ray) * ray - p;
        float far_sq = dot(v, v) + 1e-10;
        float rise = dot(v, n) * inversesqrt(far_sq);
        sum += max(rise - 0.08, 0.0) * max(1.0 - far_sq / (reach * reach), 0.0);
    }
    return clamp(1.0 - soft.z * 6.0 * sum / float(AROUND), 0.25, 1.0);
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
    vec3 p = eye.xyz + depth * ray;
    float half_width = 0.0;
    float key = to_light.w > 0.0 ? soft_key(p, n, turn, half_width) : 1.0;
    float pixels_wide = half_width > 0.0 ? half_width / (depth * length(down.xyz)) : -1.0;
    seen_here = vec4(key, around(p, n, depth, at, turn), 1.0 / depth, seen_code(facing(n), pixels_wide));
}
