// Volumes from VDB files to bodies of cubes, through a graph. The files are written by
// tests/geometry/volumes/write_by_openvdb.cpp.

#include "geometry/cubes/cubes.hpp"
#include "geometry/io/read_volume.hpp"
#include "geometry/mesh/mass_properties.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <numbers>

namespace {

using fixtures::Scene;
using geometry::Cubes;
using geometry::TriMesh;

std::string reading(const std::string& params)
{
    return fmt::format(R"("read": {{ "type": "ReadVolume@1",
        "params": {{ "path": "{}/tests/geometry/volumes/grids.vdb", {} }} }})",
                       ASPIC_SOURCE_DIR, params);
}

#define NEED_OPENVDB()                                                                             \
    if (const std::string why = geometry::why_no_volumes(); !why.empty()) GTEST_SKIP() << why

// A ball of radius 0.25 m: it weighs its volume times 1000 kg/m^3, falls freely for 12 frames of
// 1/24 s, and its mesh with it, by g t^2 / 2 = 1.226 m.
TEST(VolumeNodes, ALevelSetBecomesABodyThatFalls)
{
    NEED_OPENVDB();
    Scene scene(reading(R"("grid": "surface")") + R"(,
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "read.mesh" },
                   "params": { "method": "solid", "size": 0.1 } },
        "mass": { "type": "Measure@1", "inputs": { "cubes": "cubes.cubes" },
                  "params": { "what": "mass" } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes" },
                 "params": { "step": { "substeps": 8 } } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "read.mesh", "cubes": "cubes.cubes",
                   "state": "sim.state" } })");
    const double volume = 4.0 / 3 * std::numbers::pi * 0.25 * 0.25 * 0.25;
    EXPECT_NEAR(*scene.at<double>("mass"), 1000 * volume, 0.01 * 1000 * volume);
    const auto fallen = scene.at<TriMesh>("shape", 13);
    EXPECT_NEAR(bounds(*fallen).centre().y(), 0.5 - 9.81 / 8, 0.02 * 9.81 / 8);
    EXPECT_NEAR(mass_properties(*fallen).mass, volume, 0.01 * volume);
}

// Values of 1 to 8 along x in 4 x 4 voxels of 0.1 m each, moved by half a voxel so that cubes of
// 0.2 m hold eight each: the mass is the integral of 100 kg/m^3 times the value.
TEST(VolumeNodes, AGridPaintsTheDensityOfABody)
{
    NEED_OPENVDB();
    Scene scene(reading(R"("grid": "density", "make": "points", "attribute": "heavy")") + R"(,
        "moved": { "type": "Transform@1", "inputs": { "mesh": "read.points" },
                   "params": { "translate": [0.05, 0.05, 0.05] } },
        "samples": { "type": "Sample@2", "inputs": { "mesh": "moved.mesh" },
                     "params": { "attributes": "heavy" } },
        "cubes": { "type": "Voxelize@1", "inputs": { "points": ["samples.points"] },
                   "params": { "method": "samples", "size": 0.2, "align": "origin" } },
        "dense": { "type": "LocalMatter@1", "inputs": { "cubes": "cubes.cubes" },
                   "params": { "properties": [
                       { "property": "young", "value": "1e5 * heavy" },
                       { "property": "density", "value": "100 * heavy" }] } },
        "mass": { "type": "Measure@1", "inputs": { "cubes": "dense.cubes" },
                  "params": { "what": "mass" } })");
    const auto cubes = scene.at<Cubes>("dense");
    EXPECT_EQ(cubes->count(), 16u);
    EXPECT_NEAR(*scene.at<double>("mass"), 100 * 36 * 16 * 0.001, 1e-4);
}

TEST(VolumeNodes, ALinkToAnOutputThatIsNotMadeIsTold)
{
    NEED_OPENVDB();
    Scene scene(reading(R"("grid": "surface", "make": "mesh")") + R"(,
        "samples": { "type": "Sample@2", "inputs": { "mesh": "read.points" } })");
    const std::string told = scene.failure_at<geometry::Samples>("samples");
    EXPECT_NE(told.find("input 'mesh' is empty: 'read.points' produced no value"),
              std::string::npos)
        << told;
}

// What every run fails at is told when the document is loaded.
TEST(VolumeNodes, WhatIsMissingIsToldBeforeACook)
{
    const auto told = [](const std::string& params, const std::string& type = "ReadVolume") {
        const graph::Loaded loaded =
            graph::load_text(R"({ "aspic": 1, "nodes": { "read": { "type": ")" + type +
                                 R"(@1", "params": {)" + params + "} } } }",
                             "scene.json", nodes::registry());
        std::string all;
        for (const auto& problem : loaded.problems) all += problem.message + "\n";
        return all;
    };
    EXPECT_NE(told("").find("expected the path of a VDB file, found none"), std::string::npos);
    const std::string path =
        R"("path": ")" ASPIC_SOURCE_DIR R"(/tests/geometry/volumes/grids.vdb")";
    EXPECT_NE(told(path, "ReadMesh").find("read it with ReadVolume"), std::string::npos);
    const char* before = std::getenv("ASPIC_OPENVDB");
    const std::string kept = before ? before : "";
    setenv("ASPIC_OPENVDB", "/nowhere/aspic-openvdb", 1);
    const std::string without = told(path);
    before ? setenv("ASPIC_OPENVDB", kept.c_str(), 1) : unsetenv("ASPIC_OPENVDB");
    EXPECT_NE(without.find("Install libopenvdb-dev"), std::string::npos) << without;
}

}  // namespace
