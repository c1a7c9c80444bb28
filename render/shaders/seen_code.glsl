// What soft light knows of a place beside its shares of light and 1 / depth, as one whole number that
// a float holds exactly: how it faces, 9 bits each way, and its penumbra, 6 bits.

// How a normal faces, as seen: its equal-area projection along the view (Lambert 1772), in which
// those that are seen lie about as far apart as their ends do.
vec2 facing(vec3 n)
{
    vec3 right = across.xyz * inversesqrt(dot(across.xyz, across.xyz));
    vec3 low = down.xyz * inversesqrt(dot(down.xyz, down.xyz));
    vec3 e = vec3(dot(n, right), dot(n, low), dot(n, cross(low, right)));
    return e.xy * inversesqrt(0.5 * max(1.0 + e.z, 1e-4));
}

// The half width of a penumbra, pixels, up to which it is told apart.
const float WIDEST = 16.0, STEPS = 62.0;  // one more: nothing is in between

// `half_width` below 0: nothing is in between.
float seen_code(vec2 face, float half_width)
{
    vec2 q = round(clamp(face * 0.25 + 0.5, 0.0, 1.0) * 511.0);
    float steps = half_width < 0.0 ? STEPS + 1.0 : round(min(half_width / WIDEST, 1.0) * STEPS);
    return q.x + 512.0 * (q.y + 512.0 * steps);
}

vec2 seen_facing(float code)
{
    int bits = int(code);
    return vec2(bits & 511, bits >> 9 & 511) * (4.0 / 511.0) - 2.0;
}

// Pixels; below 0 where nothing is in between.
float seen_half_width(float code)
{
    int steps = int(code) >> 18;
    return steps > int(STEPS) ? -1.0 : float(steps) * (WIDEST / STEPS);
}

// The cosine between two normals, about, by how they face.
float facing_alike(vec2 a, vec2 b)
{
    vec2 apart = a - b;
    return 1.0 - 0.5 * dot(apart, apart);
}
