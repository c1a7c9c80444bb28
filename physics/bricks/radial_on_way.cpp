#include "physics/bricks/radial_on_way.hpp"

#include "physics/body/external_forces.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/bricks/part_groups.hpp"

#include <algorithm>

namespace physics {
namespace {

// m/s, of each part where the stage starts, or of the group that it is of.
std::vector<Vec3> velocities_of_parts(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    std::vector<Vec3> out(stage.frame.part_mass.size(), Vec3::Zero());
    for (std::size_t k = 0; k < body.corners; ++k) {
        out[body.part_of(k)] += body.mass[k] * Eigen::Map<const Vec3>(&stage.v0[4 * k]);
    }
    for (std::size_t p = 0; p < out.size(); ++p) out[p] /= stage.frame.part_mass[p];
    return out;
}

std::vector<Vec3> velocities_of_groups(const Stage& stage, const std::vector<Vec3>& of_parts,
                                       PartGroups& groups)
{
    std::vector<Vec3> out(of_parts.size(), Vec3::Zero());
    std::vector<double> mass(of_parts.size(), 0);
    for (std::uint32_t p = 0; p < out.size(); ++p) {
        const double own = stage.frame.part_mass[p];
        out[groups.sets.root(p)] += own * of_parts[p];
        mass[groups.sets.root(p)] += own;
    }
    for (std::uint32_t p = 0; p < out.size(); ++p) {
        if (mass[p] > 0) out[p] /= mass[p];
    }
    for (std::uint32_t p = 0; p < out.size(); ++p) out[p] = out[groups.sets.root(p)];
    return out;
}

// Sets parts back from where they are about to end to where the header says, but for their turn.
void set_back(const Stage& stage, Aligned<double>& ahead)
{
    const CornerBody& body = stage.frame.body;
    PartGroups groups(stage);
    const auto pins = axes_of_parts(stage.frame.loads.pins, body);
    const auto pinned = groups.with_all(pins), held = groups.with_all(groups.held);
    const auto own = velocities_of_parts(stage);
    const auto of_group = velocities_of_groups(stage, own, groups);
    std::vector<std::uint8_t> rigid(pins.size(), 0);
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) rigid[stage.rigid.part(i)] = 1;
    std::vector<Vec3> back(pins.size(), Vec3::Zero());  // m
    for (std::size_t p = 0; p < back.size(); ++p) {
        const double of_held = rigid[p] != 0 && pinned[p] != 0 ? 0.5 : 1;
        for (Eigen::Index a = 0; a < 3; ++a) {
            const bool holds = (held[p] >> a & 1) != 0;
            back[p][a] = stage.tau * (holds ? of_held * own[p][a] : 0.5 * of_group[p][a]);
        }
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::uint32_t p = body.part_of(k);
        Eigen::Map<Vec3> at(&ahead[4 * k]);
        if (rigid[p] == 0 && pins[p] == all_axes) {
            at = Eigen::Map<const Vec3>(&stage.began[4 * k]);
        } else {
            at -= back[p];
        }
    }
}

}  // namespace

void start_radial_forces(Stage& stage)
{
    const StepFrame& frame = stage.frame;
    const auto is_radial = [](const Force& f) { return f.kind == Force::Kind::radial; };
    stage.radial.clear();
    if (std::none_of(frame.forces.begin(), frame.forces.end(), is_radial)) return;
    stage.radial.assign(frame.n, 0);
    add_radial(frame.body, frame.forces, stage.began.data(), stage.radial);
    for (std::size_t i = 0; i < frame.n; ++i) stage.wind[i] += stage.radial[i];
}

void take_radial_on_way(Stage& stage, Aligned<double> ahead)
{
    if (stage.radial.empty() || stage.frame.options.leaps) return;
    if (stage.turns_start) set_back(stage, ahead);
    const Aligned<double> more = radial_beyond_stage(stage, ahead);
    for (std::size_t i = 0; i < more.size(); ++i) {
        stage.wind[i] += more[i];
        stage.radial[i] += more[i];
    }
}

Aligned<double> radial_beyond_stage(const Stage& stage, const Aligned<double>& x)
{
    Aligned<double> out = stage.radial;
    if (out.empty()) return out;
    for (double& force : out) force = -force;
    add_radial(stage.frame.body, stage.frame.forces, x.data(), out);
    return out;
}

}  // namespace physics
