#pragma once

#include "geometry/mesh_edges.hpp"
#include "geometry/sample_volume.hpp"
#include "graph/context.hpp"

#include <fmt/format.h>

namespace nodes {

// Warns when faces that share an edge disagree on what is outside, and what is inside by their
// orientation is notably less than by the number of faces crossed.
inline void warn_of_disagreeing_faces(const geometry::TriMesh& mesh, geometry::Inside rule,
                                      const graph::Context& context)
{
    if (rule != geometry::Inside::winding) return;
    const std::size_t edges = geometry::disagreeing_edges(mesh.triangles(), mesh.positions.size());
    if (edges == 0) return;
    const double found = geometry::volume_inside(mesh, rule),
                 all = geometry::volume_inside(mesh, geometry::Inside::parity);
    if (found > 0.98 * all) return;
    context.warn(fmt::format(
        "the faces on the two sides of {} edge{} disagree on what is outside, so that {:.3g} of "
        "{:.3g} m^3 count as inside; set inside to \"parity\", for which faces need not agree",
        edges, edges == 1 ? "" : "s", found, all));
}

}  // namespace nodes
