// Soft substances, pins and masses of layers through a graph.

#include "physics/layered_bodies/substance_parts.hpp"
#include "tests/nodes/scene.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace {

using fixtures::Scene;
using geometry::Vec3;
using physics::LayeredScene;

// A point skeleton of thickness 0.1 at (x, y, 0), on a frame of its own.
std::string point(double x, double y, int frame = 0)
{
    return fmt::format(R"({{ "position": [{}, {}, 0], "frame": {}, "contribution":
        {{ "thickness": 0.1, "stiffness": 10, "radius": 0.22 }} }})",
                       x, y, frame);
}

std::string skeletons(const std::string& name, const std::string& points)
{
    return fmt::format(R"("{}": {{ "type": "Skeletons@1", "params": {{ "skeletons": [{}] }} }},)",
                       name, points);
}

std::string layer(const std::string& name, const std::string& of, const std::string& params)
{
    return fmt::format(R"("{}": {{ "type": "ImplicitLayer@3", "inputs": {{ "layer": "{}.layer" }},
        "params": {{ "seed_spacing": 0.05, {} }} }},)",
                       name, of, params);
}

std::string layered(const std::string& parts, const std::string& params)
{
    return fmt::format(R"("bodies": {{ "type": "Layered@1", "inputs": {{ "parts": [{}] }},
        "params": {{ {} }} }})",
                       parts, params);
}

// Two particles of a body each that meet at 1 m/s, of the substance that `substance` tells of.
std::string two_bodies(const std::string& substance, const std::string& other_matter = "")
{
    const std::string params = R"("base": "particles", "mass": 1, "matter": { "stiffness": 3000 },
        "substance": { "stiffness": 0, "friction": 0, )" +
                               substance + "}, ";
    return skeletons("left", point(0, 0)) + skeletons("right", point(0.5, 0)) +
           layer("first", "left", params + R"("velocity": [0.5, 0, 0])") +
           layer("second", "right", params + other_matter + R"("velocity": [-0.5, 0, 0])") +
           layered(R"("first.part", "second.part")", R"("gravity": [0, 0, 0])");
}

constexpr const char* fuses = R"("fusion_threshold": 100, "fusion_time": 0.05)";

// At 1 m/s the gap of 0.3 m is closed after 0.3 s.
TEST(Substances, TwoLayersOfOneNameFuseByTheThreshold)
{
    Scene one(two_bodies(R"("name": "dough", )" + std::string(fuses)));
    const auto apart = one.at<LayeredScene>("bodies", 4), end = one.at<LayeredScene>("bodies", 24);
    ASSERT_EQ(apart->parts.size(), 1u) << "they are one body";
    EXPECT_EQ(physics::piece_count(*apart), 2u);
    EXPECT_NEAR(apart->states[0].velocity[0].x(), 0.5, 1e-9) << "each has its own first velocity";
    EXPECT_NEAR(apart->states[0].velocity[1].x(), -0.5, 1e-9);
    EXPECT_EQ(physics::piece_count(*end), 1u);

    Scene hard(two_bodies(R"("name": "dough", "fusion_threshold": 1e6)"));
    EXPECT_EQ(physics::piece_count(*hard.at<LayeredScene>("bodies", 24)), 2u);
    EXPECT_TRUE(one.warnings.empty() && hard.warnings.empty());
}

// Below the threshold parts of one body and two bodies push each other alike.
TEST(Substances, LayersOfOneNameThatDoNotFuseCollideAsTwoBodiesDo)
{
    Scene one(two_bodies(R"("name": "dough", "fusion_threshold": 1e6)"));
    Scene two(two_bodies(R"("fusion_threshold": 100)"));
    const auto joined = one.at<LayeredScene>("bodies", 24),
               own = two.at<LayeredScene>("bodies", 24);
    ASSERT_EQ(own->parts.size(), 2u) << "without a name each is a substance of its own";
    EXPECT_GT(own->states[1].position[0].x(), own->states[0].position[0].x() + 0.1);
    EXPECT_NEAR(joined->states[0].position[0].x(), own->states[0].position[0].x(), 2e-3);
    EXPECT_NEAR(joined->states[0].position[1].x(), own->states[1].position[0].x(), 2e-3);
}

TEST(Substances, LayersOfOneNameAreOfOneMatter)
{
    Scene scene(two_bodies(R"("name": "dough")", R"("volume": { "proportional": 3 }, )"));
    const std::string failure = scene.failure_at<LayeredScene>("bodies");
    EXPECT_NE(failure.find("parts 0 and 1 of Layered, counted from 0, are of the "
                           "substance 'dough', but differ in volume"),
              std::string::npos)
        << failure;
    Scene blends(two_bodies(R"("name": "dough", "separates": false)"));
    const std::string merged = blends.failure_at<LayeredScene>("bodies");
    EXPECT_NE(merged.find("separates to true"), std::string::npos) << merged;
    EXPECT_NE(merged.find("parts 0 and 1"), std::string::npos) << merged;
}

TEST(Substances, AHeldParticleBeginsWhereItsPinHasIt)
{
    Scene scene(
        skeletons("two", point(0, 0, 0) + "," + point(0.6, 0, 1)) +
        layer("body", "two",
              R"("base": "particles", "pins": [ { "frame": 1, "translate": [0.2, 0, 0] } ])") +
        layered(R"("body.part")", ""));
    for (const int frame : {1, 2}) {
        const auto bodies = scene.at<LayeredScene>("bodies", frame);
        EXPECT_NEAR(bodies->states[0].position[1].x(), 0.8, 1e-9) << frame;
    }
}

// Two particles that are drawn as one, pulled apart by pins and pushed together again.
std::string pulled(const std::string& substance)
{
    return skeletons("two", point(0, 0, 0) + "," + point(0.15, 0, 1)) +
           layer("body", "two",
                 R"("base": "particles", "matter": { "stiffness": 3000 }, "substance": {)" +
                     substance + R"( }, "pins": [ { "frame": 0 }, { "position": [0.2, 0, 0],
                     "radius": 0.06, "translate": { "keys": [
                         [1, [0, 0, 0]], [5, [0.5, 0.1, 0]], [9, [0, 0, 0]] ] } } ])") +
           layered(R"("body.part")", "");
}

TEST(Substances, PiecesThatComeApartCollideFromThenOn)
{
    Scene scene(pulled("")), blends(pulled(R"("separates": false)"));
    EXPECT_EQ(physics::piece_count(*scene.at<LayeredScene>("bodies", 2)), 1u);
    const auto away = scene.at<LayeredScene>("bodies", 5),
               back = scene.at<LayeredScene>("bodies", 9);
    EXPECT_EQ(physics::piece_count(*away), 2u);
    EXPECT_EQ(physics::piece_count(*back), 2u) << "no pressure fuses them by default";
    EXPECT_EQ(physics::piece_count(*blends.at<LayeredScene>("bodies", 9)), 1u);
    // Pins: exactly where they are told, and nothing else.
    EXPECT_LT((away->states[0].position[1] - Vec3(0.65, 0.1, 0)).norm(), 1e-12);
    EXPECT_LT(back->states[0].position[0].norm(), 1e-12);
    EXPECT_TRUE(scene.warnings.empty());
}

// A particle of 1 kg on a spring of 200 N/m that hangs on a pinned one sinks by m g / k.
// Two doughs of 3 x 2 x 2 particles, whose outer layers pins press together at 0.91 m/s for half a
// second, in two steps a frame. What is squeezed between was shot off at 7.9 m/s.
TEST(Substances, WhatIsSqueezedIsNotShotOff)
{
    const auto dough = [](const std::string& name, double x0, int pinned, double way) {
        std::string points, pins;
        for (int n = 0; n < 12; ++n) {
            const int i = n / 4, j = n / 2 % 2, k = n % 2;
            points += fmt::format(R"({}{{ "position": [{}, {}, {}], "frame": {}, "part": 0,
                "contribution": {{ "thickness": 0.085, "stiffness": 14, "radius": 0.17 }} }})",
                                  n > 0 ? ", " : "", x0 + 0.1 * i, 0.1 * j + 0.05,
                                  0.1 * k + 0.003 * ((i * 7 + j * 3 + k) % 3), n);
        }
        for (int f = pinned; f < pinned + 4; ++f) {
            pins += fmt::format(R"({}{{ "frame": {}, "translate": {{ "keys": [[1, [0, 0, 0]],
                [13, [{}, 0, 0]]], "interpolation": "linear" }} }})",
                                f > pinned ? ", " : "", f, way);
        }
        return fmt::format(R"("s{0}": {{ "type": "Skeletons@1", "params": {{
            "blend": "smooth_groups", "skeletons": [{1}] }} }},)",
                           name, points) +
               layer(name, "s" + name,
                     R"("base": "particles", "density": 1000, "matter": { "stiffness": 20000,
            "friction": 2000, "bulge_height": 0, "self_contact": true },
            "substance": { "stiffness": 200, "rest_distance": 0.12, "friction": 5,
            "reach": 1.7 }, "pins": [)" +
                         pins + "]");
    };
    Scene scene(dough("a", -0.35, 0, 0.455) + dough("b", 0.15, 8, -0.455) +
                layered(R"("a.part", "b.part")", R"("substeps": 2, "gravity": [0, 0, 0])"));
    double most = 0;
    for (int frame = 1; frame <= 30; ++frame) {
        most = std::max(most, physics::fastest(*scene.at<LayeredScene>("bodies", frame)));
    }
    EXPECT_LT(most, 3);
}

TEST(LayerPins, AParticleHangsOnAPinnedOneByASpring)
{
    Scene scene(skeletons("two", point(0, 0, 0) + "," + point(0, -0.3, 1)) +
                layer("body", "two", R"("base": "particles", "pins": [ { "frame": 0 } ],
                      "own_masses": [ { "frame": 1, "mass": 1 } ])") +
                R"("net": { "type": "Springs@1", "inputs": { "part": "body.part" },
                    "params": { "reach": 0.31, "stiffness": 200, "damping": 20 } },)" +
                layered(R"("net.part")", ""));
    const auto at = scene.at<LayeredScene>("bodies", 72);
    EXPECT_EQ(at->states[0].position[0], Vec3(0, 0, 0));
    EXPECT_NEAR(at->states[0].position[1].y(), -0.3 - 9.81 / 200, 1e-4);
}

// A rigid ball that a pin holds until frame 10, and then moves at 8 m/s at a soft one 0.15 m ahead,
// hits it: with restitution 0.5, that leaves at 12 m/s at most. It went through, to leave 0.18.
TEST(LayerPins, WhatTheyMoveFromRestHitsWhatIsAhead)
{
    const auto ball = [](const std::string& name, double x) {
        return skeletons(name, fmt::format(R"({{ "position": [{}, 0, 0], "contribution":
            {{ "thickness": 0.05, "stiffness": 20, "radius": 0.15 }} }})",
                                           x));
    };
    Scene scene(ball("sa", -0.15) + ball("sb", 0) +
                layer("a", "sa", R"("base": "rigid", "density": 1000, "matter": { "rigid": true },
                    "pins": [{ "frame": 0, "translate": { "keys": [[1, [0, 0, 0]],
                        [10, [0, 0, 0]], [16, [2, 0, 0]]], "interpolation": "linear" } }])") +
                layer("b", "sb", R"("base": "rigid", "density": 1000,
                    "matter": { "stiffness": 1e6, "restitution": 0.5 })") +
                layered(R"("a.part", "b.part")", R"("gravity": [0, 0, 0])"));
    const double leaves = scene.at<LayeredScene>("bodies", 14)->states[1].velocity[0].x();
    EXPECT_GT(leaves, 9);
    EXPECT_LT(leaves, 12.5);
}

// One rigid body of two parts, of which a pin moves one at 8 m/s at the other.
TEST(LayerPins, PartsOfOneBodyDoNotTunnel)
{
    for (const double way : {6.0, 8.0, 10.0}) {
        Scene scene(R"("s": { "type": "Skeletons@1", "params": { "blend": "smooth_groups",
            "skeletons": [{ "position": [-0.5, 0, 0], "frame": 0, "part": 0, "contribution":
                { "thickness": 0.05, "stiffness": 20, "radius": 0.15 } },
                { "position": [0, 0, 0], "frame": 1, "part": 1, "contribution":
                { "thickness": 0.05, "stiffness": 20, "radius": 0.15 } }] } },)" +
                    layer("a", "s",
                          fmt::format(R"("base": "rigid", "density": 1000, "pins": [{{ "frame": 0,
                "translate": {{ "keys": [[1, [0, 0, 0]], [9, [{}, 0, 0]]],
                "interpolation": "linear" }} }}], "matter": {{ "stiffness": 1e6,
                "restitution": 0.5, "self_contact": true }})",
                                      way * 8 / 24)) +
                    layered(R"("a.part")", R"("gravity": [0, 0, 0])"));
        const auto bodies = scene.at<LayeredScene>("bodies", 9);
        EXPECT_GT(bodies->states[0].velocity[1].x(), 0.9 * way) << way;
        EXPECT_GT(bodies->states[0].position[1].x(), bodies->states[0].position[0].x()) << way;
    }
}

TEST(LayerPins, AreToldWhereTheyDoNothing)
{
    const auto body = [](const std::string& params, const std::string& solver) {
        return skeletons("one", point(0, 0)) + layer("body", "one", params) +
               layered(R"("body.part")", solver);
    };
    Scene empty(body(R"("pins": [ { "position": [1, 0, 0] } ])", ""));
    empty.at<LayeredScene>("bodies");
    ASSERT_EQ(empty.warnings.size(), 1u);
    EXPECT_NE(empty.warnings[0].find("holds nothing"), std::string::npos);
    Scene bullet(body(R"("pins": [ { "frame": 0 } ])", R"("rigid_bodies": "bullet")"));
    EXPECT_NE(bullet.failure_at<LayeredScene>("bodies", 2).find("can't hold frames"),
              std::string::npos);
    Scene none(body(R"("pins": [ { "frame": 7 } ])", ""));
    EXPECT_NE(none.failure_at<LayeredScene>("bodies").find("the body has 1 frames"),
              std::string::npos);
}

// A body of 2 kg that swings by 3 degrees on a ball joint 0.3 m above its centre.
std::string pendulum(const std::string& inertia)
{
    const double angle = 0.05, arm = 0.3;
    return skeletons("one", point(arm * std::sin(angle), -arm * std::cos(angle))) +
           layer("body", "one", R"("own_masses": [ { "frame": 0, "mass": 2, )" + inertia + "} ]") +
           R"("figure": { "type": "Figure@1", "inputs": { "part": "body.part" }, "params": {
               "joints": [ { "a": -1, "b": 0, "kind": "ball", "point": [0, 0, 0] } ] } },)" +
           layered(R"("figure.part")", R"("substeps": 20)");
}

// Twice the time between the first two moments at which it hangs straight down.
double period(Scene& scene)
{
    std::vector<double> crossed;
    double before = 1;
    for (int frame = 2; crossed.size() < 2 && frame < 100; ++frame) {
        const double x = scene.at<LayeredScene>("bodies", frame)->states[0].position[0].x();
        if ((before > 0) != (x > 0)) crossed.push_back((frame - x / (x - before)) / 24);
        before = x;
    }
    return crossed.size() < 2 ? 0 : 2 * (crossed[1] - crossed[0]);
}

// 2 pi sqrt((I + m d^2) / (m g d)) times 1 + angle^2 / 16, which is 1.00016.
TEST(LayerMass, APendulumSwingsByTheInertiaThatItIsGiven)
{
    const auto closed = [](double I) {
        return 2 * std::numbers::pi * std::sqrt((I + 2 * 0.09) / (2 * 9.81 * 0.3)) * 1.00016;
    };
    Scene heavy(pendulum(R"("inertia": [0.2, 0.2, 0.18])"));
    EXPECT_NEAR(period(heavy) / closed(0.18), 1, 0.01);
    // A ball's own is 2/5 m r^2.
    Scene ball(pendulum(R"("inertia": [0, 0, 0])"));
    EXPECT_NEAR(period(ball) / closed(0.4 * 2 * 0.01), 1, 0.01);
}

// I = R diag(0.1, 0.2, 0.3) R^T, R a turn by 30 degrees about z.
TEST(LayerMass, InertiaIsAWholeTensorOfARigidThing)
{
    const double c = std::sqrt(0.75), s = 0.5;
    Scene scene(pendulum(fmt::format(R"("inertia": [{}, {}, 0.3], "products": [{}, 0, 0])",
                                     0.1 * c * c + 0.2 * s * s, 0.1 * s * s + 0.2 * c * c,
                                     (0.1 - 0.2) * c * s)));
    const auto at = scene.at<LayeredScene>("bodies");
    const geometry::Mat3& I = at->parts[0].body->base.inertia[0];
    EXPECT_NEAR((I * Vec3(c, s, 0) - 0.1 * Vec3(c, s, 0)).norm(), 0, 1e-12);
    EXPECT_NEAR((I * Vec3(-s, c, 0) - 0.2 * Vec3(-s, c, 0)).norm(), 0, 1e-12);
    Scene impossible(pendulum(R"("inertia": [0.1, 0.1, 0.3])"));
    EXPECT_NE(impossible.failure_at<LayeredScene>("bodies").find("more than the sum"),
              std::string::npos);
}

}  // namespace
