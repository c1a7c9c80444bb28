// Bodies of a Simulate that keep their shape, through graphs.

#include "nodes/simulate_bodies.hpp"
#include "tests/nodes/scene.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <fmt/format.h>

namespace {

using fixtures::Scene;

// A block of oak that comes to the floor at 4 m/s, tilted. `simulate`: parameters of Simulate.
std::string thrown(const std::string& simulate)
{
    return fmt::format(
        R"("box": {{ "type": "Primitive@1", "params": {{ "shape": "box",
                     "box": {{ "size": [0.2, 0.1, 0.1] }} }} }},
           "mesh": {{ "type": "Transform@1", "inputs": {{ "mesh": "box.mesh" }}, "params": {{
                      "rotate_degrees": [20, 0, 30], "translate": [0, 0.4, 0] }} }},
           "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
                       "method": "solid", "size": 0.05, "matter": {{ "preset": "oak" }} }} }},
           "floor": {{ "type": "Ground@1" }},
           "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                     "surface": "mesh.mesh", "colliders": ["floor.collider"] }}, "params": {{
                     {} }} }},
           "depth": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state" }}, "params": {{
                       "what": "contact_depth" }} }})",
        simulate);
}

// A ball that rolls without slip gains 5/7 of what a slope of 10 degrees gives. After a second it
// is at 1/2 5/7 g sin(10).
TEST(RigidBodyNodes, ABallRollsDownASlope)
{
    Scene scene(R"("mesh": { "type": "Primitive@1", "params": { "shape": "sphere",
                     "sphere": { "radius": 0.1, "subdivisions": 4 }, "centre": [0, 0.1, 0] } },
           "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "mesh.mesh" }, "params": {
                      "method": "solid", "size": 0.02, "matter": { "preset": "pine" } } },
           "floor": { "type": "Ground@1" },
           "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                    "surface": "mesh.mesh", "colliders": ["floor.collider"] }, "params": {
                    "gravity": [1.70349, -9.66097, 0], "bodies": [{ "rigid": true }],
                    "step": { "substeps": 8 } } },
           "x": { "type": "Measure@1", "inputs": { "state": "sim.state",
                  "cubes": "cubes.cubes" }, "params": { "what": "centre_of_mass",
                  "direction": [1, 0, 0] } })");
    const double way = *scene.at<double>("x", 25) - *scene.at<double>("x", 1);
    const double wanted = 0.5 * 5 / 7 * 1.70349;
    EXPECT_NEAR(way, wanted, 0.02 * wanted);
}

// A box in cubes that reach beyond it on one side, with a spin and nothing else: the middle of the
// mesh stays where it is.
TEST(RigidBodyNodes, ABodyThatSpinsFreelyStaysWhereItIs)
{
    for (const char* const spin :
         {R"("initial_spin_degrees": [0, 0, 720], "bodies": [{ "rigid": true }])",
          R"("bodies": [{ "rigid": true, "spin_degrees": [0, 0, 720] }])"}) {
        Scene scene(fmt::format(
            R"("mesh": {{ "type": "Primitive@1", "params": {{ "shape": "box",
                     "box": {{ "size": [0.2, 0.2, 0.2] }}, "centre": [0.1, 0.1, 0.1] }} }},
           "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
                      "method": "solid", "size": 0.13, "align": "origin",
                      "matter": {{ "density": 1000, "young": 1e6 }} }} }},
           "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                    "surface": "mesh.mesh" }}, "params": {{ "gravity": [0, 0, 0], {} }} }},
           "turned": {{ "type": "Embed@3", "inputs": {{ "mesh": "mesh.mesh",
                    "cubes": "cubes.cubes", "state": "sim.state" }} }})",
            spin));
        const auto turned = scene.at<geometry::TriMesh>("turned", 25);
        geometry::Vec3 middle = geometry::Vec3::Zero();
        for (const auto& p : turned->positions) middle += p.cast<double>();
        middle /= static_cast<double>(turned->positions.size());
        EXPECT_LT((middle - geometry::Vec3(0.1, 0.1, 0.1)).norm(), 1e-5) << spin;  // of its corners
    }
}

// A ball of steel that falls by 1 m comes out of the floor by a share of a cube: no step fails of
// it.
TEST(RigidBodyNodes, ABallThatLandsConvergesInEveryFrame)
{
    for (const int substeps : {1, 0}) {
        Scene scene(fmt::format(
            R"("mesh": {{ "type": "Primitive@1", "params": {{ "shape": "sphere",
                     "sphere": {{ "radius": 0.1, "subdivisions": 3 }}, "centre": [0, 1.1, 0] }} }},
           "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
                      "method": "solid", "size": 0.025,
                      "matter": {{ "density": 7800, "young": 1e6 }} }} }},
           "floor": {{ "type": "Ground@1" }},
           "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                    "surface": "mesh.mesh", "colliders": ["floor.collider"] }}, "params": {{
                    "bodies": [{{ "rigid": true }}], "step": {{ "substeps": {} }} }} }})",
            substeps));
        const auto state = scene.at<physics::State>("sim", 24);
        EXPECT_TRUE(scene.warnings.empty()) << scene.warnings[0];
        for (const auto& v : state->v) EXPECT_LT(v.norm(), 0.01) << substeps;
    }
}

// Five rings through each other, the top one pinned, let go at 30 degrees: the others lose energy
// in each frame, 0.28 J in all.
TEST(RigidBodyNodes, AChainThatIsPulledTightGainsNoEnergy)
{
    constexpr int rings = 5;
    std::string nodes, cubes, surfaces, rigid;
    for (int i = 0; i < rings; ++i) {
        const char* const comma = i > 0 ? ", " : "";
        cubes += fmt::format(R"({}"c{}.cubes")", comma, i);
        surfaces += fmt::format(R"({}"h{}.mesh")", comma, i);
        rigid += fmt::format(R"({}{{ "rigid": true }})", comma);
        nodes += fmt::format(
            R"("t{0}": {{ "type": "Primitive@1", "params": {{ "shape": "torus", "torus": {{
                   "radius": 0.05, "tube": 0.01, "segments": 32, "tube_segments": 12 }} }} }},
               "r{0}": {{ "type": "Transform@1", "inputs": {{ "mesh": "t{0}.mesh" }}, "params": {{
                   "rotate_degrees": [90, {1}, 0], "translate": [0, {2}, 0] }} }},
               "h{0}": {{ "type": "Transform@1", "inputs": {{ "mesh": "r{0}.mesh" }}, "params": {{
                   "rotate_degrees": [0, 0, 30] }} }},
               "c{0}": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "h{0}.mesh" }}, "params": {{
                   "method": "solid", "size": 0.012,
                   "matter": {{ "density": 2700, "young": 1e9 }} }} }},
               "e{0}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state",
                   "cubes": "c{0}.cubes" }}, "params": {{ "what": "kinetic_energy" }} }},
               "y{0}": {{ "type": "Measure@1", "inputs": {{ "state": "sim.state",
                   "cubes": "c{0}.cubes" }}, "params": {{ "what": "centre_of_mass",
                   "direction": [0, 1, 0] }} }},
               "m{0}": {{ "type": "Measure@1", "inputs": {{ "cubes": "c{0}.cubes" }},
                   "params": {{ "what": "mass" }} }},)",
            i, i % 2 * 90, -0.079 * i);
    }
    Scene scene(nodes +
                fmt::format(R"("pin": {{ "type": "Pin@1", "inputs": {{ "cubes": "c0.cubes" }},
                       "params": {{ "where": "box", "box": {{ "size": [1, 1, 1] }} }} }},
                   "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": [{}],
                       "surface": [{}], "pins": ["pin.pins"] }}, "params": {{
                       "bodies": [{}], "contact": {{ "friction": 0.2 }} }} }})",
                            cubes, surfaces, rigid));
    const auto energy = [&](int frame) {
        double sum = 0;
        for (int i = 1; i < rings; ++i) {
            const auto of = [&](const char* what) {
                return *scene.at<double>(what + std::to_string(i), frame);
            };
            sum += of("e") + of("m") * 9.81 * of("y");
        }
        return sum;
    };
    double before = energy(1);
    for (int frame = 2; frame <= 28; ++frame) {
        const double now = energy(frame);
        EXPECT_LT(now, before + 0.001) << frame;
        before = now;
    }
}

TEST(RigidBodyNodes, LandInFewStepsWhereStiffOnesAreToldThatTheyCould)
{
    const std::string params = R"("initial_velocity": [0, -4, 0], "step": { "substeps": 1 })";
    Scene stiff(thrown(params)), rigid(thrown(params + R"(, "bodies": [{ "rigid": true }])"));
    const auto most_steps = [](Scene& scene) {
        int most = 0;
        for (int frame = 2; frame <= 12; ++frame) {
            most = std::max(most, scene.at<physics::State>("sim", frame)->report.steps);
        }
        return most;
    };
    EXPECT_GE(most_steps(stiff), 8);
    EXPECT_LE(most_steps(rigid), 2);
    const auto hint = [](const std::string& text) {
        return text.find("set `rigid` = true in `bodies` (entry 0)") != std::string::npos;
    };
    EXPECT_TRUE(std::any_of(stiff.warnings.begin(), stiff.warnings.end(), hint));
    EXPECT_TRUE(rigid.warnings.empty()) << rigid.warnings[0];
}

TEST(RigidBodyNodes, AreNamedWhereStiffOnesDoNotConverge)
{
    const auto cubes =
        std::make_shared<const geometry::Cubes>(fixtures::box(2, 1, 1, 0.1, {.young = 1e9}));
    const auto told = [&](const physics::State& state, int asked, float stress) {
        physics::State with = state;
        with.stress.assign(2, stress);
        return nodes::simulate::told_of_stiff({cubes}, {}, with, asked);
    };
    physics::State state;
    EXPECT_TRUE(told(state, 1, 0).empty());
    state.report.steps = 8;
    EXPECT_FALSE(told(state, 1, 0).empty());
    const auto chosen = told(state, 0, 0);
    ASSERT_EQ(chosen.size(), 1u);
    EXPECT_NE(chosen[0].find("which took 8 steps a frame, or more"), std::string::npos)
        << chosen[0];
    EXPECT_TRUE(told(state, 2, 0).empty());
    state.report.steps = 7;
    EXPECT_TRUE(told(state, 0, 0).empty());
    state.report.warnings.emplace_back(physics::short_contact);
    const auto texts = told(state, 0, 0);
    ASSERT_EQ(texts.size(), 1u);
    EXPECT_NE(
        texts[0].find("are driven or turn fast, and the steps did not converge: set `rigid` = "
                      "true in `bodies` (entry 0)"),
        std::string::npos)
        << texts[0];
    state.holds.emplace_back();
    const auto hit = told(state, 0, 0);
    ASSERT_EQ(hit.size(), 1u);
    EXPECT_NE(hit[0].find("hit something, and contact did not converge: set `rigid`"),
              std::string::npos)
        << hit[0];
    EXPECT_TRUE(told(state, 0, 1e7f).empty()) << "they strain by 1 %";
}

// A bar that hangs on corners at both ends: each end carries half of its weight.
TEST(RigidBodyNodes, TheForceOfEachPinIsItsShareOfTheWeight)
{
    const auto pin = [](const char* name, double x) {
        return fmt::format(R"("{}": {{ "type": "Pin@1", "inputs": {{ "cubes": "cubes.cubes" }},
                    "params": {{ "box": {{ "centre": [{}, 0, 0], "size": [0.01, 1, 1] }} }} }},)",
                           name, x);
    };
    const auto measure = [](const char* name, const char* what, const char* pins) {
        return fmt::format(R"(, "{}": {{ "type": "Measure@1", "inputs": {{ "cubes": "cubes.cubes",
                    "state": "sim.state"{} }}, "params": {{ "what": "{}" }} }})",
                           name, pins, what);
    };
    Scene scene(R"("mesh": { "type": "Primitive@1", "params": { "shape": "box",
                     "box": { "size": [0.4, 0.1, 0.1] } } },
           "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "mesh.mesh" }, "params": {
                      "method": "solid", "size": 0.05, "matter": { "preset": "oak" } } },)" +
                pin("low", -0.2) + pin("high", 0.2) +
                R"("sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                    "pins": ["low.pins", "high.pins"] }, "params": {
                    "bodies": [{ "rigid": true }] } })" +
                measure("mass", "mass", "") + measure("all", "reaction_force", "") +
                measure("left", "reaction_force", R"(, "pins": "low.pins")") +
                measure("torque", "reaction_torque", R"(, "pins": "high.pins")"));
    const double weight = 9.81 * *scene.at<double>("mass");
    EXPECT_NEAR(*scene.at<double>("all", 8), weight, 1e-3 * weight);
    EXPECT_NEAR(*scene.at<double>("left", 8), weight / 2, 1e-3 * weight);
    EXPECT_NEAR(*scene.at<double>("torque", 8), 0, 1e-3 * weight);  // about the y axis
}

// A door on two small places: corners on a line let it fall open, points hold it.
TEST(RigidBodyNodes, CornersOnALineAreAHingeAndPointsAreAClamp)
{
    const auto hung = [](const std::string& hold) {
        const std::string pin = R"(": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
            "params": { "where": "sphere", "hold": ")" +
                                hold + R"(", "sphere": { "radius": 0.02, "centre": [-0.2, 0, )";
        return R"("mesh": { "type": "Primitive@1", "params": { "shape": "box",
                     "box": { "size": [0.4, 0.1, 0.4] } } },
           "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "mesh.mesh" }, "params": {
                      "method": "solid", "size": 0.05, "matter": { "preset": "oak" } } },
           "one)" +
               pin + R"(-0.15] } } },
           "two)" +
               pin + R"(0.15] } } },
           "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
                    "pins": ["one.pins", "two.pins"] }, "params": {
                    "bodies": [{ "rigid": true }] } },
           "y": { "type": "Measure@1", "inputs": { "state": "sim.state",
                  "cubes": "cubes.cubes" }, "params": { "what": "centre_of_mass" } })";
    };
    Scene hinge(hung("corners")), clamp(hung("points"));
    EXPECT_LT(*hinge.at<double>("y", 9), -0.1);
    EXPECT_GT(*clamp.at<double>("y", 9), -1e-3);
    EXPECT_TRUE(hinge.warnings.empty()) << hinge.warnings[0];
    ASSERT_FALSE(clamp.warnings.empty());
    EXPECT_NE(clamp.warnings[0].find("2 pins with hold = points hold the rigid body of cubes[0]"),
              std::string::npos)
        << clamp.warnings[0];
}

TEST(RigidBodyNodes, AreRefusedWhereNothingMovesThem)
{
    const auto problem = [](const std::string& simulate) {
        const auto loaded =
            graph::load_text(R"({ "aspic": 1, "nodes": {)" +
                                 thrown(R"("bodies": [{ "rigid": true }], )" + simulate) + "} }",
                             "scene.json", nodes::registry());
        return loaded.problems.empty() ? std::string() : loaded.problems[0].message;
    };
    EXPECT_NE(problem(R"("method": "springs")").find("rigid bodies need method = bricks"),
              std::string::npos);
    EXPECT_NE(problem(R"("step": { "integrator": "implicit_midpoint" })")
                  .find("rigid bodies need step.integrator = implicit_euler"),
              std::string::npos);
    EXPECT_NE(
        problem(R"("initial_shape": "equilibrium")").find("rigid bodies have no equilibrium shape"),
        std::string::npos);
    EXPECT_EQ(problem(R"("gravity": [0, -9.81, 0])"), "");
}

TEST(RigidBodyNodes, PinsThatNoRigidMotionFollowsAreTold)
{
    const auto pulled = [](double apart) {
        const std::string pin = R"(": { "type": "Pin@1", "inputs": { "cubes": "cubes.cubes" },
            "params": { "where": "ends", "ends": { "axis": "x", "layers": 0, "end": ")";
        return fmt::format(
            R"("mesh": {{ "type": "Primitive@1", "params": {{ "shape": "box",
                     "box": {{ "size": [0.4, 0.1, 0.1] }} }} }},
           "cubes": {{ "type": "Voxelize@1", "inputs": {{ "mesh": "mesh.mesh" }}, "params": {{
                      "method": "solid", "size": 0.05, "matter": {{ "preset": "oak" }} }} }},
           "one{}low" }}, "translate": ["=0.01 * frame", 0, 0] }} }},
           "two{}high" }}, "translate": ["={} * frame", 0, 0] }} }},
           "sim": {{ "type": "Simulate@3", "inputs": {{ "cubes": "cubes.cubes",
                    "pins": ["one.pins", "two.pins"] }}, "params": {{
                    "bodies": [{{ "rigid": true }}] }} }})",
            pin, pin, 0.01 + apart);
    };
    Scene torn(pulled(0.01)), moved(pulled(0));
    torn.at<physics::State>("sim", 4);
    moved.at<physics::State>("sim", 4);
    EXPECT_TRUE(moved.warnings.empty()) << moved.warnings[0];
    ASSERT_FALSE(torn.warnings.empty());
    EXPECT_NE(torn.warnings[0].find("rigid body 0 is not where its pins ask it to be"),
              std::string::npos)
        << torn.warnings[0];
}

// A bar that swings by one corner is at odds with no pin.
TEST(RigidBodyNodes, PinsThatStepsAreTooLongForAreTold)
{
    const auto bar = std::make_shared<const geometry::Cubes>(fixtures::box(4, 1, 1, 0.1));
    const std::vector<graph::Wire<geometry::Cubes>> cubes = {{bar}};
    const physics::Pins pins{.corner = {0}, .target = {geometry::Vec3(0, 0, 0)}};
    physics::State state;
    state.x.assign(bar->corner_count(), geometry::Vec3(0.004, 0, 0));
    const auto told = [&](double step_error) {
        state.report.step_error = step_error;
        return nodes::simulate::told_of_torn_pins(cubes, {{.rigid = true}}, pins, state).at(0);
    };
    EXPECT_EQ(told(0).find("step.substeps"), std::string::npos);
    EXPECT_NE(told(0.04).find("too long do so, too: raise step.substeps"), std::string::npos);
}

}  // namespace
