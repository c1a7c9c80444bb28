#include "geometry/embed/embed.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "geometry/embed/embed_kernels.hpp"
#include "geometry/embed/sheet_motion.hpp"
#include "geometry/mesh/mesh.hpp"

#include <stdexcept>
#include <string>

namespace geometry {
namespace {

constexpr std::size_t carried_a_task = 8192;

// Weights of u(q) + grad u(q) (p - q).
std::array<double, 8> affine(const Vec3& q, const Vec3& p)
{
    std::array<double, 8> w = trilinear_weights(q);
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
    throw std::invalid_argument("expected " + std::to_string(expected) + " " + what + ", found " +
                                std::to_string(got) +
                                ": do mesh, cubes and state belong together?");
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

TriMesh embed(const Binding& binding, const TriMesh& mesh, const Cubes& cubes,
              std::span<const Vec3> x, std::span<const std::uint8_t> torn)
{
    require(x.size() == cubes.corner_count(), "corner positions", cubes.corner_count(), x.size());
    require(mesh.positions.size() == binding.cube.size(), "vertices", binding.cube.size(),
            mesh.positions.size());
    require(mesh.normals.size() == binding.normal_vertex.size(), "normals",
            binding.normal_vertex.size(), mesh.normals.size());
    TriMesh out;
    out.topology = mesh.topology;
    out.colours = mesh.colours;
    out.attributes = mesh.attributes;
    out.positions.resize(mesh.positions.size());
    out.normals.resize(mesh.normals.size());
    if (cubes.is_sheet()) {
        carry_with_sheet(binding, mesh, cubes, x, out);
        return out;
    }
    const std::vector<CubePolynomial> u = polynomials(binding, cubes, x, torn);
    const auto per_metre = static_cast<float>(1 / cubes.size);
    const CarriedPlaces places{u, binding.cube, binding.local};
    parallel_for(mesh.positions.size(), carried_a_task, [&](std::size_t begin, std::size_t end) {
        if (binding.one_normal_each) {
            carry_vertices(places, mesh.positions, mesh.normals, per_metre, begin, end,
                           out.positions, out.normals);
        } else {
            carry_positions(places, mesh.positions, begin, end, out.positions);
        }
    });
    const std::size_t normals_left = binding.one_normal_each ? 0 : mesh.normals.size();
    parallel_for(normals_left, carried_a_task, [&](std::size_t begin, std::size_t end) {
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
    if (!stray) return trilinear_weights(p);
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
    parallel_for(out.size(), carried_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Vec3f inside = binding.local[v].cwiseMax(0.0f).cwiseMin(1.0f);
            const std::array<double, 8> w = trilinear_weights(inside.cast<double>());
            const auto& corners = cubes.corners[binding.used[binding.cube[v]]];
            double sum = 0;
            for (std::size_t a = 0; a < 8; ++a) sum += w[a] * values[corners[a]];
            out[v] = static_cast<float>(sum);
        }
    });
    return out;
}

std::vector<Vec3f> carried_vectors(const Binding& binding, const Cubes& cubes,
                                   std::span<const Vec3> vectors)
{
    require(vectors.size() == cubes.corner_count(), "corner vectors", cubes.corner_count(),
            vectors.size());
    std::vector<Vec3f> out(binding.cube.size());
    parallel_for(out.size(), carried_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const std::array<double, 8> w = weights(binding, static_cast<std::uint32_t>(v));
            const auto& corners = cubes.corners[binding.used[binding.cube[v]]];
            Vec3 sum = Vec3::Zero();
            for (std::size_t a = 0; a < 8; ++a) sum += w[a] * vectors[corners[a]];
            out[v] = sum.cast<float>();
        }
    });
    return out;
}

std::vector<double> at_corners(const Cubes& cubes, std::span<const float> values)
{
    require(values.size() == cubes.count(), "cube values", cubes.count(), values.size());
    const std::size_t corners = cubes.is_sheet() ? 3 : 8;  // those of a triangle come first
    std::vector<double> sum(cubes.corner_count(), 0.0), weight(cubes.corner_count(), 0.0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double fill = cubes.fill.empty() ? 1.0 : cubes.fill[c];
        const double w = cubes.is_sheet() ? fill * cell_area(cubes, c) : fill;
        for (std::size_t a = 0; a < corners; ++a) {
            const std::uint32_t k = cubes.corners[c][a];
            sum[k] += w * double(values[c]);
            weight[k] += w;
        }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] = weight[k] > 0 ? sum[k] / weight[k] : 0;
    return sum;
}

}  // namespace geometry
