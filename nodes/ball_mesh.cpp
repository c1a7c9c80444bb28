#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/balls.hpp"

namespace nodes::ball_mesh {

struct Inputs {
    std::vector<graph::Wire<physics::Ball>> balls;
    graph::Wire<physics::State> state;
    int segments = 48;
    geometry::Vec3f colour{0.75f, 0.08f, 0.05f}, second{0.9f, 0.88f, 0.82f};
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    std::vector<physics::Ball> balls;
    for (const auto& ball : in.balls) balls.push_back(*ball);
    const auto states = in.state ? in.state->balls : physics::place_balls(balls);
    return {physics::ball_mesh(balls, states, in.segments, in.colour, in.second)};
}

void add_to(graph::Registry& registry)
{
    registry.add("BallMesh", 1, run)
        .summary("Makes a mesh of rigid balls, at the places to which a simulation has moved them.")
        .inputs("balls", &Inputs::balls, "The balls, in the same order as in Simulate.")
        .input("state", &Inputs::state,
               "Simulate's state. Without it the balls are drawn at their initial positions.",
               graph::Need::optional)
        .param("segments", &Inputs::segments, "Number of segments around each ball.", {3, 1000, {}})
        .colour("colour", &Inputs::colour, "Colour of three of the six stripes.")
        .colour("second", &Inputs::second, "Colour of the other three stripes.")
        .output("mesh", &Outputs::mesh, "All balls as one mesh.");
}

}  // namespace nodes::ball_mesh
