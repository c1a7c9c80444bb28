in vec4 normal_value;
in vec4 look;

layout(location = 0) out uvec2 pixel;

layout(location = 1) uniform int mapped;
layout(binding = 3) uniform sampler2D colour_maps;
layout(location = 2) uniform float map_row;

void main()
{
    vec3 n = normalize(normal_value.xyz);
    if (!gl_FrontFacing) n = -n;
    vec3 srgb = look.rgb;
    if (mapped == 1) srgb = texture(colour_maps, vec2(normal_value.w, map_row)).rgb;
    pixel = pack_pixel(srgb, look.a, n, look.a > 2047.5);
}
