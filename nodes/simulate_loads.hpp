#pragma once

// Loads of one of several models as loads on all that Simulate moves.

#include "geometry/cubes/cubes.hpp"
#include "graph/types/node_builder.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/part_joint.hpp"
#include "physics/state/pressed_surface.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <vector>

namespace nodes::simulate {

// A pressure on the surface of one of them.
inline void place_surface(const std::vector<graph::Wire<geometry::Cubes>>& cubes,
                          const std::vector<physics::StateModel>& models, physics::Force& force)
{
    if (force.kind != physics::Force::Kind::pressure) return;
    const bool one = models.empty();
    if (one && physics::mark_of(*cubes.front()) == force.surface->cubes) return;
    for (const auto& model : models) {
        if (model.mark != force.surface->cubes) continue;
        force.first_corner = model.corner;
        return;
    }
    throw std::invalid_argument(fmt::format("a pressure is on other cubes than those that are "
                                            "simulated: link input `cubes` of Pressure "
                                            "to {}, as in Simulate",
                                            one ? "the same node" : "one of the same nodes"));
}

inline void place_joints(const std::vector<graph::Wire<geometry::Cubes>>& cubes,
                         const std::vector<physics::StateModel>& models,
                         const std::vector<graph::Wire<physics::PartJoint>>& joints,
                         physics::Loads& loads)
{
    for (const auto& joint : joints) {
        const auto points = physics::points_of_all(*joint, cubes, models);
        loads.joints.insert(loads.joints.end(), points.begin(), points.end());
    }
}

}  // namespace nodes::simulate
