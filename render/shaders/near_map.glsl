// Of pictures with two shadow maps: what the near one tells. Near its edge both are asked, as filters
// there reach beyond it.
const float BOTH = 0.12;  // stage units inside the edge

// How far inside the near map's box a point of it lies, stage units across the light; below 0 outside,
// and before or behind the box.
float inside_near(vec3 at)
{
    vec2 off_edge = min(at.xy, 1.0 - at.xy) * light.w * shadow_size.xy;
    return at.z < 0.0 || at.z > 1.0 ? -1.0 : min(off_edge.x, off_edge.y);
}
