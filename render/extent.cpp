#include "render/extent.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <algorithm>
#include <limits>

namespace render {

// Each direction looks through all points by itself: the same result for any number of threads.
Extent extent_of(std::span<const Vec3f> points)
{
    static const std::vector<Vec3f> directions = geometry::icosphere(1, 2).positions;
    constexpr std::size_t nowhere = std::numeric_limits<std::size_t>::max();
    std::vector<std::size_t> farthest(directions.size(), nowhere);
    geometry::parallel_for(directions.size(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t d = begin; d < end; ++d) {
            float most = -std::numeric_limits<float>::infinity();
            for (std::size_t i = 0; i < points.size(); ++i) {
                const float along = directions[d].dot(points[i]);
                if (!(along > most) || !points[i].allFinite()) continue;
                most = along;
                farthest[d] = i;
            }
        }
    });
    std::sort(farthest.begin(), farthest.end());
    farthest.erase(std::unique(farthest.begin(), farthest.end()), farthest.end());
    Extent out;
    for (const std::size_t i : farthest) {
        if (i != nowhere) out.points.push_back(points[i]);
    }
    return out;
}

Box box_of(const Extent& extent)
{
    Box box;
    for (const Vec3f& p : extent.points) box.add(p.cast<double>());
    return box;
}

}  // namespace render
