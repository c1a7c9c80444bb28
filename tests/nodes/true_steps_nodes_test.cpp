// Mechanics with closed forms, through graphs: free spins, a spring of two stiffnesses, an
// elastica, and bodies that keep their volume.

#include "geometry/mesh/mesh.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace {

using fixtures::Scene;
using geometry::TriMesh;
using geometry::Vec3;

// A measured number of what `sim` does to `cubes`.
std::string measure(const std::string& name, const std::string& what, const std::string& more = {})
{
    return fmt::format(R"(, "{}": {{ "type": "Measure@1", "inputs": {{ "cubes": "cubes.cubes",
        "state": "sim.state" }}, "params": {{ "what": "{}"{} }} }})",
                       name, what, more);
}

// A free box, 0.4 x 0.2 x 0.2 m in cubes of 0.1 m, that spins high above a ground.
std::string spinning(const std::string& spin, const std::string& step)
{
    return fmt::format(R"(
        "box": {{ "type": "Primitive@1", "params": {{ "shape": "box",
                  "box": {{ "size": [0.4, 0.2, 0.2] }} }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "box.mesh" }}, "params": {{
                    "method": "solid", "size": 0.1, "matter": {{ "young": 1e6 }} }} }},
        "ground": {{ "type": "Ground@1", "params": {{ "height": -100 }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                  "colliders": ["ground.collider"] }}, "params": {{ "gravity": [0, 0, 0],
                  "initial_spin_degrees": {}, "step": {{ {} }} }} }})",
                       spin, step) +
           measure("energy", "kinetic_energy") +
           measure("along_x", "angular_momentum", R"(, "direction": [1, 0, 0])") +
           measure("along_y", "angular_momentum", R"(, "direction": [0, 1, 0])") +
           measure("along_z", "angular_momentum", R"(, "direction": [0, 0, 1])");
}

void keeps_energy_and_angular_momentum(const std::string& spin, const std::string& step, int last)
{
    Scene scene(spinning(spin, step), {}, last);
    const auto angular = [&](int frame) {
        return Vec3(*scene.at<double>("along_x", frame), *scene.at<double>("along_y", frame),
                    *scene.at<double>("along_z", frame));
    };
    const double energy = *scene.at<double>("energy", 1);
    const Vec3 before = angular(1);
    EXPECT_NEAR(*scene.at<double>("energy", last), energy, 0.01 * energy) << spin << step;
    EXPECT_LT((angular(last) - before).norm(), 1e-9 * before.norm()) << spin << step;
}

// 12.5 degrees a step, and about the middle axis, where a rigid body turns over again and again.
TEST(TrueStepsNodes, AFreeSpinKeepsItsEnergyFor10000Steps)
{
    keeps_energy_and_angular_momentum("[0, 300, 0]", "", 10'001);
    keeps_energy_and_angular_momentum("[0, 300, 0]", R"("newton_iterations": 10)", 1001);
    keeps_energy_and_angular_momentum("[0, 300, 0]", R"("integrator": "implicit_midpoint")", 1001);
    keeps_energy_and_angular_momentum("[3, 300, 3]", "", 10'001);
}

// Two bars of 1 m, E = 1e6 and 1e12 Pa, under their weight along x, held at the soft one's end: it
// grows by rho g (1/2 + 1) / E = 14.7 mm, or the stiff one's half of that hangs on the stiff one.
TEST(TrueStepsNodes, AnInterfaceOfAMillionIsAtItsPlace)
{
    const auto bars = [](const std::string& first, const std::string& second) {
        return fmt::format(R"(
        "a": {{ "type": "Primitive@1", "params": {{ "shape": "box", "colour": [1, 0, 0],
                "box": {{ "size": [1, 0.2, 0.2], "divisions_x": 10 }}, "centre": [0.5, 0, 0] }} }},
        "b": {{ "type": "Primitive@1", "params": {{ "shape": "box", "colour": [0, 1, 0],
                "box": {{ "size": [1, 0.2, 0.2], "divisions_x": 10 }}, "centre": [1.5, 0, 0] }} }},
        "mesh": {{ "type": "Merge@1", "inputs": {{ "meshes": ["a.mesh", "b.mesh"] }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
                    "method": "solid", "size": 0.1, "materials": [
                    {{ "match": "colour", "colour": [1, 0, 0], "poisson": 0, "young": {} }},
                    {{ "match": "colour", "colour": [0, 1, 0], "poisson": 0, "young": {} }} ] }} }},
        "held": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                   "where": "ends", "ends": {{ "end": "low", "layers": 0 }} }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes", "pins": ["held.pins"] }},
                  "params": {{ "gravity": [9.81, 0, 0], "initial_shape": "equilibrium" }} }},
        "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "mesh.mesh", "cubes": "cubes.cubes",
                    "state": "sim.state" }} }},
        "tip": {{ "type": "Measure@1", "inputs": {{ "mesh": "shape.mesh", "rest": "mesh.mesh" }},
                  "params": {{ "what": "displacement_at", "point": [2, 0, 0],
                  "direction": [1, 0, 0] }} }})",
                           first, second);
    };
    Scene soft_first(bars("1e6", "1e12")), stiff_first(bars("1e12", "1e6"));
    EXPECT_NEAR(*soft_first.at<double>("tip"), 9810 * 1.5e-6, 0.03 * 9810 * 1.5e-6);
    EXPECT_NEAR(*stiff_first.at<double>("tip"), 9810 * 0.5e-6, 0.03 * 9810 * 0.5e-6);
}

// Frisch-Fay. Flexible bars. 1962: alpha = P L^2 / (E I) = 10. A bar of 20 cubes of 1 m, E = 1e8
// Pa, a dead load on the four corners of its tip.
TEST(TrueStepsNodes, AnElasticaIsFoundAndStaysOverAGround)
{
    const double load = 10 * 1e8 / 12 / 400 / 4;
    std::string forces, names;
    for (int k = 0; k < 4; ++k) {
        forces += fmt::format(R"(, "f{0}": {{ "type": "Force@1", "params": {{ "kind": "point",
            "point": {{ "force": [0, {1}, 0], "position": [20, {2}, {3}], "radius": 0 }} }} }})",
                              k, -load, k / 2, k % 2);
        names += fmt::format("{}\"f{}.force\"", k == 0 ? "" : ", ", k);
    }
    Scene scene(fmt::format(R"(
        "beam": {{ "type": "Primitive@1", "params": {{ "shape": "beam", "centre": [10, 0.5, 0.5],
                   "beam": {{ "length": 20, "height": 1, "width": 1, "divisions": 20 }} }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "beam.mesh" }}, "params": {{
                    "method": "solid", "size": 1, "matter": {{ "young": 1e8, "poisson": 0 }} }} }},
        "held": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                   "where": "ends", "ends": {{ "end": "low", "layers": 0 }} }} }},
        "ground": {{ "type": "Ground@1", "params": {{ "height": -100 }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes", "pins": ["held.pins"],
                  "colliders": ["ground.collider"], "forces": [{}] }}, "params": {{
                  "gravity": [0, 0, 0], "initial_shape": "equilibrium",
                  "step": {{ "newton_iterations": 20, "tolerance": 1e-5, "sleep": false }} }} }},
        "shape": {{ "type": "Embed@3", "inputs": {{ "mesh": "beam.mesh", "cubes": "cubes.cubes",
                    "state": "sim.state" }} }})",
                            names) +
                    forces + measure("solved", "converged"),
                {}, 1001);
    const auto tip = [&](int frame) {
        const auto shape = scene.at<TriMesh>("shape", frame), rest = scene.at<TriMesh>("beam");
        Vec3 sum = Vec3::Zero();
        int count = 0;
        for (std::size_t i = 0; i < rest->positions.size(); ++i) {
            if (rest->positions[i].x() < 19.99f) continue;
            sum += shape->positions[i].cast<double>(), ++count;
        }
        return Vec3(sum / count);
    };
    const Vec3 found = tip(1), later = tip(1001);
    EXPECT_NEAR(1 - found.x() / 20, 0.5549956, 0.01 * 0.555);
    EXPECT_NEAR((0.5 - found.y()) / 20, 0.8106090, 0.01 * 0.811);
    EXPECT_LT((later - found).norm(), 20 * 2e-4);
    EXPECT_EQ(*scene.at<double>("solved", 1001), 1);
    for (const std::string& w : scene.warnings) ADD_FAILURE() << w;
}

// A quarter of a tube of radii 3 and 9 m in plane strain, one layer of cubes of 0.5 m.
std::string quarter_tube()
{
    constexpr int n = 48;
    std::string text;
    for (const double r : {3.0, 9.0}) {
        for (int i = 0; i <= n; ++i) {
            const double a = 0.5 * std::numbers::pi * i / n;
            for (const double z : {0.0, 0.5}) {
                text += fmt::format("v {:.9f} {:.9f} {}\n", r * std::cos(a), r * std::sin(a), z);
            }
        }
    }
    const auto at = [](int ring, int i, int z) { return 1 + 2 * (n + 1) * ring + 2 * i + z; };
    const auto face = [&](int a, int b, int c, int d) {
        text += fmt::format("f {} {} {} {}\n", a, b, c, d);
    };
    text += "g hollow\n";
    for (int i = 0; i < n; ++i) face(at(0, i, 0), at(0, i, 1), at(0, i + 1, 1), at(0, i + 1, 0));
    text += "g others\n";
    for (int i = 0; i < n; ++i) {
        face(at(1, i, 0), at(1, i + 1, 0), at(1, i + 1, 1), at(1, i, 1));
        face(at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
        face(at(0, i, 1), at(1, i, 1), at(1, i + 1, 1), at(0, i + 1, 1));
    }
    face(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1));
    face(at(0, n, 0), at(0, n, 1), at(1, n, 1), at(1, n, 0));
    return text;
}

// Lame: u = p a^2 (1 + nu) (b^2 + (1 - 2 nu) a^2) / (E a (b^2 - a^2)) = 5.06227e-3 m at a = 3 m.
TEST(TrueStepsNodes, AThickCylinderThatKeepsItsVolumeGrowsAsLameSays)
{
    const files::Folder folder;
    folder.write("tube.obj", quarter_tube());
    const auto roller = [](const std::string& axis, const std::string& centre,
                           const std::string& size) {
        return fmt::format(
            R"(, "held_{0}": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
            "params": {{ "where": "box", "box": {{ "centre": {1}, "size": {2} }},
            "axes": "{0}" }} }})",
            axis, centre, size);
    };
    Scene scene(std::string(R"(
        "tube": { "type": "ReadMesh@1", "params": { "path": "tube.obj", "unit": "m" } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "tube.mesh" }, "params": {
                   "method": "solid", "size": 0.5, "align": "origin",
                   "matter": { "young": 1000, "poisson": 0.4999 } } },
        "load": { "type": "Pressure@1", "inputs": { "cubes": "cubes.cubes", "mesh": "tube.mesh" },
                  "params": { "pressure": 1, "part": "hollow" } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                 "forces": ["load.force"], "pins": ["held_x.pins", "held_y.pins", "held_z.pins"] },
                 "params": { "gravity": [0, 0, 0], "initial_shape": "equilibrium" } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "tube.mesh", "cubes": "cubes.cubes",
                   "state": "sim.state" } })") +
                    roller("x", "[0, 5, 0]", "[0.1, 30, 10]") +
                    roller("y", "[5, 0, 0]", "[30, 0.1, 10]") +
                    roller("z", "[5, 5, 0]", "[30, 30, 10]"),
                folder.path);
    const auto shape = scene.at<TriMesh>("shape"), rest = scene.at<TriMesh>("tube");
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < rest->positions.size(); ++i) {
        const double r = rest->positions[i].head<2>().cast<double>().norm();
        if (r > 3.01) continue;
        sum += shape->positions[i].head<2>().cast<double>().norm() - r, ++count;
    }
    EXPECT_NEAR(sum / count, 5.06227e-3, 0.02 * 5.06227e-3);
}

// One solve of linear forces for a swing through half a turn is not the step's solution, and the
// state says so; small steps are.
TEST(TrueStepsNodes, ConvergedTellsStepsThatAreSolvedFromThoseThatAreNot)
{
    const auto swing = [](int substeps) {
        return fmt::format(R"(
        "beam": {{ "type": "Primitive@1", "params": {{ "shape": "beam", "centre": [0.5, 0, 0],
                   "beam": {{ "length": 1, "height": 0.1, "width": 0.1, "divisions": 10 }} }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "beam.mesh" }}, "params": {{
                    "method": "solid", "size": 0.1, "matter": {{ "young": 2e4 }} }} }},
        "held": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }}, "params": {{
                   "where": "ends", "ends": {{ "end": "low", "layers": 0 }} }} }},
        "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                  "pins": ["held.pins"] }}, "params": {{
                  "step": {{ "substeps": {}, "newton_iterations": {} }} }} }})",
                           substeps, substeps == 1 ? 1 : 20) +
               measure("solved", "converged");
    };
    Scene once(swing(1)), finely(swing(4));
    int unsolved = 0;
    for (int frame = 2; frame <= 24; ++frame) {
        unsolved += *once.at<double>("solved", frame) == 0 ? 1 : 0;
        EXPECT_EQ(*finely.at<double>("solved", frame), 1) << frame;
    }
    EXPECT_GT(unsolved, 12);
}

TEST(TrueStepsNodes, AnErrorOfStepsThatNothingFollowsIsTold)
{
    const auto told = [](const std::string& step) {
        Scene scene(spinning("[0, 0, 0]", step));
        scene.at<physics::State>("sim", 2);
        std::string all;
        for (const auto& text : scene.warnings) all += text + "\n";
        return all;
    };
    EXPECT_EQ(told(R"("error": 0.03)"), "");
    EXPECT_EQ(told(R"("substeps": 4)"), "");
    EXPECT_EQ(told(R"("integrator": "sdirk2")"), "");
    EXPECT_NE(told(R"("error": 0.03, "substeps": 4)").find("because step.substeps = 4"),
              std::string::npos);
    EXPECT_NE(told(R"("error": 0.03, "integrator": "sdirk2")").find("others take one step a frame"),
              std::string::npos);
}

}  // namespace
