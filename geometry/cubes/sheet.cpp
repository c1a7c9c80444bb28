#include "geometry/cubes/sheet.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/mesh/cut_sides.hpp"
#include "geometry/mesh/doubled_faces.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/wound_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

// Triangles are left out whose height is less than this share of their longest side.
constexpr double least_height = 1e-6;

Vec3 area_of(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return (b - a).cross(c - a) / 2;
}

double longest_side_of(const Vec3& a, const Vec3& b, const Vec3& c)
{
    return std::sqrt(
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
}

bool has_area(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const double longest = longest_side_of(a, b, c), area = area_of(a, b, c).norm();
    return std::isfinite(area) && area > 0.5 * least_height * longest * longest;
}

// The triangles that have an area, each once, of first vertices.
struct SoundTriangles {
    std::vector<Triangle> triangles;
    std::size_t doubled = 0;  // others that have an area
};

SoundTriangles sound_triangles(const TriMesh& mesh)
{
    const DoubledFaces faces = doubled_faces(mesh);
    SoundTriangles out;
    StopCheck check;
    for (std::size_t f = 0; f < faces.triangles.size(); ++f) {
        check();
        if (faces.is[f] == Doubled::unsound) continue;
        const Triangle& t = faces.triangles[f];
        const auto at = [&](std::size_t i) { return Vec3(mesh.positions[t[i]].cast<double>()); };
        if (!has_area(at(0), at(1), at(2))) continue;
        if (faces.is[f] == Doubled::no) {
            out.triangles.push_back(t);
        } else {
            ++out.doubled;
        }
    }
    return out;
}

std::size_t joints_of(const std::vector<Triangle>& triangles, std::size_t vertices)
{
    const std::vector<EdgeUse> uses = edge_uses(triangles, vertices);
    std::size_t out = 0;
    StopCheck check;
    for (std::size_t i = 0; i + 2 < uses.size(); ++i) {
        check();
        const auto same = [&](std::size_t j) {
            return uses[j].a == uses[i].a && uses[j].b == uses[i].b;
        };
        const bool starts = i == 0 || !same(i - 1);
        if (starts && same(i + 1) && same(i + 2)) ++out;
    }
    return out;
}

// The same triangles, where neighbours face the same way.
std::vector<Triangle> turned_alike(const TriMesh& mesh, std::vector<Triangle> triangles)
{
    TriMesh sound;
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = std::move(triangles);
    sound.topology = std::move(topology);
    sound.positions = mesh.positions;
    return wound_out(sound).triangles;
}

// No fewer triangles than that have sides of at most `longest`: by their area, each at most that of
// one with three such sides.
double least_triangles(double longest, const std::vector<Vec3f>& positions,
                       const std::vector<Triangle>& triangles)
{
    const double largest = std::sqrt(3.0) / 4 * longest * longest;
    double out = 0;
    for (const Triangle& t : triangles) {
        const auto at = [&](std::size_t i) { return Vec3(positions[t[i]].cast<double>()); };
        out += area_of(at(0), at(1), at(2)).norm() / largest;
    }
    return out;
}

void cut_to(double longest, std::vector<Vec3f>& positions, std::vector<Triangle>& triangles)
{
    constexpr std::size_t most = 5'000'000;
    const auto limit = [&](double count) {
        if (count <= double(most)) return;
        throw std::invalid_argument(fmt::format(
            "sides of at most {:g} m make more than {} triangles of this mesh: use longer sides",
            longest, most));
    };
    limit(least_triangles(longest, positions, triangles));
    while (cut_sides(longest, positions, triangles)) limit(double(triangles.size()));
}

// The corners that triangles use, in the order of the mesh's vertices.
void add_places(const std::vector<Vec3f>& positions, std::vector<Triangle>& triangles, Cubes& cubes)
{
    std::vector<std::uint32_t> number(positions.size(), 0);
    for (const Triangle& t : triangles) {
        for (const auto v : t) number[v] = 1;
    }
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] == 0) continue;
        number[v] = static_cast<std::uint32_t>(cubes.place.size());
        cubes.place.push_back(positions[v].cast<double>());
    }
    for (Triangle& t : triangles) {
        for (auto& v : t) v = number[v];
    }
}

// Size, origin and lattice coordinates: about where cells and corners are.
void add_lattice(const std::vector<Triangle>& triangles, Cubes& cubes)
{
    double sum = 0;
    Vec3 lo = cubes.place[0];
    for (const Vec3& p : cubes.place) lo = lo.cwiseMin(p);
    for (const Triangle& t : triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
            sum += (cubes.place[t[(i + 1) % 3]] - cubes.place[t[i]]).norm();
        }
    }
    cubes.size = sum / static_cast<double>(3 * triangles.size());
    cubes.origin = lo;
    const auto lattice = [&](const Vec3& p) {
        const Vec3 at = ((p - lo) / cubes.size).cwiseMin(1e9);
        return Vec3i(int(std::floor(at.x())), int(std::floor(at.y())), int(std::floor(at.z())));
    };
    for (const Vec3& p : cubes.place) cubes.corner.push_back(lattice(p));
    for (const Triangle& t : triangles) {
        cubes.corners.push_back({t[0], t[1], t[2], t[2], t[0], t[1], t[2], t[2]});
        cubes.cell.push_back(
            lattice((cubes.place[t[0]] + cubes.place[t[1]] + cubes.place[t[2]]) / 3));
    }
}

}  // namespace

SheetOfMesh make_sheet(const TriMesh& mesh, double thickness, const Matter& matter, double longest)
{
    if (!(thickness > 0) || !std::isfinite(thickness)) {
        throw std::invalid_argument(
            fmt::format("expected a thickness of the sheet above 0 m, found {}", thickness));
    }
    SoundTriangles sound = sound_triangles(mesh);
    std::vector<Triangle>& triangles = sound.triangles;
    if (triangles.empty()) {
        throw std::invalid_argument(
            mesh.triangles().empty()
                ? "a sheet needs a mesh with faces, found points alone: make a surface of them "
                  "first, or use Voxelize"
                : "a sheet needs faces that have an area, found none: check the mesh and its "
                  "scale");
    }
    SheetOfMesh out;
    stop_if_asked();
    out.doubled = sound.doubled;
    out.left_out = mesh.triangles().size() - triangles.size() - sound.doubled;
    out.joints = joints_of(triangles, mesh.positions.size());
    triangles = turned_alike(mesh, std::move(triangles));
    stop_if_asked();
    std::vector<Vec3f> positions = mesh.positions;
    if (longest > 0) cut_to(longest, positions, triangles);
    Cubes& cubes = out.cubes;
    add_places(positions, triangles, cubes);
    stop_if_asked();
    add_lattice(triangles, cubes);
    stop_if_asked();
    const std::size_t n = triangles.size();
    for (std::size_t c = 0; c < n; ++c) {
        cubes.mass.push_back(matter.density * thickness * cell_area(cubes, c));
    }
    cubes.fill.assign(n, thickness / cubes.size);
    cubes.young.assign(n, matter.young);
    cubes.poisson.assign(n, matter.poisson);
    cubes.mass_damping.assign(n, matter.mass_damping);
    cubes.stiffness_damping.assign(n, matter.stiffness_damping);
    cubes.matter.assign(n, 0);
    cubes.matters = {matter};
    return out;
}

Vec3 place_in_cell(const Vec3& barycentric)
{
    const double t = barycentric.z(), rest = 1 - t;
    return {rest > 0 ? std::clamp(barycentric.y() / rest, 0.0, 1.0) : 0.0, t, 0};
}

double cell_area(const Cubes& cubes, std::size_t cell)
{
    if (!cubes.is_sheet()) return cubes.size * cubes.size;
    const auto [a, b, c] = sheet_triangle(cubes, cell);
    return area_of(cubes.place[a], cubes.place[b], cubes.place[c]).norm();
}

Vec3 cell_middle(const Cubes& cubes, std::size_t cell)
{
    Vec3 sum = Vec3::Zero();
    if (cubes.is_sheet()) {
        for (const auto k : sheet_triangle(cubes, cell)) sum += cubes.place[k] / 3;
    } else {
        for (const auto k : cubes.corners[cell]) sum += cubes.corner_position(k) / 8;
    }
    return sum;
}

TriMesh sheet_mesh(const Cubes& sheet)
{
    TriMesh mesh;
    auto topology = std::make_shared<MeshTopology>();
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        topology->triangles.push_back(sheet_triangle(sheet, c));
    }
    topology->normal_triangles = topology->triangles;
    for (const Vec3& p : sheet.place) mesh.positions.push_back(p.cast<float>());
    for (const Vec3& n : sheet_normals(sheet, sheet.place)) {
        mesh.normals.push_back(n.cast<float>());
    }
    mesh.topology = std::move(topology);
    return mesh;
}

std::vector<Vec3> sheet_normals(const Cubes& sheet, std::span<const Vec3> x)
{
    std::vector<Vec3> normal(sheet.corner_count(), Vec3::Zero());
    for (std::size_t cell = 0; cell < sheet.count(); ++cell) {
        const auto k = sheet_triangle(sheet, cell);
        const Vec3 n = area_of(x[k[0]], x[k[1]], x[k[2]]);
        const double length = n.norm();
        if (!(length > 0) || !std::isfinite(length)) continue;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 u = x[k[(i + 1) % 3]] - x[k[i]], v = x[k[(i + 2) % 3]] - x[k[i]];
            normal[k[i]] += std::atan2(u.cross(v).norm(), u.dot(v)) / length * n;
        }
    }
    for (Vec3& n : normal) {
        const double length = n.norm();
        n = length > 0 && std::isfinite(length) ? Vec3(n / length) : Vec3(Vec3::Zero());
    }
    return normal;
}

}  // namespace geometry
