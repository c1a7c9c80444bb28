#include "physics/body/closed_shape.hpp"

#include "geometry/base/union_find.hpp"
#include "geometry/embed/bind.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/pieces.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "physics/body/halved_triangle.hpp"
#include "physics/body/mesh_of_some.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::Triangle;
using geometry::TriMesh;
using geometry::Vec3;

// A face of a cube by its corners, and which cube's.
struct CubeFace {
    std::array<std::uint32_t, 4> key;   // corners, ascending
    std::array<std::uint32_t, 4> loop;  // corners, counter-clockwise seen from outside
};

CubeFace face_of(const std::array<std::uint32_t, 8>& corners, unsigned axis, unsigned side)
{
    const unsigned u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, base = side << axis;
    CubeFace face{};
    face.loop = {corners[base], corners[base + u], corners[base + u + v], corners[base + v]};
    if (side == 0) std::swap(face.loop[1], face.loop[3]);
    face.key = face.loop;
    std::sort(face.key.begin(), face.key.end());
    return face;
}

// An edge that triangles run more often one way than the other, as the one way goes.
struct RimEdge {
    std::uint32_t from = 0, to = 0;
    std::uint32_t triangle = 0;  // one of them
};

std::vector<RimEdge> rim_edges(const TriMesh& mesh)
{
    std::vector<RimEdge> out;
    const auto uses = geometry::edge_uses(mesh.triangles(), mesh.positions.size());
    for (auto at = uses.begin(); at != uses.end();) {
        std::ptrdiff_t more = 0;  // forward than back
        auto end = at;
        for (; end != uses.end() && end->a == at->a && end->b == at->b; ++end) {
            more += end->forward ? 1 : -1;
        }
        const RimEdge edge =
            more > 0 ? RimEdge{at->a, at->b, at->triangle} : RimEdge{at->b, at->a, at->triangle};
        out.insert(out.end(), std::size_t(std::abs(more)), edge);
        at = end;
    }
    return out;
}

// A hole: rim edges that hang together.
struct Hole {
    Vec3 middle = Vec3::Zero();  // m, the mean of its vertices
    Vec3 area = Vec3::Zero();    // m^2, of what would fill it: 1/2 the sum of p x q along the rim
    double edges = 0;
    std::uint32_t triangle = 0;  // one of those at its rim
    std::uint32_t tip = 0;       // vertex over which it is capped
};

struct Holes {
    std::vector<Hole> hole;
    std::vector<std::uint32_t> of;  // of each rim edge
};

Holes find_holes(const TriMesh& mesh, const std::vector<RimEdge>& rims)
{
    geometry::UnionFind sets(mesh.positions.size());
    for (const RimEdge& edge : rims) sets.join(edge.from, edge.to);
    std::map<std::uint32_t, std::uint32_t> number;
    Holes out;
    const auto at = [&](std::uint32_t v) { return Vec3(mesh.positions[v].cast<double>()); };
    for (const RimEdge& edge : rims) {
        const auto [found, fresh] =
            number.try_emplace(sets.root(edge.from), static_cast<std::uint32_t>(out.hole.size()));
        if (fresh) out.hole.emplace_back().triangle = edge.triangle;
        Hole& hole = out.hole[found->second];
        hole.middle += at(edge.from);
        hole.edges += 1;
        out.of.push_back(found->second);
    }
    for (Hole& hole : out.hole) hole.middle /= hole.edges;
    for (std::size_t i = 0; i < rims.size(); ++i) {
        Hole& hole = out.hole[out.of[i]];
        hole.area += (at(rims[i].from) - hole.middle).cross(at(rims[i].to) - hole.middle) / 2;
    }
    return out;
}

// Of each triangle, whether its piece has no inside: it has no volume, or holes that are large.
std::vector<std::uint8_t> open_triangles(const TriMesh& mesh, const std::vector<RimEdge>& rims)
{
    constexpr double least = 1e-6;  // of the volume of a ball of its area, about
    constexpr double small = 0.05;  // of the area; of a box, a lid is a fifth
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    std::vector<double> holes(pieces.count(), 0);  // m^2
    for (const Hole& hole : find_holes(mesh, rims).hole) {
        const std::uint32_t p = pieces.of[hole.triangle];
        if (p != geometry::no_index) holes[p] += hole.area.norm();
    }
    std::vector<std::uint8_t> open, out;
    for (std::size_t p = 0; p < pieces.count(); ++p) {
        const double area = pieces.area[p];
        const bool flat = !(std::abs(pieces.volume[p]) > least * std::pow(area, 1.5));
        open.push_back(flat || holes[p] > small * area ? 1 : 0);
    }
    for (const auto p : pieces.of) out.push_back(p == geometry::no_index ? 1 : open[p]);
    return out;
}

// The mesh with a cone over each of its holes.
TriMesh capped(TriMesh mesh)
{
    const std::vector<RimEdge> rims = rim_edges(mesh);
    if (rims.empty()) return mesh;
    Holes holes = find_holes(mesh, rims);
    for (Hole& hole : holes.hole) {
        hole.tip = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(hole.middle.cast<float>());
    }
    geometry::MeshTopology topology;
    topology.triangles = mesh.triangles();
    for (std::size_t i = 0; i < rims.size(); ++i) {
        topology.triangles.push_back({rims[i].to, rims[i].from, holes.hole[holes.of[i]].tip});
    }
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return mesh;
}

// Adds the middles of the parts of a triangle that is cut in two along its longest side until that
// is no longer than `longest`, and their area.
void add_middles(const std::array<Vec3, 3>& t, double longest, std::vector<geometry::Vec3f>& middle,
                 std::vector<double>& area)
{
    const HalvedTriangle halved(t);
    if (halved.longest > longest) {
        add_middles(halved.first, longest, middle, area);
        add_middles(halved.second, longest, middle, area);
        return;
    }
    const Vec3 &p = halved.first[0], &q = halved.second[1], &r = halved.first[2];
    middle.push_back(((p + q + r) / 3).cast<float>());
    area.push_back((q - p).cross(r - p).norm() / 2);
}

// For each of the cubes `of`: the area of closed pieces in it less that of open ones, m^2.
std::vector<double> closed_area(const TriMesh& mesh, const std::vector<std::uint8_t>& open,
                                const Cubes& cubes, std::span<const std::uint32_t> of)
{
    TriMesh middles;
    std::vector<double> area;
    for (std::size_t t = 0; t < open.size(); ++t) {
        const Triangle& v = mesh.triangles()[t];
        const std::size_t first = area.size();
        add_middles({mesh.positions[v[0]].cast<double>(), mesh.positions[v[1]].cast<double>(),
                     mesh.positions[v[2]].cast<double>()},
                    0.5 * cubes.size, middles.positions, area);
        if (open[t] == 0) continue;
        for (std::size_t i = first; i < area.size(); ++i) area[i] *= -1;
    }
    std::vector<double> out(of.size(), 0);
    geometry::MeshTopology joined;  // all go with one body of the cubes
    for (std::uint32_t i = 1; i < area.size(); ++i) joined.triangles.push_back({i - 1, i, i});
    if (!cubes.part.empty()) {
        middles.topology = std::make_shared<const geometry::MeshTopology>(std::move(joined));
    }
    const geometry::Binding binding = geometry::bind(middles, cubes);
    for (std::size_t i = 0; i < area.size(); ++i) {
        const std::uint32_t cube = binding.used[binding.cube[i]];
        const auto at = std::lower_bound(of.begin(), of.end(), cube);
        if (at != of.end() && *at == cube) out[std::size_t(at - of.begin())] += area[i];
    }
    return out;
}

}  // namespace

TriMesh outside_of(const Cubes& cubes, std::span<const std::uint32_t> of)
{
    std::vector<CubeFace> faces;
    faces.reserve(6 * of.size());
    for (const auto c : of) {
        for (unsigned f = 0; f < 6; ++f) faces.push_back(face_of(cubes.corners[c], f / 2, f % 2));
    }
    const auto less = [](const CubeFace& a, const CubeFace& b) { return a.key < b.key; };
    std::stable_sort(faces.begin(), faces.end(), less);
    MeshOfSome mesh(cubes.corner_count());
    const auto at = [&](std::uint32_t k) {
        return geometry::Vec3f(cubes.corner_position(k).cast<float>());
    };
    for (std::size_t i = 0; i < faces.size();) {
        std::size_t end = i + 1;
        while (end < faces.size() && faces[end].key == faces[i].key) ++end;
        const auto& l = faces[i].loop;
        if (end == i + 1) {
            mesh.add({l[0], l[1], l[2]}, at);
            mesh.add({l[0], l[2], l[3]}, at);
        }
        i = end;
    }
    return mesh.take();
}

TriMesh closed_shape(TriMesh mesh, const Cubes& cubes, std::span<const std::uint32_t> of)
{
    const std::vector<RimEdge> rims = rim_edges(mesh);
    const std::vector<std::uint8_t> open = open_triangles(mesh, rims);
    const auto opens = std::count(open.begin(), open.end(), 1);
    if (opens == std::ptrdiff_t(open.size())) return outside_of(cubes, of);
    if (opens == 0) return capped(std::move(mesh));
    MeshOfSome some(mesh.positions.size());
    for (std::size_t t = 0; t < open.size(); ++t) {
        if (open[t] != 0) continue;
        some.add(mesh.triangles()[t], [&](std::uint32_t v) { return mesh.positions[v]; });
    }
    const TriMesh closed = capped(some.take());
    const geometry::TriangleBvh tree(closed);
    const std::vector<double> balance = closed_area(mesh, open, cubes, of);
    std::vector<std::uint32_t> rest;
    for (std::size_t i = 0; i < of.size(); ++i) {
        const Vec3 middle =
            cubes.origin + cubes.size * (cubes.cell[of[i]].cast<double>() + Vec3::Constant(0.5));
        if (balance[i] < 0 || (balance[i] == 0 && !tree.inside(middle))) rest.push_back(of[i]);
    }
    const TriMesh others = outside_of(cubes, rest);
    return geometry::merge(std::array{&closed, &others});
}

}  // namespace physics
