#pragma once

// A check of Voxelize: whether open pieces that hold nothing by themselves, as the leaves of a
// tree, count as a solid together, because the rays that ask what is inside meet several of them.

#include "geometry/mesh/on_triangle.hpp"
#include "nodes/filled_shell.hpp"

#include <array>
#include <string>

namespace nodes {

// Whether a side of another piece is within `gap` (m) of a vertex. The faces of dense leaves are.
inline bool has_neighbour(const geometry::TriMesh& mesh, const geometry::Pieces& pieces,
                          const geometry::TriangleBvh& tree, std::uint32_t piece,
                          const geometry::Vec3& at, double gap)
{
    geometry::Box3f box;
    box.add(geometry::Vec3f((at.array() - gap).cast<float>()));
    box.add(geometry::Vec3f((at.array() + gap).cast<float>()));
    const std::vector<std::uint32_t> near = tree.triangles_in(box);
    return std::any_of(near.begin(), near.end(), [&](std::uint32_t t) {
        if (pieces.of[t] == piece) return false;
        std::array<geometry::Vec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = mesh.positions[mesh.triangles()[t][k]].cast<double>() - at;
        }
        const geometry::OnTriangle on = geometry::on_triangle(p[0], p[1], p[2]);
        const geometry::Vec3& b = on.barycentric;
        return on.feature != geometry::OnTriangle::face &&
               (b[0] * p[0] + b[1] * p[1] + b[2] * p[2]).norm() <= gap;
    });
}

// Whether the corners of most of these pieces are apart from all others, as those of leaves are and
// those of the tiles of a solid are not.
inline bool are_apart(const geometry::TriMesh& mesh, const geometry::Pieces& pieces,
                      const std::vector<std::uint32_t>& some)
{
    constexpr std::size_t looked_at = 500;  // pieces
    constexpr double narrow = 0.05;         // a gap, of the edge of a square as large as the piece
    const geometry::TriangleBvh tree(mesh);
    std::size_t apart = 0, count = 0;
    for (std::size_t i = 0; i < some.size(); i += (some.size() + looked_at - 1) / looked_at) {
        const std::uint32_t piece = some[i];
        for (const auto v : mesh.triangles()[pieces.first[piece]]) {
            const bool touches =
                has_neighbour(mesh, pieces, tree, piece, mesh.positions[v].cast<double>(),
                              narrow * std::sqrt(pieces.area[piece]));
            apart += touches ? 0 : 1, ++count;
        }
    }
    return 2 * apart > count;
}

struct FilledBetween {
    std::size_t pieces = 0;      // that hold nothing by themselves
    std::uint32_t triangle = 0;  // of the largest of them
    double volume = 0;           // m^3, that counts as inside between them
    double all = 0;              // m^3, that counts as inside of the mesh
    bool filled() const { return volume > 0; }
};

// Loose polygons whose gaps are narrow are a solid on purpose.
inline FilledBetween find_filled_between(const geometry::TriMesh& mesh, geometry::Inside rule)
{
    if (geometry::is_closed(mesh.triangles(), mesh.positions.size())) return {};
    constexpr double least_volume = 0.01;  // of area^1.5; a ball has 0.094
    constexpr double least_share = 0.1;    // of the inside of all pieces
    constexpr int resolution = 24;         // leaves are many, and only the share is asked for
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    std::vector<std::uint32_t> part(pieces.count(), 1), flat;
    FilledBetween out;
    for (const geometry::OpenPiece& open : geometry::open_pieces(mesh, pieces)) {
        const double area = pieces.area[open.piece];
        if (open.volume >= least_volume * std::pow(area, 1.5)) continue;
        if (flat.empty() || area > pieces.area[pieces.of[out.triangle]]) {
            out.triangle = pieces.first[open.piece];
        }
        flat.push_back(open.piece);
        part[open.piece] = 0;
    }
    if (flat.size() < 2 || !are_apart(mesh, pieces, flat)) return {};
    out.pieces = flat.size();
    out.all = geometry::volume_inside(mesh, rule, resolution);
    out.volume = geometry::volume_inside(two_parts(mesh, pieces, part)[0].mesh, rule, resolution);
    return out.volume > least_share * out.all ? out : FilledBetween{};
}

inline void warn_of_filled_between(const geometry::TriMesh& mesh, geometry::Inside rule,
                                   const graph::Context& context)
{
    if (!geometry::what_place_is_not_finite(mesh).empty()) return;
    const FilledBetween found = find_filled_between(mesh, rule);
    if (!found.filled()) return;
    const geometry::MeshTopology& topology = *mesh.topology;
    const std::size_t group =
        found.triangle < topology.group.size() ? topology.group[found.triangle] : 0;
    const std::string in = group < topology.groups.size()
                               ? fmt::format(" (the largest in '{}')", topology.groups[group])
                               : "";
    context.warn(fmt::format(
        "{} open pieces of the mesh{} hold nothing by themselves, but between them {:.2g} m^3 "
        "count as inside, of {:.2g} m^3 of the whole mesh. If they are leaves or other sheets, set "
        "pieces = each, or method = surface and its thickness",
        found.pieces, in, found.volume, found.all));
}

}  // namespace nodes
