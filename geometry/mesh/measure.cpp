#include "geometry/mesh/measure.hpp"

#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

std::array<Vec3, 3> corners(const TriMesh& mesh, const Triangle& t)
{
    return {mesh.positions[t[0]].cast<double>(), mesh.positions[t[1]].cast<double>(),
            mesh.positions[t[2]].cast<double>()};
}

void check_same_vertices(const TriMesh& mesh, const TriMesh& rest)
{
    if (mesh.positions.size() != rest.positions.size()) {
        throw std::invalid_argument(fmt::format(
            "the moved mesh has {} vertices, the mesh at rest {}: link `rest` to the mesh that was "
            "embedded. If it is torn, set `torn` of Embed to hide: cutting adds vertices",
            mesh.positions.size(), rest.positions.size()));
    }
}

}  // namespace

std::string far_from_origin(const TriMesh& mesh, const char* remedy)
{
    const Box box = bounds(mesh);
    if (box.empty()) return {};
    const double far = std::max(box.lo.cwiseAbs().maxCoeff(), box.hi.cwiseAbs().maxCoeff());
    const double size = box.size().maxCoeff();
    const double spacing = far * 0x1p-23;  // of numbers there, at most
    if (!(spacing > 1e-3 * size) || !(size > 0)) return {};
    return fmt::format(
        "coordinates near {:.2g} m are rounded to steps of {:.1g} m, which is visible "
        "on a mesh {:.2g} m long: {}",
        far, spacing, size, remedy);
}

double surface_area(const TriMesh& mesh)
{
    double sum = 0;
    for (const Triangle& t : mesh.triangles()) {
        const auto [a, b, c] = corners(mesh, t);
        sum += 0.5 * (b - a).cross(c - a).norm();
    }
    return sum;
}

double enclosed_volume(const TriMesh& mesh)
{
    const Vec3 apex = mesh.positions.empty() ? Vec3(Vec3::Zero()) : bounds(mesh).centre();
    double sum = 0;
    for (const Triangle& t : mesh.triangles()) {
        const auto [a, b, c] = corners(mesh, t);
        sum += (a - apex).dot((b - apex).cross(c - apex)) / 6;
    }
    return sum;
}

Displacement displacement(const TriMesh& mesh, const TriMesh& rest)
{
    check_same_vertices(mesh, rest);
    Displacement out;
    double sum = 0, sum_sq = 0;
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const double d = (mesh.positions[i] - rest.positions[i]).cast<double>().norm();
        sum += d;
        sum_sq += d * d;
        if (exceeds(d, out.largest)) {
            out.largest = d;
            out.where = i;
        }
    }
    if (!mesh.positions.empty()) {
        const auto n = static_cast<double>(mesh.positions.size());
        out.mean = sum / n;
        out.rms = std::sqrt(sum_sq / n);
    }
    return out;
}

Vec3 displacement_at(const TriMesh& mesh, const TriMesh& rest, const Vec3& point)
{
    check_same_vertices(mesh, rest);
    if (rest.positions.empty()) throw std::invalid_argument("expected a mesh with vertices");
    std::size_t nearest = 0;
    double nearest_sq = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < rest.positions.size(); ++i) {
        const double d_sq = (rest.positions[i].cast<double>() - point).squaredNorm();
        if (d_sq < nearest_sq) {
            nearest_sq = d_sq;
            nearest = i;
        }
    }
    return (mesh.positions[nearest] - rest.positions[nearest]).cast<double>();
}

double largest_stretch(const TriMesh& mesh, const TriMesh& rest, double ignore)
{
    check_same_vertices(mesh, rest);
    const double shortest = ignore * bounds(rest).diagonal();
    double largest = 1;
    for (const Triangle& t : rest.triangles()) {
        const auto before = corners(rest, t);
        const auto after = corners(mesh, t);
        for (std::size_t i = 0; i < 3; ++i) {
            const double l = (before[(i + 1) % 3] - before[i]).norm();
            if (l <= shortest) continue;
            const double ratio = (after[(i + 1) % 3] - after[i]).norm() / l;
            if (exceeds(ratio, largest)) largest = ratio;
        }
    }
    return largest;
}

std::array<double, 2> extent(const TriMesh& mesh, const Vec3& direction)
{
    if (mesh.positions.empty()) return {0, 0};
    std::array<double, 2> out{std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity()};
    for (const Vec3f& p : mesh.positions) {
        const double s = p.cast<double>().dot(direction);
        out[0] = std::min(out[0], s);
        out[1] = std::max(out[1], s);
    }
    return out;
}

Spread attribute_spread(const TriMesh& mesh, const std::string& name)
{
    std::string has;
    for (const Attribute& a : mesh.attributes) {
        has += (has.empty() ? "" : ", ") + a.name;
        if (a.name != name) continue;
        Spread out;
        for (std::size_t v = 0; v < a.values.size(); ++v) {
            const auto x = double(a.values[v]);
            if (v == 0 || exceeds(x, out.most)) out.most = x;
            if (v == 0 || exceeds(-x, -out.least)) out.least = x;
            out.mean += x / static_cast<double>(a.values.size());
        }
        return out;
    }
    throw std::invalid_argument(
        fmt::format("the mesh has no attribute '{}'; it has {}", name, has.empty() ? "none" : has));
}

std::string what_place_is_not_finite(const TriMesh& mesh)
{
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3f& p = mesh.positions[i];
        if (!p.allFinite()) {
            return fmt::format("vertex {} is at ({:g}, {:g}, {:g})", i + 1, p.x(), p.y(), p.z());
        }
    }
    return {};
}

std::string what_is_not_finite(const TriMesh& mesh)
{
    if (std::string place = what_place_is_not_finite(mesh); !place.empty()) return place;
    for (std::size_t i = 0; i < mesh.normals.size(); ++i) {
        if (!mesh.normals[i].allFinite()) return fmt::format("normal {} is not finite", i + 1);
    }
    for (const Attribute& a : mesh.attributes) {
        for (std::size_t i = 0; i < a.values.size(); ++i) {
            if (std::isfinite(a.values[i])) continue;
            return fmt::format("'{}' of vertex {} is {:g}", a.name, i + 1, a.values[i]);
        }
    }
    return {};
}

}  // namespace geometry
