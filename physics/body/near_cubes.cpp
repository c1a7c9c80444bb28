#include "physics/body/near_cubes.hpp"

namespace physics {

void NearCubes::clear()
{
    cube_.clear();
    box_ = {};
    for (auto* bounds : {&lo_, &hi_}) {
        for (auto& axis : *bounds) axis.clear();
    }
}

void NearCubes::add(const NearCube& cube)
{
    cube_.push_back(cube.cube);
    box_.add(cube.box);
    for (std::size_t i = 0; i < 3; ++i) {
        lo_[i].push_back(cube.box.lo[static_cast<Eigen::Index>(i)]);
        hi_[i].push_back(cube.box.hi[static_cast<Eigen::Index>(i)]);
    }
}

void NearCubes::meeting(const geometry::Box3f& span, std::vector<NearCube>& out)
{
    out.clear();
    if (!box_.overlaps(span)) return;
    // Without branches, so that compilers take several boxes at a time.
    meets_.assign(cube_.size(), 1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float from = span.lo[static_cast<Eigen::Index>(axis)];
        const float to = span.hi[static_cast<Eigen::Index>(axis)];
        const float *low = lo_[axis].data(), *high = hi_[axis].data();
        std::uint32_t* meets = meets_.data();
        for (std::size_t i = 0; i < cube_.size(); ++i) {
            meets[i] &= static_cast<std::uint32_t>(low[i] <= to) &
                        static_cast<std::uint32_t>(from <= high[i]);
        }
    }
    for (std::size_t i = 0; i < cube_.size(); ++i) {
        if (meets_[i] == 0) continue;
        out.push_back(
            {{{lo_[0][i], lo_[1][i], lo_[2][i]}, {hi_[0][i], hi_[1][i], hi_[2][i]}}, cube_[i]});
    }
}

}  // namespace physics
