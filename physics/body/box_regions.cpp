#include "physics/body/box_regions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace physics {
namespace {

using geometry::Box;
using geometry::Box3f;
using geometry::Vec3f;

// Not smaller than the box.
Box3f around(const Box& box)
{
    constexpr float far = std::numeric_limits<float>::infinity();
    Box3f out{box.lo.cast<float>(), box.hi.cast<float>()};
    for (int d = 0; d < 3; ++d) {
        out.lo[d] = std::nextafter(out.lo[d], -far);
        out.hi[d] = std::nextafter(out.hi[d], far);
    }
    return out;
}

}  // namespace

BoxRegions::BoxRegions(std::span<const Box> boxes) : boxes_(boxes)
{
    constexpr std::size_t few = 8;
    if (boxes.size() <= few) return;
    std::vector<Box3f> all;
    for (const Box& box : boxes) {
        all.push_back(around(box));
        if (!all.back().lo.allFinite() || !all.back().hi.allFinite()) return;
    }
    tree_ = geometry::build_box_tree(all);
}

bool BoxRegions::meet(const Box& box) const
{
    const auto meets = [&](const Box& region) { return overlap(region, box); };
    if (tree_.nodes.empty()) return std::any_of(boxes_.begin(), boxes_.end(), meets);
    bool found = false;
    tree_.overlapping(around(box), [&](std::uint32_t i) { found = found || meets(boxes_[i]); });
    return found;
}

}  // namespace physics
