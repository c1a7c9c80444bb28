#include "physics/body/points_now.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/trilinear.hpp"

#include <algorithm>

namespace physics {
namespace {

using geometry::Vec3;

PointNow point_now(const std::array<std::uint32_t, 8>& corners, const geometry::Vec3f& place,
                   const double* x, const double* v)
{
    PointNow out;
    const std::array<double, 8> weight = geometry::trilinear_weights(place.cast<double>());
    for (std::size_t a = 0; a < 8; ++a) {
        const std::size_t at = 4 * std::size_t{corners[a]};
        out.p += weight[a] * Eigen::Map<const Vec3>(x + at);
        out.v += weight[a] * Eigen::Map<const Vec3>(v + at);
    }
    return out;
}

void move(const PartShapes& shapes, std::uint32_t holder, const double* x, const double* v,
          PointsNow& out)
{
    HolderNow& now = out.holder[holder];
    const auto begin = shapes.point_at[holder], end = shapes.point_at[holder + 1];
    for (auto p = begin; p < end; ++p) {
        PointNow& point = out.point[p];
        point = point_now(shapes.corners[shapes.holder[holder]], shapes.point[p].place, x, v);
        now.box.add(point.p);
        now.velocity += point.v / double(end - begin);
    }
    for (auto p = begin; p < end; ++p) {
        now.spread = std::max(now.spread, (out.point[p].v - now.velocity).norm());
    }
}

}  // namespace

PointsNow points_now(const PartShapes& shapes, const std::vector<PartPair>& pairs, const double* x,
                     const double* v)
{
    std::vector<char> near(shapes.parts(), 0);
    for (const PartPair& pair : pairs) near[pair.a] = near[pair.b] = 1;
    PointsNow out;
    out.point.resize(shapes.point.size());
    out.holder.resize(shapes.holder.size());
    geometry::parallel_for(shapes.parts(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t part = begin; part < end; ++part) {
            if (near[part] == 0) continue;
            for (const auto holder : shapes.holders[part]) move(shapes, holder, x, v, out);
        }
    });
    return out;
}

}  // namespace physics
