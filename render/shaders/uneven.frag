// Marks the pixels whose four samples do not agree: there one light for all would show stairs.
layout(binding = 7) uniform usampler2DArray fine_pixels;
layout(binding = 8) uniform sampler2DArray fine_depths;

// How far the square roots of colours may differ, in steps of 255. Textures are filtered to the size
// of a pixel: where there are some, colours that differ less need no light of their own.
layout(location = 1) uniform int alike;

// The largest difference of two packed colours and roughnesses.
int difference(uint a, uint b)
{
    vec4 d = abs(unpackUnorm4x8(a) - unpackUnorm4x8(b)) * 255.0;
    return int(max(max(d.r, d.g), max(d.b, d.a)) + 0.5);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    float least = texelFetch(fine_depths, ivec3(at, 0), 0).x, most = least;
    for (int k = 1; k < 4; ++k) {
        float depth = texelFetch(fine_depths, ivec3(at, k), 0).x;
        least = min(least, depth);
        most = max(most, depth);
    }
    bool even = most - least <= 0.02 * most;
    // Only where depths do not tell. Turns of a loop are skipped where no pixel near needs them.
    int looks = most > 0.0 && even ? 4 : 0;
    uvec2 first = uvec2(0u);
    for (int k = 0; k < looks; ++k) {
        uvec2 pixel = texelFetch(fine_pixels, ivec3(at, k), 0).xy;
        first = k == 0 ? pixel : first;
        ivec2 a = ivec2(pixel.y & 16383u, pixel.y >> 14 & 16383u);
        ivec2 b = ivec2(first.y & 16383u, first.y >> 14 & 16383u);
        even = even && (pixel.x == first.x || (alike > 0 && difference(pixel.x, first.x) <= alike)) && all(lessThan(abs(a - b), ivec2(1200)));
    }
    if (even) discard;
}
