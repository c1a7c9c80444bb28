#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::ground {

struct Inputs {
    double height = 0;
    double friction = 0.5;
    double bounce = 0;
};
struct Outputs {
    physics::Collider collider;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    physics::Collider out;
    out.kind = physics::Collider::Kind::plane;
    out.pose = geometry::Transform(Eigen::Translation3d(0, in.height, 0));
    out.before = out.pose;
    out.friction = in.friction;
    out.bounce = in.bounce;
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Ground", 1, run)
        .summary("A level floor. Bodies sink in slightly: by a tenth of their compression under "
                 "their own weight. For a floor that moves, use Collider.",
                 {"floor", "ground plane", "terrain"})
        .param("height", &Inputs::height, "Height of the floor (y).", {.unit = "m"})
        .param("friction", &Inputs::friction,
               "Coulomb coefficient of friction: 0 for ice, 0.5 for wood on wood, 1 for rubber.",
               {.min = 0, .max = 100})
        .param(
            "bounce", &Inputs::bounce,
            "Share of the speed of an impact that bricks and springs leave it with (coefficient of "
            "restitution): 0 for clay, 0.5 for wood, 0.9 for a rubber ball. Slow impacts do not "
            "bounce. Other methods ignore it.",
            {.min = 0, .max = 1})
        .output("collider", &Outputs::collider, "The floor, as a collider.");
}

}  // namespace nodes::ground
