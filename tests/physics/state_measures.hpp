#pragma once

// What tests ask of a moving body's state.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/cube_mass.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <Eigen/SVD>

#include <algorithm>
#include <memory>
#include <vector>

namespace fixtures {

using geometry::Mat3;
using geometry::Vec3;
using physics::State;

inline bool finite(const State& s)
{
    const auto sound = [](const Vec3& p) { return p.allFinite(); };
    return std::all_of(s.x.begin(), s.x.end(), sound) && std::all_of(s.v.begin(), s.v.end(), sound);
}

// Energy of motion (J) and momenta (N s, N m s about the origin) of a body of bricks.
struct BrickMotion {
    double energy = 0;
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
inline BrickMotion brick_motion(const geometry::Cubes& cubes, const State& s)
{
    BrickMotion out;
    const auto momenta = physics::brick_momenta(cubes, s.v);
    for (std::size_t k = 0; k < momenta.size(); ++k) {
        out.energy += 0.5 * momenta[k].dot(s.v[k]);
        out.linear += momenta[k];
        out.angular += s.x[k].cross(momenta[k]);
    }
    return out;
}

// Of several models, whose corners follow each other.
inline BrickMotion brick_motion(const std::vector<std::shared_ptr<const geometry::Cubes>>& models,
                                const State& s)
{
    BrickMotion out;
    std::ptrdiff_t begin = 0;
    for (const auto& cubes : models) {
        const auto end = begin + std::ptrdiff_t(cubes->corner_count());
        State own;
        own.x.assign(s.x.begin() + begin, s.x.begin() + end);
        own.v.assign(s.v.begin() + begin, s.v.begin() + end);
        const BrickMotion motion = brick_motion(*cubes, own);
        out.energy += motion.energy, out.linear += motion.linear, out.angular += motion.angular;
        begin = end;
    }
    return out;
}

// Between what two parts carry at points of joints, m.
inline double widest_gap(const std::vector<physics::JointPoint>& joints, const State& s)
{
    double most = 0;
    for (const physics::JointPoint& p : joints) {
        Vec3 sum = Vec3::Zero();
        for (std::size_t i = 0; i < 16; ++i) sum += p.weight[i] * s.x[p.corner[i]];
        most = std::max(most, sum.norm());
    }
    return most;
}

// The largest change of a distance between corners since rest: 0 for any rigid motion.
inline double shape_error(const geometry::Cubes& cubes, const State& s)
{
    const auto rest = corner_positions(cubes);
    double worst = 0;
    for (std::size_t k = 1; k < rest.size(); ++k) {
        for (const std::size_t j : {std::size_t{0}, rest.size() / 2}) {
            worst =
                std::max(worst, std::abs((s.x[k] - s.x[j]).norm() - (rest[k] - rest[j]).norm()));
        }
    }
    return worst;
}

// The largest distance between a state and the rest shape moved rigidly as well as can be.
inline double misfit(const State& rest, const State& state)
{
    const std::size_t n = rest.x.size();
    Vec3 a = Vec3::Zero(), b = a;
    for (std::size_t i = 0; i < n; ++i) a += rest.x[i] / double(n), b += state.x[i] / double(n);
    Mat3 m = Mat3::Zero();
    for (std::size_t i = 0; i < n; ++i) m += (state.x[i] - b) * (rest.x[i] - a).transpose();
    const Eigen::JacobiSVD<Mat3> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Vec3 signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1);
    const Mat3 r = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    double worst = 0;
    for (std::size_t i = 0; i < n; ++i) {
        worst = std::max(worst, (state.x[i] - b - r * (rest.x[i] - a)).norm());
    }
    return worst;
}

}  // namespace fixtures
