// Four points of the floor. Its depth is a hair lower than itself, so that a sheet that lies on it
// hides it, and not here and there as depths are rounded. Where the floor is seen, its colour is
// found along the ray and knows nothing of this.
layout(location = 1) uniform vec3 points[4];

void main()
{
    vec3 lower = points[gl_VertexID] - vec3(0.0, 1e-3, 0.0);
    gl_Position = clip_from_stage * vec4(lower, 1.0);
}
