#pragma once

// What is known before a cook of what Measure cannot tell, or tells amiss, of the node that its
// state comes from.

#include "graph/types/node_type.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>

namespace nodes::measure {

// Why the state of a simulation lacks a quantity, whatever its frame; empty where it may have it.
inline std::string not_of_simulation(std::string_view name, const graph::LinkedNode& source)
{
    if (source.input != "state" || source.type->name != "Simulate") return {};
    const std::string_view method = source.text("method");
    const bool of_pins = name.starts_with("reaction_");
    if (method == "lattice" && (of_pins || name == "contact_force")) {
        return fmt::format("method lattice knows no {}, and '{}' has it: bricks, springs and shell "
                           "know them",
                           of_pins ? "forces of pins" : "contact forces", source.node);
    }
    if (of_pins && !source.links("pins")) {
        return fmt::format(
            "'{}' has no pins whose force to measure: link a Pin to its input 'pins'", source.node);
    }
    if (name != "stress_max" && name != "elastic_energy") return {};
    if (method.empty() || method == "bricks") return {};
    return fmt::format("only method bricks knows {} of cubes, and '{}' has method {}",
                       name == "stress_max" ? "the stress" : "the elastic energy", source.node,
                       method);
}

inline std::string no_such_collider(std::string_view name, int collider,
                                    const graph::LinkedNode& source)
{
    if (name != "contact_force" || source.input != "state" || source.type->name != "Simulate") {
        return {};
    }
    const auto colliders = std::count(source.linked.begin(), source.linked.end(), "colliders");
    if (collider <= colliders) return {};
    return fmt::format("expected 0 to {}, as many colliders as '{}' has, found {}", colliders,
                       source.node, collider);
}

// Whether a node keeps all its bodies rigid.
inline bool all_rigid(const graph::LinkedNode& source)
{
    const graph::Bends& bends = source.type->bends;
    if (!bends.link) return false;
    const auto bodies = std::count(source.linked.begin(), source.linked.end(), bends.input);
    for (std::size_t k = 0; k < static_cast<std::size_t>(bodies); ++k) {
        if (bends.link(*source.params, k)) return false;
    }
    return bodies > 0;
}

// What a quantity of cubes is not for bodies that are rigid. A state does not say which are.
inline std::string of_rigid(std::string_view name, const graph::LinkedNode& source)
{
    if (name != "angular_momentum" && name != "moment_of_inertia") return {};
    if (source.input != "state" || !all_rigid(source)) return {};
    return fmt::format(
        "'{}' gives rigid bodies the inertia of their surfaces, and {} is by that of "
        "their cubes: it is off by what `accuracy` of these cubes says of the inertia "
        "(aspic card), which is less the smaller they are",
        source.node, name);
}

}  // namespace nodes::measure
