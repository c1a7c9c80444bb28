#include "physics/carry_frames.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/pins.hpp"

namespace nodes::carry {

enum class Mover { simulate, layered };

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    std::vector<graph::Wire<physics::Pins>> pins;
    Mover moved_by = Mover::simulate;
    std::shared_ptr<const physics::LayeredBody> body;
    std::shared_ptr<const physics::CarriedFrames> binding;
};
struct Outputs {
    physics::LayeredPart part;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    if (in.moved_by == Mover::layered) {
        physics::set_on_cubes(body, *in.cubes);
    } else {
        body.base.kind = physics::BaseKind::led;
    }
    return body;
}

static physics::CarriedFrames bind(const Inputs& in)
{
    if (in.moved_by == Mover::layered) return {};
    return physics::bind_frames(in.part->body->base.frames, in.part->body->seeds, *in.cubes);
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{*in.part};
    out.part.body = in.body;
    if (in.moved_by == Mover::layered) {
        if (in.state) {
            throw std::invalid_argument("Layered moves these cubes itself: unlink state, or set "
                                        "moved_by to simulate");
        }
        out.part.pins = physics::merge_pins(in.pins, in.cubes->corner_count());
        return out;
    }
    if (!in.state) {
        throw std::invalid_argument("expected the cubes' state from Simulate, found none: link "
                                    "it, or set moved_by to layered");
    }
    if (!in.pins.empty()) {
        throw std::invalid_argument("pins hold cubes that Layered moves: give them to Simulate, "
                                    "or set moved_by to layered");
    }
    out.part.frames = physics::carry(*in.binding, in.body->base.frames, *in.cubes, in.state->x);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Carry", 1, run)
        .summary("Lets simulated cubes carry a layer: a squashing-cubes model coated by it.")
        .input("part", &Inputs::part,
               "The layer, of base = still, drawn where the cubes are at rest.")
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input("state", &Inputs::state,
               "Where their corners are now, from Simulate, where that moves them.",
               graph::Need::optional)
        .inputs("pins", &Inputs::pins, "Corners that are held or moved, where Layered moves them.")
        .choice("moved_by", &Inputs::moved_by, {"simulate", "layered"},
                "simulate: the cubes are where Simulate has them and feel its forces, pins and "
                "colliders, but not what the layer touches. layered: Layered moves them as bricks, "
                "together with the layer, whose contact they feel; they start with its velocity.")
        .prepare("body", &Inputs::body, build, {"part", "cubes", "moved_by"})
        .prepare("binding", &Inputs::binding, bind, {"part", "cubes", "moved_by"})
        .output("part", &Outputs::part,
                "The layer on the cubes, for Layered. It pushes others and is deformed by them; "
                "where Simulate moves the cubes its skeletons stay out of what those go into.");
}

}  // namespace nodes::carry
