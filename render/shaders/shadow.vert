layout(location = 0) in vec3 position;

void main()
{
    vec4 p = shadow_from_stage * vec4((position - units.xyz) * units.w, 1.0);
    gl_Position = vec4(p.xy * 2.0 - 1.0, p.z, 1.0);
}
