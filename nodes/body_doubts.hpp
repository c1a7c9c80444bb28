#pragma once

// What Voxelize doubts of the bodies that it makes: that they are as many as was meant, and that
// their stiffness is in the right unit.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/welded_groups.hpp"
#include "graph/types/context.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace nodes {

// Each piece is a body, but what one file holds as closed objects is one where they touch.
inline void warn_of_welded_groups(const geometry::TriMesh& mesh, const graph::Context& context)
{
    const geometry::WeldedGroups welded = geometry::find_welded_groups(mesh);
    if (welded.groups == 0) return;
    context.warn(fmt::format(
        "{} groups, each closed in itself, share vertices where they touch and make {} bod{}: set "
        "weld = groups in ReadMesh to have each of them as a body",
        welded.groups, welded.pieces, welded.pieces == 1 ? "y" : "ies"));
}

inline void warn_of_joined_groups(const geometry::TriMesh& mesh, std::size_t bodies,
                                  const graph::Context& context)
{
    std::vector<std::uint16_t> used = mesh.topology->group;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    if (bodies >= used.size()) return;
    context.warn(fmt::format(
        "{} groups make {} bod{}: groups that share vertices are one body, as those of one "
        "file do where they meet. Set weld = groups in ReadMesh, or make them by Copies with "
        "number_groups",
        used.size(), bodies, bodies == 1 ? "y" : "ies"));
}

// No solid is so soft, nor so stiff: what was typed is in another unit more often.
inline void warn_of_odd_young(const geometry::Cubes& cubes, const graph::Context& context)
{
    constexpr double softest = 100, stiffest = 1e13;  // Pa
    if (cubes.young.empty()) return;
    const auto [least, most] = std::minmax_element(cubes.young.begin(), cubes.young.end());
    if (*least >= softest && *most <= stiffest) return;
    const bool soft = *least < softest;
    context.warn(
        fmt::format("Young's modulus is {:.3g} Pa, {}: is it meant in another unit? `young` "
                    "is in Pa: 1 MPa is 1e6, 1 GPa is 1e9",
                    soft ? *least : *most,
                    soft ? "less than any solid has (jelly 10,000 Pa)"
                         : "more than any solid has (diamond 1e12 Pa)"));
}

}  // namespace nodes
