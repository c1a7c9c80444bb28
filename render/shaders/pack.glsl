// A pixel of the first pass: what lies there, before any light. x: square roots of the linear
// colour, and roughness, 8 bits each; y: the octahedral normal, 14 bits each, metallic in 3 bits, and whether it is lit.
uvec2 pack_pixel(vec3 root, float code, vec3 n, bool is_lit)
{
    uint steps = uint(code + 0.5);
    uvec2 q = uvec2(round((octahedral(n) * 0.5 + 0.5) * 16383.0));
    return uvec2((packUnorm4x8(vec4(root, 0.0)) & 0xffffffu) | (steps & 255u) << 24,
                 q.x | q.y << 14 | (steps >> 8 & 7u) << 28 | (is_lit ? 1u << 31 : 0u));
}
