#pragma once

// A check that Sample and Voxelize share: whether the faces of a mesh agree on what is inside of
// it, once they are turned as far as can be (geometry/mesh/solid_faces.hpp).

#include "geometry/cubes/sample_volume.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/solid_faces.hpp"
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
    const auto closed = [&](const std::vector<geometry::Triangle>& faces) {
        return geometry::is_closed(faces, mesh.positions.size());
    };
    if (rule != geometry::Inside::winding || closed(mesh.triangles())) return {};
    const auto faces = geometry::solid_faces(mesh).triangles;
    const std::size_t edges = geometry::crowded_edges(faces, mesh.positions.size());
    if (edges == 0 || closed(faces)) return {};
    const double found = geometry::volume_inside(mesh, rule),
                 all = geometry::volume_inside(mesh, geometry::Inside::parity);
    if (!(found < 0.98 * all)) return {};
    return {1 - found / all,
            fmt::format("more than two faces meet at {} edge{}, so that it is not known which way "
                        "those beyond look, and only {:.3g} of {:.3g} m^3 count as inside: set "
                        "inside = parity, which ignores orientation",
                        edges, edges == 1 ? "" : "s", found, all)};
}

// Warns if more than two faces meet at an edge, so that some could not be turned to look out, and
// the enclosed volume by orientation (winding) is more than 2 % smaller than by the number of faces
// crossed (parity).
inline void warn_of_disagreeing_faces(const geometry::TriMesh& mesh, geometry::Inside rule,
                                      const graph::Context& context)
{
    if (const LostInside lost = lost_inside(mesh, rule); !lost.text.empty()) {
        context.warn(lost.text);
    }
}

}  // namespace nodes
