#include "physics/bricks/mean_forces.hpp"

#include "physics/body/plane_touch.hpp"
#include "physics/state/measure.hpp"

#include <algorithm>

namespace physics {
namespace {

void add(std::vector<Vec3>& sum, const std::vector<Vec3>& some, double share)
{
    sum.resize(std::max(sum.size(), some.size()), Vec3::Zero());
    for (std::size_t i = 0; i < some.size(); ++i) sum[i] += share * some[i];
}

Grip force_alone(const Grip& of)
{
    Grip out;
    out.point = of.point, out.other = of.other;
    out.corners = of.corners;
    out.force = of.force;
    return out;
}

void add(std::vector<Grip>& sum, const std::vector<Grip>& grips, double share)
{
    std::vector<Grip> out;
    out.reserve(sum.size() + grips.size());
    auto old = sum.begin();
    for (const Grip& grip : grips) {
        while (old != sum.end() && in_order(*old, grip)) out.push_back(*old++);
        out.push_back(force_alone(grip));
        out.back().force *= static_cast<float>(share);
        if (old != sum.end() && !in_order(grip, *old)) out.back().force += (old++)->force;
    }
    out.insert(out.end(), old, sum.end());
    sum.swap(out);
}

}  // namespace

MeanForces forces_of_pins(const Stage& stage, const StepRecord& record, const Aligned<double>& x)
{
    MeanForces out;
    out.reaction = stage.frame.pin_paths.at_end(record.reaction, stage.share);
    const HeldMatter& matter = stage.frame.loads.pins.matter;
    if (matter.cubes.empty()) return out;
    std::vector<Vec3> off = stage.elasticity.targets(stage.share);
    for (std::size_t i = 0; i < off.size(); ++i) {
        const std::size_t at = 4 * stage.frame.body.slot_of(matter.corner[i]);
        off[i] -= Vec3(x[at], x[at + 1], x[at + 2]);
    }
    out.held = stage.elasticity.at_end(forces_of(matter, off), stage.share);
    return out;
}

MeanForces forces_of_stage(const Stage& stage, const StepRecord& record)
{
    MeanForces out = forces_of_pins(stage, record, stage.x);
    const Aligned<double>& x0 = stage.rigid.none() ? stage.x0 : stage.began;
    const StepEnd at{x0.data(), stage.x.data(), stage.tau};
    out.grips = grips_of(stage.touches, at);
    out.holds = grips_of(stage.holds, at);
    return out;
}

void add_share(MeanForces& mean, const MeanForces& some, double share)
{
    add(mean.reaction, some.reaction, share);
    add(mean.held, some.held, share);
    add(mean.grips, some.grips, share);
    add(mean.holds, some.holds, share);
}

void tell_pins(const MeanForces& mean, const Pins& pins, State& state)
{
    state.reactions.clear();
    for (std::size_t p = 0; p < mean.reaction.size(); ++p) {
        state.reactions.push_back({pins.corner[p], mean.reaction[p].cast<float>()});
    }
    const HeldMatter& matter = pins.matter;
    state.held.clear();
    state.held_forces.clear();
    if (matter.cubes.empty()) return;
    state.held = matter.target;
    std::vector<Vec3> forces = mean.held;
    forces.resize(matter.corner.size(), Vec3::Zero());
    for (std::size_t i = 0; i < forces.size(); ++i) {
        state.held_forces.push_back({matter.corner[i], forces[i].cast<float>()});
    }
}

std::vector<Grip> with_mean(std::vector<Grip> last, const std::vector<Grip>& mean)
{
    std::vector<Grip> out;
    out.reserve(last.size() + mean.size());
    auto one = mean.begin();
    const auto keep_those_before = [&](const auto& is_before) {
        for (; one != mean.end() && is_before(*one); ++one) {
            if (!one->force.isZero(0)) out.push_back(*one);
        }
    };
    for (Grip& grip : last) {
        keep_those_before([&](const Grip& of) { return in_order(of, grip); });
        const bool pushed = one != mean.end() && !in_order(grip, *one);
        grip.force = pushed ? (one++)->force : Eigen::Vector3f(Eigen::Vector3f::Zero());
        out.push_back(grip);
    }
    keep_those_before([](const Grip&) { return true; });
    return out;
}

std::vector<Grip> without_those_gone(std::vector<Grip> grips)
{
    std::erase_if(grips, [](const Grip& grip) { return grip.normal.isZero(0); });
    return grips;
}

}  // namespace physics
