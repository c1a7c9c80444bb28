// The floor, IN_SHADOW 1 where a shadow may lie on it.
layout(location = 0) out vec4 colour;

void main()
{
    vec2 place = gl_FragCoord.xy / floor_colour.w;
    vec3 ray = ray_at(place);
    float t = floor_depth(ray);
    vec2 reach = vec2(1.0);
#if IN_SHADOW == 1 || SOFT == 1
    reach = light_reaching(place, t, eye.xyz + t * ray, vec3(0.0, 1.0, 0.0));
#elif FAR == 1
    reach.x = far_share(eye.xyz + t * ray, vec3(0.0, 1.0, 0.0));
#endif
    float stays;
    vec3 sum = floor_light(ray, t, reach, stays);
    colour = finished(sum, stays);
}
