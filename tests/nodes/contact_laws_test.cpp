// Contact against closed forms, through graphs: the angle at which friction gives way, the speed
// after an impact, two elastic spheres.

#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>

namespace {

using fixtures::Scene;
using geometry::Vec3;

// A block of 0.4 x 0.1 x 0.4 m on a slope, told by its gravity. Returns how far it is along the
// slope at frames 24 and 48, m.
std::array<double, 2> slides(const std::string& method, double degrees)
{
    const double angle = degrees * std::numbers::pi / 180, g = 9.81;
    Scene scene(fmt::format(
        R"("mesh": {{ "type": "Primitive@1", "params": {{ "shape": "box",
                      "box": {{ "size": [0.4, 0.1, 0.4] }}, "centre": [0, 0.05, 0] }} }},
           "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
                       "method": "solid", "size": 0.05, "align": "origin",
                       "matter": {{ "young": 1e6, "stiffness_damping": 0.004 }} }} }},
           "ground": {{ "type": "Ground@1", "params": {{ "friction": 0.5 }} }},
           "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                     "surface": "mesh.mesh", "colliders": ["ground.collider"] }}, "params": {{
                     "method": "{}", "gravity": [{}, {}, 0], {}
                     "step": {{ "substeps": 0 }} }} }},
           "x": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state", "cubes": "cubes.cubes" }},
                   "params": {{ "what": "centre_of_mass", "direction": [1, 0, 0] }} }})",
        method, g * std::sin(angle), -g * std::cos(angle),
        method == "lattice" ? R"("lattice": { "half_width": 1 },)" : ""));
    const double at_24 = *scene.at<double>("x", 24);
    return {at_24, *scene.at<double>("x", 48)};
}

// atan(0.5) = 26.57 degrees. At 27 a block gains g (sin - 0.5 cos) = 0.083 m/s a second.
TEST(ContactLaws, ABlockStaysAtTwentySixDegreesAndSlidesAtTwentySeven)
{
    for (const std::string method : {"bricks", "springs", "lattice"}) {
        const auto [early, late] = slides(method, 26);
        EXPECT_LT(early, 2e-3) << method;
        EXPECT_LT(late - early, method == "lattice" ? 1e-3 : 1e-6) << method << " creeps";
        const auto [from, to] = slides(method, 27);
        const double gained = 0.5 * 0.0833 * (std::pow(47 / 24.0, 2) - std::pow(23 / 24.0, 2));
        EXPECT_NEAR(to - from, gained, 0.25 * gained) << method;
    }
}

// A ball of radius 0.1 m comes to x = 0 from the left, through free space, in steps of 1/96 s.
// More nodes, inputs of Simulate and parameters of it are JSON.
std::string ball(double young, double speed, const std::string& cubes, const std::string& inputs,
                 const std::string& params)
{
    return fmt::format(
        R"("a": {{ "type": "Primitive@1", "params": {{ "shape": "sphere",
                   "sphere": {{ "radius": 0.1 }}, "centre": [-0.2, 0, 0] }} }},
           "light": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "a.mesh" }}, "params": {{
                       "method": "solid", "size": 0.025, "matter": {{ "young": {} }} }} }},
           {}
           "sim": {{ "type": "Simulate@3", "inputs": {{ {} }}, "params": {{ "gravity": [0, 0, 0],
                     "bodies": [ {{ "velocity": [{}, 0, 0] }} ], "step": {{ "substeps": 4 }}{} }} }},
           "p": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state", "cubes": "light.cubes" }},
                   "params": {{ "what": "momentum", "direction": [1, 0, 0] }} }},
           "m": {{ "type": "Measure@1", "inputs": {{ "cubes": "light.cubes" }},
                   "params": {{ "what": "mass" }} }})",
        young, cubes, inputs, speed, params);
}

// At any time within a step, soft as a tyre or stiff.
TEST(ContactLaws, ABallLeavesAWallWithTheShareOfItsSpeedThatTheWallStates)
{
    const auto share = [](const std::string& method, double young, double bounce, double speed) {
        Scene scene(ball(young, speed,
                         fmt::format(R"("wall": {{ "type": "Collider@1", "params": {{
                             "kind": "plane", "rotate_degrees": [0, 0, 90], "bounce": {} }} }},)",
                                     bounce),
                         R"("cubes": "light.cubes", "surface": "a.mesh",
                            "colliders": ["wall.collider"])",
                         fmt::format(R"(, "method": "{}")", method)));
        return -*scene.at<double>("p", 12) / *scene.at<double>("m") / speed;
    };
    for (const double speed : {1.6, 1.7, 1.9, 2.0, 2.1, 2.3}) {
        EXPECT_NEAR(share("bricks", 1e7, 0.9, speed), 0.9, 0.03) << speed;
    }
    // What is soft comes back by 0.07 where the wall gives nothing: by its own elasticity.
    for (const double bounce : {0.0, 0.5, 0.9}) {
        EXPECT_NEAR(share("bricks", 1e9, bounce, 2), bounce, 0.03);
        EXPECT_NEAR(share("springs", 1e9, bounce, 2), bounce, 0.03);
    }
}

// One is twice as wide as the other.
TEST(ContactLaws, BallsThatMeetPartWithTheShareOfTheirSpeedAndKeepTheirMomentum)
{
    const auto check = [](double bounce, double speed) {
        Scene scene(ball(1e9, speed,
                         R"("b": { "type": "Primitive@1", "params": { "shape": "sphere",
                                   "sphere": { "radius": 0.2 }, "centre": [0.2, 0, 0] } },
                            "heavy": { "type": "Voxelize@1", "inputs": { "mesh": "b.mesh" },
                                       "params": { "method": "solid", "size": 0.05,
                                                   "matter": { "young": 1e9 } } },)",
                         R"("cubes": ["light.cubes", "heavy.cubes"],
                            "surface": ["a.mesh", "b.mesh"])",
                         fmt::format(R"(, "contact": {{ "bounce": {} }})", bounce)));
        const auto state = scene.at<physics::State>("sim", 12);
        const auto light = scene.at<geometry::Cubes>("light");
        const auto heavy = scene.at<geometry::Cubes>("heavy");
        const auto momentum = [&](const geometry::Cubes& cubes, std::size_t first) {
            double sum = 0;
            for (std::uint32_t c = 0; c < cubes.count(); ++c) {
                const auto share = geometry::corner_shares(cubes, c);
                for (std::size_t a = 0; a < 8; ++a) {
                    sum += share[a] * cubes.mass[c] * state->v[first + cubes.corners[c][a]].x();
                }
            }
            return sum;
        };
        const auto mass = [](const geometry::Cubes& cubes) {
            double sum = 0;
            for (const double m : cubes.mass) sum += m;
            return sum;
        };
        const double one = momentum(*light, 0), two = momentum(*heavy, light->corner_count());
        EXPECT_NEAR(two / mass(*heavy) - one / mass(*light), speed * bounce, 0.05 * speed)
            << bounce << " at " << speed << " m/s";
        EXPECT_NEAR(one + two, mass(*light) * speed, 1e-3 * mass(*light) * speed);
    };
    for (const double speed : {1.7, 2.0, 2.3}) check(0.9, speed);
    check(0, 2);
    check(0.5, 2);
}

// An eighth of a ball of radius r about `centre`, on the side of its axes that `up` says, as OBJ.
std::string eighth(double r, const Vec3& centre, double up, int n)
{
    std::string out;
    std::map<std::array<int, 2>, int> known;
    int count = 0;
    const auto vertex = [&](const Vec3& p) {
        const Vec3 at = centre + r * Vec3(p.x(), up * p.y(), p.z());
        out += fmt::format("v {} {} {}\n", at.x(), at.y(), at.z());
        return ++count;
    };
    const auto on_ball = [&](int i, int j) {
        const auto [found, fresh] = known.emplace(std::array{i, j}, 0);
        if (fresh) {
            // Angles in proportion, so that the triangles are nearly equal.
            const Vec3 along(i, n - i - j, j);
            found->second =
                vertex((along / n * std::numbers::pi / 2).array().sin().matrix().normalized());
        }
        return found->second;
    };
    const auto face = [&](int a, int b, int c) {
        if (up < 0) std::swap(b, c);
        out += fmt::format("f {} {} {}\n", a, b, c);
    };
    const int middle = vertex(Vec3::Zero());
    for (int i = 0; i < n; ++i) {
        for (int j = 0; i + j < n; ++j) {
            const int a = on_ball(i, j), b = on_ball(i, j + 1), c = on_ball(i + 1, j);
            face(a, b, c);
            if (i + j + 1 < n) face(b, on_ball(i + 1, j + 1), c);
        }
        const int xy[] = {on_ball(i, 0), on_ball(i + 1, 0)};
        const int yz[] = {on_ball(0, i), on_ball(0, i + 1)};
        const int zx[] = {on_ball(i, n - i), on_ball(i + 1, n - i - 1)};
        face(middle, xy[0], xy[1]);
        face(middle, yz[1], yz[0]);
        face(middle, zx[1], zx[0]);
    }
    return out;
}

// Hertz: spheres of radius R whose far sides come closer by d each hold 8/15 E* sqrt(R) d^(5/2)
// each, where contact is 4/3 E* sqrt(R) d^(3/2), E* = E / (1 - nu^2). Planes of symmetry leave an
// eighth of a ball on either side, a quarter of the contact. Its radius of 0.14 R is 2.8 cubes.
TEST(ContactLaws, TwoElasticSpheresHoldTheEnergyThatHertzGives)
{
    const double r = 0.5, d = 0.01, young = 1e6, nu = 0.3;
    const auto pins = [&](const std::string& name, const std::string& far, double way) {
        const auto pin = [&](const std::string& which, const std::string& axis,
                             const std::string& end, double by) {
            return fmt::format(R"(,
                "{}_{}": {{ "type": "Pin@1", "inputs": {{ "cubes": "{}.cubes" }}, "params": {{
                   "where": "ends", "ends": {{ "axis": "{}", "end": "{}", "layers": 0 }},
                   "axes": "{}", "translate": [0, {}, 0] }} }})",
                               name, which, name, axis, end, axis, by);
        };
        return pin("x", "x", "low", 0) + pin("z", "z", "low", 0) + pin("y", "y", far, way);
    };
    const files::Folder folder;
    folder.write("top.obj", eighth(r, {0, r, 0}, -1, 96));
    folder.write("bottom.obj", eighth(r, {0, -r, 0}, 1, 96));
    const auto body = [&](const std::string& name, double size) {
        return fmt::format(R"("{0}_mesh": {{ "type": "ReadMesh@1", "params": {{
              "path": "{0}.obj", "unit": "m" }} }},
            "{0}": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "{0}_mesh.mesh" }}, "params": {{
              "method": "solid", "size": {1}, "align": "origin",
              "matter": {{ "young": {2}, "poisson": {3}, "density": 100 }} }} }})",
                           name, size, young, nu);
    };
    const auto energy = [&](double size) {
        Scene scene(body("top", size) + "," + body("bottom", size) + pins("top", "high", -d) +
                        pins("bottom", "low", d) +
                        R"(, "sim": { "type": "Simulate@3", "inputs": {
              "cubes": ["top.cubes", "bottom.cubes"], "surface": ["top_mesh.mesh", "bottom_mesh.mesh"],
              "pins": ["top_x.pins", "top_y.pins", "top_z.pins", "bottom_x.pins", "bottom_y.pins",
                       "bottom_z.pins"] },
              "params": { "gravity": [0, 0, 0], "initial_shape": "equilibrium",
                          "contact": { "friction": 0 } } },
            "energy": { "type": "Measure@1", "inputs": { "state": "sim.state" },
                        "params": { "what": "elastic_energy" } })",
                    folder.path);
        const double out = *scene.at<double>("energy");
        for (const auto& warning : scene.warnings) ADD_FAILURE() << warning;
        return out;
    };
    const double expected =
        2 * 0.25 * 8.0 / 15 * young / (1 - nu * nu) * std::sqrt(r) * std::pow(d, 2.5);
    EXPECT_NEAR(energy(r / 20) / expected, 1, 0.05);
}

}  // namespace
