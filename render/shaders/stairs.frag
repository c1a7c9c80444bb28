// Marks the pixels across which the brightness jumps.
layout(binding = 0) uniform sampler2D picture;

void main()
{
    vec2 pixel = 1.0 / vec2(across.w, down.w);
    vec2 at = gl_FragCoord.xy * pixel;
    // The 2 x 2 pixels around two opposite corners of this one: all its neighbours but two.
    vec4 a = textureGather(picture, at - 0.5 * pixel, 3), b = textureGather(picture, at + 0.5 * pixel, 3);
    vec4 low4 = min(a, b), high4 = max(a, b);
    float low = min(min(low4.x, low4.y), min(low4.z, low4.w));
    float high = max(max(high4.x, high4.y), max(high4.z, high4.w));
    if (high - low < max(0.035, 0.125 * high)) discard;
}
