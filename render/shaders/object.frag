// Light on the things that the first pass found.
layout(location = 0) out vec4 colour;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 ray = ray_at(gl_FragCoord.xy / floor_colour.w);
    colour = finished(stored_light(texelFetch(pixels, at, 0).xy, texelFetch(depths, at, 0).x, ray));
}
