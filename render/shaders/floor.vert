// Four points of the floor, lowered in depth alone: where the floor is seen, its colour is found along
// the ray.
layout(location = 1) uniform vec3 points[4];

void main()
{
    vec3 lower = points[gl_VertexID] - vec3(0.0, FLOOR_LOWERED, 0.0);
    gl_Position = clip_from_stage * vec4(lower, 1.0);
}
