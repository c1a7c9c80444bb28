// The depths of the nearest of what is clear, behind the layers before.
#ifdef TEXTURED
in vec2 at_picture;
layout(binding = 9) uniform sampler2D picture;
layout(location = 6) uniform vec4 laid;  // as in clear.frag
#endif

void main()
{
    if (in_layers_before()) discard;
#ifdef TEXTURED
    if (texture(picture, at_picture).a < laid.y) discard;
#endif
}
