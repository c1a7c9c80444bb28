// Pictures a second, beside what each part of one costs. The model is a published bridge where its
// file is, else a ball of 82k triangles.

#include "geometry/io/read_mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "render/draw.hpp"
#include "render/make_draw_list.hpp"
#include "render/png.hpp"
#include "render/surface_layout.hpp"

#include <benchmark/benchmark.h>
#include <thread>

namespace {

using render::Antialias;
using render::Look;
using render::Scene;
using render::ShadowQuality;

geometry::TriMesh model()
{
    const std::filesystem::path bridge =
        std::filesystem::path(ASPIC_SOURCE_DIR) / "../shared/models/simple_bridge.obj";
    if (!std::filesystem::exists(bridge)) return geometry::icosphere(1, 6);
    geometry::ReadOptions options;
    options.unit = geometry::LengthUnit::centimetre;
    return geometry::read_mesh(bridge, options).mesh;
}

struct Shot {
    Scene scene;
    render::Camera camera;
    Look look;

    explicit Shot(geometry::TriMesh mesh)
    {
        render::Surface surface;
        surface.layout =
            std::make_shared<const render::SurfaceLayout>(render::surface_layout(mesh));
        scene.stage = geometry::bounds(mesh);
        scene.ground = scene.stage.lo.y();
        surface.mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
        scene.surfaces = {surface};
        camera = render::fit(scene.stage, 0.6, 0.35, 0.5, double(look.width) / look.height, 0.06);
    }
};

const Shot& shot()
{
    static const Shot made(model());
    return made;
}

void picture(benchmark::State& state, const Shot& of, const Look& look)
{
    render::draw(of.scene, of.camera, look);  // compiles the shaders
    for (auto _ : state) benchmark::DoNotOptimize(render::draw(of.scene, of.camera, look));
    state.counters["pictures/s"] =
        benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);
    state.counters["triangles"] = double(of.scene.surfaces[0].mesh->triangles().size());
}

void Picture(benchmark::State& state)
{
    picture(state, shot(), shot().look);
}
BENCHMARK(Picture)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

void PictureByAntialias(benchmark::State& state)
{
    Look look = shot().look;
    look.antialias = Antialias(state.range(0));
    picture(state, shot(), look);
}
BENCHMARK(PictureByAntialias)
    ->DenseRange(0, 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

void PictureByShadow(benchmark::State& state)
{
    Look look = shot().look;
    look.shadow = ShadowQuality(state.range(0));
    picture(state, shot(), look);
}
BENCHMARK(PictureByShadow)
    ->DenseRange(0, 3)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

void PictureByTriangles(benchmark::State& state)
{
    const Shot ball(geometry::icosphere(1, int(state.range(0))));
    picture(state, ball, ball.look);
}
BENCHMARK(PictureByTriangles)
    ->DenseRange(4, 7)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

// Two frames at a time, each with a context of its own: pictures a second of both together.
void TwoPicturesAtOnce(benchmark::State& state)
{
    render::draw(shot().scene, shot().camera, shot().look);
    for (auto _ : state) {
        std::thread other([] { render::draw(shot().scene, shot().camera, shot().look); });
        render::draw(shot().scene, shot().camera, shot().look);
        other.join();
    }
    state.counters["pictures/s"] =
        benchmark::Counter(2.0 * double(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(TwoPicturesAtOnce)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

// The part that needs no OpenGL.
void DrawList(benchmark::State& state)
{
    for (auto _ : state) {
        benchmark::DoNotOptimize(render::make_draw_list(shot().scene, shot().camera, shot().look));
    }
}
BENCHMARK(DrawList)->Unit(benchmark::kMillisecond)->UseRealTime();

void EncodePng(benchmark::State& state)
{
    const render::Image image = render::draw(shot().scene, shot().camera, shot().look);
    std::size_t bytes = 0;
    for (auto _ : state) bytes = render::encode_png(image).size();
    state.counters["kB"] = double(bytes) / 1024;
}
BENCHMARK(EncodePng)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
