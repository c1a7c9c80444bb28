#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/net_base.hpp"

namespace nodes::springs {

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    graph::Wire<geometry::TriMesh> mesh;
    enum class Along { near, skeletons } along = Along::near;
    double reach = 0.2, stiffness = 1000, damping = 5;
    std::shared_ptr<const physics::LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    if (in.along == Inputs::Along::skeletons) {
        physics::add_spring_skeletons(body.base, in.stiffness, in.damping);
    } else if (in.mesh) {
        physics::add_spring_edges(body.base, *in.mesh, in.reach, in.stiffness, in.damping);
    } else {
        physics::add_spring_network(body.base, in.reach, in.stiffness, in.damping);
    }
    return body;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.along == Inputs::Along::skeletons && in.mesh) {
        context.warn("the input 'mesh' has no effect, because along = skeletons: unlink it, or set "
                     "along = near");
    }
    Outputs out{*in.part};
    out.part.body = in.body;
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Springs", 1, run)
        .summary("Joins the frames of a layered body by springs: a mass-spring network under its "
                 "layer.",
                 {"spring", "mass spring"})
        .input("part", &Inputs::part,
               "A body with base = net, particles or rigid. With particles, the springs replace "
               "the forces of the substance. Several Springs nodes in a row add up.")
        .input("mesh", &Inputs::mesh,
               "A mesh whose edges become the springs: each joins the frames nearest to its ends.",
               graph::Need::optional)
        .choice("along", &Inputs::along, {"near", "skeletons"},
                "What springs run along. near: frames within `reach` of each other, or the edges "
                "of `mesh`. skeletons: the segments and the sides of the triangles of a net.")
        .param("reach", &Inputs::reach,
               "Frames closer than this, as drawn, are joined; with a mesh, the largest distance "
               "of a frame from the end of an edge.",
               {.min = 1e-9, .unit = "m"}, {"along", {"near"}})
        .param("stiffness", &Inputs::stiffness,
               "Stiffness of a spring: force per metre of stretch.", {.min = 0, .unit = "N/m"})
        .param("damping", &Inputs::damping,
               "Damping of a spring: force per relative speed along it.",
               {.min = 0, .unit = "N s/m"})
        .prepare("body", &Inputs::body, build,
                 {"part", "mesh", "along", "reach", "stiffness", "damping"})
        .output("part", &Outputs::part, "The body with its springs, for Layered.");
}

}  // namespace nodes::springs
