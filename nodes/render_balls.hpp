#pragma once

// What the balls of points take beside the points, for a camera that holds them.

#include "geometry/mesh/primitive.hpp"
#include "render/scene.hpp"

#include <algorithm>
#include <span>
#include <vector>

namespace nodes::render {

// m, of the balls that are drawn alone, without surfaces: what stands out of their points.
inline double radius_of_balls(const ::render::Scene& scene)
{
    float radius = 0;
    if (!scene.surfaces.empty() || !scene.fields.empty()) return 0;
    for (const auto& balls : scene.balls) radius = std::max(radius, balls.radius);
    return radius;
}

// `points` and the corners of an icosahedron around each that holds a ball of that radius.
inline std::vector<geometry::Vec3f> with_balls(std::span<const geometry::Vec3f> points,
                                               double radius)
{
    // As wide as the ball: the inner radius of an icosahedron is 0.7947 of the outer.
    const std::vector<geometry::Vec3f> around = geometry::icosphere(radius / 0.7946, 0).positions;
    std::vector<geometry::Vec3f> out;
    out.reserve(points.size() * around.size());
    for (const geometry::Vec3f& p : points) {
        for (const geometry::Vec3f& r : around) out.push_back(p + r);
    }
    return out;
}

}  // namespace nodes::render
