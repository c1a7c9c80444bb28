#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered.hpp"

namespace nodes::springs {

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    graph::Wire<geometry::TriMesh> mesh;
    double reach = 0.2, stiffness = 1000, damping = 5;
    std::shared_ptr<const physics::LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    if (in.mesh) {
        physics::add_spring_edges(body.base, *in.mesh, in.reach, in.stiffness, in.damping);
    } else {
        physics::add_spring_network(body.base, in.reach, in.stiffness, in.damping);
    }
    return body;
}

static Outputs run(const Inputs& in, const graph::Context&)
{
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
               "A body with base = particles or rigid. With particles, the springs replace the "
               "forces of the substance.")
        .input("mesh", &Inputs::mesh,
               "A mesh whose edges become the springs: each joins the frames nearest to its ends.",
               graph::Need::optional)
        .param("reach", &Inputs::reach,
               "Frames closer than this, as drawn, are joined; with a mesh, the largest distance "
               "of a frame from the end of an edge.",
               {.min = 1e-9, .unit = "m"})
        .param("stiffness", &Inputs::stiffness,
               "Stiffness of a spring: force per metre of stretch.", {.min = 0, .unit = "N/m"})
        .param("damping", &Inputs::damping,
               "Damping of a spring: force per relative speed along it.",
               {.min = 0, .unit = "N s/m"})
        .prepare("body", &Inputs::body, build, {"part", "mesh", "reach", "stiffness", "damping"})
        .output("part", &Outputs::part, "The body with its springs, for Layered.");
}

}  // namespace nodes::springs
