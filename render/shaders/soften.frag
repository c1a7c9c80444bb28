// The mean of four neighbours in a row or a column of what seen.frag found of the key light, and of
// eight of the light from all around, without those that lie at another depth or face elsewhere: at
// its foot, a thing is as far away as the floor. 1 / depth runs evenly over a plane, so a floor seen
// at a slant stays together.
layout(binding = 4) uniform sampler2D seen;
layout(location = 1) uniform ivec2 along;  // (1, 0) or (0, 1)

layout(location = 0) out vec4 seen_here;

// The place `by` steps away; outside the picture nothing is at its depth.
vec4 at(int by)
{
    ivec2 from = ivec2(gl_FragCoord.xy) + by * along, inside = clamp(from, ivec2(0), textureSize(seen, 0) - 1);
    vec4 there = texelFetch(seen, inside, 0);
    return from == inside ? there : vec4(there.xy, -1e9, there.w);
}

// Whether light that was found `there` is that of a place which faces as `face`, at most `off` of
// 1 / depth apart.
bool is_of(vec4 middle, vec2 face, vec4 there, float off)
{
    return there.z >= 0.0 && abs(there.z - middle.z) <= off && facing_alike(seen_facing(there.w), face) > 0.6;
}

const vec2 SHARP = vec2(4.0, 16.0);  // pixels from which and up to which a penumbra is spread

// How much of the key of two places is shared: as far as the sharper one may be spread, where that
// is known. The turns do not show in a penumbra of a few pixels, and a mean would spread it.
float shared_key(float a, float b)
{
    float sharper = min(a < 0.0 ? WIDEST : a, b < 0.0 ? WIDEST : b);
    return clamp((sharper - SHARP.x) / (SHARP.y - SHARP.x), 0.0, 1.0);
}

void main()
{
    vec4 middle = at(0);
    // Three pixels' size at this depth, as a change of 1 / depth.
    float even = 3.0 * length(down.xyz) * middle.z;
    float slope = min(abs(at(-1).z - middle.z), abs(at(1).z - middle.z)) * 1.5 + even;
    vec2 face = seen_facing(middle.w);
    float half_width = seen_half_width(middle.w);
    vec4 sum = vec4(middle.xy, 1.0, 1.0);
    ivec3 steps = ivec3(-1, 1, 2);
    bvec3 found = bvec3(false);
    // What is not of this place is looked for on the other side, where the next of the same turn is.
    // The second look is a turn of a loop: this OpenGL skips turns that no pixel needs, but never a
    // branch.
    int looks = 1;
    for (int look = 0; look < looks; ++look) {
        for (int k = 0; k < 3; ++k) {
            vec4 there = at(steps[k]);
            if (found[k] || !is_of(middle, face, there, float(abs(steps[k])) * slope)) continue;
            float share = shared_key(half_width, seen_half_width(there.w));
            sum += vec4(share * there.x, there.y, share, 1.0);
            found[k] = true;
        }
        looks = all(found) ? 1 : 2;
        steps -= 4 * sign(steps);
    }
    const ivec4 farther = ivec4(-3, -2, 3, 4);
    for (int k = 0; k < 4; ++k) {
        vec4 there = at(farther[k]);
        if (is_of(middle, face, there, float(abs(farther[k])) * slope)) sum.yw += vec2(there.y, 1.0);
    }
    seen_here = vec4(sum.xy / sum.zw, middle.zw);
}
