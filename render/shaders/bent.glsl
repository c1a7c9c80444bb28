// Normals by a normal map.
//   Mikkelsen, Simulation of wrinkled surfaces revisited, thesis, 2008 (the frame: the direction of
//   growing u, at right angles to the normal, and theirs).
// The frame comes from how place and coordinates change from pixel to pixel, so that a mesh that
// deforms needs no tangents.
layout(binding = 10) uniform sampler2D normal_map;
layout(location = 7) uniform float bump;  // 0: there is none

// n: the normal outwards, p: the point, uv: its place in the picture, whose rows run down.
vec3 bent(vec3 n, vec3 p, vec2 uv)
{
    vec3 along = dFdx(p), up = dFdy(p);
    vec2 uv_along = dFdx(uv), uv_up = dFdy(uv);
    vec3 m = texture(normal_map, uv).xyz * 2.0 - 1.0;
    float turn = uv_along.x * uv_up.y - uv_up.x * uv_along.y;
    vec3 u = (along * uv_up.y - up * uv_along.y) * sign(turn);
    vec3 v = (along * uv_up.x - up * uv_along.x) * sign(turn);  // against the rows
    u -= n * dot(n, u);
    float size = dot(u, u);
    if (bump == 0.0 || turn == 0.0 || size == 0.0) return n;
    u *= inversesqrt(size);
    vec3 w = cross(n, u);
    w *= dot(w, v) < 0.0 ? -1.0 : 1.0;
    return normalize(bump * (m.x * u + m.y * w) + m.z * n);
}
