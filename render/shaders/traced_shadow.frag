// Depths that rays of the key light found, into the shadow map.
layout(location = 1) uniform ivec4 part;  // first column and row in texels, columns, rows

layout(std430, binding = 3) readonly buffer Depths { float depths[]; };

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy) - part.xy;
    if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, part.zw))) discard;
    float depth = depths[at.x + at.y * part.z];
    if (depth > 1.0) discard;
    gl_FragDepth = depth;
}
