#include "geometry/mesh/open_pieces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace geometry {
namespace {

using Edge = std::array<std::uint32_t, 2>;

// The edges of one triangle each, ascending.
std::vector<Edge> single_edges(const TriMesh& mesh)
{
    const std::vector<EdgeUse> uses = edge_uses(mesh.triangles(), mesh.positions.size());
    std::vector<Edge> out;
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
        while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
        if (end == i + 1) out.push_back({uses[i].a, uses[i].b});
    }
    return out;
}

std::size_t next_of(std::size_t i, std::size_t count)
{
    return i + 1 < count ? i + 1 : 0;
}

// Whether most of a rim's edges have one triangle only.
bool is_rim(std::span<const std::uint32_t> rim, const std::vector<Edge>& single)
{
    std::size_t found = 0;
    for (std::size_t i = 0; i < rim.size(); ++i) {
        const auto [a, b] = std::minmax(rim[i], rim[next_of(i, rim.size())]);
        found += std::binary_search(single.begin(), single.end(), Edge{a, b}) ? 1 : 0;
    }
    return 2 * found > rim.size();
}

// A fan of triangles that closes a hole.
struct Lid {
    Vec3 centre = Vec3::Zero();
    Vec3 normal = Vec3::Zero();  // m^2, as long as the lid is large; outward
    double volume = 0;           // m^3, of the cone from the apex to it, signed
};

Lid lid_of(const TriMesh& mesh, std::span<const std::uint32_t> rim, const Vec3& apex)
{
    Lid lid;
    double length = 0;
    const auto at = [&](std::size_t i) {
        return mesh.positions[rim[i % rim.size()]].cast<double>();
    };
    for (std::size_t i = 0; i < rim.size(); ++i) {
        const double side = (at(i + 1) - at(i)).norm();
        lid.centre += side * (at(i) + at(i + 1)) / 2;
        length += side;
    }
    if (length > 0) lid.centre /= length;
    for (std::size_t i = 0; i < rim.size(); ++i) {  // triangles run the rim one way, lids back
        const Vec3 a = at(i + 1) - lid.centre, b = at(i) - lid.centre;
        lid.normal += 0.5 * a.cross(b);
        lid.volume += (lid.centre - apex).dot(a.cross(b)) / 6;
    }
    return lid;
}

}  // namespace

std::vector<OpenPiece> open_pieces(const TriMesh& mesh, const Pieces& pieces)
{
    const std::vector<Edge> single = single_edges(mesh);
    if (single.empty()) return {};
    std::vector<std::uint32_t> piece_of(mesh.positions.size(), no_index);
    for (std::size_t t = 0; t < pieces.of.size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        for (const auto v : mesh.triangles()[t]) piece_of[v] = pieces.of[t];
    }
    std::vector<OpenPiece> all(pieces.count());
    std::vector<double> largest(pieces.count(), 0.0);
    for (const auto& rim : border_loops(mesh.triangles(), mesh.positions.size())) {
        const std::uint32_t piece = piece_of[rim.front()];
        if (piece == no_index || !is_rim(rim, single)) continue;
        const Vec3 apex = mesh.positions[mesh.triangles()[pieces.first[piece]][0]].cast<double>();
        const Lid lid = lid_of(mesh, rim, apex);
        const double area = lid.normal.norm();
        OpenPiece& open = all[piece];
        open.lids += area;
        open.volume += lid.volume;
        if (area <= largest[piece]) continue;
        largest[piece] = area;
        open.centre = lid.centre;
        open.across = 2 * std::sqrt(area / std::numbers::pi);
        for (std::size_t i = 0; i < open.half_way.size(); ++i) {
            const auto v = rim[i * rim.size() / open.half_way.size()];
            open.half_way[i] = (lid.centre + mesh.positions[v].cast<double>()) / 2;
        }
    }
    std::vector<OpenPiece> out;
    for (std::uint32_t p = 0; p < all.size(); ++p) {
        if (largest[p] == 0) continue;
        all[p].piece = p;
        all[p].volume = std::abs(all[p].volume + pieces.volume[p]);
        out.push_back(all[p]);
    }
    return out;
}

}  // namespace geometry
