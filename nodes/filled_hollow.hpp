#pragma once

// A check of Voxelize: whether a closed piece of a mesh that lies in another one, and looks like a
// hollow of it, is filled, because the faces of both look out.

#include "geometry/cubes/assign_matter.hpp"
#include "geometry/mesh/nested_pieces.hpp"
#include "geometry/mesh/solid_faces.hpp"
#include "geometry/mesh/split.hpp"
#include "graph/types/context.hpp"
#include "nodes/large_cubes.hpp"

#include <fmt/format.h>

#include <cmath>

namespace nodes {

// "of material "inner", " where the faces of a mesh have several.
inline std::string material_text(const geometry::TriMesh& mesh, std::size_t face)
{
    const geometry::MeshTopology& topology = *mesh.topology;
    const std::size_t m = face < topology.material.size() ? topology.material[face] : 0;
    if (topology.materials.size() < 2 || m >= topology.materials.size()) return {};
    return "of material \"" + topology.materials[m].name + "\", ";
}

// A piece of another matter than the one around it, as a bone in flesh, is filled on purpose.
inline void warn_of_filled_hollow(const geometry::TriMesh& mesh, const geometry::FaceMatter& matter,
                                  geometry::Inside rule, const graph::Context& context)
{
    if (rule != geometry::Inside::winding || geometry::find_pieces(mesh).count() < 2) return;
    const geometry::SolidFaces solid = geometry::solid_faces(mesh);
    const geometry::TriMesh faces = geometry::mesh_of(mesh, solid);
    const geometry::Pieces pieces = geometry::find_pieces(faces);
    const auto source = [&](std::uint32_t piece) { return solid.source[pieces.first[piece]]; };
    std::size_t count = 0;
    std::uint32_t largest = 0;
    for (const geometry::NestedPiece& nested : geometry::nested_pieces(faces, pieces)) {
        if (!geometry::is_wound_as_around(pieces, nested)) continue;
        if (matter.of(source(nested.piece)) != matter.of(source(nested.around))) continue;
        if (count++ == 0 ||
            std::abs(pieces.volume[nested.piece]) > std::abs(pieces.volume[largest])) {
            largest = nested.piece;
        }
    }
    if (count == 0) return;
    geometry::Box box;
    for (std::size_t t = 0; t < pieces.of.size(); ++t) {
        if (pieces.of[t] != largest) continue;
        for (const auto v : faces.triangles()[t]) box.add(faces.positions[v].cast<double>());
    }
    const double across = (box.hi - box.lo).maxCoeff();
    const geometry::Vec3 middle = (0.5 * (box.lo + box.hi)).unaryExpr([&](double v) {
        return std::abs(v) < 1e-5 * across ? 0 : v;
    });
    const std::string about =
        fmt::format("{}{:.2g} m across, about {}", material_text(mesh, source(largest)), across,
                    place_text(middle));
    const std::string what =
        count == 1 ? fmt::format("a closed piece of the mesh ({}) lies", about)
                   : fmt::format("{} closed pieces of the mesh (the largest {}) lie", count, about);
    context.warn(what + " wholly within a larger one, and the faces of both look out: it is filled "
                        "there. For a hollow, set inside = parity, or let the inner faces look in");
}

}  // namespace nodes
