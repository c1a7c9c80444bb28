// The mean of four neighbours in a row or a column of what seen.frag found, without those that lie
// at another depth or face elsewhere: at its foot, a thing is as far away as the floor. 1 / depth
// runs evenly over a plane, so a floor seen at a slant stays together.
layout(binding = 4) uniform sampler2D seen;
layout(location = 1) uniform ivec2 along;  // (1, 0) or (0, 1)

layout(location = 0) out vec4 seen_here;

vec4 at(int by)
{
    return texelFetch(seen, clamp(ivec2(gl_FragCoord.xy) + by * along, ivec2(0), textureSize(seen, 0) - 1), 0);
}

// Whether light that was found `there` is that of a place with normal n, at most `off` of 1 / depth
// apart.
bool is_of(vec4 middle, vec3 n, vec4 there, float off)
{
    return abs(there.z - middle.z) <= off && dot(seen_normal(there.w), n) > 0.6;
}

// How much of the key of two places is shared: as far as the sharper one may be spread, where that
// is known.
float shared_key(float a, float b)
{
    return min(a < 0.0 ? 1.0 : a, b < 0.0 ? 1.0 : b);
}

void main()
{
    const ivec3 steps = ivec3(-1, 1, 2);
    vec4 middle = at(0);
    vec4 there[3] = vec4[3](at(steps.x), at(steps.y), at(steps.z));
    // Three pixels' size at this depth, as a change of 1 / depth.
    float even = 3.0 * length(down.xyz) * middle.z;
    float slope = min(abs(there[0].z - middle.z), abs(there[1].z - middle.z)) * 1.5 + even;
    vec3 n = seen_normal(middle.w);
    float spread = seen_spread(middle.w);
    vec4 sum = vec4(middle.xy, 1.0, 1.0);
    for (int k = 0; k < 3; ++k) {
        int by = steps[k];
        if (!is_of(middle, n, there[k], float(abs(by)) * slope)) {
            // On the other side the next of the same turn.
            by -= 4 * sign(by);
            there[k] = at(by);
            if (!is_of(middle, n, there[k], float(abs(by)) * slope)) continue;
        }
        float share = shared_key(spread, seen_spread(there[k].w));
        sum += vec4(share * there[k].x, there[k].y, share, 1.0);
    }
    seen_here = vec4(sum.xy / sum.zw, middle.zw);
}
