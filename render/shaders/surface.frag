in vec4 normal_value;
in vec4 look;

layout(location = 0) out uvec2 pixel;

layout(location = 3) uniform int mapped;
layout(binding = 3) uniform sampler2D colour_maps;
layout(location = 4) uniform float map_row;

#ifdef TEXTURED
in vec2 at_picture;
in vec3 stage_point;
layout(binding = 9) uniform sampler2D picture;
layout(location = 6) uniform vec4 laid;  // x 1: it colours too; y least alpha that is there; z 1: alpha blends
#endif

void main()
{
    vec3 n = normalize(normal_value.xyz);
#ifdef TEXTURED
    n = bent(n, stage_point, at_picture);
#endif
    if (!gl_FrontFacing) n = -n;
    vec3 root = look.rgb;
    if (mapped == 1) root = texture(colour_maps, vec2(normal_value.w, map_row)).rgb;
#ifdef TEXTURED
    vec4 texel = texture(picture, at_picture);
    if (texel.a < laid.y) discard;
    if (laid.x == 1.0) root *= texel.rgb;  // square roots
#endif
    pixel = pack_pixel(root, look.a, n, look.a > 2047.5);
}
