// What the first pass left in each pixel, see pack.glsl.
layout(binding = 0) uniform usampler2D pixels;
layout(binding = 1) uniform sampler2D depths;

vec3 stored_normal(uvec2 pixel)
{
    vec2 o = vec2(pixel.y & 16383u, pixel.y >> 14 & 16383u) / 16383.0 * 2.0 - 1.0;
    return from_octahedral(o);
}

// How far along the view a stored depth is.
float view_depth(float stored) { return corner.w / (1.0 + stored * (corner.w - eye.w) / eye.w); }

// The light that a pixel stored sends to the eye along `ray`; `reach` as for shade().
vec3 stored_light(uvec2 pixel, vec3 n, vec3 ray, vec2 reach)
{
    Material m;
    vec3 root = unpackUnorm4x8(pixel.x).rgb;
    m.colour = root * root;
    m.rough = float(pixel.x >> 24) / 255.0;
    m.metal = float(pixel.y >> 28 & 7u) / 7.0;
    vec3 lit = shade(m, n, -normalize(ray), reach);
    return pixel.y >> 31 == 0u ? m.colour : lit;
}
