#pragma once

// Checks of open meshes that Voxelize and Sample fill: whether one is a shell with an opening, as a
// bowl is, that is filled up to its rim, or has too few faces to be filled at all. Small holes,
// which models of solids often have, are filled on purpose.

#include "geometry/cubes/sample_volume.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/open_pieces.hpp"
#include "geometry/mesh/solid_faces.hpp"
#include "geometry/mesh/split.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "graph/types/context.hpp"
#include "nodes/large_cubes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace nodes {

// Two meshes: of the pieces p with part[p] = 0, and of those with part[p] = 1.
inline std::vector<geometry::SplitMesh> two_parts(const geometry::TriMesh& mesh,
                                                  const geometry::Pieces& pieces,
                                                  const std::vector<std::uint32_t>& part)
{
    std::vector<std::uint32_t> of(pieces.of.size(), 1);
    for (std::size_t t = 0; t < of.size(); ++t) {
        if (pieces.of[t] < part.size()) of[t] = part[pieces.of[t]];
    }
    return geometry::split(mesh, of, 2);
}

struct FilledShell {
    double volume = 0;  // m^3, that the filling takes for the inside of open pieces
    double across = 0;  // m, of the largest hole
    geometry::Vec3 where{0, 0, 0};
    bool filled() const { return volume > 0; }
};

// Whether something lies before most of a piece's largest hole, by its middle and places around
// that: a pole may pass through the middle of a lampshade's. In a bare hole the winding number is a
// half, below a lid or within another part it is not.
inline bool is_covered(const geometry::OpenPiece& open, const geometry::TriangleBvh& tree)
{
    const auto covered = [&](const geometry::Vec3& at) {
        return std::abs(std::abs(tree.winding_number(at)) - 0.5) > 0.25;
    };
    const auto around = std::count_if(open.half_way.begin(), open.half_way.end(), covered);
    return 2 * (around + (covered(open.centre) ? 1 : 0)) > std::ssize(open.half_way) + 1;
}

// Open pieces whose holes are a twentieth of their faces or more (a fiftieth where faces have a
// thickness, m, as shells do); that hold something, as flat sheets do not; and whose largest hole
// nothing covers.
inline FilledShell find_filled_shell(const geometry::TriMesh& mesh, geometry::Inside rule,
                                     double thickness)
{
    if (geometry::is_closed(mesh.triangles(), mesh.positions.size())) return {};
    const double least_hole = thickness > 0 ? 0.02 : 0.05;
    constexpr double least_volume = 0.01;  // of area^1.5; a ball has 0.094
    constexpr double least_filled = 0.1;   // of what it holds
    constexpr double least_share = 0.1;  // of the inside of all pieces: a cable's ends are nothing
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    FilledShell out;
    double area = 0, held = 0;
    geometry::TriangleBvh tree;
    std::vector<std::uint32_t> part(pieces.count(), 1);
    for (const geometry::OpenPiece& open : geometry::open_pieces(mesh, pieces)) {
        const double faces = pieces.area[open.piece];
        if (open.lids < least_hole * faces || open.volume < least_volume * std::pow(faces, 1.5)) {
            continue;
        }
        if (tree.triangle_count() == 0) tree = geometry::TriangleBvh(mesh);
        if (rule == geometry::Inside::winding && is_covered(open, tree)) continue;
        part[open.piece] = 0;
        area += faces, held += open.volume;
        if (open.across <= out.across) continue;
        out.across = open.across;
        out.where = open.centre.unaryExpr(
            [&](double v) { return std::abs(v) < 1e-5 * open.across ? 0 : v; });
    }
    if (held == 0) return {};
    const double filled = geometry::volume_inside(two_parts(mesh, pieces, part)[0].mesh, rule);
    if (filled <= std::max(least_filled * held, thickness * area)) return {};
    const bool all = std::find(part.begin(), part.end(), 1u) == part.end();
    if (!all && filled < least_share * geometry::volume_inside(mesh, rule)) return {};
    out.volume = filled;
    return out;
}

// Open pieces of which next to nothing is inside, though they would hold much with their holes
// closed: too little is left of them for the winding number to pass a half. Closed pieces have an
// inside of their own, and what lies in one is not lost.
struct LostSolid {
    double inside = 0, held = 0;  // m^3, of open pieces: as they are, and with their holes closed
    double across = 0;            // m, of the largest hole
    geometry::Vec3 where{0, 0, 0};
    bool lost() const { return held > 0; }
};

inline LostSolid find_lost_solid(const geometry::TriMesh& mesh, geometry::Inside rule)
{
    constexpr double least_volume = 0.01;  // of area^1.5; a ball has 0.094
    constexpr double least_inside = 0.1;   // of what it would hold
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    const std::vector<geometry::OpenPiece> open_ones = geometry::open_pieces(mesh, pieces);
    std::vector<std::uint32_t> part(pieces.count(), 1);
    for (const geometry::OpenPiece& open : open_ones) part[open.piece] = 0;
    const std::vector<geometry::SplitMesh> parts = two_parts(mesh, pieces, part);
    const geometry::TriangleBvh closed(parts[1].mesh);
    LostSolid out;
    for (const geometry::OpenPiece& open : open_ones) {
        if (open.volume < least_volume * std::pow(pieces.area[open.piece], 1.5)) continue;
        if (closed.triangle_count() > 0 && std::abs(closed.winding_number(open.centre)) > 0.5) {
            continue;
        }
        out.held += open.volume;
        if (open.across <= out.across) continue;
        out.across = open.across;
        out.where = open.centre.unaryExpr(
            [&](double v) { return std::abs(v) < 1e-5 * open.across ? 0 : v; });
    }
    if (out.held == 0) return {};
    out.inside = geometry::volume_inside(parts[0].mesh, rule);
    return out.inside < least_inside * out.held ? out : LostSolid{};
}

// Faces of vertices that are not finite are holes.
inline void warn_of_lost_solid(const geometry::TriMesh& mesh, geometry::Inside rule,
                               const char* fill, const char* instead, const graph::Context& context)
{
    const bool finite = geometry::what_place_is_not_finite(mesh).empty();
    if (finite && geometry::is_closed(mesh.triangles(), mesh.positions.size())) return;
    const LostSolid found =
        find_lost_solid(finite ? mesh : geometry::mesh_of(mesh, geometry::solid_faces(mesh)), rule);
    if (!found.lost()) return;
    context.warn(fmt::format(
        "the mesh is so open that {} finds almost no inside: {:.2g} m^3 of the {:.2g} m^3 that "
        "it would hold with its holes closed (one {:.2g} m across is at {}). The body is as much "
        "too light: close the holes in the mesh, or set {} and its thickness",
        fill, found.inside, found.held, found.across, place_text(found.where), instead));
}

// `rule`: how inside is decided, `fill`: the setting that fills, `instead`: what to set for a
// shell.
inline void warn_of_filled_shell(const geometry::TriMesh& mesh, geometry::Inside rule,
                                 double thickness, const char* fill, const char* instead,
                                 const graph::Context& context)
{
    const FilledShell shell = find_filled_shell(mesh, rule, thickness);
    if (!shell.filled()) {
        if (thickness <= 0) warn_of_lost_solid(mesh, rule, fill, instead, context);
        return;
    }
    context.warn(fmt::format(
        "the mesh is open: a hole {:.2g} m across at {}. {} fills it up to the rim "
        "({:.2g} m^3){}. If it is a shell, as a bowl is, set {}{}; if it is solid, "
        "close the hole in the mesh",
        shell.across, place_text(shell.where), fill, shell.volume,
        thickness > 0
            ? fmt::format(", although thickness = {:.3g} m says that it is a shell", thickness)
            : "",
        instead, thickness > 0 ? "" : " and its thickness"));
}

}  // namespace nodes
