#include "physics/bricks/mean_forces.hpp"

#include "physics/body/plane_touch.hpp"
#include "physics/state/measure.hpp"

#include <utility>

namespace physics {
namespace {

void add(std::vector<Vec3>& sum, const std::vector<Vec3>& some, double share)
{
    sum.resize(some.size(), Vec3::Zero());
    for (std::size_t i = 0; i < some.size(); ++i) sum[i] += share * some[i];
}

}  // namespace

void add_pins(MeanForces& mean, const Stage& stage, const StepRecord& record,
              const Aligned<double>& x, double begin, double end)
{
    const double share = end - begin;
    add(mean.reaction, stage.frame.pin_paths.at_end(record.reaction, end), share);
    const HeldMatter& matter = stage.frame.loads.pins.matter;
    if (matter.cubes.empty()) return;
    std::vector<Vec3> off = stage.elasticity.targets(end);
    for (std::size_t i = 0; i < off.size(); ++i) {
        const std::size_t at = 4 * stage.frame.body.slot_of(matter.corner[i]);
        off[i] -= Vec3(x[at], x[at + 1], x[at + 2]);
    }
    add(mean.held, stage.elasticity.at_end(forces_of(matter, off), end), share);
}

namespace {

Grip force_alone(const Grip& of)
{
    Grip out;
    out.point = of.point, out.other = of.other;
    out.corners = of.corners;
    out.force = of.force;
    return out;
}

void add_forces(std::vector<Grip>& sum, const std::vector<Grip>& grips, double share)
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

void add_touches(MeanForces& mean, const Stage& stage, double begin, double end)
{
    add_forces(mean.grips, stage.grips, end - begin);
    add_forces(mean.holds, stage.held, end - begin);
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
    out.reserve(mean.size());
    auto grip = last.begin();
    for (const Grip& one : mean) {  // has all of the last step's
        if (grip != last.end() && !in_order(one, *grip)) {
            out.push_back(*grip++);
            out.back().force = one.force;
        } else if (!one.force.isZero(0)) {
            out.push_back(one);
        }
    }
    return out;
}

std::vector<Grip> without_those_gone(std::vector<Grip> grips)
{
    std::erase_if(grips, [](const Grip& grip) { return grip.normal.isZero(0); });
    return grips;
}

}  // namespace physics
