// Third pass, only where something is transparent: lit and laid over what is there.
in vec4 normal_value;
in vec4 look;
in float opacity;
in vec3 stage_point;

layout(location = 0) out vec4 colour;  // premultiplied

layout(location = 3) uniform int mapped;
layout(binding = 3) uniform sampler2D colour_maps;
layout(location = 4) uniform float map_row;

#ifdef TEXTURED
in vec2 at_picture;
layout(binding = 9) uniform sampler2D picture;
layout(location = 6) uniform vec4 laid;  // x 1: it colours too; y least alpha that is there; z 1: alpha blends
#endif

#if PEEL == 1
layout(location = 9) uniform int up_to_layer;  // 1: only what lies no farther than this layer
layout(binding = 12) uniform sampler2D layer;
#endif

// A smooth pane over a body of `opacity`: what it reflects does not fade with the body. Schlick 1994.
vec4 as_glass(vec3 body, vec3 n, vec3 v)
{
    float share = 0.04 + 0.96 * pow(1.0 - max(dot(n, v), 0.0), 5.0);
    vec3 mirror = reflect(-v, n);
    vec3 below = sky.w == 1.0 ? 0.8 * floor_colour.rgb * light.rgb * to_light.y : bounce.rgb;
    vec3 around = mix(below, backdrop(mirror) * 1.5, smoothstep(-0.1, 0.1, mirror.y));
    float sun = pow(max(dot(mirror, to_light.xyz), 0.0), 400.0);
    vec3 reflected = share * around + sun * light.rgb;
    return vec4((1.0 - share) * opacity * body + reflected, mix(opacity, 1.0, share));
}

void main()
{
#if PEEL == 1
    if (in_layers_before() || (up_to_layer == 1 && gl_FragCoord.z < end_of(layer))) discard;
#endif
    vec3 v = normalize(eye.xyz - stage_point);
    vec3 n = normalize(normal_value.xyz);
#ifdef TEXTURED
    n = bent(n, stage_point, at_picture);
#endif
    if (!gl_FrontFacing) n = -n;
    vec3 c = look.rgb;
    if (mapped == 1) c = texture(colour_maps, vec2(normal_value.w, map_row)).rgb;
    float there = 1.0;
#ifdef TEXTURED
    vec4 texel = texture(picture, at_picture);
    if (texel.a < laid.y) discard;
    if (laid.x == 1.0) c *= texel.rgb;  // square roots
    if (laid.z == 1.0) there = texel.a;
#endif
    Material m;
    m.colour = c * c;
    int steps = int(look.a + 0.5);
    m.rough = float(steps & 255) / 255.0;
    m.metal = float(steps >> 8 & 7) / 7.0;
    vec3 sum = m.colour;
    float cover = opacity;
    if ((steps & 2048) != 0) {
        sum = shade(m, n, v, vec2(lit_share(stage_point, n), 1.0));
        // At a grazing angle glass hides what is behind it.
        cover = mix(opacity, 1.0, 0.6 * pow(1.0 - max(dot(n, v), 0.0), 5.0));
    }
    cover *= there;
    colour = vec4(sum * cover, cover);
#if STYLE != DIAGRAM
    if (GLASS == 1 && (steps & 2048) != 0) colour = there * as_glass(sum, n, v);
#endif
}
