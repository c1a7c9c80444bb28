// What is behind everything.
layout(location = 0) out vec4 colour;

void main()
{
    colour = linear_out == 2 ? vec4(0.0) : finished(backdrop(ray_at(gl_FragCoord.xy / floor_colour.w)), 1.0);
}
