#include "physics/layers/surface_samples.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/fields/polygonize.hpp"
#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layers/geodesic_sphere.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>

namespace physics {
namespace {

using geometry::Foot;
using geometry::Mat3;
using geometry::Skeleton;
using geometry::SkeletonKind;
using geometry::Triangle;
using geometry::TriMesh;

constexpr double most_samples = 1e7;

// The vertex across the edge opposite each corner of each face; no_sample for an edge that is not
// one of two faces.
std::vector<Triangle> across_edges(std::span<const Triangle> faces)
{
    struct Side {
        std::uint32_t low, high, face, corner;
    };
    std::vector<Side> sides;
    sides.reserve(3 * faces.size());
    for (std::uint32_t f = 0; f < faces.size(); ++f) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = faces[f][(k + 1) % 3], b = faces[f][(k + 2) % 3];
            sides.push_back({std::min(a, b), std::max(a, b), f, k});
        }
    }
    const auto edge = [](const Side& s) { return std::pair(s.low, s.high); };
    std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) {
        return std::tuple(a.low, a.high, a.face) < std::tuple(b.low, b.high, b.face);
    });
    std::vector<Triangle> across(faces.size(), Triangle{no_sample, no_sample, no_sample});
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && edge(sides[end]) == edge(sides[begin])) ++end;
        if (end - begin != 2) continue;
        const Side &a = sides[begin], &b = sides[begin + 1];
        across[a.face][a.corner] = faces[b.face][b.corner];
        across[b.face][b.corner] = faces[a.face][a.corner];
    }
    return across;
}

// Appends the faces of a skeleton's samples, which count from `base`.
void add_faces(std::span<const Triangle> faces, std::span<const Triangle> across,
               std::uint32_t base, SurfaceSamples& samples)
{
    samples.valence.resize(samples.count(), 0);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        Triangle face = faces[f], beyond = across[f];
        for (std::size_t k = 0; k < 3; ++k) {
            ++samples.valence[face[k] += base];
            if (beyond[k] != no_sample) beyond[k] += base;
        }
        samples.faces.push_back(face);
        samples.across.push_back(beyond);
    }
}

// A sphere of 10 n^2 + 2 samples: made once for all points that take as many.
struct SphereSamples {
    GeodesicSphere sphere;
    std::vector<Triangle> across;
    std::vector<double> share;  // of the whole solid angle, of each sample
};

SphereSamples make_sphere(int n)
{
    SphereSamples out{geodesic_sphere(n), {}, {}};
    const GeodesicSphere& sphere = out.sphere;
    out.across = across_edges(sphere.faces);
    out.share.assign(sphere.points.size(), 0);
    double total = 0;
    geometry::StopCheck check;
    for (std::size_t f = 0; f < sphere.faces.size(); ++f) {
        check();
        std::array<std::uint32_t, 6> near;
        std::array<Vec3, 6> points;
        for (std::size_t k = 0; k < 6; ++k) {
            near[k] = k < 3 ? sphere.faces[f][k] : out.across[f][k - 3];
            points[k] = sphere.points[near[k]];
        }
        const Eigen::Matrix<double, 6, 1> share = solid_angles(points);
        for (std::size_t k = 0; k < 6; ++k) {
            out.share[near[k]] += share[static_cast<Eigen::Index>(k)];
        }
        total += share.sum();
    }
    for (double& share : out.share) share *= 4 * std::numbers::pi / total;
    return out;
}

using Spheres = std::map<int, SphereSamples>;  // by n

void add_point_samples(const Vec3& centre, double thickness, double spacing, Spheres& spheres,
                       SurfaceSamples& samples)
{
    // 10 n^2 + 2 samples, each with a hexagon of sqrt(3)/2 spacing^2.
    const double samples_wanted =
        4 * std::numbers::pi * thickness * thickness / (0.866 * spacing * spacing);
    const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(samples_wanted / 10))));
    auto known = spheres.find(n);
    if (known == spheres.end()) known = spheres.emplace(n, make_sphere(n)).first;
    const SphereSamples& unit = known->second;
    const auto base = static_cast<std::uint32_t>(samples.count());
    for (std::size_t i = 0; i < unit.share.size(); ++i) {
        samples.origin.push_back(centre);
        samples.direction.push_back(unit.sphere.points[i]);
        samples.a0.push_back(0);
        samples.a1.push_back(0);
        samples.a2.push_back(unit.share[i]);
    }
    add_faces(unit.sphere.faces, unit.across, base, samples);
}

// What the shares of edges, corners and faces of a convex skeleton add up to: sum of a0, a1, a2.
Vec3 steiner_totals(const Skeleton& s)
{
    constexpr double pi = std::numbers::pi;
    switch (s.kind) {
    case SkeletonKind::segment:
        return {0, 2 * pi * (s.points[1] - s.points[0]).norm(), 4 * pi};
    case SkeletonKind::triangle: {
        const Vec3 a = s.points[1] - s.points[0], b = s.points[2] - s.points[0];
        return {a.cross(b).norm(), pi * (a.norm() + b.norm() + (a - b).norm()), 4 * pi};
    }
    case SkeletonKind::box: {
        const Vec3 e = 2 * s.half_size;
        return {2 * (e.x() * e.y() + e.y() * e.z() + e.z() * e.x()), 2 * pi * e.sum(), 4 * pi};
    }
    case SkeletonKind::cylinder:
    case SkeletonKind::cone: {
        // Each rim turns by an angle; the slope's own curvature is 2 pi for each metre of height.
        const geometry::RoundShape c = geometry::round_shape(s.kind, s.half_size);
        const double slant = std::hypot(c.base - c.top, 2 * c.height);
        const double at_base = std::acos((c.top - c.base) / slant), at_top = pi - at_base;
        return {pi * (c.base * c.base + c.top * c.top + (c.base + c.top) * slant),
                2 * pi * (2 * c.height + c.base * at_base + c.top * at_top), 4 * pi};
    }
    default:
        return Vec3::Zero();  // not known in a closed form, or not convex
    }
}

double core_volume(const Skeleton& s)
{
    switch (s.kind) {
    case SkeletonKind::box:
        return 8 * s.half_size.prod();
    case SkeletonKind::ellipsoid:
        return 4 * std::numbers::pi / 3 * s.half_size.prod();
    case SkeletonKind::torus: {
        const geometry::RoundShape t = geometry::round_shape(s.kind, s.half_size);
        return 2 * std::numbers::pi * std::numbers::pi * t.ring * t.tube * t.tube;
    }
    case SkeletonKind::cylinder:
    case SkeletonKind::cone: {
        const geometry::RoundShape c = geometry::round_shape(s.kind, s.half_size);
        return 2 * std::numbers::pi / 3 * c.height *
               (c.base * c.base + c.base * c.top + c.top * c.top);
    }
    case SkeletonKind::mesh: {
        double volume = 0;
        const TriMesh& mesh = s.mesh->mesh;
        for (const Triangle& t : mesh.triangles()) {
            volume +=
                mesh.positions[t[0]].cast<double>().dot(mesh.positions[t[1]].cast<double>().cross(
                    mesh.positions[t[2]].cast<double>())) /
                6;
        }
        return volume;
    }
    default:
        return 0;
    }
}

// Whether the surface is curved inward somewhere, so that shares of edges and corners may be below
// zero.
bool bends_inward(SkeletonKind kind)
{
    return kind == SkeletonKind::curve || kind == SkeletonKind::torus;
}

// What a stretched skeleton is in narrowed space.
Skeleton narrowed(Skeleton s)
{
    if (!s.stretches()) return s;
    const Mat3 narrow = s.stretch.inverse();
    for (Vec3& p : s.points) p = narrow * p;
    s.stretch = Mat3::Identity();
    return s;
}

// Takes samples from narrowed space: by A n of a direction n, a distance grows by |A n|, volumes by
// det A, and so an area square to the ray by det A / |A n|.
void widen(const Mat3& stretch, std::size_t begin, SurfaceSamples& samples)
{
    const double volume = stretch.determinant();
    for (std::size_t i = begin; i < samples.count(); ++i) {
        samples.origin[i] = stretch * samples.origin[i];
        const Vec3 along = stretch * samples.direction[i];
        const double length = along.norm();
        samples.direction[i] = along / length;
        samples.a0[i] *= volume / length;
        samples.a1[i] *= volume / (length * length);
        samples.a2[i] *= volume / (length * length * length);
    }
}

// By how much an area grows at most: by the two largest eigenvalues.
double largest_growth(const Mat3& stretch)
{
    return stretch.determinant() / Eigen::SelfAdjointEigenSolver<Mat3>(stretch).eigenvalues()[0];
}

// Samples of any other skeleton: the vertices of the surface it has alone, each with its share of
// that surface. Principal curvatures h1, h2 of the surface, at distance e, are eigenvalues of the
// Hessian of r, so at distance d the share is (1 + (d - e) h1)(1 + (d - e) h2) times as large.
// `s`: the skeleton `drawn` in narrowed space, where these lie.
void add_surface_samples(const Skeleton& drawn, const Skeleton& s,
                         const geometry::Contribution& contribution, double isovalue,
                         double spacing, SurfaceSamples& samples)
{
    const double e = contribution.thickness;
    ImplicitLayer alone;
    alone.isovalue = isovalue;
    alone.skeletons = {drawn};
    alone.contributions = {contribution};
    alone.frame = {0};
    const Transform here = Transform::Identity();
    Field field = geometry::make_field(alone, {&here, 1});
    // Not of `s`: a curve through narrowed positions is another than the narrowed curve.
    if (drawn.stretches()) field = geometry::narrowed(std::move(field));
    const TriMesh mesh =
        geometry::polygonize(geometry::iso_field(field), spacing, geometry::unlimited);

    std::vector<double> share(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles()) {
        const auto p = [&](std::size_t k) { return Vec3(mesh.positions[t[k]].cast<double>()); };
        const double third = (p(1) - p(0)).cross(p(2) - p(0)).norm() / 6;
        for (const std::uint32_t v : t) share[v] += third;
    }
    const auto base = static_cast<std::uint32_t>(samples.count());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 p = mesh.positions[v].cast<double>();
        const Foot foot = geometry::foot(field, 0, p);
        const double sum = foot.hessian.trace();
        const double product = 0.5 * (sum * sum - (foot.hessian * foot.hessian).trace());
        samples.origin.push_back(p - foot.r * foot.n);
        samples.direction.push_back(foot.n);
        samples.a0.push_back(share[v] * (1 - e * sum + e * e * product));
        samples.a1.push_back(share[v] * (sum - 2 * e * product));
        samples.a2.push_back(share[v] * product);
    }
    add_faces(mesh.triangles(), across_edges(mesh.triangles()), base, samples);
    const Vec3 totals = steiner_totals(s);
    const auto scale = [&](std::vector<double>& a, double to) {
        double sum = 0;
        for (std::size_t k = base; k < a.size(); ++k) {
            if (!bends_inward(s.kind)) a[k] = std::max(0.0, a[k]);  // no less than round-off
            sum += a[k];
        }
        for (std::size_t k = base; k < a.size() && sum > 0; ++k) a[k] *= to / sum;
    };
    if (totals[2] > 0) {
        scale(samples.a0, totals[0]);
        scale(samples.a1, totals[1]);
        scale(samples.a2, totals[2]);
    }
}

}  // namespace

SurfaceSamples make_surface_samples(const ImplicitLayer& layer, double asked)
{
    if (!(asked > 0) || !std::isfinite(asked)) {
        throw std::invalid_argument(fmt::format("seed_spacing must be above 0 m, got {}.", asked));
    }
    SurfaceSamples samples;
    samples.frame = layer.frame;
    samples.first.push_back(0);
    Spheres spheres;
    for (std::size_t i = 0; i < layer.skeletons.size(); ++i) {
        geometry::stop_if_asked();
        const Skeleton& drawn = layer.skeletons[i];
        geometry::check(drawn);
        const Mat3& stretch = drawn.stretch;
        const bool stretches = drawn.stretches();
        const Skeleton s = narrowed(drawn);
        const double spacing = stretches ? asked / std::sqrt(largest_growth(stretch)) : asked;
        const double e = layer.contributions[i].thickness;
        if (s.kind != SkeletonKind::plane) {
            Box box;
            for (const Vec3& p : s.points) box.add(p);
            if (s.mesh) box.add(geometry::bounds(s.mesh->mesh));
            const bool sized = geometry::is_solid(s.kind) && s.kind != SkeletonKind::mesh;
            const Vec3 half = geometry::half_extent(s.kind, s.half_size);
            const double width = box.diagonal() + (sized ? 2 * half.norm() : 0) + 2 * e;
            if (4 * width * width / (spacing * spacing) > most_samples) {
                throw std::invalid_argument(
                    fmt::format("seed_spacing = {} m is too small for skeleton {} (about {} m "
                                "wide): it would emit "
                                "more than {} samples. Use a larger spacing.",
                                asked, i, width * geometry::stretch_of(drawn).most, most_samples));
            }
        }
        if (s.kind == SkeletonKind::point) {
            add_point_samples(s.points[0], e, spacing, spheres, samples);
        } else if (s.kind != SkeletonKind::plane) {
            add_surface_samples(drawn, s, layer.contributions[i], layer.isovalue, spacing, samples);
        }
        if (stretches) widen(stretch, samples.first.back(), samples);
        if (s.kind != SkeletonKind::plane && samples.count() < samples.first.back() + 12) {
            throw std::invalid_argument(
                fmt::format("seed_spacing = {:g} m is too large for skeleton {} (counted from 0): "
                            "only {} samples "
                            "would find its contacts. Use a tenth of its width, or less.",
                            asked, i, samples.count() - samples.first.back()));
        }
        samples.first.push_back(static_cast<std::uint32_t>(samples.count()));
        samples.core.push_back(core_volume(s));
    }
    return samples;
}

}  // namespace physics
