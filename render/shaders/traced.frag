// What rays found of surfaces without triangles, into the first pass. A pixel of which one ray tells
// all is a plane; others have samples.
layout(location = 0) out uvec2 pixel;

layout(location = 1) uniform ivec4 part;      // first column and row in pixels, columns, rows
layout(location = 2) uniform int which;       // sample; -1: the middle of the pixel
layout(location = 3) uniform vec2 moved;      // the sample's place, pixels from the middle

// Packed colour, packed normal, depth, 1 + where its samples begin (0: it has none).
layout(std430, binding = 1) readonly buffer Pixels { uvec4 middles[]; };
layout(std430, binding = 2) readonly buffer Samples { uvec4 samples[]; };

void main()
{
    int along_side = int(floor_colour.w);
    ivec2 fragment = ivec2(gl_FragCoord.xy);
    ivec2 at = fragment / along_side - part.xy, within = fragment % along_side;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, part.zw))) discard;
    uvec4 here = middles[at.x + at.y * part.z];
    int sample_number = along_side > 1 ? within.x + 2 * within.y : which;
    vec2 place = along_side > 1 ? (vec2(within) + 0.5) / floor_colour.w - 0.5 : moved;
    if (here.w > 0u && sample_number >= 0) {
        here = samples[int(here.w) - 1 + sample_number];
        if (here.z == 0u) discard;
        gl_FragDepth = uintBitsToFloat(here.z);
    } else {
        if (here.z == 0u) discard;
        // The corner has moved with the sample: this is the ray through it.
        vec3 ray = ray_at(gl_FragCoord.xy / floor_colour.w);
        vec3 middle = ray - place.x * across.xyz - place.y * down.xyz;
        vec3 n = stored_normal(here.xy);
        float stored = uintBitsToFloat(here.z);
        float depth = view_depth(stored) * clamp(dot(n, middle) / dot(n, ray), 0.97, 1.03);
        float moved_depth = eye.w / (corner.w - eye.w) * (corner.w / depth - 1.0);
        gl_FragDepth = place == vec2(0.0) ? stored : clamp(moved_depth, 0.0, 1.0);
    }
    pixel = here.xy;
}
