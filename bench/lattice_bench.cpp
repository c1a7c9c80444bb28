// Lattice shape matching, a particle and step at a time, beside Bullet's soft bodies on the same
// lattice where Bullet is found.

#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/lattice/torn_regions.hpp"
#include "physics/regions/find_regions.hpp"
#include "physics/regions/region_sums.hpp"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <numbers>

namespace {

using namespace physics;

geometry::Cubes block(int n)
{
    std::vector<geometry::Vec3i> cells;
    for (int z = 0; z < n; ++z) {
        for (int y = 0; y < n; ++y) {
            for (int x = 0; x < n; ++x) cells.emplace_back(x, y, z);
        }
    }
    return geometry::solid_cubes(std::move(cells), 0.05);
}

// What a body and where it is keep.
double bytes_a_particle(const LatticeBody& body, const State& state)
{
    return double(body.bytes() + state.rotation.size() * sizeof(float) +
                  (state.x.size() + state.v.size()) * sizeof(geometry::Vec3)) /
           double(state.x.size());
}

// Arguments: cubes along an edge, half width, threads.
void lattice(benchmark::State& state)
{
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(state.range(2)));
    const geometry::Cubes cubes = block(int(state.range(0)));
    const LatticeOptions options{
        .half_width = int(state.range(1)), .stiffness = Stiffness::rate, .substeps = 10};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    // Squashed, and turning once a second: so whatever the width, no rotation is that of the step
    // before.
    State motion = rest_state(body);
    const geometry::Vec3 spin = 2 * std::numbers::pi * geometry::Vec3(0.36, 0.48, 0.8);
    for (std::size_t i = 0; i < motion.x.size(); ++i) {
        motion.x[i][1] *= 1.05;
        motion.v[i] = spin.cross(motion.x[i]);
    }
    motion = advance(body, std::move(motion), loads, 1.0 / 24, options);  // finds room
    for (auto _ : state) motion = advance(body, std::move(motion), loads, 1.0 / 24, options);
    const auto steps = double(state.iterations()) * options.substeps;
    state.counters["particle_step"] =
        benchmark::Counter(steps * double(cubes.corner_count()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["bytes_a_particle"] = bytes_a_particle(body, motion);
}
BENCHMARK(lattice)
    ->Args({45, 1, 1})
    ->Args({45, 2, 1})
    ->Args({45, 3, 1})
    ->Args({45, 4, 1})
    ->Args({45, 6, 1})
    ->Args({45, 16, 1})
    ->Args({45, 3, 2})
    ->Args({99, 3, 1})
    ->Args({99, 3, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The sums alone, there and back, over 46^3 particles on one thread, after what the rest of a step
// goes through has been in the cache. Argument: half width.
template <class T> void sums(benchmark::State& state)
{
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Lattice particles = corner_lattice(block(45));
    const LatticeRegions regions = find_regions(particles, int(state.range(0)));
    RegionSums<T> room(regions);
    std::vector<float> rest_of_step(100 / sizeof(float) * particles.count());  // 100 bytes each
    for (auto _ : state) {
        state.PauseTiming();
        for (float& number : rest_of_step) number += 1;
        for (auto& f : room.particles) f = Quad<T>(1, 2, 3, 4);
        state.ResumeTiming();
        collect_and_spread<T>(regions, room, [](std::size_t, std::span<Quad<T>>) {});
    }
    state.counters["particle_step"] =
        benchmark::Counter(double(state.iterations()) * double(particles.count()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
void half_widths(benchmark::internal::Benchmark* sums)
{
    for (const int w : {1, 2, 3, 4, 6, 10, 16}) sums->Arg(w);
    sums->Unit(benchmark::kMillisecond)->UseRealTime();
}
BENCHMARK_TEMPLATE(sums, float)->Apply(half_widths);
BENCHMARK_TEMPLATE(sums, double)->Apply(half_widths);

// What a body costs before its first step. Arguments: cubes along an edge, half width.
void make(benchmark::State& state)
{
    const geometry::Cubes cubes = block(int(state.range(0)));
    const LatticeOptions options{.half_width = int(state.range(1))};
    for (auto _ : state) benchmark::DoNotOptimize(make_lattice(cubes, options).whole.mass.data());
}
BENCHMARK(make)
    ->Args({45, 1})
    ->Args({45, 3})
    ->Args({45, 16})
    ->Args({99, 3})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// Regions after ten more links of two thousand have broken, side by side; where nothing is known of
// those that broke before, all are found anew.
void tear(benchmark::State& state, const geometry::Cubes& cubes, const LatticeOptions& options,
          bool anew)
{
    const LatticeBody body = make_lattice(cubes, options);
    const auto [low, high] =
        std::ranges::minmax(cubes.corner, {}, [](const auto& p) { return p[0]; });
    std::vector<std::uint32_t> links;
    for (std::uint32_t i = 0; i < cubes.corner_count(); ++i) {
        const int x = cubes.corner[i][0] - low[0];
        if (x % 12 == 5 && x < high[0] - low[0]) links.push_back(3 * i);
    }
    std::size_t first = 0, last = 2000;
    const auto find = [&] {
        const std::vector<std::uint32_t> broken(links.begin() + std::ptrdiff_t(first),
                                                links.begin() + std::ptrdiff_t(last));
        benchmark::DoNotOptimize(body.torn->find(body.whole, broken).get());
    };
    find();
    for (auto _ : state) {
        last += 10;
        if (anew) first += 10;
        if (last > links.size()) {
            state.PauseTiming();
            first = 0, last = 2000;
            find();
            state.ResumeTiming();
        }
        find();
    }
}
void tear_solid(benchmark::State& state, int half_width, bool plastic, bool anew)
{
    const double yield = plastic ? 0.1 : 0;
    tear(state, block(45), {.half_width = half_width, .plastic = {.yield = yield}, .tear = 1},
         anew);
}
void tear_plane(benchmark::State& state, int half_width, bool anew)
{
    const int n = 316;
    tear(state, geometry::plane_cubes(geometry::rectangle_cells(n, n), {1, 0.05, {0, 0, 0}}, 0.01),
         {.half_width = half_width, .tear = 1}, anew);
}
BENCHMARK_CAPTURE(tear_solid, w_3, 3, false, false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(tear_solid, w_3_anew, 3, false, true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(tear_solid, w_8, 8, false, false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(tear_solid, plastic, 3, true, false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(tear_plane, w_3, 3, false)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(tear_plane, w_3_anew, 3, true)->Unit(benchmark::kMillisecond)->UseRealTime();

// A sheet of n x n cells in space; arguments: n, half width, threads, and whether its stretch is a
// membrane's: as thin as paper, or as stiff in bending as in stretch.
void plane(benchmark::State& state)
{
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(state.range(2)));
    const int n = int(state.range(0));
    const geometry::Cubes cubes =
        geometry::plane_cubes(geometry::rectangle_cells(n, n), {1, 0.05, {0, 0, 0}}, 0.01);
    const LatticeOptions options{.half_width = int(state.range(1)),
                                 .stiffness = Stiffness::rate,
                                 .bend = state.range(3) ? 1e-3 : 1,
                                 .substeps = 10};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    State motion = rest_state(body);
    for (auto& x : motion.x) x[1] += 0.05 * std::sin(2 * x[0]);
    motion = advance(body, std::move(motion), loads, 1.0 / 24, options);  // finds room
    for (auto _ : state) motion = advance(body, std::move(motion), loads, 1.0 / 24, options);
    state.counters["particle_step"] = benchmark::Counter(
        double(state.iterations()) * options.substeps * double(cubes.corner_count()),
        benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
    state.counters["bytes_a_particle"] = bytes_a_particle(body, motion);
}
BENCHMARK(plane)
    ->Args({316, 1, 1, 0})
    ->Args({316, 3, 1, 0})
    ->Args({316, 16, 1, 0})
    ->Args({316, 3, 2, 0})
    ->Args({316, 1, 1, 1})
    ->Args({316, 3, 1, 1})
    ->Args({316, 3, 2, 1})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The heap of graphs/many_jellies.json two seconds after it was let go: 150 blocks of 150 particles
// in contact with each other and the ground. Argument: threads.
void many_jellies(benchmark::State& state)
{
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    std::size_t(state.range(0)));
    std::vector<geometry::Vec3i> cells;
    for (int k = 0; k < 150; ++k) {
        const int layer = k / 25, shift = layer % 2 * 2;
        const geometry::Vec3i low(k % 5 * 6 + shift, 5 + 7 * layer, k / 5 % 5 * 6 + shift);
        for (int c = 0; c < 80; ++c)
            cells.push_back(low + geometry::Vec3i(c % 4, c / 16, c / 4 % 4));
    }
    const geometry::Cubes cubes =
        geometry::solid_cubes(std::move(cells), 0.1, {"jelly", 1000, 60000, 0.4, 0, 0.004});
    LatticeOptions options{.half_width = 2, .substeps = 5};
    options.contact.on = true;
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State motion = rest_state(body);
    for (int f = 0; f < 48; ++f)
        motion = advance(body, std::move(motion), loads, 1.0 / 24, options);
    for (auto _ : state) motion = advance(body, std::move(motion), loads, 1.0 / 24, options);
    state.counters["steps_a_second"] = benchmark::Counter(
        double(state.iterations()) * options.substeps, benchmark::Counter::kIsRate);
}
BENCHMARK(many_jellies)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// Structural, face and space diagonal springs between the corners of the same cubes. `matching`
// adds Bullet's pose matching, one rigid motion for the whole body.
void bullet(benchmark::State& state, bool matching)
{
    const geometry::Cubes cubes = block(45);
    btSoftBodyWorldInfo world;
    btAlignedObjectArray<btVector3> points;
    for (std::size_t i = 0; i < cubes.corner_count(); ++i) {
        const auto p = cubes.corner_position(i);
        points.push_back({btScalar(p[0]), btScalar(p[1]), btScalar(p[2])});
    }
    btSoftBody body(&world, points.size(), &points[0], nullptr);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
    for (const auto& corners : cubes.corners) {
        for (const auto a : corners) {
            for (const auto b : corners) {
                if (a < b) links.emplace_back(a, b);
            }
        }
    }
    std::sort(links.begin(), links.end());
    links.erase(std::unique(links.begin(), links.end()), links.end());
    for (const auto& [a, b] : links) body.appendLink(int(a), int(b));
    body.setTotalMass(1000);
    if (matching) body.setPose(false, true);
    for (auto _ : state) {
        body.predictMotion(btScalar(1.0 / 240));
        body.solveConstraints();
        body.integrateMotion();
    }
    state.counters["particle_step"] =
        benchmark::Counter(double(state.iterations()) * double(cubes.corner_count()),
                           benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK_CAPTURE(bullet, springs, false)->Unit(benchmark::kMillisecond)->Iterations(5);
BENCHMARK_CAPTURE(bullet, pose_matching, true)->Unit(benchmark::kMillisecond)->Iterations(5);

}  // namespace

BENCHMARK_MAIN();
