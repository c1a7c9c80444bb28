// Whole cooks as the command line does them: 120 frames simulated, drawn, written as PNG and joined
// to a video, from a cold start in memory and without stored results.

#include "nodes/registry.hpp"
#include "runtime/commands/command_line.hpp"

#include <benchmark/benchmark.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace {

namespace fs = std::filesystem;

// The published bridge (shared/models/README.md) as a scene: 1,700 cubes that sway in gusts.
// Metres for the file's centimetres, so that its sway can be seen.
const char* const shared_bridge = R"({ "aspic": 1,
  "frames": { "first": 1, "last": 120, "fps": 24 },
  "nodes": {
    "bridge": { "type": "ReadMesh@1",
      "params": { "path": "simple_bridge.obj", "unit": "m", "up": "y" } },
    "samples": { "type": "Sample@2", "inputs": { "mesh": "bridge.mesh" },
      "params": { "count": 200000, "mass": "density", "thickness": 0.05, "matter":
        { "density": 1000, "young": 2e8, "poisson": 0.45, "stiffness_damping": 0.004 } } },
    "cubes": { "type": "Voxelize@1", "inputs": { "points": "samples.points" },
      "params": { "size": 0.245 } },
    "part": { "type": "ConnectedComponent@1", "inputs": { "cubes": "cubes.cubes" } },
    "ends": { "type": "Pin@1", "inputs": { "cubes": "part.cubes" },
      "params": { "where": "ends", "ends": { "axis": "x", "end": "both", "layers": 2 } } },
    "gusts": { "type": "Force@1", "params": { "kind": "wind", "wind": { "drag": 1.2, "velocity":
      { "keys": [[1, [0, 0, 0]], [12, [6, 0, 42]], [58, [0, 0, 50]], [110, [0, 0, 0]]] } } } },
    "sim": { "type": "Simulate@2",
      "inputs": { "cubes": "part.cubes", "pins": "ends.pins", "forces": "gusts.force" },
      "params": { "step": { "substeps": 2, "tolerance": 0.001 } } },
    "shape": { "type": "Embed@3",
      "inputs": { "mesh": "bridge.mesh", "cubes": "part.cubes", "state": "sim.state" } },
    "picture": { "type": "Render@2", "inputs": { "mesh": "shape.mesh", "rest": "bridge.mesh" },
      "params": { "width": 960, "height": 540, "ground": { "kind": "at", "height": -1 } } },
    "frames": { "type": "WriteImage@1", "inputs": { "image": "picture.image" } },
    "video": { "type": "WriteVideo@1", "inputs": { "frames": "frames.file" } } } })";

void cook(benchmark::State& state, const fs::path& document)
{
    const fs::path out = fs::temp_directory_path() / ("aspic-cook-" + std::to_string(::getpid()));
    for (auto _ : state) {
        std::ostringstream said, mistakes;
        runtime::Console console{said, mistakes, false, {}, {}, "bench"};
        const int exit = runtime::run_command_line({"cook", document.string(), "--no-disk-cache",
                                                    "--allow-outside", "--out", out.string()},
                                                   nodes::registry(), console);
        if (exit != runtime::exit_ok) state.SkipWithError(mistakes.str().c_str());
        state.PauseTiming();
        fs::remove_all(out);
        state.ResumeTiming();
    }
}

void SharedBridge(benchmark::State& state)
{
    const fs::path model = fs::path(ASPIC_SOURCE_DIR) / "../shared/models/simple_bridge.obj";
    if (!fs::exists(model)) return state.SkipWithError("there is no ../shared/models");
    std::string text = shared_bridge;
    const std::string name = "simple_bridge.obj";
    text.replace(text.find(name), name.size(), fs::canonical(model).string());
    const fs::path document =
        fs::temp_directory_path() / ("aspic-bridge-" + std::to_string(::getpid()) + ".json");
    std::ofstream(document) << text;
    cook(state, document);
    fs::remove(document);
}
BENCHMARK(SharedBridge)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

void OwnBridge(benchmark::State& state)
{
    cook(state, fs::path(ASPIC_SOURCE_DIR) / "graphs/bridge.json");
}
BENCHMARK(OwnBridge)->Iterations(1)->Unit(benchmark::kSecond)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
