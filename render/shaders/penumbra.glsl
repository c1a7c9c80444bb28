// The share of a wide key light that reaches a point.
//   Fernando, Percentage-closer soft shadows, SIGGRAPH sketches 2005 (a disc as wide as the
//   penumbra);
//   Vogel, A better way to construct the sunflower head, Mathematical Biosciences 44, 1979.
layout(binding = 6) uniform sampler2DShadow shadow_smooth;

// Places on a disc, evenly: each is a golden angle further than the one before, and further out.
const vec2 GOLDEN = vec2(-0.73736888, 0.67549029);  // its cosine and sine

vec2 turned(vec2 by) { return vec2(by.x * GOLDEN.x - by.y * GOLDEN.y, by.x * GOLDEN.y + by.y * GOLDEN.x); }

float away(int i, int of) { return sqrt((float(i) + 0.5) / float(of)); }

// A point as the shadow map has it.
struct Mapped {
    vec2 at;
    float ahead;
    vec2 span;   // stage units across the map
    vec2 steep;  // the map's depth of the tangent plane, per unit of its x and y
};

Mapped mapped_to(vec3 p, vec3 n)
{
    float nl = dot(n, to_light.xyz);
    float texel = light.w, slope = 1.0 - max(nl, 0.0);
    vec3 start = p + n * texel * (1.0 + 3.0 * slope) + to_light.xyz * texel;
    vec3 at = (shadow_from_stage * vec4(start, 1.0)).xyz;
    Mapped m;
    m.at = at.xy;
    m.ahead = at.z;  // below 0 before the map's depth, where what is drawn there has depth 0
    m.span = texel * shadow_size.xy;
    mat3 rows = transpose(mat3(shadow_from_stage));
    vec2 across_light = vec2(dot(n, rows[0]), dot(n, rows[1])) * m.span;  // of unit axes
    m.steep = clamp(across_light / max(nl, 0.05), -4.0, 4.0) * soft.y * m.span;
    return m;
}

// As lit_places(), of 16 places, each at another of the 4 x 4 texels over which shadow.frag spreads
// what a clear thing covers: within its shadow their mean is exact.
float lit_phases(Mapped m, float half_width, vec2 turn)
{
    vec2 wide = half_width / m.span, direction = turn;
    float lit = 0.0;
    for (int i = 0; i < 16; ++i) {
        vec2 by = direction * away(i, 16) * wide;
        direction = turned(direction);
        vec2 texel = 4.0 * floor(0.25 * (m.at + by) * shadow_size.xy) + vec2(i & 3, i >> 2) + 0.5;
        by = texel / shadow_size.xy - m.at;
        lit += textureLod(shadow_smooth, vec3(m.at + by, clamp(m.ahead + dot(m.steep, by), 0.0, 1.0)), 0.0);
    }
    return lit / 16.0;
}

// The share of `places` on a disc that is lit, `half_width` in stage units; 0 unless `wanted`.
float lit_places(Mapped m, float half_width, vec2 turn, int places, bool wanted)
{
    vec2 wide = half_width / m.span, direction = turn;
    float lit = 0.0;
    int reads = wanted ? places : 0;
    for (int i = 0; i < reads; ++i) {
        vec2 by = direction * away(i, places) * wide;
        direction = turned(direction);
        lit += textureLod(shadow_smooth, vec3(m.at + by, clamp(m.ahead + dot(m.steep, by), 0.0, 1.0)), 0.0);
    }
    return lit / float(places);
}
