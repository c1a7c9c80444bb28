#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/balls.hpp"

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
        .summary("Rigid balls where a simulation has moved them, as a mesh.")
        .inputs("balls", &Inputs::balls, "The balls, in the order in which Simulate has them.")
        .input("state", &Inputs::state, "Simulate's state; without it, where they start.",
               graph::Need::optional)
        .param("segments", &Inputs::segments, "Pieces around each.", {3, 1000, {}})
        .colour("colour", &Inputs::colour, "Of every other sixth.")
        .colour("second", &Inputs::second, "Of those between.")
        .output("mesh", &Outputs::mesh, "All of them.");
}

}  // namespace nodes::ball_mesh
