// What is behind everything.
layout(location = 0) out vec4 colour;

void main() { colour = finished(backdrop(ray_at(gl_FragCoord.xy / floor_colour.w))); }
