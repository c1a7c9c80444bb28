// A pixel of the first pass: what lies there, before any light. x: square roots of the linear
// colour, and roughness, 8 bits each; y: the octahedral normal, 14 bits each, metallic in 3 bits, and whether it is lit.
uvec2 pack_pixel(vec3 root, float code, vec3 n, bool is_lit)
{
    uint steps = uint(code + 0.5);
    vec2 o = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if (n.z < 0.0) o = (1.0 - abs(o.yx)) * vec2(o.x < 0.0 ? -1.0 : 1.0, o.y < 0.0 ? -1.0 : 1.0);
    uvec2 q = uvec2(round((o * 0.5 + 0.5) * 16383.0));
    return uvec2((packUnorm4x8(vec4(root, 0.0)) & 0xffffffu) | (steps & 255u) << 24,
                 q.x | q.y << 14 | (steps >> 8 & 7u) << 28 | (is_lit ? 1u << 31 : 0u));
}
