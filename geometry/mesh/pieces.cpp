#include "geometry/mesh/pieces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>

namespace geometry {
namespace {

// The area, volume and closure of each piece. A cone over the piece's first corner loses the fewest
// digits.
void measure_pieces(const TriMesh& mesh, Pieces& pieces)
{
    const std::vector<Triangle>& triangles = mesh.triangles();
    std::vector<Vec3> normals(pieces.count(), Vec3::Zero());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const std::uint32_t p = pieces.of[t];
        if (p == no_index) continue;
        const Vec3 apex = mesh.positions[triangles[pieces.first[p]][0]].cast<double>();
        const Vec3 a = mesh.positions[triangles[t][0]].cast<double>() - apex,
                   b = mesh.positions[triangles[t][1]].cast<double>() - apex,
                   c = mesh.positions[triangles[t][2]].cast<double>() - apex;
        const Vec3 normal = 0.5 * (b - a).cross(c - a);
        normals[p] += normal;
        pieces.area[p] += normal.norm();
        pieces.volume[p] += a.dot(b.cross(c)) / 6;
    }
    constexpr double closure = 0.01;  // of its area: a small hole leaves an inside
    for (std::size_t p = 0; p < pieces.count(); ++p) {
        pieces.encloses[p] = normals[p].norm() <= closure * pieces.area[p] ? 1 : 0;
    }
}

}  // namespace

bool is_finite(const TriMesh& mesh, const Triangle& t)
{
    return std::max({t[0], t[1], t[2]}) < mesh.positions.size() &&
           std::all_of(t.begin(), t.end(),
                       [&](std::uint32_t v) { return mesh.positions[v].allFinite(); });
}

Pieces find_pieces(const TriMesh& mesh)
{
    const std::vector<Triangle>& triangles = mesh.triangles();
    UnionFind sets(mesh.positions.size());
    Pieces pieces;
    pieces.of.assign(triangles.size(), no_index);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        if (!is_finite(mesh, triangles[t])) continue;
        pieces.of[t] = 0;
        sets.join(triangles[t][0], triangles[t][1]);
        sets.join(triangles[t][0], triangles[t][2]);
    }
    std::vector<std::uint32_t> number(mesh.positions.size(), no_index);
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        std::uint32_t& piece = number[sets.root(triangles[t][0])];
        if (piece == no_index) {
            piece = static_cast<std::uint32_t>(pieces.count());
            pieces.first.push_back(t);
        }
        pieces.of[t] = piece;
    }
    pieces.area.assign(pieces.count(), 0.0);
    pieces.volume.assign(pieces.count(), 0.0);
    pieces.encloses.assign(pieces.count(), 0);
    measure_pieces(mesh, pieces);
    return pieces;
}

std::vector<std::uint32_t> first_vertices(const TriMesh& mesh)
{
    UnionFind sets(mesh.positions.size());
    for (const auto& [a, b, c] : mesh.triangles()) {
        if (std::max({a, b, c}) >= mesh.positions.size()) continue;
        sets.join(a, b);
        sets.join(a, c);
    }
    return sets.roots();
}

}  // namespace geometry
