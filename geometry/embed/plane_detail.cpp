#include "geometry/embed/plane_detail.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/normals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace geometry {
namespace {

// The shortest turn of a's direction to b's; about any axis where they are opposed. What Eigen has
// for it falls back on a singular value decomposition, five seconds to compile.
Eigen::Quaterniond turn_between(const Vec3& a, const Vec3& b)
{
    const Vec3 u = a.normalized(), v = b.normalized();
    const double w = 1 + u.dot(v);
    const Vec3 axis = w > 1e-14 ? Vec3(u.cross(v)) : u.unitOrthogonal();
    return Eigen::Quaterniond(w > 1e-14 ? w : 0, axis.x(), axis.y(), axis.z()).normalized();
}

using CellNumbers = std::map<std::array<int, 2>, std::uint32_t>;

struct CellPlace {
    std::uint32_t cell = no_index;
    double x = 0, y = 0;  // 0..1 within it
};

// Where (s, t), in cells, lies. A point on the rim, or outside of it by rounding, belongs to the
// cell beside it.
CellPlace cell_place(const CellNumbers& cells, double s, double t)
{
    constexpr double rim = 1e-3;
    for (const double a : {0.0, -rim, rim}) {
        for (const double b : {0.0, -rim, rim}) {
            const double i = std::floor(s + a), j = std::floor(t + b);
            const auto found = cells.find({int(i), int(j)});
            if (found == cells.end()) continue;
            return {found->second, std::clamp(s - i, 0.0, 1.0), std::clamp(t - j, 0.0, 1.0)};
        }
    }
    return {};
}

}  // namespace

PlaneDetail bind_plane_detail(const TriMesh& rest, const Cubes& patch, double distance)
{
    if (patch.is_sheet()) {
        throw std::invalid_argument("the patch has to be a plane, found the sheet of a mesh: make "
                                    "it with Plane");
    }
    const int axis = flat_axis(patch);
    if (axis < 0) {
        throw std::invalid_argument(
            "the patch has to be a plane, found cubes with a thickness: make "
            "it with Plane");
    }
    const auto [u, v] = plane_axes(axis);
    CellNumbers cells;
    for (std::uint32_t c = 0; c < patch.count(); ++c) {
        cells[{patch.cell[c][u], patch.cell[c][v]}] = c;
    }
    PlaneDetail out;
    for (std::uint32_t i = 0; i < rest.positions.size(); ++i) {
        const Vec3 at = (rest.positions[i].cast<double>() - patch.origin) / patch.size;
        const double height = std::abs(at[axis]) * patch.size;
        if (!at.allFinite() || at.cwiseAbs().maxCoeff() > 1e9 || !(height < distance)) continue;
        const auto [cell, x, y] = cell_place(cells, at[u], at[v]);
        if (cell == no_index) continue;
        const auto& corners = patch.corners[cell];
        const std::size_t a = std::size_t{1} << u, b = std::size_t{1} << v;
        const double fall = 1 - height / distance;
        const double share = fall * fall * (3 - 2 * fall);
        out.vertices.push_back({i,
                                {corners[0], corners[a], corners[b], corners[a | b]},
                                {float(share * (1 - x) * (1 - y)), float(share * x * (1 - y)),
                                 float(share * (1 - x) * y), float(share * x * y)}});
    }
    return out;
}

namespace {

// The smooth normal at each bound vertex, by area.
std::vector<Vec3> smooth_normals(const PlaneDetail& binding, const TriMesh& mesh)
{
    std::vector<Vec3> at(mesh.positions.size(), Vec3::Zero());
    const std::vector<Vec3> area = area_vectors(mesh);
    for (std::size_t t = 0; t < area.size(); ++t) {
        for (const auto i : mesh.triangles()[t]) {
            if (i < at.size()) at[i] += area[t];
        }
    }
    std::vector<Vec3> out;
    for (const auto& vertex : binding.vertices) out.push_back(at[vertex.vertex]);
    return out;
}

void need(bool good, const char* what, std::size_t expected, std::size_t found, const char* remedy)
{
    if (good) return;
    throw std::invalid_argument(
        fmt::format("expected {} {}, found {}: {}", what, expected, found, remedy));
}

}  // namespace

TriMesh add_plane_detail(const PlaneDetail& binding, const TriMesh& mesh, const Cubes& patch,
                         std::span<const Vec3> x, std::span<const Vec3f> carried)
{
    const std::size_t n = patch.corner_count();
    need(x.size() == n, "corners in the state of the patch", n, x.size(),
         "link the state of the Simulate that moves these cells");
    need(carried.size() == n, "vertices in the carried mesh, one for each corner of the patch", n,
         carried.size(),
         "link the mesh that Plane made with these cells, embedded in the cubes of the object");
    TriMesh out = mesh;
    for (const auto& vertex : binding.vertices) {
        need(vertex.vertex < mesh.positions.size(), "vertices or more in the mesh",
             vertex.vertex + std::size_t{1}, mesh.positions.size(),
             "link the surface that lies along the plane at rest, moved");
        Vec3 detail = Vec3::Zero();
        for (std::size_t k = 0; k < 4; ++k) {
            const std::uint32_t corner = vertex.corner[k];
            detail += double(vertex.weight[k]) * (x[corner] - carried[corner].cast<double>());
        }
        out.positions[vertex.vertex] += detail.cast<float>();
    }
    if (out.normals.empty()) return out;
    const auto before = smooth_normals(binding, mesh), after = smooth_normals(binding, out);
    std::vector<std::uint32_t> bound(mesh.positions.size(), no_index);
    for (std::uint32_t b = 0; b < binding.vertices.size(); ++b) {
        bound[binding.vertices[b].vertex] = b;
    }
    const MeshTopology& topology = *mesh.topology;
    const auto& corners = topology.normal_triangles.size() == topology.triangles.size()
                              ? topology.normal_triangles
                              : topology.triangles;
    std::vector<std::uint8_t> turned(out.normals.size(), 0);
    for (std::size_t t = 0; t < corners.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t normal = corners[t][k], v = topology.triangles[t][k];
            if (normal >= turned.size() || v >= bound.size() || bound[v] == no_index ||
                turned[normal]) {
                continue;
            }
            turned[normal] = 1;
            const Vec3 &from = before[bound[v]], &to = after[bound[v]];
            if (!(from.squaredNorm() > 0) || !(to.squaredNorm() > 0)) continue;
            out.normals[normal] =
                (turn_between(from, to) * out.normals[normal].cast<double>()).cast<float>();
        }
    }
    return out;
}

}  // namespace geometry
