// Models that others made, as they come: read, set in cubes, dropped on the floor, carried along.
// They are no part of the project: a test whose model is not on the machine skips, and says so.

#include "nodes/registry.hpp"
#include "runtime/commands/command_line.hpp"
#include "tests/geometry/files.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sstream>

namespace fs = std::filesystem;

// Cooks eight frames of `model` falling on the floor, and holds it to staying finite and whole.
static void drop(const fs::path& model, const char* unit, double fit)
{
    const files::Folder folder;
    const std::string document = fmt::format(R"({{
      "aspic": 1,
      "frames": {{ "first": 1, "last": 8, "fps": 24 }},
      "nodes": {{
        "model": {{ "type": "ReadMesh@1", "params": {{ "path": "{}", "unit": "{}", "up": "y",
                   "fit": {}, "place": "ground" }} }},
        "lifted": {{ "type": "Transform@1", "inputs": {{ "mesh": "model.mesh" }},
                    "params": {{ "translate": [0, 0.05, 0] }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "lifted.mesh" }},
                   "params": {{ "method": "surface", "resolution": 16, "thickness": 0.01,
                               "matter": {{ "density": 500, "young": 1e6 }} }} }},
        "part": {{ "type": "ConnectedComponent@1", "inputs": {{ "cubes": "cubes.cubes" }} }},
        "floor": {{ "type": "Ground@1" }},
        "sim": {{ "type": "Simulate@3",
                 "inputs": {{ "cubes": "part.cubes", "colliders": ["floor.collider"] }} }},
        "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "lifted.mesh", "cubes": "part.cubes",
                   "state": "sim.state" }} }},
        "finite": {{ "type": "Measure@1", "inputs": {{ "mesh": "shape.mesh" }},
                    "params": {{ "what": "mesh_finite" }} }},
        "fallen": {{ "type": "Measure@1",
                    "inputs": {{ "mesh": "shape.mesh", "rest": "lifted.mesh" }},
                    "params": {{ "what": "displacement_max" }} }}
      }},
      "expect": [
        {{ "value": "finite.value", "frame": "every", "min": 1 }},
        {{ "value": "fallen.value", "frame": "last", "min": 0.01, "max": 0.4 }}
      ] }})",
                                             model.generic_string(), unit, fit);
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    EXPECT_EQ(runtime::run_command_line({"check", folder.write("drop.json", document).string(),
                                         "--no-disk-cache", "--allow-outside"},
                                        nodes::registry(), console),
              runtime::exit_ok)
        << model << "\n"
        << out.str() << err.str();
}

TEST(FoundModels, TheSharedBridgeFallsOnTheFloorInOnePiece)
{
    const fs::path shared = files::shared();
    if (shared.empty()) GTEST_SKIP() << "there is no ../shared/models beside the project";
    drop(shared / "models/simple_bridge.obj", "cm", 1);
}

TEST(FoundModels, FurnitureOfALibraryFallsOnTheFloorInOnePiece)
{
    const fs::path library = "/usr/share/sweethome3d/furniture";
    if (!fs::exists(library) || std::system("command -v unzip >/dev/null") != 0) {
        GTEST_SKIP() << "the Debian packages sweethome3d-furniture and unzip are not installed";
    }
    const files::Folder folder;
    std::size_t tried = 0;
    for (const char* archive : {"BlendSwap-CC-0", "KatorLegaz", "Scopia"}) {
        const std::string unpack =
            fmt::format("unzip -qo '{}/{}.sh3f' '*.obj' '*.mtl' -d '{}/{}'", library.string(),
                        archive, folder.path.string(), archive);
        ASSERT_EQ(std::system(unpack.c_str()), 0) << unpack;
        std::vector<fs::path> models;
        for (const auto& entry : fs::recursive_directory_iterator(folder.path / archive)) {
            if (entry.path().extension() == ".obj") models.push_back(entry.path());
        }
        std::sort(models.begin(), models.end());
        // Four of each archive, spread over it.
        for (std::size_t i = 0; i < 4 && i < models.size(); ++i) {
            drop(models[i * models.size() / 4], "cm", 1);
            ++tried;
        }
    }
    EXPECT_GE(tried, 6u);
}
