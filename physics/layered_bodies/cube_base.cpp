#include "physics/layered_bodies/cube_base.hpp"

#include "physics/math/cross_matrix.hpp"
#include "physics/math/polar.hpp"

#include <map>

namespace physics {

CubeBase::CubeBase(Source source) : source_(std::move(source))
{
    const geometry::Cubes& cubes = source_.cubes;
    bricks_ = make_bricks(cubes, source_.options);
    const CarriedFrames& frames = source_.frames;
    for (std::uint32_t f = 0; f < frames.centre.size(); ++f) {
        // Of each corner: its weight, and its slope along each axis.
        std::map<std::uint32_t, Eigen::Vector4d> at;
        const auto add = [&](std::uint32_t probe, int what, double share) {
            const std::array<double, 8> w = geometry::weights(frames.binding, 7 * f + probe);
            const auto& corners =
                cubes.corners[frames.binding.used[frames.binding.cube[7 * f + probe]]];
            for (std::size_t a = 0; a < 8; ++a) {
                at.try_emplace(corners[a], Eigen::Vector4d::Zero()).first->second[what] +=
                    share * w[a];
            }
        };
        add(0, 0, 1);
        for (std::uint32_t k = 0; k < 3; ++k) {
            add(1 + 2 * k, 1 + static_cast<int>(k), 0.5 / frames.step);
            add(2 + 2 * k, 1 + static_cast<int>(k), -0.5 / frames.step);
        }
        Carried carried;
        double easy = 0;
        Mat3 unit = Mat3::Zero();  // sum X_a g_a^T, I but for probes in single precision
        for (const auto& [corner, entry] : at) {
            carried.corner.push_back(corner);
            carried.weight.push_back(entry[0]);
            carried.slope.push_back(entry.tail<3>());
            carried.centre += entry[0] * cubes.corner_position(corner);
            unit += cubes.corner_position(corner) * carried.slope.back().transpose();
            easy += entry[0] * entry[0] / bricks_.base.mass[bricks_.base.slot[corner]];
        }
        const Mat3 mend = unit.transpose().inverse();
        for (Vec3& g : carried.slope) g = mend * g;
        carried.mass = 1 / easy;
        carried_.push_back(std::move(carried));
    }
}

FrameHold CubeBase::hold(std::size_t f, const Transform& rest, std::span<const Vec3> x) const
{
    constexpr double least = 0.1;  // of what turns at rest
    const Carried& carried = carried_[f];
    Vec3 place = Vec3::Zero();
    Mat3 F = Mat3::Zero();
    for (std::size_t a = 0; a < carried.corner.size(); ++a) {
        place += carried.weight[a] * x[carried.corner[a]];
        F += x[carried.corner[a]] * carried.slope[a].transpose();
    }
    FrameHold hold;
    hold.by.assign(carried.corner.size(), Eigen::Matrix<double, 6, 3>::Zero());
    if (!F.allFinite()) return hold;
    const auto [R, U, stretch] = polar_of(F);
    hold.moved.translate(place).rotate(R).translate(-carried.centre);
    // (tr(S) I - S)^-1 has the axes of S.
    const Vec3 turned =
        (Vec3::Constant(stretch.sum()) - stretch).cwiseMax(2 * least).cwiseInverse();
    const Mat3 Q = U * turned.asDiagonal() * U.transpose();
    const Mat3 arm = cross_matrix(hold.moved * rest.translation() - place);
    for (std::size_t a = 0; a < hold.by.size(); ++a) {
        const Mat3 spin = Q * cross_matrix(R * carried.slope[a]);
        hold.by[a].topRows<3>() = carried.weight[a] * Mat3::Identity() - arm * spin;
        hold.by[a].bottomRows<3>() = spin;
    }
    return hold;
}

std::size_t CubeBase::bytes() const
{
    std::size_t sum = bricks_.bytes() + source_.frames.bytes();
    for (const Carried& carried : carried_) {
        sum += carried.corner.size() * (sizeof(std::uint32_t) + sizeof(double) + sizeof(Vec3));
    }
    return sum;
}

}  // namespace physics
