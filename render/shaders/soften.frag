// The mean of four neighbours in a row or a column of what seen.frag found, without those that lie
// at another depth. 1 / depth runs evenly over a plane, so a floor seen at a slant stays together.
layout(binding = 4) uniform sampler2D seen;
layout(location = 1) uniform ivec2 along;  // (1, 0) or (0, 1)

layout(location = 0) out vec4 seen_here;

void main()
{
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(seen, 0) - 1;
    vec4 middle = texelFetch(seen, here, 0);
    vec4 before = texelFetch(seen, max(here - along, ivec2(0)), 0);
    vec4 after = texelFetch(seen, min(here + along, last), 0);
    vec4 beyond = texelFetch(seen, min(here + 2 * along, last), 0);
    // Three pixels' size at this depth, as a change of 1 / depth.
    float even = 3.0 * length(down.xyz) * middle.z;
    float slope = min(abs(before.z - middle.z), abs(after.z - middle.z)) * 1.5 + even;
    vec3 sum = vec3(middle.xy, 1.0);
    if (abs(before.z - middle.z) <= slope) sum += vec3(before.xy, 1.0);
    if (abs(after.z - middle.z) <= slope) sum += vec3(after.xy, 1.0);
    if (abs(beyond.z - middle.z) <= 2.0 * slope) sum += vec3(beyond.xy, 1.0);
    seen_here = vec4(sum.xy / sum.z, middle.z, 0.0);
}
