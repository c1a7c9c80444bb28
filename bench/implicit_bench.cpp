// Implicit layers: fields asked at scattered points, meshes, contact, whole steps.

#ifdef ASPIC_HAVE_OPENVDB
#include "bench/openvdb_mesher.hpp"
#endif
#include "geometry/base/random.hpp"
#include "geometry/fields/evaluate_points.hpp"
#include "geometry/fields/polygonize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_mesh.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/layered_step.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace {

using namespace geometry;

Vec3 in_unit_cube(const Random& random, std::uint64_t i)
{
    return {random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)};
}

const std::vector<Transform> at_rest{Transform::Identity()};

// `count` point skeletons in the unit cube, whose balls of influence hold a point of it `overlap`
// times on average.
ImplicitLayer balls(std::size_t count, double overlap)
{
    const double n = static_cast<double>(count);
    const double radius = std::cbrt(overlap / n * 3 / (4 * std::numbers::pi));
    ImplicitLayer layer;
    const Random random(1);
    for (std::size_t i = 0; i < count; ++i) {
        layer.skeletons.push_back(
            {.kind = SkeletonKind::point, .points = {in_unit_cube(random, i)}});
        layer.contributions.push_back({0.5 * radius, 2 / radius, radius, 0});
        layer.frame.push_back(0);
    }
    return layer;
}

// Scattered samples a second; the average overlap is the second argument.
void field_samples(benchmark::State& state, BlendRule rule)
{
    ImplicitLayer layer =
        balls(static_cast<std::size_t>(state.range(0)), static_cast<double>(state.range(1)));
    layer.blend.rule = rule;
    layer.blend.part.assign(layer.skeletons.size(), 0);
    for (std::uint32_t i = 0; i < layer.skeletons.size(); ++i) layer.blend.part[i] = i % 3;
    const Field field = make_field(layer, at_rest);
    const Random random(2);
    std::vector<Vec3> points(1'000'000);
    for (std::size_t i = 0; i < points.size(); ++i) points[i] = in_unit_cube(random, i);
    std::vector<double> f(points.size());
    std::vector<Vec3> gradient(points.size());
    for (auto _ : state) {
        evaluate(field, points, f, gradient);
        benchmark::DoNotOptimize(f.data());
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(points.size()));
}
BENCHMARK_CAPTURE(field_samples, sum, BlendRule::sum)
    ->Args({64, 4})
    ->Args({1000, 4})
    ->Args({20000, 4})
    ->Args({1000, 16})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(field_samples, smooth_groups, BlendRule::smooth_groups)
    ->Args({1000, 4})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(field_samples, largest_group, BlendRule::largest_group)
    ->Args({1000, 4})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// 64 balls of the size of Blender's metaballs.
Field metaballs()
{
    ImplicitLayer layer = balls(64, 4);
    for (Contribution& c : layer.contributions) c = {0.11, 15, 0.22, 0};
    return make_field(layer, at_rest);
}

// How good a mesh of the surface is: edges that not just two faces share, the largest distance of a
// vertex from the surface in cells, and the worst shape, 4 sqrt(3) area / sum of squared edges.
void rate(benchmark::State& state, const Field& field, double cell,
          const std::vector<Vec3f>& positions, const std::vector<Triangle>& triangles)
{
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    double worst_shape = 1;
    for (const Triangle& t : triangles) {
        double squares = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto a = t[k], b = t[(k + 1) % 3];
            edges.emplace_back(std::min(a, b), std::max(a, b));
            squares += (positions[a] - positions[b]).cast<double>().squaredNorm();
        }
        const Vec3 p = positions[t[0]].cast<double>(), q = positions[t[1]].cast<double>(),
                   r = positions[t[2]].cast<double>();
        const double area = 0.5 * (q - p).cross(r - p).norm();
        worst_shape = std::min(worst_shape, 4 * std::numbers::sqrt3 * area / squares);
    }
    std::sort(edges.begin(), edges.end());
    double odd_edges = 0;
    for (auto at = edges.begin(); at != edges.end();) {
        const auto next = std::find_if(at, edges.end(), [&](const auto& e) { return e != *at; });
        odd_edges += next - at != 2;
        at = next;
    }
    std::vector<Vec3> points;
    for (const Vec3f& p : positions) points.push_back(p.cast<double>());
    std::vector<double> f(points.size());
    std::vector<Vec3> gradient(points.size());
    evaluate(field, points, f, gradient);
    double off = 0;
    for (std::size_t i = 0; i < f.size(); ++i) {
        off = std::max(off, std::abs(f[i] - field.isovalue) / gradient[i].norm() / cell);
    }
    state.counters["triangles"] = static_cast<double>(triangles.size());
    state.counters["odd_edges"] = odd_edges;
    state.counters["off_surface_cells"] = off;
    state.counters["worst_shape"] = worst_shape;
}

// Field and final mesh in a grid of so many cells a side, by our mesher and by OpenVDB's.
template <class Mesher> void balls_by(benchmark::State& state, const Mesher& mesher)
{
    const Field field = metaballs();
    const IsoField iso = iso_field(field);
    const double cell = iso.domain.size().maxCoeff() / static_cast<double>(state.range(0));
    TriMesh mesh;
    for (auto _ : state) {
        mesh = mesher(iso, cell);
        benchmark::DoNotOptimize(mesh.positions.data());
    }
    rate(state, field, cell, mesh.positions, mesh.triangles());
}
void polygonize_balls(benchmark::State& state)
{
    balls_by(state, [](const IsoField& iso, double cell) { return polygonize(iso, cell); });
}
BENCHMARK(polygonize_balls)
    ->RangeMultiplier(2)
    ->Range(64, 256)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
#ifdef ASPIC_HAVE_OPENVDB
void openvdb_balls(benchmark::State& state)
{
    balls_by(state, [](const IsoField& iso, double cell) {
        return polygonize_by_openvdb(iso, cell, 0, 20'000'000);
    });
}
BENCHMARK(openvdb_balls)
    ->RangeMultiplier(2)
    ->Range(64, 256)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
#endif

// A ball of `skeletons` point skeletons each, two of them pressed together: one step with contact.
physics::LayeredScene pressed_clusters(std::size_t skeletons, double spacing)
{
    std::vector<physics::LayeredPart> parts;
    for (const double side : {-1.0, 1.0}) {
        const Random random(5);
        ImplicitLayer layer;
        for (std::size_t i = 0; i < skeletons; ++i) {
            const Vec3 p = 0.8 * (in_unit_cube(random, i) - Vec3::Constant(0.5));
            layer.skeletons.push_back(
                {.kind = SkeletonKind::point, .points = {p + Vec3(0.45 * side, 0, 0)}});
            const double e = 0.5 / std::cbrt(static_cast<double>(skeletons));
            layer.contributions.push_back({e, 1 / e, 2 * e, 0});
            layer.frame.push_back(0);
        }
        physics::LayeredPart part;
        part.body = std::make_shared<const physics::LayeredBody>(
            physics::make_layered_body(std::move(layer), physics::BaseKind::rigid, 1000, spacing));
        part.velocity = {-0.1 * side, 0, 0};
        parts.push_back(std::move(part));
    }
    return physics::start(std::move(parts));
}

void layered_step(benchmark::State& state)
{
    physics::LayeredScene scene = pressed_clusters(static_cast<std::size_t>(state.range(0)),
                                                   1e-4 * static_cast<double>(state.range(1)));
    std::size_t samples = 0;
    for (const auto& part : scene.parts) samples += part.body->samples.count();
    for (int warm = 0; warm < 3; ++warm) {
        scene = physics::advance(scene, scene.parts, {}, 1.0 / 240, 1);
    }
    for (auto _ : state) {
        auto next = physics::advance(scene, scene.parts, {}, 1.0 / 240, 1);
        benchmark::DoNotOptimize(next.states.data());
    }
    state.counters["seeds"] = static_cast<double>(samples);
}
BENCHMARK(layered_step)
    ->Args({16, 190})
    ->Args({500, 400})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The quick mesh of the same scene, from its samples as the step left them.
void preview(benchmark::State& state)
{
    physics::LayeredScene scene = pressed_clusters(static_cast<std::size_t>(state.range(0)),
                                                   1e-4 * static_cast<double>(state.range(1)));
    for (int warm = 0; warm < 3; ++warm) {
        scene = physics::advance(scene, scene.parts, {}, 1.0 / 240, 1);
    }
    geometry::TriMesh mesh;
    for (auto _ : state) {
        mesh = physics::layered_mesh(scene,
                                     {.surface = physics::LayeredMeshOptions::Surface::samples});
        benchmark::DoNotOptimize(mesh.positions.data());
    }
    state.counters["triangles"] = static_cast<double>(mesh.triangles().size());
}
BENCHMARK(preview)->Args({16, 190})->Args({500, 400})->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
BENCHMARK_MAIN();
