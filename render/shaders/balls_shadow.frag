#ifdef BEYOND
flat in vec3 near_at;
#endif

void main()
{
#ifdef BEYOND
    if (inside_near(near_at) > BOTH + 4.0 * far_size.z) discard;
#endif
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    if (dot(at, at) > 1.0) discard;
}
