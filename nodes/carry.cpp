#include "physics/layered_bodies/carry_frames.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/state/pins.hpp"
#include "physics/state/state_models.hpp"

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
    if (body.base.kind == physics::BaseKind::net) {
        throw std::invalid_argument(
            "a layer on cubes must have base = still, found a net: the cubes move it");
    }
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
    return physics::bind_frames(in.part->body->base.frames, in.part->body->samples, *in.cubes);
}

constexpr const char* no_state =
    "moved_by = layered needs no state, as Layered moves the cubes: unlink the input 'state', or "
    "set moved_by = simulate";
constexpr const char* needs_state =
    "moved_by = simulate needs the input 'state': link the state from Simulate, or set moved_by = "
    "layered";
constexpr const char* no_pins =
    "moved_by = simulate takes no pins: link them to Simulate, or set moved_by = layered";

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults;
    const bool layered = in.moved_by == Mover::layered, state = setting.links("state");
    if (layered && state) faults.push_back({"state", no_state});
    if (!layered && !state) faults.push_back({"moved_by", needs_state});
    if (!layered && setting.links("pins")) faults.push_back({"pins", no_pins});
    return faults;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    Outputs out{*in.part};
    out.part.body = in.body;
    if (in.moved_by == Mover::layered) {
        if (in.state) {
            throw std::invalid_argument(no_state);
        }
        out.part.pins = physics::merge_pins(in.pins, in.cubes->corner_count());
        physics::require_all_axes(out.part.pins, "Layered");
        physics::require_corners(out.part.pins, "Layered");
        for (const auto& warning : physics::conflicting_pins(in.pins, 1e-3 * in.cubes->size)) {
            context.warn(warning);
        }
        return out;
    }
    if (!in.state) {
        throw std::invalid_argument(needs_state);
    }
    if (!in.pins.empty()) {
        throw std::invalid_argument(no_pins);
    }
    out.part.frames = physics::carry(*in.binding, in.body->base.frames, *in.cubes,
                                     physics::state_of(in.state, *in.cubes)->x);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Carry", 1, run)
        .summary("Attaches an implicit layer to squashing cubes, so that the cubes carry it.")
        .input("part", &Inputs::part,
               "The layer, with base = still, drawn where the cubes are at rest.")
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input(
            "state", &Inputs::state,
            "State of the cubes at this frame, from Simulate. Needed for moved_by = simulate only.",
            graph::Need::optional)
        .inputs("pins", &Inputs::pins,
                "Corners that are held or moved, for moved_by = layered only.")
        .choice("moved_by", &Inputs::moved_by, {"simulate", "layered"},
                "Which node moves the cubes. simulate: Simulate moves them by its forces, pins and "
                "colliders; they do not feel the contacts of the layer. layered: Layered moves "
                "them as bricks together with the layer, and they feel its contacts; their initial "
                "velocity is that of the layer.")
        .prepare("body", &Inputs::body, build, {"part", "cubes", "moved_by"})
        .prepare("binding", &Inputs::binding, bind, {"part", "cubes", "moved_by"})
        .check(check)
        .output(
            "part", &Outputs::part,
            "The layer on its cubes, for Layered. It pushes other bodies and is deformed by them. "
            "With moved_by = simulate, its skeletons stay out of any body that the cubes enter.");
}

}  // namespace nodes::carry
