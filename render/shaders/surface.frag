in vec4 normal_value;
in vec4 look;

layout(location = 0) out uvec2 pixel;

layout(location = 3) uniform int mapped;
layout(binding = 3) uniform sampler2D colour_maps;
layout(location = 4) uniform float map_row;

void main()
{
    vec3 n = normalize(normal_value.xyz);
    if (!gl_FrontFacing) n = -n;
    vec3 root = look.rgb;
    if (mapped == 1) root = texture(colour_maps, vec2(normal_value.w, map_row)).rgb;
    pixel = pack_pixel(root, look.a, n, look.a > 2047.5);
}
