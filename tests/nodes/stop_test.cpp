// A cook that is to end, by Ctrl-C, SIGTERM or --time-limit, does not wait for the node that runs.

#include "geometry/base/sanitizers.hpp"
#include "tests/nodes/one_node.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <thread>

namespace {

using fixtures::NodeRun;
using Clock = std::chrono::steady_clock;

// How long the node takes to end once it was asked to, after it had run for `before` seconds. It
// must not have ended by then.
double seconds_to_stop(NodeRun& node, double before)
{
    std::stop_source source;
    node.stop = source.get_token();
    Clock::time_point asked;
    std::thread other([&] {
        std::this_thread::sleep_for(std::chrono::duration<double>(before));
        asked = Clock::now();
        source.request_stop();
    });
    const auto run = [&] { node.outputs(2); };
    EXPECT_THROW(run(), graph::Cancelled);
    const Clock::time_point ended = Clock::now();
    other.join();
    return std::chrono::duration<double>(ended - asked).count();
}

graph::Value output_of(
    const std::string& type, const std::string& input, const graph::Value& value,
    const std::function<void(NodeRun&)>& set = [](NodeRun&) {})
{
    NodeRun node(type);
    if (!input.empty()) node.inputs[input] = {value};
    set(node);
    return node.run();
}

graph::Value ball_of_cubes(const graph::Value& ball, std::int64_t resolution)
{
    return output_of("Voxelize", "mesh", ball, [&](NodeRun& voxelize) {
        voxelize.param("method").is = std::string("solid");
        voxelize.param("resolution").is = resolution;
    });
}

// Twice as long as is promised: the machine may be busy with other tests. Sanitizers slow down.
#if defined(ASPIC_ADDRESS_SANITIZER) || defined(ASPIC_THREAD_SANITIZER)
constexpr double soon = 60;  // s
#else
constexpr double soon = 0.6;  // s
#endif

TEST(Stop, ReachesIntoASphereOfManyFaces)
{
    NodeRun node("Primitive");
    node.param("shape").is = std::string("sphere");
    node.param("sphere.subdivisions").is = std::int64_t(9);
    EXPECT_LT(seconds_to_stop(node, 0.05), soon);
}

TEST(Stop, ReachesIntoBlueNoise)
{
    NodeRun node("Sample");
    node.inputs["mesh"] = {output_of("Primitive", "", {})};
    node.param("count").is = std::int64_t(2'000'000);
    node.param("pattern").is = std::string("blue");
    EXPECT_LT(seconds_to_stop(node, 0.2), soon);
    EXPECT_LT(seconds_to_stop(node, 0.8), soon);
}

TEST(Stop, ReachesIntoSubstepsOfEveryMethod)
{
    const auto cubes = ball_of_cubes(output_of("Primitive", "", {}), 8);
    for (const char* method : {"bricks", "springs", "lattice"}) {
        NodeRun sim("Simulate");
        sim.inputs["cubes"] = {cubes};
        sim.param("method").is = std::string(method);
        sim.param("step.substeps").is = std::int64_t(10'000);
        sim.previous = {sim.run(1)};
        EXPECT_LT(seconds_to_stop(sim, 0.1), soon) << method;
    }
}

TEST(Stop, ReachesIntoOneLongStep)
{
    NodeRun sim("Simulate");
    sim.inputs["cubes"] = {ball_of_cubes(output_of("Primitive", "", {}), 56)};
    sim.previous = {sim.run(1)};
    EXPECT_LT(seconds_to_stop(sim, 0.2), soon);
}

TEST(Stop, ReachesIntoVoxelizeOfManyFaces)
{
    NodeRun node("Voxelize");
    node.inputs["mesh"] = {output_of("Primitive", "", {}, [](NodeRun& sphere) {
        sphere.param("shape").is = std::string("sphere");
        sphere.param("sphere.subdivisions").is = std::int64_t(8);
    })};
    node.param("method").is = std::string("solid");
    node.param("resolution").is = std::int64_t(120);
    for (const double before : {0.1, 0.3}) EXPECT_LT(seconds_to_stop(node, before), soon) << before;
}

TEST(Stop, ReachesIntoTheMatricesAndTheFactorOfModes)
{
    const auto ball = output_of("Primitive", "", {});
    NodeRun node("Modes");
    node.inputs["mesh"] = {ball};
    node.inputs["cubes"] = {ball_of_cubes(ball, 32)};
    for (const double before : {0.1, 0.4}) EXPECT_LT(seconds_to_stop(node, before), soon) << before;
}

TEST(Stop, ReachesIntoModes)
{
    const auto ball = output_of("Primitive", "", {});
    NodeRun node("Modes");
    node.inputs["mesh"] = {ball};
    node.inputs["cubes"] = {ball_of_cubes(ball, 12)};
    node.param("count").is = std::int64_t(300);
    EXPECT_LT(seconds_to_stop(node, 0.5), soon);
}

}  // namespace
