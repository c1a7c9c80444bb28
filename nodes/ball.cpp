#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <numbers>

namespace nodes::ball {

using geometry::Vec3;

struct Inputs {
    double radius = 0.1;
    double density = 500;
    Vec3 position{0, 1, 0};
    Vec3 velocity{0, 0, 0};
    double friction = 0.5;
};
struct Outputs {
    physics::Ball ball;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    const double volume = 4 * std::numbers::pi / 3 * in.radius * in.radius * in.radius;
    return {{in.radius, in.density * volume, in.position, in.velocity, in.friction}};
}

void add_to(graph::Registry& registry)
{
    registry.add("Ball", 1, run)
        .summary("A rigid ball with a weight of its own, for Simulate's method lattice.")
        .param("radius", &Inputs::radius, "Its radius.", {1e-9, 1e6, "m"})
        .param("density", &Inputs::density, "What it is made of: 80 is a beach ball, 1000 floats.",
               {1e-6, 1e9, "kg/m^3"})
        .param("position", &Inputs::position, "Where its centre starts.", {.unit = "m"})
        .param("velocity", &Inputs::velocity, "How it starts.", {.unit = "m/s"})
        .param("friction", &Inputs::friction, "Coulomb coefficient with bodies and other balls.",
               {.min = 0, .max = 100})
        .output("ball", &Outputs::ball, "The ball as it starts.");
}

}  // namespace nodes::ball
