// Marks the pixels whose four samples do not agree: there one light for all would show stairs.
layout(binding = 0) uniform usampler2D pixels;
layout(binding = 1) uniform sampler2D depths;

void main()
{
    ivec2 at = 2 * ivec2(gl_FragCoord.xy);
    uvec2 first = texelFetch(pixels, at, 0).xy;
    float least = texelFetch(depths, at, 0).x, most = least;
    bool even = true;
    for (int k = 1; k < 4; ++k) {
        ivec2 from = at + ivec2(k & 1, k >> 1);
        uvec2 pixel = texelFetch(pixels, from, 0).xy;
        float depth = texelFetch(depths, from, 0).x;
        least = min(least, depth);
        most = max(most, depth);
        ivec2 a = ivec2(pixel.y & 16383u, pixel.y >> 14 & 16383u);
        ivec2 b = ivec2(first.y & 16383u, first.y >> 14 & 16383u);
        even = even && pixel.x == first.x && all(lessThan(abs(a - b), ivec2(1200)));
    }
    if (most == 0.0 || (even && most - least <= 0.02 * most)) discard;
}
