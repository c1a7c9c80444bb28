#include "geometry/embed.hpp"

#include "geometry/box_tree.hpp"
#include "geometry/cell_set.hpp"
#include "geometry/embed_kernels.hpp"
#include "geometry/parallel.hpp"
#include "geometry/plane.hpp"
#include "geometry/sets.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <string>

namespace geometry {
namespace {

constexpr double inside_slack = 1e-3;  // of a cube
constexpr std::size_t vertices_a_task = 8192;

using Lanes = Eigen::Array4f;  // a vector in four lanes

// A mesh's pieces, joined by triangles: the first vertex of each vertex's piece.
std::vector<std::uint32_t> pieces(const TriMesh& mesh)
{
    Sets sets(mesh.positions.size());
    for (const auto& [a, b, c] : mesh.triangles()) {
        if (std::max({a, b, c}) >= mesh.positions.size()) continue;
        sets.join(a, b);
        sets.join(a, c);
    }
    return sets.roots();
}

// Finds the cube nearest to a place in lattice coordinates.
class NearestCubes {
public:
    explicit NearestCubes(const Cubes& cubes)
    {
        std::vector<Box3f> boxes;
        for (const Vec3i& c : cubes.cell) {
            boxes.push_back({c.cast<float>(), (c + Vec3i::Ones()).cast<float>()});
        }
        tree_ = build_box_tree(boxes);
        for (const std::uint32_t i : tree_.items) boxes_.push_back(boxes[i]);
        cube_ = tree_.items;
        std::iota(tree_.items.begin(), tree_.items.end(), 0u);
    }

    // Its number, and its distance in cubes.
    std::pair<std::uint32_t, double> find(const Vec3& at) const
    {
        double best_sq = std::numeric_limits<double>::infinity();
        std::uint32_t best = 0;
        tree_.nearest(at, best_sq, [&](std::uint32_t i, double& sq) {
            const double d_sq = boxes_[i].distance_sq(at);
            if (d_sq < sq) sq = d_sq, best = cube_[i];
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

// Vertices in no cube: cube[v] and anchors.
void bind_strays(const TriMesh& mesh, const Cubes& cubes, int flat, const std::vector<Vec3>& at,
                 const std::vector<std::uint32_t>& outside, Binding& binding)
{
    const NearestCubes nearest(cubes);
    std::vector<std::pair<std::uint32_t, double>> found(outside.size());
    parallel_for(outside.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            found[i] = nearest.find(flattened(at[outside[i]], cubes, flat));
        }
    });
    const std::vector<std::uint32_t> piece = pieces(mesh);
    // A piece all outside goes with the cube nearest to any of its vertices.
    std::vector<std::uint8_t> touches(mesh.positions.size(), 0);
    for (std::uint32_t v = 0; v < piece.size(); ++v) {
        if (binding.cube[v] != Binding::none) touches[piece[v]] = 1;
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
    std::vector<std::uint32_t> vertex(mesh.normals.size(), Binding::none);
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

const Binding::Stray* find_stray(const Binding& binding, std::uint32_t vertex)
{
    const auto at =
        std::lower_bound(binding.strays.begin(), binding.strays.end(), vertex,
                         [](const Binding::Stray& s, std::uint32_t v) { return s.vertex < v; });
    return at != binding.strays.end() && at->vertex == vertex ? &*at : nullptr;
}

std::array<double, 8> trilinear(const Vec3& p)
{
    std::array<double, 8> w;
    for (std::size_t a = 0; a < 8; ++a) {
        w[a] =
            (a & 1 ? p.x() : 1 - p.x()) * (a & 2 ? p.y() : 1 - p.y()) * (a & 4 ? p.z() : 1 - p.z());
    }
    return w;
}

// Weights of u(q) + grad u(q) (p - q).
std::array<double, 8> affine(const Vec3& q, const Vec3& p)
{
    std::array<double, 8> w = trilinear(q);
    for (std::size_t a = 0; a < 8; ++a) {
        const std::array<double, 3> n{a & 1 ? q.x() : 1 - q.x(), a & 2 ? q.y() : 1 - q.y(),
                                      a & 4 ? q.z() : 1 - q.z()};
        for (std::size_t d = 0; d < 3; ++d) {
            const double slope = (a >> d & 1) ? 1 : -1;
            const auto k = static_cast<Eigen::Index>(d);
            w[a] += slope * n[(d + 1) % 3] * n[(d + 2) % 3] * (p[k] - q[k]);
        }
    }
    return w;
}

void require(bool holds, const char* what, std::size_t expected, std::size_t got)
{
    if (holds) return;
    throw std::invalid_argument(std::string("embed: expected ") + std::to_string(expected) + " " +
                                what + ", got " + std::to_string(got) +
                                "; do mesh, cubes and state belong together?");
}

// The polynomials of the cubes in use. A plane's cells get a thickness: their upper corners stand
// off along its normals.
std::vector<CubePolynomial> polynomials(const Binding& binding, const Cubes& cubes,
                                        std::span<const Vec3> x, std::span<const std::uint8_t> torn)
{
    std::vector<CubePolynomial> out(binding.used.size());
    const int axis = flat_axis(cubes);
    const std::size_t upper = axis < 0 ? 0 : std::size_t{1} << axis;
    const std::vector<Vec3> normal = axis < 0 ? std::vector<Vec3>{} : plane_normals(cubes, x, torn);
    parallel_for(out.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            std::array<Vec3, 8> u;
            for (std::size_t a = 0; a < 8; ++a) {
                const std::uint32_t k = cubes.corners[binding.used[i]][a];
                u[a] = x[k] - cubes.corner_position(k);
                if (a & upper) u[a] += cubes.size * (normal[k] - Vec3::Unit(axis));
            }
            out[i] = polynomial_of(u);
        }
    });
    return out;
}

}  // namespace

Binding bind(const TriMesh& mesh, const Cubes& cubes)
{
    Binding binding;
    const std::size_t n = mesh.positions.size();
    if (n > 0 && cubes.count() == 0) {
        throw std::invalid_argument("there are no cubes to embed the mesh in");
    }
    const CellIndex index(cubes.cell);
    const int flat = flat_axis(cubes);
    binding.cube.resize(n);
    binding.local.resize(n);
    std::vector<Vec3> at(n);
    parallel_for(n, vertices_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3f& p = mesh.positions[v];
            if (!p.allFinite()) {
                binding.cube[v] = 0;
                binding.local[v] = Vec3f::Zero();
                continue;
            }
            at[v] = (p.cast<double>() - cubes.origin) / cubes.size;
            const double reach = CellSet::extent;
            const Vec3 seen = flattened(at[v], cubes, flat);
            const Vec3 cell = seen.array().floor().cwiseMax(-reach - 1).cwiseMin(reach);
            const CellIndex::Found found = index.find(cell.cast<int>());
            binding.cube[v] = found ? found.begin : Binding::none;
            binding.local[v] = (at[v] - cell).cast<float>();
        }
    });
    std::vector<std::uint32_t> outside;
    for (std::uint32_t v = 0; v < n; ++v) {
        if (binding.cube[v] == Binding::none) outside.push_back(v);
    }
    if (!outside.empty()) bind_strays(mesh, cubes, flat, at, outside, binding);
    number_used(cubes.count(), binding);
    binding.normal_vertex = vertex_of_normals(mesh);
    binding.one_normal_each = binding.normal_vertex.size() == n;
    for (std::uint32_t v = 0; v < n && binding.one_normal_each; ++v) {
        binding.one_normal_each = binding.normal_vertex[v] == v;
    }
    for (std::uint32_t i = 0; i < binding.normal_vertex.size() && !binding.strays.empty(); ++i) {
        const std::uint32_t v = binding.normal_vertex[i];
        if (v != Binding::none && find_stray(binding, v)) binding.stray_normals.push_back(i);
    }
    return binding;
}

TriMesh embed(const Binding& binding, const TriMesh& mesh, const Cubes& cubes,
              std::span<const Vec3> x, std::span<const std::uint8_t> torn)
{
    require(x.size() == cubes.corner_count(), "corner positions", cubes.corner_count(), x.size());
    require(mesh.positions.size() == binding.cube.size(), "vertices", binding.cube.size(),
            mesh.positions.size());
    require(mesh.normals.size() == binding.normal_vertex.size(), "normals",
            binding.normal_vertex.size(), mesh.normals.size());
    const std::vector<CubePolynomial> u = polynomials(binding, cubes, x, torn);
    const auto per_metre = static_cast<float>(1 / cubes.size);

    TriMesh out;
    out.topology = mesh.topology;
    out.colours = mesh.colours;
    out.attributes = mesh.attributes;
    out.positions.resize(mesh.positions.size());
    out.normals.resize(mesh.normals.size());
    const CarriedPlaces places{u, binding.cube, binding.local};
    parallel_for(mesh.positions.size(), vertices_a_task, [&](std::size_t begin, std::size_t end) {
        if (binding.one_normal_each) {
            carry_vertices(places, mesh.positions, mesh.normals, per_metre, begin, end,
                           out.positions, out.normals);
        } else {
            carry_positions(places, mesh.positions, begin, end, out.positions);
        }
    });
    const std::size_t normals_left = binding.one_normal_each ? 0 : mesh.normals.size();
    parallel_for(normals_left, vertices_a_task, [&](std::size_t begin, std::size_t end) {
        turn_normals(places, binding.normal_vertex, per_metre, mesh.normals, begin, end,
                     out.normals);
    });

    // Strays move with their anchors, and turn as those do.
    std::vector<std::uint32_t> stray_cube;
    std::vector<Vec3f> anchor;
    for (const Binding::Stray& s : binding.strays) {
        const Vec3f moved =
            affine_at(u[binding.cube[s.vertex]], s.anchor, binding.local[s.vertex] - s.anchor);
        out.positions[s.vertex] = mesh.positions[s.vertex] + moved;
        stray_cube.push_back(binding.cube[s.vertex]);
        anchor.push_back(s.anchor);
    }
    std::vector<std::uint32_t> stray;
    std::vector<Vec3f> normal;
    for (const std::uint32_t n : binding.stray_normals) {
        const auto* s = find_stray(binding, binding.normal_vertex[n]);
        stray.push_back(static_cast<std::uint32_t>(s - binding.strays.data()));
        normal.push_back(mesh.normals[n]);
    }
    const std::vector<Vec3f> rest = normal;
    turn_normals({u, stray_cube, anchor}, stray, per_metre, rest, 0, rest.size(), normal);
    for (std::size_t i = 0; i < normal.size(); ++i) {
        out.normals[binding.stray_normals[i]] = normal[i];
    }
    return out;
}

std::array<double, 8> weights(const Binding& binding, std::uint32_t vertex)
{
    const Vec3 p = binding.local[vertex].cast<double>();
    const Binding::Stray* stray = find_stray(binding, vertex);
    if (!stray) return trilinear(p);
    return affine(stray->anchor.cast<double>(), p);
}

std::vector<Vec3> transpose(const Binding& binding, const Cubes& cubes,
                            std::span<const Vec3> forces)
{
    require(forces.size() == binding.cube.size(), "forces", binding.cube.size(), forces.size());
    std::vector<Vec3> out(cubes.corner_count(), Vec3::Zero());
    for (std::uint32_t v = 0; v < forces.size(); ++v) {
        if (forces[v].isZero(0)) continue;
        const std::array<double, 8> w = weights(binding, v);
        const auto& corners = cubes.corners[binding.used[binding.cube[v]]];
        for (std::size_t a = 0; a < 8; ++a) out[corners[a]] += w[a] * forces[v];
    }
    return out;
}

std::vector<float> interpolate(const Binding& binding, const Cubes& cubes,
                               std::span<const double> values)
{
    require(values.size() == cubes.corner_count(), "corner values", cubes.corner_count(),
            values.size());
    std::vector<float> out(binding.cube.size());
    parallel_for(out.size(), vertices_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3f inside = binding.local[v].cwiseMax(0.0f).cwiseMin(1.0f);
            const std::array<double, 8> w = trilinear(inside.cast<double>());
            const auto& corners = cubes.corners[binding.used[binding.cube[v]]];
            double sum = 0;
            for (std::size_t a = 0; a < 8; ++a) sum += w[a] * values[corners[a]];
            out[v] = static_cast<float>(sum);
        }
    });
    return out;
}

std::vector<double> at_corners(const Cubes& cubes, std::span<const float> values)
{
    require(values.size() == cubes.count(), "cube values", cubes.count(), values.size());
    std::vector<double> sum(cubes.corner_count(), 0.0), weight(cubes.corner_count(), 0.0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double w = cubes.fill.empty() ? 1.0 : cubes.fill[c];
        for (const std::uint32_t k : cubes.corners[c]) {
            sum[k] += w * double(values[c]);
            weight[k] += w;
        }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = weight[k] > 0 ? sum[k] / weight[k] : 0;
    return sum;
}

}  // namespace geometry
