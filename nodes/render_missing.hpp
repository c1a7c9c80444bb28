#pragma once

// What Render says of colours that are asked for and not known.

#include "graph/types/context.hpp"
#include "nodes/render_things.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace nodes::render {

// Throws std::invalid_argument, with what to link, where displacements are asked for and none is
// known.
inline void require_displacement(const Inputs& in, const Coloured& coloured)
{
    const std::string& attribute = in.colour.attribute;
    const bool wanted =
        in.colour.by == ::render::Paint::By::attribute && attribute == "displacement";
    if (!wanted || in.mesh.empty() || any_has(coloured.meshes, attribute)) return;
    if (others_have(in, attribute)) return;
    if (!in.rest) {
        throw std::invalid_argument(
            "the mesh is to be coloured by `displacement`, and where it is at rest is not known: "
            "link the mesh at rest to `rest`, or name another attribute by colour.attribute");
    }
    throw std::invalid_argument(
        fmt::format("the mesh is to be coloured by `displacement` from `rest`, which has {} "
                    "vertices where the mesh has {}: link the same mesh at rest",
                    in.rest->positions.size(), in.mesh[0]->positions.size()));
}

// Warns where vertices' own colours are asked for and no mesh has any.
inline void warn_of_no_colours(const Inputs& in, const graph::Context& context)
{
    if (in.colour.by != ::render::Paint::By::vertex_colour || in.mesh.empty()) return;
    const bool any = std::any_of(in.mesh.begin(), in.mesh.end(),
                                 [](const auto& mesh) { return !mesh->colours.empty(); });
    if (any) return;
    context.warn("colour.by = vertex, and no linked mesh has colours of its vertices: they are "
                 "drawn in their materials");
}

}  // namespace nodes::render
