flat in vec3 ball_colour;
flat in vec4 ball;

layout(location = 0) out uvec2 pixel;

void main()
{
    vec2 at = gl_PointCoord * 2.0 - 1.0;
    float rest = 1.0 - dot(at, at);
    if (rest <= 0.0) discard;
    vec3 right = normalize(across.xyz), down_ = normalize(down.xyz), back = cross(right, -down_);
    // gl_PointCoord runs along the framebuffer's rows, and those run down the picture.
    vec3 n = normalize(at.x * right + at.y * down_ + sqrt(rest) * back);
    pixel = pack_pixel(ball_colour, 120.0, n, true);
    float depth = max(ball.y - sqrt(rest) * ball.x, eye.w);
    gl_FragDepth = clamp(eye.w / (corner.w - eye.w) * (corner.w / depth - 1.0), 0.0, 1.0);
}
