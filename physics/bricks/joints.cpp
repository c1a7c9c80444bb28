#include "physics/bricks/joints.hpp"

#include "geometry/base/union_find.hpp"

#include <algorithm>

namespace physics {
namespace {

// `mass`: of each part, to hold.
double stiffness_of(const Stage& stage, const JointPoint& joint, std::span<const double> mass,
                    std::uint32_t a, std::uint32_t b)
{
    constexpr double of_cubes = 10, of_rigid = 1e4;
    const bool rigid_a = stage.rigid.of_corner(a) != RigidBodies::not_rigid;
    const bool rigid_b = stage.rigid.of_corner(b) != RigidBodies::not_rigid;
    if (!rigid_a && !rigid_b) return of_cubes * std::min(joint.stiffness[0], joint.stiffness[1]);
    if (!rigid_a) return of_cubes * joint.stiffness[0];
    if (!rigid_b) return of_cubes * joint.stiffness[1];
    const CornerBody& body = stage.frame.body;
    const double least = std::min(mass[body.part_of(a)], mass[body.part_of(b)]);
    return of_rigid * least / (stage.tau * stage.tau);
}

}  // namespace

void add_joints(const Stage& stage, const Aligned<double>& x, std::vector<PointContact>& to)
{
    const CornerBody& body = stage.frame.body;
    const auto& joints = stage.frame.loads.joints;
    if (joints.empty()) return;
    const std::vector<double> mass = masses_to_hold(body, joints, stage.frame.part_mass);
    for (const JointPoint& joint : joints) {
        PointContact& out = to.emplace_back();
        out.count = PointContact::most;
        Vec3 gap = Vec3::Zero();
        for (std::size_t i = 0; i < PointContact::most; ++i) {
            const auto slot = static_cast<std::uint32_t>(body.slot_of(joint.corner[i]));
            out.corners[i] = slot;
            out.weight[i] = static_cast<float>(joint.weight[i]);
            gap += joint.weight[i] * Eigen::Map<const Vec3>(&x[4 * std::size_t{slot}]);
        }
        const double k = stiffness_of(stage, joint, mass, out.corners[0], out.corners[8]);
        out.force = -k * gap;
        out.stiffness = {k, 0, 0, k, 0, k};
        out.energy = 0.5 * k * gap.squaredNorm();
    }
}

std::vector<std::uint32_t> joined_parts(const CornerBody& body, std::span<const JointPoint> joints)
{
    geometry::UnionFind sets(std::max<std::size_t>(body.parts, 1));
    for (const JointPoint& joint : joints) {
        sets.join(body.part_of(body.slot_of(joint.corner[0])),
                  body.part_of(body.slot_of(joint.corner[8])));
    }
    return sets.roots();
}

std::vector<double> masses_to_hold(const CornerBody& body, std::span<const JointPoint> joints,
                                   std::span<const double> part_mass)
{
    constexpr double share = 0.1;
    std::vector<double> out(part_mass.begin(), part_mass.end());
    if (joints.empty()) return out;
    const std::vector<std::uint32_t> first = joined_parts(body, joints);
    std::vector<double> heaviest(out.size(), 0);
    for (std::size_t p = 0; p < out.size(); ++p) {
        heaviest[first[p]] = std::max(heaviest[first[p]], out[p]);
    }
    for (std::size_t p = 0; p < out.size(); ++p) {
        out[p] = std::max(out[p], share * heaviest[first[p]]);
    }
    return out;
}

}  // namespace physics
