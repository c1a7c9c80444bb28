// Light on the things that the first pass found.
layout(location = 0) out vec4 colour;

#if STYLE == DIAGRAM
// Whether the thing's outline or a crease runs here: a neighbour lies behind the tangent plane, or
// faces elsewhere.
float outline(ivec2 at, float stored, vec3 ray)
{
    ivec2 last = textureSize(depths, 0) - 1;
    float depth = view_depth(stored), pixel = depth * length(down.xyz) / floor_colour.w;
    vec3 n = stored_normal(texelFetch(pixels, at, 0).xy);
    float ink = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 by = ivec2(k < 2 ? 2 * k - 1 : 0, k < 2 ? 0 : 2 * k - 5);
        ivec2 from = clamp(at + by, ivec2(0), last);
        float there = texelFetch(depths, from, 0).x;
        vec3 v = view_depth(max(there, 1e-9)) * ray_at((vec2(from) + 0.5) / floor_colour.w) - depth * ray;
        vec3 m = stored_normal(texelFetch(pixels, from, 0).xy);
        bool behind = there <= 0.0 || (dot(v, ray) > 0.0 && dot(v, n) < -3.0 * pixel);
        ink = max(ink, behind ? 1.0 : smoothstep(0.75, 0.55, dot(m, n)) * 0.8);
    }
    return ink;
}
#endif

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec2 place = gl_FragCoord.xy / floor_colour.w;
    vec3 ray = ray_at(place);
    float stored = texelFetch(depths, at, 0).x;
    float depth = view_depth(stored);
    uvec2 pixel = texelFetch(pixels, at, 0).xy;
    vec3 n = stored_normal(pixel);
    vec3 sum = stored_light(pixel, n, ray, light_reaching(place, depth, eye.xyz + depth * ray, n));
#if STYLE == DIAGRAM
    sum *= 1.0 - 0.9 * outline(at, stored, ray);
#endif
    colour = finished(sum, 1.0);
}
