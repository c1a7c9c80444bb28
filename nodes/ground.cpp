#include "graph/types/node_builder.hpp"
#include "nodes/obstacle_texts.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::ground {

struct Inputs {
    double height = 0;
    double friction = 0.5;
    double bounce = 0;
    graph::Wire<physics::Collider> last;
};
struct Outputs {
    physics::Collider collider;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    physics::Collider out;
    out.kind = physics::Collider::Kind::plane;
    out.pose = geometry::Transform(Eigen::Translation3d(0, in.height, 0));
    out.friction = in.friction;
    out.bounce = in.bounce;
    out.began_as(in.last ? *in.last : out);
    return {out};
}

void add_to(graph::Registry& registry)
{
    registry.add("Ground", 1, run)
        .summary(
            "A level floor. Bodies that have come to rest on it sink in by about a hundredth of a "
            "cube or less. For a floor that turns or moves sideways, use Collider.",
            {"floor", "ground plane", "terrain"})
        .param("height", &Inputs::height,
               "Height of the floor (y); keyframe it to raise or lower the floor.", {.unit = "m"})
        .param("friction", &Inputs::friction, friction_text, {.min = 0, .max = 100})
        .param("bounce", &Inputs::bounce, bounce_text, {.min = 0, .max = 1})
        .output("collider", &Outputs::collider,
                "The floor at this frame and at the frame before, as a collider.")
        .previous("collider", &Inputs::last, graph::Memory::of_motion);
}

}  // namespace nodes::ground
