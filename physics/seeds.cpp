#include "physics/seeds.hpp"

#include "geometry/parallel.hpp"
#include "geometry/polygonize.hpp"

#include <Eigen/LU>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>

namespace physics {
namespace {

using geometry::BlockValues;
using geometry::FieldBlock;
using geometry::Foot;
using geometry::Skeleton;
using geometry::SkeletonKind;
using geometry::Triangle;
using geometry::TriMesh;

constexpr double most_seeds = 1e7;

// A sphere of unit directions: each face of an icosahedron in n^2 triangles.
struct Directions {
    std::vector<Vec3> points;
    std::vector<Triangle> faces;
};

Directions geodesic_sphere(int n)
{
    const double g = std::numbers::phi;
    const std::vector<Vec3> corners{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                    {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                    {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    const int faces[20][3] = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                              {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                              {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                              {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    Directions sphere;
    // A point inside a face is its own; on edges and corners it is shared: named by the corners it
    // mixes and how much of each.
    std::map<std::array<int, 6>, std::uint32_t> shared;
    for (const auto& face : faces) {
        const auto point = [&](int a, int b) {
            const int share[3] = {n - a - b, a, b};
            std::array<std::array<int, 2>, 3> parts;
            for (std::size_t i = 0; i < 3; ++i) {
                parts[i] = share[i] > 0 ? std::array{face[i], share[i]} : std::array{-1, 0};
            }
            std::sort(parts.begin(), parts.end());
            const std::array<int, 6> name{parts[0][0], parts[0][1], parts[1][0],
                                          parts[1][1], parts[2][0], parts[2][1]};
            const auto [found, fresh] =
                shared.emplace(name, static_cast<std::uint32_t>(sphere.points.size()));
            if (fresh) {
                Vec3 sum = Vec3::Zero();  // in the order of corners, the same from every face
                for (const auto& [corner, times] : parts) {
                    if (times > 0) sum += times * corners[static_cast<std::size_t>(corner)];
                }
                sphere.points.push_back(sum.normalized());
            }
            return found->second;
        };
        for (int a = 0; a < n; ++a) {
            for (int b = 0; a + b < n; ++b) {
                sphere.faces.push_back({point(a, b), point(a + 1, b), point(a, b + 1)});
                if (a + b + 1 < n) {
                    sphere.faces.push_back({point(a + 1, b), point(a + 1, b + 1), point(a, b + 1)});
                }
            }
        }
    }
    return sphere;
}

// The vertex across the edge opposite each corner of each face; no_seed for an edge that is not one
// of two faces.
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
    std::vector<Triangle> across(faces.size(), Triangle{no_seed, no_seed, no_seed});
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
        while (end < sides.size() && edge(sides[end]) == edge(sides[begin])) ++end;
        if (end - begin != 2) continue;
        const Side &a = sides[begin], &b = sides[begin + 1];
        across[a.face][a.corner] = faces[b.face][b.corner];
        across[b.face][b.corner] = faces[a.face][a.corner];
    }
    return across;
}

// Appends the faces of a skeleton's seeds, which count from `base`.
void add_faces(std::span<const Triangle> faces, std::span<const Triangle> across,
               std::uint32_t base, Seeds& seeds)
{
    seeds.valence.resize(seeds.count(), 0);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        Triangle face = faces[f], beyond = across[f];
        for (std::size_t k = 0; k < 3; ++k) {
            ++seeds.valence[face[k] += base];
            if (beyond[k] != no_seed) beyond[k] += base;
        }
        seeds.faces.push_back(face);
        seeds.across.push_back(beyond);
    }
}

// What a face of unit vectors gives each of its corners and of the vertices across its edges, so
// that sums over all faces integrate smooth functions over the sphere with order 3 to 4. Seen from
// the middle of the sphere, in the plane that touches it at the middle of the face, a function of
// direction is taken as the quadratic through its six values; x there stands for solid angle d^2x /
// (1 + |x|^2)^(3/2). (A third of the solid angle for each corner has order 2.)
Eigen::Matrix<double, 6, 1> solid_angles(const std::array<Vec3, 6>& points)
{
    using Vec2 = Eigen::Vector2d;
    using Vec6 = Eigen::Matrix<double, 6, 1>;
    const Vec3 middle = (points[0] + points[1] + points[2]).normalized();
    const Vec3 u = middle.unitOrthogonal(), v = middle.cross(u);
    std::array<Vec2, 6> x;
    for (std::size_t j = 0; j < 6; ++j) {
        x[j] = Vec2(points[j].dot(u), points[j].dot(v)) / points[j].dot(middle);
    }
    const double size = x[0].norm();
    Eigen::Matrix<double, 6, 6> monomials;  // a row each
    Vec6 measure;
    for (std::size_t j = 0; j < 6; ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        measure[column] = std::pow(1 + x[j].squaredNorm(), -1.5);
        x[j] /= size;
        const double a = x[j].x(), b = x[j].y();
        monomials.col(column) << 1, a, b, a * a, a * b, b * b;
    }
    // Means over the triangle: of x_a x_b, (sum x_a x_b + sum x_a sum x_b) / 12.
    const Vec2 sum = x[0] + x[1] + x[2];
    const Eigen::Matrix2d second = (x[0] * x[0].transpose() + x[1] * x[1].transpose() +
                                    x[2] * x[2].transpose() + sum * sum.transpose()) /
                                   12;
    Vec6 mean;
    mean << 1, sum / 3, second(0, 0), second(0, 1), second(1, 1);
    const Vec2 ab = x[1] - x[0], ac = x[2] - x[0];
    const double area = 0.5 * size * size * std::abs(ab.x() * ac.y() - ab.y() * ac.x());
    return area * monomials.partialPivLu().solve(mean).cwiseProduct(measure);
}

void add_point_seeds(const Vec3& centre, double thickness, double spacing, Seeds& seeds)
{
    // 10 n^2 + 2 seeds, each with a hexagon of sqrt(3)/2 spacing^2.
    const double seeds_wanted =
        4 * std::numbers::pi * thickness * thickness / (0.866 * spacing * spacing);
    const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(seeds_wanted / 10))));
    const Directions sphere = geodesic_sphere(n);
    const auto base = static_cast<std::uint32_t>(seeds.count());
    for (const Vec3& d : sphere.points) {
        seeds.origin.push_back(centre);
        seeds.direction.push_back(d);
        seeds.a0.push_back(0);
        seeds.a1.push_back(0);
        seeds.a2.push_back(0);
    }
    const std::vector<Triangle> across = across_edges(sphere.faces);
    double total = 0;
    for (std::size_t f = 0; f < sphere.faces.size(); ++f) {
        std::array<std::uint32_t, 6> near;
        std::array<Vec3, 6> points;
        for (std::size_t k = 0; k < 6; ++k) {
            near[k] = k < 3 ? sphere.faces[f][k] : across[f][k - 3];
            points[k] = sphere.points[near[k]];
        }
        const Eigen::Matrix<double, 6, 1> share = solid_angles(points);
        for (std::size_t k = 0; k < 6; ++k) {
            seeds.a2[base + near[k]] += share[static_cast<Eigen::Index>(k)];
        }
        total += share.sum();
    }
    for (std::size_t i = base; i < seeds.count(); ++i) seeds.a2[i] *= 4 * std::numbers::pi / total;
    add_faces(sphere.faces, across, base, seeds);
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

// Seeds of any other skeleton: the vertices of the surface it has alone, each with its share of
// that surface. Principal curvatures h1, h2 of the surface, at distance e, are eigenvalues of the
// Hessian of r, so at distance d the share is (1 + (d - e) h1)(1 + (d - e) h2) times as large.
void add_surface_seeds(const ImplicitLayer& layer, std::size_t i, double spacing, Seeds& seeds)
{
    const Skeleton& s = layer.skeletons[i];
    const double e = layer.contributions[i].thickness;
    ImplicitLayer alone;
    alone.isovalue = layer.isovalue;
    alone.skeletons = {s};
    alone.contributions = {layer.contributions[i]};
    alone.frame = {0};
    const Transform here = Transform::Identity();
    const Field field = geometry::make_field(alone, {&here, 1});
    const TriMesh mesh =
        geometry::polygonize(geometry::iso_field(field), spacing, geometry::unlimited);

    std::vector<double> share(mesh.positions.size(), 0);
    for (const Triangle& t : mesh.triangles()) {
        const auto p = [&](std::size_t k) { return Vec3(mesh.positions[t[k]].cast<double>()); };
        const double third = (p(1) - p(0)).cross(p(2) - p(0)).norm() / 6;
        for (const std::uint32_t v : t) share[v] += third;
    }
    const auto base = static_cast<std::uint32_t>(seeds.count());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 p = mesh.positions[v].cast<double>();
        const Foot foot = geometry::foot(field, 0, p);
        const double sum = foot.hessian.trace();
        const double product = 0.5 * (sum * sum - (foot.hessian * foot.hessian).trace());
        seeds.origin.push_back(p - foot.r * foot.n);
        seeds.direction.push_back(foot.n);
        seeds.a0.push_back(share[v] * (1 - e * sum + e * e * product));
        seeds.a1.push_back(share[v] * (sum - 2 * e * product));
        seeds.a2.push_back(share[v] * product);
    }
    add_faces(mesh.triangles(), across_edges(mesh.triangles()), base, seeds);
    const Vec3 totals = steiner_totals(s);
    const auto scale = [&](std::vector<double>& a, double to) {
        double sum = 0;
        for (std::size_t k = base; k < a.size(); ++k) {
            a[k] = std::max(0.0, a[k]);  // no less than round-off
            sum += a[k];
        }
        for (std::size_t k = base; k < a.size() && sum > 0; ++k) a[k] *= to / sum;
    };
    if (totals[2] > 0) {
        scale(seeds.a0, totals[0]);
        scale(seeds.a1, totals[1]);
        scale(seeds.a2, totals[2]);
    }
}

}  // namespace

Seeds make_seeds(const ImplicitLayer& layer, double spacing)
{
    if (!(spacing > 0) || !std::isfinite(spacing)) {
        throw std::invalid_argument(
            fmt::format("seeds: expected a spacing above 0 m, got {}", spacing));
    }
    Seeds seeds;
    seeds.frame = layer.frame;
    seeds.first.push_back(0);
    for (std::size_t i = 0; i < layer.skeletons.size(); ++i) {
        const Skeleton& s = layer.skeletons[i];
        geometry::check(s);
        const double e = layer.contributions[i].thickness;
        if (s.kind != SkeletonKind::plane) {
            Box box;
            for (const Vec3& p : s.points) box.add(p);
            if (s.mesh) box.add(geometry::bounds(s.mesh->mesh));
            const bool solid = s.kind == SkeletonKind::box || s.kind == SkeletonKind::ellipsoid;
            const double width = box.diagonal() + (solid ? 2 * s.half_size.norm() : 0) + 2 * e;
            if (4 * width * width / (spacing * spacing) > most_seeds) {
                throw std::invalid_argument(fmt::format(
                    "seeds: a spacing of {} m on skeleton {}, about {} m wide, gives more than {} "
                    "seeds; space them wider",
                    spacing, i, width, most_seeds));
            }
        }
        if (s.kind == SkeletonKind::point) {
            add_point_seeds(s.points[0], e, spacing, seeds);
        } else if (s.kind != SkeletonKind::plane) {
            add_surface_seeds(layer, i, spacing, seeds);
        }
        if (s.kind != SkeletonKind::plane && seeds.count() < seeds.first.back() + 12) {
            throw std::invalid_argument(fmt::format(
                "seeds: a spacing of {:g} m leaves skeleton {}, counted from 0, {} samples to meet "
                "others with; space them a tenth of its width apart, or less",
                spacing, i, seeds.count() - seeds.first.back()));
        }
        seeds.first.push_back(static_cast<std::uint32_t>(seeds.count()));
        seeds.core.push_back(core_volume(s));
    }
    return seeds;
}

double SeedWalk::volume() const
{
    double sum = 0;
    for (const double v : local_volume) sum += v;
    return sum;
}

namespace {

// Up to a block of seeds of one skeleton.
struct Batch {
    std::uint32_t skeleton, begin, end;
};

// One seed on its way: it stops at the first zero of
//   chi(t) = min(f - c, f_own - f_rival)
// between `inside`, where chi > 0 (or t = 0), and `outside`, where it is not.
struct Walker {
    double t = 0, inside = 0, outside = 0;
    bool done = false;
};

// Newton's step from t for a function of this value and slope; its bracket's middle when the step
// leaves the bracket.
double step(const Walker& w, double phi, double phi_slope, double psi, double psi_slope)
{
    double next = std::numeric_limits<double>::infinity();
    if (phi_slope < 0) next = std::min(next, w.t - phi / phi_slope);
    if (psi_slope < 0) next = std::min(next, w.t - psi / psi_slope);
    if (next > w.inside && next <= w.outside) return next;
    return 0.5 * (w.inside + w.outside);
}

// What a batch adds to dV/dtau of each skeleton.
using Slopes = std::vector<std::pair<std::uint32_t, double>>;

// A seed's share of dV/dtau of every skeleton that was evaluated at point k.
void add_slopes(const geometry::FieldScratch& scratch, std::size_t k, double weight, Slopes& slopes)
{
    for (std::size_t s = 0; s < scratch.near.size(); ++s) {
        const BlockValues& one = scratch.each[s];
        if (!(one.f[k] > 0)) continue;
        const double share =
            scratch.share.empty() ? 1 : scratch.share[s * FieldBlock::capacity + k];
        const auto found = std::find_if(slopes.begin(), slopes.end(), [&](const auto& slope) {
            return slope.first == scratch.near[s];
        });
        const double own = weight * share * one.gradient(k).norm();
        if (found != slopes.end()) {
            found->second += own;
        } else {
            slopes.emplace_back(scratch.near[s], own);
        }
    }
}

void walk_batch(const Field& field, const Seeds& seeds, const Transform& frame, const Batch& batch,
                const SeedWalk* before, SeedWalk& result, Slopes* slopes)
{
    thread_local std::vector<std::uint32_t> near;
    thread_local geometry::FieldScratch scratch;
    thread_local geometry::TerritoryValues values;
    thread_local FieldBlock block;
    const std::uint32_t own = batch.skeleton;
    const double reach = field.profile[own].R, c = field.isovalue;
    const std::size_t n = batch.end - batch.begin;

    geometry::candidates(field, field.influence[own], near);
    if (field.rule != geometry::BlendRule::sum) {
        std::erase_if(near, [&](std::uint32_t j) { return !(field.weights(own, j) > 0); });
    }
    std::vector<Vec3> origin(n), direction(n);
    std::vector<Walker> walkers(n);
    std::vector<std::size_t> active(n);
    for (std::size_t i = 0; i < n; ++i) {
        origin[i] = frame * seeds.origin[batch.begin + i];
        direction[i] = frame.linear() * seeds.direction[batch.begin + i];
        walkers[i].outside = std::max(0.0, reach);
        walkers[i].t = before ? before->distance[batch.begin + i] : field.profile[own].e;
        walkers[i].t = std::clamp(walkers[i].t, 0.0, walkers[i].outside);
        active[i] = i;
    }
    const double tolerance = 1e-12 * std::max(field.profile[own].e, 1e-3 * reach);
    for (int round = 0; round < 100 && !active.empty(); ++round) {
        block.count = 0;
        for (const std::size_t i : active) block.add(origin[i] + walkers[i].t * direction[i]);
        block.pad();
        geometry::evaluate(field, near, own, block, scratch, values);
        std::size_t left = 0;
        for (std::size_t k = 0; k < active.size(); ++k) {
            const std::size_t i = active[k];
            Walker& w = walkers[i];
            const double phi = values.blend.f[k] - c;
            const double psi = values.own.f[k] - values.rival.f[k];
            const double phi_slope = direction[i].dot(values.blend.gradient(k));
            const double psi_slope =
                direction[i].dot(values.own.gradient(k) - values.rival.gradient(k));
            if (std::min(phi, psi) > 0)
                w.inside = w.t;
            else
                w.outside = w.t;
            const double next = step(w, phi, phi_slope, psi, psi_slope);
            w.done = std::abs(next - w.t) <= tolerance || w.outside - w.inside <= tolerance;
            const double at = w.t;
            if (!w.done) {
                w.t = next;
                active[left++] = i;
                continue;
            }
            // Converged: keep what was asked here. On the surface unless the border came first.
            const std::size_t seed = batch.begin + i;
            const Vec3 gradient = values.blend.gradient(k);
            const double slope = gradient.norm();
            const double cosine = slope > 0 ? -phi_slope / slope : 0;
            const bool on_surface = std::abs(phi) <= 10 * tolerance * slope + 1e-13 * c;
            const bool own_ground = psi >= -(10 * tolerance * std::abs(psi_slope) + 1e-13 * c);
            result.distance[seed] = at;
            result.position[seed] = block.point(k);
            result.gradient[seed] = gradient;
            result.valid[seed] = on_surface && own_ground && cosine > 1e-6;
            const double across = seeds.a0[seed] + at * (seeds.a1[seed] + at * seeds.a2[seed]);
            result.area[seed] = result.valid[seed] ? across / cosine : 0;
            if (slopes && result.valid[seed]) {
                add_slopes(scratch, k, across / -phi_slope, *slopes);
            }
        }
        active.resize(left);
    }
    for (const std::size_t i : active) {  // a field with a jump in it: as near as it came
        const std::size_t seed = batch.begin + i;
        result.distance[seed] = walkers[i].inside;
        result.position[seed] = origin[i] + walkers[i].inside * direction[i];
        result.gradient[seed] = -direction[i];
        result.valid[seed] = 0;
        result.area[seed] = 0;
    }
}

}  // namespace

SeedWalk walk(const Field& field, const Seeds& seeds, std::span<const Transform> frames,
              const SeedWalk* before, bool slopes)
{
    if (seeds.skeletons() != field.count() ||
        (before && before->distance.size() != seeds.count())) {
        throw std::invalid_argument(fmt::format(
            "seeds of {} skeletons cannot walk on a field of {}, or {} seeds from a walk of {}",
            seeds.skeletons(), field.count(), seeds.count(),
            before ? before->distance.size() : seeds.count()));
    }
    SeedWalk result;
    result.distance.resize(seeds.count());
    result.valid.resize(seeds.count());
    result.position.resize(seeds.count());
    result.gradient.resize(seeds.count());
    result.area.resize(seeds.count());
    result.local_volume.resize(seeds.skeletons());

    std::vector<Batch> batches;
    for (std::uint32_t s = 0; s < seeds.skeletons(); ++s) {
        constexpr auto most = static_cast<std::uint32_t>(FieldBlock::capacity);
        for (std::uint32_t b = seeds.first[s]; b < seeds.first[s + 1]; b += most) {
            batches.push_back({s, b, std::min(b + most, seeds.first[s + 1])});
        }
    }
    std::vector<Slopes> found(slopes ? batches.size() : 0);
    geometry::parallel_for(batches.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            walk_batch(field, seeds, frames[seeds.frame[batches[b].skeleton]], batches[b], before,
                       result, slopes ? &found[b] : nullptr);
        }
    });
    if (slopes) {
        result.volume_slope.assign(seeds.skeletons(), 0);
        for (const Slopes& some : found) {
            for (const auto& [skeleton, slope] : some) result.volume_slope[skeleton] += slope;
        }
    }
    for (std::size_t s = 0; s < seeds.skeletons(); ++s) {
        double volume = seeds.core[s];
        for (std::size_t i = seeds.first[s]; i < seeds.first[s + 1]; ++i) {
            volume += seeds.swept(i, result.distance[i]);
        }
        result.local_volume[s] = volume;
    }
    return result;
}

geometry::TriMesh preview_mesh(const Seeds& seeds, const SeedWalk& walk)
{
    TriMesh mesh;
    mesh.positions.reserve(seeds.count());
    mesh.normals.reserve(seeds.count());
    for (std::size_t i = 0; i < seeds.count(); ++i) {
        mesh.positions.push_back(walk.position[i].cast<float>());
        const double slope = walk.gradient[i].norm();
        mesh.normals.push_back(slope > 0
                                   ? geometry::Vec3f((-walk.gradient[i] / slope).cast<float>())
                                   : geometry::Vec3f(geometry::Vec3f::UnitY()));
    }
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (const Triangle& t : seeds.faces) {
        if (walk.valid[t[0]] || walk.valid[t[1]] || walk.valid[t[2]]) {
            topology->triangles.push_back(t);
        }
    }
    topology->normal_triangles = topology->triangles;
    mesh.topology = std::move(topology);
    return mesh;
}

}  // namespace physics
