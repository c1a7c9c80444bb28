#include "graph/types/node_builder.hpp"
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
        .summary("A rigid ball with mass, for Simulate's method lattice.",
                 {"rigid body", "rigidbody", "rbd"})
        .param("radius", &Inputs::radius, "Radius of the ball.", {1e-9, 1e6, "m"})
        .param("density", &Inputs::density,
               "Density of the ball: about 80 for a beach ball, 1000 for water.",
               {1e-6, 1e9, "kg/m^3"})
        .param("position", &Inputs::position, "Initial position of the centre.", {.unit = "m"})
        .param("velocity", &Inputs::velocity, "Initial velocity.", {.unit = "m/s"})
        .param("friction", &Inputs::friction,
               "Coulomb coefficient of friction with bodies and other balls.",
               {.min = 0, .max = 100})
        .output("ball", &Outputs::ball, "The ball in its initial state.");
}

}  // namespace nodes::ball
