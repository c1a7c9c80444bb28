#pragma once

// A check that Sample and Voxelize share: whether the orientation of a mesh's faces is consistent
// enough to decide what is inside of it.

#include "geometry/cubes/sample_volume.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "graph/types/context.hpp"

#include <fmt/format.h>

namespace nodes {

// What is lost of a mesh's inside where its faces disagree on what is outside.
struct LostInside {
    double share = 0;  // of the volume by the number of faces crossed (parity)
    std::string text;  // a warning; empty where at most 2 % are lost
};
inline LostInside lost_inside(const geometry::TriMesh& mesh, geometry::Inside rule)
{
    if (rule != geometry::Inside::winding) return {};
    const std::size_t edges = geometry::disagreeing_edges(mesh.triangles(), mesh.positions.size());
    if (edges == 0) return {};
    const double found = geometry::volume_inside(mesh, rule),
                 all = geometry::volume_inside(mesh, geometry::Inside::parity);
    if (found > 0.98 * all) return {};
    return {1 - found / all,
            fmt::format("the faces at {} edge{} have opposite orientations, so only {:.3g} of "
                        "{:.3g} m^3 count as inside: set inside = parity, which ignores "
                        "orientation",
                        edges, edges == 1 ? "" : "s", found, all)};
}

// Warns if faces that share an edge have opposite orientations and the enclosed volume by
// orientation (winding) is more than 2 % smaller than by the number of faces crossed (parity).
inline void warn_of_disagreeing_faces(const geometry::TriMesh& mesh, geometry::Inside rule,
                                      const graph::Context& context)
{
    if (const LostInside lost = lost_inside(mesh, rule); !lost.text.empty()) {
        context.warn(lost.text);
    }
}

}  // namespace nodes
