#include "geometry/embed/corner_frames.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <utility>

namespace geometry {

CornerFrames::CornerFrames(std::vector<std::uint32_t> after, std::span<const std::uint32_t> broken,
                           double size)
    : size_(size), after_(std::move(after)), before_(after_.size(), no_index)
{
    for (const std::uint32_t link : broken) {
        if (link < after_.size()) after_[link] = no_index;
    }
    for (std::uint32_t link = 0; link < after_.size(); ++link) {
        if (after_[link] != no_index) before_[3 * after_[link] + link % 3] = link / 3;
    }
}

Mat3 CornerFrames::at(std::uint32_t corner, std::span<const Vec3> x) const
{
    Mat3 frame = size_ * Mat3::Identity();
    std::array<bool, 3> known{};
    int count = 0;
    for (int d = 0; d < 3; ++d) {
        const auto side = std::size_t(3 * corner) + std::size_t(d);
        const std::uint32_t after = after_[side], before = before_[side];
        if (after == no_index && before == no_index) continue;
        const Vec3& end = x[after == no_index ? corner : after];
        const Vec3& start = x[before == no_index ? corner : before];
        const Vec3 step = (end - start) / (after == no_index || before == no_index ? 1 : 2);
        if (!(step.norm() > 1e-6 * size_)) continue;
        frame.col(d) = step;
        known[std::size_t(d)] = true;
        ++count;
    }
    if (count == 3 || count == 0) return frame;
    const auto first = int(std::find(known.begin(), known.end(), true) - known.begin());
    if (count == 2) {
        const auto d = int(std::find(known.begin(), known.end(), false) - known.begin());
        const Vec3 across = frame.col((d + 1) % 3).cross(frame.col((d + 2) % 3));
        if (across.norm() > 1e-6 * size_ * size_) {
            frame.col(d) = size_ * across.normalized();
            return frame;
        }
    }
    const Mat3 turn =
        Eigen::Quaterniond::FromTwoVectors(Vec3::Unit(first), frame.col(first)).toRotationMatrix();
    for (int d = 0; d < 3; ++d) {
        if (!known[std::size_t(d)]) frame.col(d) = size_ * turn.col(d);
    }
    return frame;
}

}  // namespace geometry
