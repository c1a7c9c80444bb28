#include "graph/node_type.hpp"
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
        throw std::invalid_argument(
            fmt::format("body {} of {} has no cubes that Layered moves: name one that comes from "
                        "Carry with moved_by = layered, counted from 0 among Layered's parts",
                        part, in.scene->states.size()));
    }
    return {in.scene->states[part].cubes};
}

void add_to(graph::Registry& registry)
{
    registry.add("Carried", 1, run)
        .summary("Where Layered has moved the cubes that carry a layer, for Embed.")
        .input("scene", &Inputs::scene, "From Layered.")
        .param("part", &Inputs::part, "Which of its bodies, counted from 0.", {.min = 0})
        .output("state", &Outputs::state, "Where the corners are and how fast they move.");
}

}  // namespace nodes::carried
