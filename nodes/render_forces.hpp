#pragma once

// Linked forces as Render draws them: where the material that they act on is at this frame.

#include "nodes/render_inputs.hpp"
#include "physics/state/state_models.hpp"
#include "render/carried_force.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace nodes::render {

inline bool acts_at_rest_place(const physics::Force& force)
{
    using Kind = physics::Force::Kind;
    return force.kind == Kind::point || force.kind == Kind::torque;
}

// The corners of the cubes, or else the points of the first mesh that is like `rest`; none where
// neither is known to have moved.
inline std::optional<::render::CarriedPoints> carried_points(const Inputs& in)
{
    if (in.cubes && in.state && in.cubes->count() > 0) {
        return ::render::CarriedPoints{geometry::corner_positions(*in.cubes),
                                       physics::state_of(in.state, *in.cubes)->x};
    }
    if (!in.rest || in.rest->positions.empty()) return std::nullopt;
    const std::size_t points = in.rest->positions.size();
    const auto like = std::find_if(in.mesh.begin(), in.mesh.end(), [&](const auto& mesh) {
        return mesh->positions.size() == points;
    });
    if (like == in.mesh.end()) return std::nullopt;
    ::render::CarriedPoints out;
    for (const Vec3f& p : in.rest->positions) out.rest.push_back(p.cast<double>());
    for (const Vec3f& p : (*like)->positions) out.now.push_back(p.cast<double>());
    return out;
}

// The stage where nothing but forces is linked: what they reach, or a metre about the origin.
inline geometry::Box stage_of_forces(const std::vector<graph::Wire<physics::Force>>& forces)
{
    geometry::Box box;
    for (const auto& force : forces) {
        if (!acts_at_rest_place(*force) && force->kind != physics::Force::Kind::radial) continue;
        const Vec3 reach = Vec3::Constant(std::max(force->radius, 1e-3));
        box.add(force->position - reach), box.add(force->position + reach);
    }
    if (box.empty() && !forces.empty()) {
        box.add(Vec3::Constant(-0.5)), box.add(Vec3::Constant(0.5));
    }
    return box;
}

// Of a state of several bodies, forces far from these cubes stay: they act on others.
inline std::vector<graph::Wire<physics::Force>> forces_now(const Inputs& in)
{
    std::vector<graph::Wire<physics::Force>> out = in.forces;
    const bool any =
        std::any_of(out.begin(), out.end(), [](const auto& f) { return acts_at_rest_place(*f); });
    if (!in.show.forces || !any) return out;
    const auto points = carried_points(in);
    if (!points) return out;
    const bool by_cubes = in.cubes && in.state && in.cubes->count() > 0;
    for (auto& force : out) {
        if (!acts_at_rest_place(*force)) continue;
        const auto motion = by_cubes
                                ? ::render::motion_at(*in.cubes, *points, force->position,
                                                      force->radius, in.state->models.size() > 1)
                                : ::render::motion_at(*points, force->position, force->radius);
        if (!motion || !motion->matrix().allFinite()) continue;
        force = std::make_shared<const physics::Force>(::render::carried(*force, *motion));
    }
    return out;
}

}  // namespace nodes::render
