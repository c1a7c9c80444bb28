// Bricks: the shared bridge in steps a second, and solid blocks in seconds a step.

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/choose_corners.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <benchmark/benchmark.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace {

using namespace physics;
using geometry::Cubes;
using geometry::Vec3i;

// Positions and faces of the shared bridge, which is in centimetres and y up (its towers are); in
// metres. Nothing where the file is not there.
std::optional<geometry::TriMesh> shared_bridge()
{
    const char* given = std::getenv("ASPIC_SHARED_MODELS");
    const std::string folder = given ? given : ASPIC_SOURCE_DIR "/../shared/models";
    std::ifstream in(folder + "/simple_bridge.obj");
    if (!in) return std::nullopt;
    geometry::TriMesh mesh;
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (std::string line; std::getline(in, line);) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            float x = 0, y = 0, z = 0;
            words >> x >> y >> z;
            mesh.positions.emplace_back(0.01f * x, 0.01f * y, 0.01f * z);
        } else if (kind == "f") {
            std::vector<std::uint32_t> face;
            for (std::string word; words >> word;) {
                face.push_back(static_cast<std::uint32_t>(std::stoul(word) - 1));
            }
            for (std::size_t i = 2; i < face.size(); ++i) {
                topology->triangles.push_back({face[0], face[i - 1], face[i]});
            }
        }
    }
    mesh.topology = std::move(topology);
    return mesh;
}

Cubes bridge_cubes(const geometry::TriMesh& mesh)
{
    geometry::FaceMatter matter;
    matter.matters = {{"steel", 1000, 1e7, 0.45}};
    return geometry::voxelize_surface(mesh, matter, 0, {.size = 0.00265}, {});
}

Loads ends_held(const Cubes& cubes)
{
    Loads loads;
    loads.pins = pins_at(cubes, corners_at_end(cubes, 0, End::both, 0), Transform::Identity());
    loads.forces.push_back({});
    return loads;
}

// A bridge under its weight from rest: 100 frames of 0.01 s, the first left out.
void bridge_steps(benchmark::State& bench)
{
    const auto mesh = shared_bridge();
    if (!mesh) return bench.SkipWithError("the shared bridge is not there");
    const Cubes cubes = bridge_cubes(*mesh);
    const BricksBody body = make_bricks(cubes, {}, &*mesh);
    const Loads loads = ends_held(cubes);
    const StepOptions options{.tolerance = std::pow(10.0, -double(bench.range(0)))};
    const State first = advance(body, rest_state(body), loads, 0.01, options);
    const State exact_first = advance(body, rest_state(body), loads, 0.01, {.tolerance = 1e-9});
    State state = first;
    std::int64_t steps = 0, iterations = 0;
    for (auto _ : bench) {
        if (steps % 100 == 0) state = first;
        state = advance(body, std::move(state), loads, 0.01, options);
        iterations += state.report.iterations;
        ++steps;
    }
    // Error over 100 steps, against a solve to 1e-9, in cubes.
    double error = 0;
    State exact = exact_first;
    state = first;
    for (int i = 0; i < 100; ++i) {
        state = advance(body, std::move(state), loads, 0.01, options);
        exact = advance(body, std::move(exact), loads, 0.01, {.tolerance = 1e-9});
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            error = std::max(error, (state.x[k] - exact.x[k]).norm() / cubes.size);
        }
    }
    bench.counters["cubes"] = static_cast<double>(cubes.count());
    bench.counters["iterations"] = double(iterations) / double(steps);
    bench.counters["error_in_cubes"] = error;
    bench.counters["steps_per_s"] =
        benchmark::Counter(static_cast<double>(steps), benchmark::Counter::kIsRate);
}
BENCHMARK(bridge_steps)->DenseRange(2, 6)->UseRealTime()->Unit(benchmark::kMillisecond);

// Mesh to cubes to body to the first step taken.
void bridge_ready(benchmark::State& bench)
{
    const auto mesh = shared_bridge();
    if (!mesh) return bench.SkipWithError("the shared bridge is not there");
    for (auto _ : bench) {
        const Cubes cubes = bridge_cubes(*mesh);
        const BricksBody body = make_bricks(cubes, {}, &*mesh);
        benchmark::DoNotOptimize(advance(body, rest_state(body), ends_held(cubes), 0.01));
    }
}
BENCHMARK(bridge_ready)->UseRealTime()->Unit(benchmark::kMillisecond);

Cubes block(int n)
{
    Cubes cubes;
    cubes.size = 1.0 / n;
    const auto corner = [n](int x, int y, int z) {
        return static_cast<std::uint32_t>((z * (n + 1) + y) * (n + 1) + x);
    };
    for (int z = 0; z <= n; ++z)
        for (int y = 0; y <= n; ++y)
            for (int x = 0; x <= n; ++x) {
                cubes.corner.emplace_back(x, y, z);
                if (x == n || y == n || z == n) continue;
                cubes.cell.emplace_back(x, y, z);
                std::array<std::uint32_t, 8> eight;
                for (int a = 0; a < 8; ++a) {
                    eight[std::size_t(a)] = corner(x + (a & 1), y + (a >> 1 & 1), z + (a >> 2));
                }
                cubes.corners.push_back(eight);
            }
    const std::size_t count = cubes.cell.size();
    cubes.mass.assign(count, 1000 * cubes.size * cubes.size * cubes.size);
    cubes.fill.assign(count, 1);
    cubes.young.assign(count, 1e6);
    cubes.poisson.assign(count, 0.3);
    cubes.mass_damping.assign(count, 0);
    cubes.stiffness_damping.assign(count, 0);
    return cubes;
}

// A solid block of n^3 cubes hung from one side: one step of 0.01 s to a residual of 1e-6, with
// multigrid where it pays, and without.
void block_step(benchmark::State& bench)
{
    const Cubes cubes = block(static_cast<int>(bench.range(0)));
    BricksBody body = make_bricks(cubes);
    Loads loads = ends_held(cubes);
    loads.pins = pins_at(cubes, corners_at_end(cubes, 0, End::low, 0), Transform::Identity());
    const StepOptions options{.tolerance = 1e-6};
    if (bench.range(1) == 0) body.multigrids = nullptr;
    const State start = advance(body, rest_state(body), loads, 0.01, options);
    int iterations = 0;
    for (auto _ : bench) {
        const State state = advance(body, start, loads, 0.01, options);
        iterations = state.report.iterations;
    }
    bench.counters["cubes"] = static_cast<double>(cubes.count());
    bench.counters["iterations"] = iterations;
}
BENCHMARK(block_step)
    ->ArgNames({"n", "multigrid"})
    ->ArgsProduct({{10, 22, 46, 100}, {0, 1}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

// The same many steps of a block that lands on the ground, contact included.
void block_landing(benchmark::State& bench)
{
    Cubes cubes = block(static_cast<int>(bench.range(0)));
    cubes.origin.y() = 0.001;
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    int iterations = 0;
    for (auto _ : bench) {
        State state = rest_state(body);
        iterations = 0;
        for (int i = 0; i < 30; ++i) {
            state = advance(body, std::move(state), loads, 0.01);
            iterations += state.report.iterations;
        }
    }
    bench.counters["iterations_a_step"] = iterations / 30.0;
}
BENCHMARK(block_landing)->Arg(8)->Arg(16)->UseRealTime()->Unit(benchmark::kMillisecond);

// A heap of across^3 blocks of 4 x 4 x 5 cubes that falls together on the ground: 24 frames of four
// steps, a second, with contact between the blocks and without.
void heap_falls(benchmark::State& bench)
{
    const int across = static_cast<int>(bench.range(0));
    const Vec3i block(4, 5, 4);
    std::vector<Vec3i> cells;
    for (int b = 0; b < across * across * across; ++b) {
        const Vec3i at(b % across, b / across % across, b / across / across);
        const Vec3i low(6 * at.x() + 2 * (at.y() % 2), 2 + 7 * at.y(), 6 * at.z() + at.y() % 3);
        for (int c = 0; c < block.prod(); ++c) {
            cells.emplace_back(low + Vec3i(c % 4, c / 4 % 5, c / 20));
        }
    }
    const Cubes cubes = fixtures::cubes_on(
        cells, 0.1, {.young = 1.5e5, .poisson = 0.4, .stiffness_damping = 0.004});
    const BricksBody body = make_bricks(cubes, {.contact = {.on = bench.range(1) == 1}});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    int steps = 0;
    for (auto _ : bench) {
        State state = rest_state(body);
        for (int i = 0; i < 24; ++i) {
            state = advance(body, std::move(state), loads, 1.0 / 24, {.substeps = 4});
            steps += state.report.steps;
        }
    }
    bench.counters["bodies"] = across * across * across;
    bench.counters["steps"] = steps / static_cast<double>(bench.iterations());
}
BENCHMARK(heap_falls)
    ->ArgNames({"across", "contact"})
    ->ArgsProduct({{4, 10}, {0, 1}})
    ->Iterations(1)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
