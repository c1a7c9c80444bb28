#include "physics/bricks/rigid_pins.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/bricks/joints.hpp"

#include <algorithm>

namespace physics {

using geometry::no_index;

Pins with_rigid_pins(const BricksBody& body, const Pins& pins, double dt,
                     std::span<const JointPoint> joints)
{
    constexpr double stiff = 1e4;  // of what stops the part within a step
    const CornerBody& base = body.base;
    const auto part_of = [&](std::uint32_t corner) { return base.part_of(base.slot_of(corner)); };
    if (base.rigid.empty() || pins.corner.empty()) return pins;
    std::vector<double> mass(base.parts, 0);
    for (std::size_t k = 0; k < base.corners; ++k) mass[base.part_of(k)] += base.mass[k];
    mass = masses_to_hold(base, joints, mass);
    std::vector<std::uint32_t> cube_of(base.corners, no_index);
    for (std::uint32_t c = 0; c < body.cubes; ++c) {
        for (const auto k : body.rest->corners[c]) cube_of[k] = c;
    }
    Pins out;
    out.cubes = pins.cubes;
    out.matter = pins.matter;
    if (out.matter.pivot.empty())
        out.matter.pivot.assign(out.matter.corner.size(), pivot_of({}, 0));
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const auto corner = pins.corner[p];
        const auto axes = held_axes(pins, p);
        if (base.rigid[part_of(corner)] == 0) {
            out.corner.push_back(corner);
            out.target.push_back(pins.target[p]);
            out.pivot.push_back(pivot_of(pins.pivot, p));
            if (!pins.axes.empty()) out.axes.push_back(axes);
            continue;
        }
        HeldCube held{.cube = cube_of[corner], .axes = axes};
        const auto& eight = body.rest->corners[held.cube];
        held.corner.fill(static_cast<std::uint32_t>(out.matter.corner.size()));
        out.matter.corner.push_back(corner);
        out.matter.target.push_back(pins.target[p]);
        out.matter.pivot.push_back(pivot_of(pins.pivot, p));
        for (std::size_t a = 0; a < 8; ++a) {  // nothing holds the other seven
            if (eight[a] != corner) continue;
            held.stiffness[a * (a + 1) / 2 + a] =
                static_cast<float>(stiff * mass[part_of(corner)] / (dt * dt));
        }
        out.matter.cubes.push_back(held);
    }
    return out;
}

PinForce rigid_pin_force(const State& state, const Pins& pins, const Vec3& point)
{
    PinForce out;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const auto at = [corner = pins.corner[p]](const Reaction& r) { return r.corner == corner; };
        if (std::any_of(state.reactions.begin(), state.reactions.end(), at)) continue;
        const auto held = std::find_if(state.held_forces.rbegin(), state.held_forces.rend(), at);
        if (held == state.held_forces.rend()) continue;
        Vec3 force = held->force.cast<double>();
        for (int a = 0; a < 3; ++a) {
            if ((held_axes(pins, p) >> a & 1) == 0) force[a] = 0;
        }
        out.force += force;
        out.torque += (state.x[held->corner] - point).cross(force);
        ++out.pins;
    }
    return out;
}

}  // namespace physics
