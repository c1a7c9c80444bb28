// The floor, IN_SHADOW 1 where a shadow may lie on it.
layout(location = 0) out vec4 colour;

void main()
{
    vec3 ray = ray_at(gl_FragCoord.xy / floor_colour.w);
    float t = floor_depth(ray), key = 1.0;
#if IN_SHADOW == 1
    key = lit_share(eye.xyz + t * ray, vec3(0.0, 1.0, 0.0));
#endif
    colour = finished(floor_light(ray, t, key));
}
