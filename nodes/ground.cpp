#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::ground {

struct Inputs {
    double height = 0;
    double friction = 0.5;
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
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Ground", 1, run)
        .summary(
            "A level floor that bodies rest and slide on, sunk in by a tenth of what their own "
            "weight squashes them. For one that moves, use Collider.")
        .param("height", &Inputs::height, "The y of the floor.", {.unit = "m"})
        .param("friction", &Inputs::friction,
               "Coulomb coefficient: 0 is ice, 0.5 wood on wood, 1 rubber.", {.min = 0, .max = 100})
        .output("collider", &Outputs::collider, "The floor.");
}

}  // namespace nodes::ground
