#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

namespace nodes::carried {

struct Inputs {
    graph::Wire<physics::LayeredScene> scene;
    int part = 0;
};
struct Outputs {
    physics::State state;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    const auto part = static_cast<std::size_t>(in.part);
    if (part >= in.scene->states.size() || in.scene->states[part].cubes.x.empty()) {
        if (in.scene->presses) {
            throw std::invalid_argument(
                "a scene that was read from files has no cubes: link the scene of Layered");
        }
        throw std::invalid_argument(fmt::format(
            "body {} of {} has no cubes that Layered moves: choose one that comes from Carry "
            "with moved_by = layered, counted from 0 among the parts of Layered",
            part, in.scene->states.size()));
    }
    return {in.scene->states[part].cubes};
}

void add_to(graph::Registry& registry)
{
    registry.add("Carried", 1, run)
        .summary("Gives the state of the cubes that Layered moves under a layer, for Embed.")
        .input("scene", &Inputs::scene, "The scene, from Layered.")
        .param("part", &Inputs::part, "Index of the body among Layered's parts, counted from 0.",
               {.min = 0})
        .output("state", &Outputs::state, "Positions and velocities of the cubes' corners.");
}

}  // namespace nodes::carried
