#include "physics/layer_skin.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

namespace nodes::skin {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    graph::Wire<physics::LayeredPart> part;
    graph::Wire<physics::LayeredScene> scene;
    int body = 0;
    std::shared_ptr<const physics::LayerSkin> skin;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static physics::LayerSkin build(const Inputs& in)
{
    return physics::bind(*in.mesh, *in.part->body);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (static_cast<std::size_t>(in.body) >= in.scene->parts.size()) {
        throw std::invalid_argument(fmt::format("there is no body {} among Layered's {}; they are "
                                                "counted from 0",
                                                in.body, in.scene->parts.size()));
    }
    if (in.skin->out_of_reach > 0) {
        context.warn(std::to_string(in.skin->out_of_reach) + " of " +
                     std::to_string(in.mesh->positions.size()) +
                     " vertices are out of the layer's reach and only ride on its frames");
    }
    return {physics::follow(*in.skin, *in.mesh, *in.scene, static_cast<std::size_t>(in.body))};
}

void add_to(graph::Registry& registry)
{
    registry.add("Skin", 1, run)
        .summary("Lets a mesh follow a layered body, its contacts and its volume included: a "
                 "character's skin.")
        .input("mesh", &Inputs::mesh, "The skin, drawn where the body is drawn.")
        .input("part", &Inputs::part, "The body, as it goes into Layered.")
        .input("scene", &Inputs::scene, "Where everything is, from Layered.")
        .param("body", &Inputs::body, "Which of Layered's parts it is, counted from 0.",
               {.min = 0, .max = 1e6})
        .prepare("skin", &Inputs::skin, build, {"mesh", "part"})
        .output("mesh", &Outputs::mesh,
                "The skin in its place: each vertex where the deformed field has the value that it "
                "had at rest, slid to where its neighbours want it. Beyond 125 degrees or so the "
                "crease of a joint tangles: the limbs leave less surface than there is skin.");
}

}  // namespace nodes::skin
