layout(location = 0) in vec3 position;
layout(location = 1) in vec2 normal;
layout(location = 2) in vec4 colour;
layout(location = 3) in vec4 material;
layout(location = 4) in float value;

#ifdef TEXTURED
layout(location = 5) in vec2 uv;
out vec2 at_picture;
#endif

out vec4 normal_value;
out vec4 look;        // square roots of the colour, and roughness + 256 * round(7 * metallic), both in steps
out float opacity;
out vec3 stage_point;

layout(location = 5) uniform int as_lines;  // 1: drawn a little nearer than they are, so that lines lie on top

void main()
{
    vec2 o = normal;
    vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    normal_value = vec4(normalize(n), value);
    look = vec4(colour.rgb, 255.0 * colour.a + 256.0 * round(7.0 * material.x) + 2048.0 * material.z);
    opacity = material.y;
#ifdef TEXTURED
    at_picture = vec2(uv.x, 1.0 - uv.y);  // its first row is the upper one
#endif
    stage_point = (position - units.xyz) * units.w;
    gl_Position = clip_from_stage * vec4(stage_point, 1.0);
    if (as_lines == 1) {
        // A share of the distance, and no more than so many stage units: the eye of a parallel view is
        // so far away that such a share is longer than what is drawn, and hidden lines came through.
        float nearer = min(1.5e-3, 6e-3 / max(gl_Position.w, 1e-3));
        gl_Position.z += nearer * eye.w * corner.w / (corner.w - eye.w);
    }
}
