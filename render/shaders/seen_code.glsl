// What soft light knows of a place beside its shares of light and 1 / depth, as one whole number that
// a float holds exactly: the normal, 9 bits each way, and how far its key may be spread, 6 bits.
const float SPREADS = 62.0;  // steps; one more: nothing is in between, so that others know

float seen_code(vec3 n, float spread)
{
    vec2 q = round((octahedral(n) * 0.5 + 0.5) * 511.0);
    return q.x + 512.0 * (q.y + 512.0 * (spread < 0.0 ? SPREADS + 1.0 : round(spread * SPREADS)));
}

vec3 seen_normal(float code)
{
    float rest = floor(code / 512.0);
    vec2 q = vec2(code - 512.0 * rest, rest - 512.0 * floor(rest / 512.0));
    return from_octahedral(q / 511.0 * 2.0 - 1.0);
}

// 0 .. 1; below 0 where nothing is in between.
float seen_spread(float code)
{
    float steps = floor(code / 262144.0);
    return steps > SPREADS ? -1.0 : steps / SPREADS;
}
