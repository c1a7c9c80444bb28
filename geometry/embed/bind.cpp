#include "geometry/embed/bind.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/cubes/body_finder.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace geometry {
namespace {

constexpr double inside_slack = 1e-3;  // of a cube
constexpr double own_reach = 1;        // cubes, see nearest_of_body()
constexpr std::size_t bound_a_task = 8192;

// Finds the cube nearest to a place in lattice coordinates.
class NearestCubes {
public:
    explicit NearestCubes(const Cubes& cubes)
    {
        std::vector<Box3f> boxes;
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const Box held = held_box(cubes, c);
            boxes.push_back({held.lo.cast<float>(), held.hi.cast<float>()});
        }
        tree_ = build_box_tree(boxes);
        for (const std::uint32_t i : tree_.items) boxes_.push_back(boxes[i]);
        cube_ = tree_.items;
        std::iota(tree_.items.begin(), tree_.items.end(), 0u);
    }

    // Its number, and its distance in cubes, of those that `counts(cube)`. Infinity: there are
    // none.
    template <class Counts>
    std::pair<std::uint32_t, double> find(const Vec3& at, const Counts& counts) const
    {
        double best_sq = std::numeric_limits<double>::infinity();
        std::uint32_t best = 0;
        tree_.nearest(at, best_sq, [&](std::uint32_t i, double& sq) {
            const double d_sq = boxes_[i].distance_sq(at);
            if (d_sq < sq && counts(cube_[i])) sq = d_sq, best = cube_[i];
        });
        return {best, std::sqrt(best_sq)};
    }

private:
    BoxTree tree_;
    std::vector<Box3f> boxes_;         // in the tree's order
    std::vector<std::uint32_t> cube_;  // the same
};

// A place over or under a plane as one in it, for a plane across the axis `flat`.
Vec3 flattened(Vec3 at, const Cubes& cubes, int flat)
{
    if (flat >= 0) at[flat] = cubes.cell[0][flat];
    return at;
}

// The mesh in lattice coordinates, and the body that each vertex goes with.
struct Placed {
    std::vector<Vec3> at;             // V
    std::vector<std::uint32_t> body;  // V, or empty: not known, as BodyFinder::bodies_of()

    std::uint32_t body_of(std::uint32_t v) const { return body.empty() ? no_index : body[v]; }
};

// The cube that an outside vertex goes with, and how far it is: the nearest of its body. One that
// is farther from its body than `own_reach`, and nearer to another by as much, goes with that: it
// is part of a skin over several bodies.
std::pair<std::uint32_t, double> nearest_of_body(const NearestCubes& nearest,
                                                 const BodyFinder& finder, const Vec3& at,
                                                 std::uint32_t body)
{
    const auto any = nearest.find(at, [](std::uint32_t) { return true; });
    if (body == no_index || finder.body_of(any.first) == body) return any;
    const auto own = nearest.find(at, [&](std::uint32_t c) { return finder.body_of(c) == body; });
    if (own.second <= any.second + own_reach) return own;
    const std::uint32_t holder = finder.find(at, no_index);
    return holder != no_index ? std::pair(holder, 0.0) : any;
}

// Vertices in no cube of their body: cube[v] and anchors.
void bind_strays(const TriMesh& mesh, const Cubes& cubes, const BodyFinder& finder, int flat,
                 const Placed& placed, const std::vector<std::uint32_t>& outside, Binding& binding)
{
    const std::vector<Vec3>& at = placed.at;
    const NearestCubes nearest(cubes);
    std::vector<std::pair<std::uint32_t, double>> found(outside.size());
    parallel_for(outside.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t v = outside[i];
            found[i] =
                nearest_of_body(nearest, finder, flattened(at[v], cubes, flat), placed.body_of(v));
        }
    });
    const std::vector<std::uint32_t> piece = first_vertices(mesh);
    // A piece all outside goes with the cube nearest to any of its vertices.
    std::vector<std::uint8_t> touches(mesh.positions.size(), 0);
    for (std::uint32_t v = 0; v < piece.size(); ++v) {
        if (binding.cube[v] != no_index) touches[piece[v]] = 1;
    }
    for (std::size_t i = 0; i < outside.size(); ++i) {
        if (found[i].second <= inside_slack) touches[piece[outside[i]]] = 1;
    }
    std::vector<std::size_t> nearest_of(mesh.positions.size(), outside.size());
    for (std::size_t i = 0; i < outside.size(); ++i) {
        std::size_t& best = nearest_of[piece[outside[i]]];
        if (best == outside.size() || found[i].second < found[best].second) best = i;
    }
    for (std::size_t i = 0; i < outside.size(); ++i) {
        const std::uint32_t v = outside[i];
        const bool alone = !touches[piece[v]];
        binding.cube[v] = found[alone ? nearest_of[piece[v]] : i].first;
        binding.local[v] = (at[v] - cubes.cell[binding.cube[v]].cast<double>()).cast<float>();
        if (found[i].second <= inside_slack) continue;
        Vec3f nearby = binding.local[v].cwiseMax(0.0f).cwiseMin(1.0f);
        if (flat >= 0) nearby[flat] = binding.local[v][flat];
        const Vec3f anchor = alone ? Vec3f(Vec3f::Constant(0.5f)) : nearby;
        const double distance = double((binding.local[v] - nearby).norm()) * cubes.size;
        binding.strays.push_back({v, anchor});
        binding.farthest = std::max(binding.farthest, distance);
    }
}

// cube[] and local[] where the cubes are a sheet.
void bind_to_sheet(const TriMesh& mesh, const Cubes& sheet, Binding& binding)
{
    const TriangleBvh tree(sheet_mesh(sheet));
    std::vector<double> distance(mesh.positions.size(), 0.0);
    parallel_for(distance.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const auto hit = tree.closest(mesh.positions[v].cast<double>());
            binding.cube[v] = hit ? hit.triangle : 0;
            binding.local[v] =
                hit ? Vec3f(place_in_cell(hit.barycentric).cast<float>()) : Vec3f(Vec3f::Zero());
            if (hit) distance[v] = hit.distance;
        }
    });
    for (const double d : distance) binding.farthest = std::max(binding.farthest, d);
}

// cube[] and local[] where the cubes lie on a lattice, and strays.
void bind_to_lattice(const TriMesh& mesh, const Cubes& cubes, bool by_pieces, Binding& binding)
{
    const std::size_t n = mesh.positions.size();
    const BodyFinder finder(cubes);
    const int flat = flat_axis(cubes);
    Placed placed;
    if (by_pieces) placed.body = finder.bodies_of(mesh);
    placed.at.resize(n);
    parallel_for(n, bound_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const auto v = static_cast<std::uint32_t>(i);
            const Vec3f& p = mesh.positions[v];
            if (!p.allFinite()) {
                binding.cube[v] = 0;
                binding.local[v] = Vec3f::Zero();
                continue;
            }
            placed.at[v] = (p.cast<double>() - cubes.origin) / cubes.size;
            const std::uint32_t body = placed.body_of(v);
            const std::uint32_t c = finder.find(flattened(placed.at[v], cubes, flat), body);
            const bool of_another = c != no_index && body != no_index && finder.body_of(c) != body;
            binding.cube[v] = of_another ? no_index : c;
            if (binding.cube[v] == no_index) continue;
            binding.local[v] = (placed.at[v] - cubes.cell[c].cast<double>()).cast<float>();
        }
    });
    std::vector<std::uint32_t> outside;
    for (std::uint32_t v = 0; v < n; ++v) {
        if (binding.cube[v] == no_index) outside.push_back(v);
    }
    if (!outside.empty()) bind_strays(mesh, cubes, finder, flat, placed, outside, binding);
}

// Numbers the cubes in use and makes cube[] point at them.
void number_used(std::size_t cubes, Binding& binding)
{
    std::vector<std::uint32_t> number(cubes, 0);
    for (const std::uint32_t c : binding.cube) number[c] = 1;
    for (std::uint32_t c = 0; c < cubes; ++c) {
        if (number[c] == 0) continue;
        number[c] = static_cast<std::uint32_t>(binding.used.size());
        binding.used.push_back(c);
    }
    for (std::uint32_t& c : binding.cube) c = number[c];
}

std::vector<std::uint32_t> vertex_of_normals(const TriMesh& mesh)
{
    std::vector<std::uint32_t> vertex(mesh.normals.size(), no_index);
    const MeshTopology& topology = *mesh.topology;
    const std::size_t listed = topology.normal_triangles.size();
    if (listed == 0 || listed != topology.triangles.size()) {
        // No list of their own: one normal a vertex, in a cloud of points too.
        const std::size_t n = std::min(vertex.size(), mesh.positions.size());
        std::iota(vertex.begin(), vertex.begin() + static_cast<std::ptrdiff_t>(n), 0u);
        return vertex;
    }
    for (std::size_t t = 0; t < topology.triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t n = topology.normal_triangles[t][k], v = topology.triangles[t][k];
            if (n < vertex.size() && v < mesh.positions.size()) vertex[n] = v;
        }
    }
    return vertex;
}

}  // namespace

const Binding::Stray* find_stray(const Binding& binding, std::uint32_t vertex)
{
    const auto at =
        std::lower_bound(binding.strays.begin(), binding.strays.end(), vertex,
                         [](const Binding::Stray& s, std::uint32_t v) { return s.vertex < v; });
    return at != binding.strays.end() && at->vertex == vertex ? &*at : nullptr;
}

Binding bind(const TriMesh& mesh, const Cubes& cubes, bool by_pieces)
{
    Binding binding;
    const std::size_t n = mesh.positions.size();
    if (n > 0 && cubes.count() == 0) {
        throw std::invalid_argument("no cubes to embed the mesh in");
    }
    binding.cube.resize(n);
    binding.local.resize(n);
    if (cubes.is_sheet()) {
        bind_to_sheet(mesh, cubes, binding);
    } else {
        bind_to_lattice(mesh, cubes, by_pieces, binding);
    }
    number_used(cubes.count(), binding);
    binding.normal_vertex = vertex_of_normals(mesh);
    binding.one_normal_each = binding.normal_vertex.size() == n;
    for (std::uint32_t v = 0; v < n && binding.one_normal_each; ++v) {
        binding.one_normal_each = binding.normal_vertex[v] == v;
    }
    for (std::uint32_t i = 0; i < binding.normal_vertex.size() && !binding.strays.empty(); ++i) {
        const std::uint32_t v = binding.normal_vertex[i];
        if (v != no_index && find_stray(binding, v)) binding.stray_normals.push_back(i);
    }
    return binding;
}

std::string warning_of_strays(const Binding& binding)
{
    if (binding.strays.empty()) return {};
    return fmt::format("{} of {} vertices lie in no cube of their body: each follows the nearest "
                       "one, at most {:.3g} m away",
                       binding.strays.size(), binding.cube.size(), binding.farthest);
}

}  // namespace geometry
