// Colliders that stop a mesh that vibrates in modes, through a graph.

#include "geometry/mesh/mesh.hpp"
#include "physics/modal/vibrate.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace {

using fixtures::Scene;
using geometry::TriMesh;

float lowest(const TriMesh& mesh)
{
    float y = 1e30f;
    for (const auto& p : mesh.positions) y = std::min(y, p.y());
    return y;
}

// One oscillator of 2 Hz and 3 kg, the whole box, sent down at 2 m/s on a floor that lies 0.05 m
// under it. Without the floor it would go 0.159 m down. It loses its speed there, and from then on
// swings from rest at the floor: y = -d cos(omega (t - t1)), sin(omega t1) = omega d / v. A frame
// takes 8 steps here, by one of which the moment of impact is wrong: omega / 192 = 0.065 of d.
TEST(VibrateColliders, AnOscillatorSwingsBackFromRestAtTheFloor)
{
    const files::Folder folder;
    std::string file = "aspic-modes 1\nvertices 8\nmodes 1\nmode 2 0 3  0 3 0\n";
    for (int i = 0; i < 8; ++i) file += "0 1 0\n";
    folder.write("hand.txt", file);
    Scene scene(R"("box": { "type": "Primitive@1" },
        "floor": { "type": "Ground@1", "params": { "height": -0.55 } },
        "modes": { "type": "ReadModes@1", "inputs": { "mesh": "box.mesh" },
                   "params": { "path": "hand.txt" } },
        "play": { "type": "Vibrate@1", "inputs": { "model": "modes.model",
                  "colliders": ["floor.collider"] }, "params": {
                  "kicks": [{ "position": [0, 0, 0], "radius": 2, "impulse": [0, -6, 0] }] } })",
                folder.path);
    const double omega = 4 * std::numbers::pi, d = 0.05, t1 = std::asin(omega * d / 2) / omega;
    const double bottom = lowest(*scene.at<TriMesh>("box"));
    for (int frame = 2; frame <= 30; ++frame) {
        const double y = lowest(*scene.at<TriMesh>("play", frame)) - bottom;
        EXPECT_NEAR(y, -d * std::cos(omega * ((frame - 1) / 24.0 - t1)), 0.07 * d) << frame;
        EXPECT_GT(y, -d - 1e-6) << frame;
    }
}

// A document whose frames begin at 101, and a kick whose frame is the default, 1.
TEST(VibrateColliders, AKickBeforeTheFirstFrameIsTold)
{
    const files::Folder folder;
    std::string file = "aspic-modes 1\nvertices 8\nmodes 1\nmode 2 0 3  0 3 0\n";
    for (int i = 0; i < 8; ++i) file += "0 1 0\n";
    folder.write("hand.txt", file);
    const auto warnings = [&](const char* kick) {
        const auto loaded = graph::load_text(
            fmt::format(R"({{ "aspic": 1, "frames": {{ "first": 101, "last": 103 }}, "nodes": {{
                "box": {{ "type": "Primitive@1" }},
                "modes": {{ "type": "ReadModes@1", "inputs": {{ "mesh": "box.mesh" }},
                           "params": {{ "path": "hand.txt" }} }},
                "play": {{ "type": "Vibrate@1", "inputs": {{ "model": "modes.model" }},
                          "params": {{ "kicks": [{}] }} }} }} }})",
                        kick),
            folder.path / "scene.json", nodes::registry());
        EXPECT_TRUE(loaded.problems.empty());
        struct : runtime::Observer {
            std::vector<std::string> texts;
            void warned(const runtime::Warning& w) override { texts.push_back(w.text); }
        } heard;
        runtime::Caches caches;
        runtime::Evaluator(loaded.graph, caches, {}, &heard).cook({{2, 103}});
        return heard.texts;
    };
    const auto early = warnings(R"({ "radius": 2 })");
    ASSERT_EQ(early.size(), 1u);
    EXPECT_EQ(early[0], "the kick at frame 1 has no effect, because the frames begin at 101: set "
                        "kicks[].frame to 101 or later");
    EXPECT_TRUE(warnings(R"({ "frame": 101 }, { "frame": 102 }, { "frame": 110 })").empty());
}

std::string cantilever(const std::string& colliders, const std::string& gravity)
{
    return fmt::format(R"("beam": {{ "type": "Primitive@1", "params": {{ "shape": "beam", "beam":
              {{ "length": 1, "height": 0.05, "width": 0.05, "divisions": 20 }} }} }},
        "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "beam.mesh" }},
                   "params": {{ "method": "solid", "size": 0.05,
                      "matter": {{ "young": 2e7, "density": 1000, "poisson": 0 }} }} }},
        "held": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                  "params": {{ "where": "ends", "ends": {{ "end": "low", "layers": 0 }} }} }},
        "modes": {{ "type": "Modes@1", "inputs": {{ "cubes": "cubes.cubes", "mesh": "beam.mesh",
                   "pins": "held.pins" }}, "params": {{ "count": 10 }} }},
        {} "play": {{ "type": "Vibrate@1", "inputs": {{ "model": "modes.model" {} }}, "params": {{
              "gravity": [0, {}, 0], "damping": {{ "kind": "ratio", "ratio": 0.5 }} }} }})",
                       colliders.empty() ? "" : colliders + ",",
                       colliders.empty() ? "" : R"(, "colliders": ["stop.collider"])", gravity);
}

// How far the vertices at x have come down, on average.
double sag(Scene& scene, int frame, double x)
{
    const auto rest = scene.at<TriMesh>("beam"), now = scene.at<TriMesh>("play", frame);
    float from = 1e30f;
    for (const auto& p : rest->positions) from = std::min(from, p.x());
    double sum = 0;
    int count = 0;
    for (std::size_t v = 0; v < rest->positions.size(); ++v) {
        if (std::abs(double(rest->positions[v].x() - from) - x) > 0.01) continue;
        sum += double(rest->positions[v].y() - now->positions[v].y());
        ++count;
    }
    return count > 0 ? sum / count : 0;
}

// With w = q L^4 / (8 E I) the tip's sag, a stop at half of it bears R = 3 q L / 16, and the middle
// sags by 19/768 q L^4 / (E I) = 0.198 w. (Euler and Bernoulli.)
TEST(VibrateColliders, ACantileverOnAStopSagsByTheClosedForm)
{
    Scene free(cantilever("", "-1"));
    const double tip = sag(free, 49, 1);
    EXPECT_NEAR(tip, 1.0 * 2.5 / (8 * 2e7 * std::pow(0.05, 4) / 12), 0.03 * tip);
    const float low = lowest(*free.at<TriMesh>("beam"));
    Scene stopped(cantilever(fmt::format(R"("stop": {{ "type": "Ground@1",
        "params": {{ "height": {} }} }})",
                                         double(low) - tip / 2),
                             "-1"));
    EXPECT_NEAR(sag(stopped, 49, 1) / tip, 0.5, 0.01);
    EXPECT_NEAR(sag(stopped, 49, 0.5) / tip, 8 * 19.0 / 768, 0.03 * 0.198);
    EXPECT_GT(lowest(*stopped.at<TriMesh>("play", 49)), double(low) - tip / 2 - 1e-6);
}

// A floor makes no energy, whatever is thrown at it.
TEST(VibrateColliders, ImpactsTakeEnergyAndMakeNone)
{
    Scene scene(cantilever("", "0"));
    const auto model = scene.at<physics::ModalModel>("modes");
    physics::Collider floor;
    floor.pose.translate(physics::Vec3(0, double(lowest(*model->rest)) - 0.02, 0));
    floor.before = floor.pose;
    physics::ModalState state =
        physics::struck(*model, physics::rest_state(*model), {{0.5, 0, 0}, {0, -1, 0}, 0.1});
    const physics::ModalDamping none{physics::ModalDamping::Kind::ratio, 0};
    const double first = physics::energy(*model, state);
    double before = first;
    for (int frame = 0; frame < 48; ++frame) {
        state = physics::advance(*model, std::move(state), {{}, {0, 0, 0}, {&floor, 1}}, none,
                                 1.0 / 24);
        const double now = physics::energy(*model, state);
        EXPECT_LE(now, before * (1 + 1e-9)) << frame;
        before = now;
    }
    EXPECT_LT(before, 0.99 * first) << "it hit the floor";
    EXPECT_GT(before, 0.01 * first) << "and came back";
}

// A box of 0.01 m, 0.05 m under the beam, which comes at many times that a step.
TEST(VibrateColliders, AThinBoxStopsWhatCrossesItWithinAStep)
{
    Scene scene(cantilever("", "0"));
    const auto model = scene.at<physics::ModalModel>("modes");
    const double low = double(lowest(*model->rest));
    physics::Collider plate;
    plate.kind = physics::Collider::Kind::box;
    plate.half_size = {2, 0.005, 2};
    plate.pose.translate(physics::Vec3(0, low - 0.055, 0));
    plate.before = plate.pose;
    physics::ModalState state =
        physics::struck(*model, physics::rest_state(*model), {{0.5, 0, 0}, {0, -400, 0}, 0.1});
    const physics::ModalDamping none{physics::ModalDamping::Kind::ratio, 0};
    for (int frame = 0; frame < 4; ++frame) {
        state = physics::advance(*model, std::move(state), {{}, {0, 0, 0}, {&plate, 1}}, none,
                                 1.0 / 24);
        double deepest = 0;
        for (std::size_t v = 0; v < model->rest->positions.size(); ++v) {
            double y = double(model->rest->positions[v].y()) - low + 0.05;
            for (std::size_t k = 0; k < model->count(); ++k) {
                y += state.q[k] * double(model->shape[k][v].y());
            }
            deepest = std::min(deepest, y);
        }
        EXPECT_GT(deepest, -0.002) << frame;
    }
}

// A floor out of reach leaves what the wind does. Without parts that are short for the wind, too,
// the beam is 7 % off.
TEST(VibrateColliders, WindBesideAFarFloorIsAsWithout)
{
    std::string two_modes = cantilever("", "0");
    const std::string count = R"("count": 10)";
    two_modes.replace(two_modes.find(count), count.size(), R"("count": 2)");
    Scene scene(two_modes);
    const auto model = scene.at<physics::ModalModel>("modes");
    physics::Force wind;
    wind.kind = physics::Force::Kind::wind;
    wind.velocity = {0, 40, 0};
    wind.air_density = 400;
    physics::Collider floor;
    floor.pose.translate(physics::Vec3(0, -100, 0));
    floor.before = floor.pose;
    const physics::ModalDamping some{physics::ModalDamping::Kind::ratio, 0.1};
    physics::ModalState free = physics::rest_state(*model), beside = free;
    for (int frame = 0; frame < 2; ++frame) {
        free =
            physics::advance(*model, std::move(free), {{&wind, 1}, {0, 0, 0}, {}}, some, 1.0 / 24);
        beside = physics::advance(*model, std::move(beside), {{&wind, 1}, {0, 0, 0}, {&floor, 1}},
                                  some, 1.0 / 24);
    }
    EXPECT_GT(std::abs(free.q[0]), 1e-3);
    EXPECT_NEAR(beside.q[0] / free.q[0], 1, 2e-3);
}

}  // namespace
