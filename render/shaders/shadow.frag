// With BEYOND, for the far shadow map: without what the near one holds.
// With CLEAR, a clear thing covers that share of the texels of each square of 4 x 4 that it is opaque
// of: the filters of shadows take the mean.
#ifdef TEXTURED
in vec2 at_picture;
layout(binding = 9) uniform sampler2D picture;
layout(location = 6) uniform vec4 laid;  // as in surface.frag
#endif
#ifdef CLEAR
in float opacity;

bool is_open(float cover)
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int x = at.x ^ at.y, y = at.y;
    int order = (x & 1) << 3 | (y & 1) << 2 | (x & 2) | (y & 2) >> 1;
    return cover <= (float(order) + 0.5) / 16.0;
}
#endif

#ifdef BEYOND
in vec3 near_at;
#endif

void main()
{
#ifdef BEYOND
    if (inside_near(near_at) > BOTH + 4.0 * far_size.z) discard;
#endif
    float cover = 1.0;
#ifdef TEXTURED
    float alpha = texture(picture, at_picture).a;
    if (alpha < laid.y) discard;
    if (laid.z == 1.0) cover = alpha;
#endif
#ifdef CLEAR
    if (is_open(cover * opacity)) discard;
#endif
}
