// Mesh to cubes and back, against peers in the same run where they are installed.
// The mesh: a closed bumpy sphere of 81,920 triangles, made here.

#include "geometry/base/parallel.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/cubes/sample_volume.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "physics/bricks/bending_error.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#ifdef ASPIC_HAVE_OPENVDB
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#endif
#ifdef ASPIC_HAVE_VTK
#include <vtkCellArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataToImageStencil.h>
#endif

namespace {

using namespace geometry;

const TriMesh& sphere()
{
    static const TriMesh mesh = test_meshes::bumpy_sphere(6);
    return mesh;
}

VoxelGrid grid_at(const TriMesh& mesh, int resolution)
{
    const Box box = triangle_bounds(mesh);
    return fit_grid(box, size_for(box, resolution));
}

FaceMatter plain()
{
    return {{}, {{}}, {}};
}

// range(0): cubes along the longest side, range(1): threads.
struct Threads {
    explicit Threads(const benchmark::State& state, std::size_t arg = 1)
        : limit(tbb::global_control::max_allowed_parallelism,
                static_cast<std::size_t>(state.range(arg)))
    {}
    tbb::global_control limit;
};

void surface_cells_of_sphere(benchmark::State& state)
{
    const Threads threads(state);
    const VoxelGrid grid = grid_at(sphere(), static_cast<int>(state.range(0)));
    std::size_t cells = 0;
    for (auto _ : state) {
        cells = surface_cells(to_lattice(sphere(), grid), CellShape::half_open).count();
    }
    state.counters["cells"] = static_cast<double>(cells);
}
BENCHMARK(surface_cells_of_sphere)
    ->ArgsProduct({{128, 256, 512}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void solid_cells_of_sphere(benchmark::State& state)
{
    const Threads threads(state);
    const VoxelGrid grid = grid_at(sphere(), static_cast<int>(state.range(0)));
    std::size_t cells = 0;
    for (auto _ : state) {
        cells = solid_cells(to_lattice(sphere(), grid), Inside::winding).count();
    }
    state.counters["cells"] = static_cast<double>(cells);
}
BENCHMARK(solid_cells_of_sphere)
    ->ArgsProduct({{128, 256, 512}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// The whole way to Cubes: cells, corners, clipped areas, masses.
void voxelize_surface_of_sphere(benchmark::State& state)
{
    const Threads threads(state);
    const VoxelGrid grid = grid_at(sphere(), static_cast<int>(state.range(0)));
    for (auto _ : state) {
        benchmark::DoNotOptimize(voxelize_surface(sphere(), plain(), 0.001, grid, {}).count());
    }
}
BENCHMARK(voxelize_surface_of_sphere)
    ->ArgsProduct({{64, 256}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void voxelize_solid_of_sphere(benchmark::State& state)
{
    const Threads threads(state);
    const VoxelGrid grid = grid_at(sphere(), static_cast<int>(state.range(0)));
    for (auto _ : state) {
        benchmark::DoNotOptimize(
            voxelize_solid(sphere(), plain(), Inside::winding, 0, grid, {}).count());
    }
}
BENCHMARK(voxelize_solid_of_sphere)
    ->ArgsProduct({{64}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

// What Voxelize asks of every model afterwards: how far its walls are too stiff. To be set against
// voxelize_solid_of_sphere.
void thin_parts_of_sphere(benchmark::State& state)
{
    const Threads threads(state);
    const Cubes cubes = voxelize_solid(sphere(), plain(), Inside::winding, 0,
                                       grid_at(sphere(), static_cast<int>(state.range(0))), {});
    for (auto _ : state) {
        benchmark::DoNotOptimize(physics::thin_parts(sphere(), cubes, {true, 0}).size());
    }
}
BENCHMARK(thin_parts_of_sphere)
    ->ArgsProduct({{64}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

#ifdef ASPIC_HAVE_OPENVDB
void openvdb_unsigned_band_of_sphere(benchmark::State& state)
{
    const Threads threads(state);
    openvdb::initialize();
    const VoxelGrid grid = grid_at(sphere(), static_cast<int>(state.range(0)));
    std::vector<openvdb::Vec3s> points;
    for (const Vec3f& p : sphere().positions) points.emplace_back(p.x(), p.y(), p.z());
    std::vector<openvdb::Vec3I> triangles;
    for (const auto& [a, b, c] : sphere().triangles()) triangles.emplace_back(a, b, c);
    const auto transform = openvdb::math::Transform::createLinearTransform(grid.size);
    for (auto _ : state) {
        const auto band = openvdb::tools::meshToUnsignedDistanceField<openvdb::FloatGrid>(
            *transform, points, triangles, {}, 1.0f);
        benchmark::DoNotOptimize(band->activeVoxelCount());
    }
}
BENCHMARK(openvdb_unsigned_band_of_sphere)
    ->ArgsProduct({{128, 256, 512}, {1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
#endif

#ifdef ASPIC_HAVE_VTK
void vtk_stencil_of_sphere(benchmark::State& state)
{
    const int n = static_cast<int>(state.range(0));
    const VoxelGrid grid = grid_at(sphere(), n);
    vtkNew<vtkPoints> points;
    for (const Vec3f& p : sphere().positions) points->InsertNextPoint(p.x(), p.y(), p.z());
    vtkNew<vtkCellArray> faces;
    for (const auto& [a, b, c] : sphere().triangles()) {
        const vtkIdType ids[3] = {a, b, c};
        faces->InsertNextCell(3, ids);
    }
    vtkNew<vtkPolyData> mesh;
    mesh->SetPoints(points);
    mesh->SetPolys(faces);
    for (auto _ : state) {
        vtkNew<vtkPolyDataToImageStencil> stencil;
        stencil->SetInputData(mesh);
        stencil->SetOutputSpacing(grid.size, grid.size, grid.size);
        stencil->SetOutputOrigin(grid.origin.x() + 0.5 * grid.size,
                                 grid.origin.y() + 0.5 * grid.size,
                                 grid.origin.z() + 0.5 * grid.size);
        stencil->SetOutputWholeExtent(0, grid.cells.x() - 1, 0, grid.cells.y() - 1, 0,
                                      grid.cells.z() - 1);
        stencil->Update();
        benchmark::DoNotOptimize(stencil->GetOutput());
    }
}
BENCHMARK(vtk_stencil_of_sphere)->Arg(128)->Arg(256)->Unit(benchmark::kMillisecond)->UseRealTime();
#endif

void components_of_shell(benchmark::State& state)
{
    const Threads threads(state);
    const Cubes cubes = voxelize_surface(sphere(), plain(), 0,
                                         grid_at(sphere(), static_cast<int>(state.range(0))), {});
    for (auto _ : state) {
        benchmark::DoNotOptimize(
            find_components(cubes, static_cast<Connectivity>(state.range(2))).count());
    }
    state.counters["cubes"] = static_cast<double>(cubes.count());
}
BENCHMARK(components_of_shell)
    ->ArgsProduct({{256}, {1}, {0, 1, 2}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

void sample_million_even(benchmark::State& state)
{
    const Threads threads(state, 0);
    for (auto _ : state) {
        benchmark::DoNotOptimize(sample_surface(sphere(), plain(), 1'000'000, 1).positions.data());
    }
}
BENCHMARK(sample_million_even)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void sample_100k_blue(benchmark::State& state)
{
    const Threads threads(state, 0);
    for (auto _ : state) {
        benchmark::DoNotOptimize(
            sample_surface_blue(sphere(), plain(), 100'000, 1).positions.data());
    }
}
BENCHMARK(sample_100k_blue)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void sample_100k_inside(benchmark::State& state)
{
    const Threads threads(state, 0);
    for (auto _ : state) {
        benchmark::DoNotOptimize(
            sample_volume(sphere(), plain(), Inside::winding, 100'000, 1).positions.data());
    }
}
BENCHMARK(sample_100k_inside)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// A million vertices and normals on cubes that bend.
struct Carried {
    TriMesh mesh;
    Cubes cubes;
    std::vector<Vec3> x;
    Binding binding;

    Carried()
    {
        const TriMesh& ball = sphere();
        cubes = voxelize_surface(ball, plain(), 0, grid_at(ball, 40), {});
        std::vector<Vec3f> positions;
        while (positions.size() < 1'000'000) {
            positions.insert(positions.end(), ball.positions.begin(), ball.positions.end());
        }
        positions.resize(1'000'000);
        mesh.positions = mesh.normals = positions;
        binding = bind(mesh, cubes);
        x = corner_positions(cubes);
        for (Vec3& p : x) p += Vec3(0.1 * p.y() * p.y(), 0, 0.2 * p.x());
    }
};
const Carried& carried()
{
    static const Carried scene;
    return scene;
}

void embed_million(benchmark::State& state)
{
    const Threads threads(state, 0);
    const Carried& c = carried();
    for (auto _ : state) {
        benchmark::DoNotOptimize(embed(c.binding, c.mesh, c.cubes, c.x).positions.data());
    }
}
BENCHMARK(embed_million)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

// The bytes that embed() reads and writes, copied by as many threads into memory that is there and
// warm; embed() itself has to find memory for what it returns.
void embed_million_copied(benchmark::State& state)
{
    const Threads threads(state, 0);
    const Carried& c = carried();
    const auto bytes = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    const std::size_t n = bytes(c.mesh.positions, c.mesh.normals, c.binding.cube, c.binding.local,
                                c.binding.normal_vertex, c.mesh.positions, c.mesh.normals);
    const std::vector<char> from(n, 1);
    std::vector<char> to(n, 2);
    for (auto _ : state) {
        parallel_for(n, 1 << 20, [&](std::size_t begin, std::size_t end) {
            std::memcpy(&to[begin], &from[begin], end - begin);
        });
        benchmark::DoNotOptimize(to.data());
        benchmark::ClobberMemory();
    }
    state.counters["MB"] = double(n) / 1e6;
}
BENCHMARK(embed_million_copied)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void bind_million(benchmark::State& state)
{
    const Threads threads(state, 0);
    const Carried& c = carried();
    for (auto _ : state) benchmark::DoNotOptimize(bind(c.mesh, c.cubes).used.data());
}
BENCHMARK(bind_million)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

void bvh_build(benchmark::State& state)
{
    for (auto _ : state) benchmark::DoNotOptimize(TriangleBvh(sphere()).triangle_count());
}
BENCHMARK(bvh_build)->Unit(benchmark::kMillisecond)->UseRealTime();

void bvh_closest(benchmark::State& state)
{
    const TriangleBvh bvh(sphere());
    const Random random(1);
    std::uint64_t i = 0;
    for (auto _ : state) {
        const Vec3 p(2 * random.unit(3 * i) - 1, 2 * random.unit(3 * i + 1) - 1,
                     2 * random.unit(3 * i + 2) - 1);
        ++i;
        benchmark::DoNotOptimize(bvh.closest(p).distance);
    }
}
BENCHMARK(bvh_closest);

void bvh_winding_number(benchmark::State& state)
{
    const TriangleBvh bvh(sphere());
    const Random random(1);
    std::uint64_t i = 0;
    for (auto _ : state) {
        const Vec3 p(2 * random.unit(3 * i) - 1, 2 * random.unit(3 * i + 1) - 1,
                     2 * random.unit(3 * i + 2) - 1);
        ++i;
        benchmark::DoNotOptimize(bvh.winding_number(p));
    }
}
BENCHMARK(bvh_winding_number);

// The bridge shared with other projects, where it is at hand: positions and faces of its OBJ file.
const TriMesh* bridge()
{
    static const auto mesh = []() -> std::unique_ptr<TriMesh> {
        const char* shared = std::getenv("ASPIC_SHARED");
        const std::filesystem::path folder =
            shared ? std::filesystem::path(shared)
                   : std::filesystem::path(ASPIC_SOURCE_DIR).parent_path() / "shared";
        std::ifstream file(folder / "models/simple_bridge.obj");
        if (!file) return nullptr;
        std::vector<Vec3f> positions;
        std::vector<Triangle> triangles;
        for (std::string line, word; std::getline(file, line);) {
            std::istringstream words(line);
            words >> word;
            if (word == "v") {
                Vec3f p;
                words >> p.x() >> p.y() >> p.z();
                positions.push_back(0.01f * p);
            } else if (word == "f") {
                std::vector<std::uint32_t> corner;
                while (words >> word) {
                    corner.push_back(static_cast<std::uint32_t>(std::stoul(word) - 1));
                }
                for (std::size_t k = 2; k < corner.size(); ++k) {
                    triangles.push_back({corner[0], corner[k - 1], corner[k]});
                }
            }
        }
        return std::make_unique<TriMesh>(
            test_meshes::mesh_of(std::move(positions), std::move(triangles)));
    }();
    return mesh.get();
}

void bridge_to_bound_cubes(benchmark::State& state)
{
    if (!bridge()) return state.SkipWithError("no simple_bridge.obj: set ASPIC_SHARED");
    const Threads threads(state, 0);
    std::size_t cubes = 0;
    for (auto _ : state) {
        const Cubes all = voxelize_surface(*bridge(), plain(), 0, grid_at(*bridge(), 79), {});
        const Components found = find_components(all, Connectivity::face);
        std::vector<std::uint8_t> keep(all.count());
        for (std::size_t c = 0; c < keep.size(); ++c) keep[c] = found.label[c] == 0;
        const Cubes largest = kept(all, keep);
        benchmark::DoNotOptimize(bind(*bridge(), largest).used.data());
        cubes = largest.count();
    }
    state.counters["cubes"] = static_cast<double>(cubes);
}
BENCHMARK(bridge_to_bound_cubes)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
