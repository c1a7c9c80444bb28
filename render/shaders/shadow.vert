layout(location = 0) in vec3 position;
#ifdef TEXTURED
layout(location = 5) in vec2 uv;
out vec2 at_picture;
#endif
#ifdef CLEAR
layout(location = 3) in vec4 material;
out float opacity;
#endif

#ifdef BEYOND
out vec3 near_at;  // on the near map
#endif

void main()
{
#ifdef CLEAR
    opacity = material.y;
#endif
#ifdef TEXTURED
    at_picture = vec2(uv.x, 1.0 - uv.y);
#endif
    vec4 p = vec4((position - units.xyz) * units.w, 1.0);
#ifdef BEYOND
    near_at = (shadow_from_stage * p).xyz;
    p = far_from_stage * p;
#else
    p = shadow_from_stage * p;
#endif
    gl_Position = vec4(p.xy * 2.0 - 1.0, p.z, 1.0);
}
