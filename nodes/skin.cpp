#include "physics/layered_bodies/layer_skin.hpp"

#include "graph/types/node_builder.hpp"
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
        throw std::invalid_argument(
            fmt::format("there is no body {}: Layered has {} parts, counted from 0", in.body,
                        in.scene->parts.size()));
    }
    if (in.skin->out_of_reach > 0) {
        context.warn(
            std::to_string(in.skin->out_of_reach) + " of " +
            std::to_string(in.mesh->positions.size()) +
            " vertices are outside the layer's radius of influence and follow its frames rigidly");
    }
    return {physics::follow(*in.skin, *in.mesh, *in.scene, static_cast<std::size_t>(in.body))};
}

void add_to(graph::Registry& registry)
{
    registry.add("Skin", 1, run)
        .summary(
            "Deforms a mesh with a layered body, its contacts and its volume: a character's skin.")
        .input("mesh", &Inputs::mesh, "The skin at rest, drawn where the body is drawn.")
        .input("part", &Inputs::part, "The body, as it is linked to Layered.")
        .input("scene", &Inputs::scene, "The scene, from Layered.")
        .param("body", &Inputs::body, "Index of the body among Layered's parts, counted from 0.",
               {.min = 0, .max = 1e6})
        .prepare("skin", &Inputs::skin, build, {"mesh", "part"})
        .output("mesh", &Outputs::mesh,
                "The deformed skin. Each vertex keeps the field value that it had at rest, and "
                "slides along the surface to keep its distances to its neighbours. In a joint bent "
                "by more than about 125 degrees the crease tangles: the limbs leave less surface "
                "than there is skin.");
}

}  // namespace nodes::skin
