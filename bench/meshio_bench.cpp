// Reading and writing mesh files, beside assimp alone on the same file in the same run. What is on
// top of assimp: a process of its own, the way back of the data, welding and normals.

#include "geometry/io/read_mesh.hpp"
#include "geometry/io/write_mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <benchmark/benchmark.h>

#include <unistd.h>

namespace {

namespace fs = std::filesystem;

// A sphere of 20 * 4^subdivisions faces, written as OBJ or PLY. 5: 20,480 faces, 7: 327,680.
fs::path sphere_file(int subdivisions, const char* ending)
{
    const fs::path path = fs::temp_directory_path() / ("aspic-bench-" + std::to_string(::getpid()) +
                                                       "-" + std::to_string(subdivisions) + ending);
    if (!fs::exists(path)) {
        geometry::write_mesh(path, geometry::mesh_format(path),
                             geometry::icosphere(1, subdivisions));
    }
    return path;
}

void count_faces(benchmark::State& state, std::size_t faces)
{
    state.counters["faces/s"] =
        benchmark::Counter(double(faces), benchmark::Counter::kIsIterationInvariantRate);
}

void assimp_alone(benchmark::State& state, const fs::path& path)
{
    std::size_t faces = 0;
    for (auto _ : state) {
        Assimp::Importer importer;
        const aiScene* scene = importer.ReadFile(path.string(), aiProcess_JoinIdenticalVertices);
        benchmark::DoNotOptimize(scene);
        faces = scene ? scene->mMeshes[0]->mNumFaces : 0;
    }
    count_faces(state, faces);
}

void read(benchmark::State& state, const fs::path& path)
{
    std::size_t faces = 0;
    for (auto _ : state) faces = geometry::read_mesh(path).mesh.triangles().size();
    count_faces(state, faces);
}

void import(benchmark::State& state, const fs::path& path)
{
    for (auto _ : state) benchmark::DoNotOptimize(geometry::import_scene(path));
}

void ObjByAssimpAlone(benchmark::State& state)
{
    assimp_alone(state, sphere_file(int(state.range(0)), ".obj"));
}
void ObjRead(benchmark::State& state)
{
    read(state, sphere_file(int(state.range(0)), ".obj"));
}
void ObjImportedOnly(benchmark::State& state)
{
    import(state, sphere_file(int(state.range(0)), ".obj"));
}
void PlyRead(benchmark::State& state)
{
    read(state, sphere_file(int(state.range(0)), ".ply"));
}
void Write(benchmark::State& state, const char* ending)
{
    const geometry::TriMesh mesh = geometry::icosphere(1, int(state.range(0)));
    const fs::path path =
        fs::temp_directory_path() / ("aspic-bench-" + std::to_string(::getpid()) + "-out" + ending);
    for (auto _ : state) {
        geometry::write_mesh(path, geometry::mesh_format(path), mesh);
    }
    fs::remove(path);
    count_faces(state, mesh.triangles().size());
}

// 20 faces: what a process costs.
BENCHMARK(ObjByAssimpAlone)->Arg(0)->Arg(5)->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(ObjImportedOnly)->Arg(0)->Arg(5)->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(ObjRead)->Arg(0)->Arg(5)->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(PlyRead)->Arg(5)->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(Write, obj, ".obj")->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(Write, ply, ".ply")->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(Write, glb, ".glb")->Arg(7)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
