#include "physics/carry_frames.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::carry {

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    std::shared_ptr<const physics::LayeredBody> body;
    std::shared_ptr<const physics::CarriedFrames> binding;
};
struct Outputs {
    physics::LayeredPart part;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    body.base.kind = physics::BaseKind::led;
    return body;
}

static physics::CarriedFrames bind(const Inputs& in)
{
    return physics::bind_frames(*in.part->body, *in.cubes);
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{*in.part};
    out.part.body = in.body;
    out.part.frames = physics::carry(*in.binding, *in.body, *in.cubes, in.state->x);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Carry", 1, run)
        .summary("Lets simulated cubes carry a layer: a squashing-cubes model coated by it.")
        .input("part", &Inputs::part, "The layer, drawn where the cubes are at rest.")
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input("state", &Inputs::state, "Where their corners are now, from Simulate.")
        .prepare("body", &Inputs::body, build, {"part"})
        .prepare("binding", &Inputs::binding, bind, {"part", "cubes"})
        .output("part", &Outputs::part,
                "The layer where the cubes carry it, for Layered. It pushes others and is deformed "
                "by them; its skeletons stay out of what the cubes go into, since they feel "
                "their own colliders only.");
}

}  // namespace nodes::carry
