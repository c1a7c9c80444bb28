// Four points of the floor.
layout(location = 1) uniform vec3 points[4];

void main() { gl_Position = clip_from_stage * vec4(points[gl_VertexID], 1.0); }
