// Smooths the stairs at the marked pixels of a finished picture. After the idea of Lottes, FXAA, NVIDIA
// 2009: find on which side of a pixel an edge in brightness runs, follow it both ways to its ends,
// and mix in the other side by how far along the stair the pixel is.
layout(binding = 0) uniform sampler2D picture;

layout(location = 0) out vec4 colour;

float brightness(vec2 at) { return texture(picture, at).a; }

void main()
{
    vec2 pixel = 1.0 / vec2(across.w, down.w);
    vec2 at = gl_FragCoord.xy * pixel;
    float m = brightness(at);
    float n = brightness(at + vec2(0, -1) * pixel), s = brightness(at + vec2(0, 1) * pixel);
    float w = brightness(at + vec2(-1, 0) * pixel), e = brightness(at + vec2(1, 0) * pixel);
    float high = max(m, max(max(n, s), max(w, e))), low = min(m, min(min(n, s), min(w, e)));
    float range = high - low;
    float nw = brightness(at + vec2(-1, -1) * pixel), ne = brightness(at + vec2(1, -1) * pixel);
    float sw = brightness(at + vec2(-1, 1) * pixel), se = brightness(at + vec2(1, 1) * pixel);
    float across_rows = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * m) + abs(ne + se - 2.0 * e);
    float across_columns = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * m) + abs(sw + se - 2.0 * s);
    bool level = across_rows >= across_columns;  // the edge runs along a row

    float before = level ? n : w, after = level ? s : e;
    bool to_before = abs(before - m) >= abs(after - m);
    vec2 side = (level ? vec2(0, 1) : vec2(1, 0)) * pixel * (to_before ? -1.0 : 1.0);
    float other = to_before ? before : after;
    float edge = 0.5 * (m + other), step_size = 0.25 * abs(other - m);

    // Walk along the edge, half a pixel over it, until the brightness there no longer is the mean.
    vec2 along = (level ? vec2(1, 0) : vec2(0, 1)) * pixel;
    vec2 start = at + 0.5 * side;
    float reach[2] = float[2](0.0, 0.0), found[2] = float[2](0.0, 0.0);
    for (int k = 0; k < 2; ++k) {
        vec2 stride = k == 0 ? -along : along;
        float far = 1.0;
        for (int i = 0; i < 7; ++i) {
            found[k] = brightness(start + far * stride) - edge;
            reach[k] = far;
            if (abs(found[k]) >= step_size) break;
            far += i < 3 ? 1.0 : 2.0;
        }
    }
    int near_end = reach[0] < reach[1] ? 0 : 1;
    float nearest = near_end == 0 ? reach[0] : reach[1];
    float at_end = near_end == 0 ? found[0] : found[1];
    bool stair = (at_end < 0.0) != (m < edge);
    float shift = stair ? 0.5 - nearest / (reach[0] + reach[1]) : 0.0;

    // A lone bright or dark pixel has no edge to follow: blend it by how much it stands out.
    float mean = (2.0 * (n + s + w + e) + nw + ne + sw + se) / 12.0;
    float lone = smoothstep(0.0, 1.0, clamp(abs(mean - m) / range, 0.0, 1.0));
    shift = max(shift, 0.6 * lone * lone);
    colour = texture(picture, at + side * shift);
}
