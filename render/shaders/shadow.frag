#ifdef TEXTURED
in vec2 at_picture;
layout(binding = 9) uniform sampler2D picture;
layout(location = 6) uniform vec4 laid;  // as in surface.frag

void main()
{
    if (texture(picture, at_picture).a < laid.y) discard;
}
#else
void main() {}
#endif
