#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::vibrate {

using geometry::Vec3;

// A blow, and when.
struct KickParams {
    int frame = 1;
    Vec3 position{0, 0, 0};
    Vec3 impulse{0, -1, 0};
    double radius = 0.1;
};

struct Inputs {
    graph::Wire<physics::ModalModel> model;
    std::vector<graph::Wire<physics::Force>> forces;
    std::vector<KickParams> kicks;
    Vec3 gravity{0, 0, 0};
    Vec3 base{0, 0, 0};
    physics::ModalDamping damping;
    double amplitude = 1;
    double dt = 0;
    graph::Wire<physics::ModalState> last;
};
struct Outputs {
    geometry::TriMesh mesh;
    physics::ModalState state;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    physics::ModalState state;
    if (in.last) {
        std::vector<physics::Force> forces;
        for (const auto& force : in.forces) forces.push_back(*force);
        forces.push_back({physics::Force::Kind::gravity, in.gravity});
        const double dt = in.dt > 0 ? in.dt : context.frame_seconds();
        state = advance(*in.model, *in.last, forces, in.base, in.damping, dt);
    } else {
        state = rest_state(*in.model);
        state.base = in.base;
    }
    for (const auto& k : in.kicks) {
        if (k.frame == context.frame()) {
            state = struck(*in.model, std::move(state), {k.position, k.impulse, k.radius});
        }
    }
    return {deformed(*in.model, state, in.amplitude), std::move(state)};
}

static void describe_kick(graph::ParamsOf<KickParams>& p)
{
    p.param("frame", &KickParams::frame, "When it strikes: what follows this frame moves.")
        .param("position", &KickParams::position, "Where, in the rest shape.", {.unit = "m"})
        .param("impulse", &KickParams::impulse, "How hard and which way.", {.unit = "N s"})
        .param("radius", &KickParams::radius,
               "Vertices nearer than this share it, the nearest most; the nearest vertex alone "
               "takes it when none is.",
               {.min = 0, .unit = "m"});
}

static void describe_damping(graph::ParamsOf<physics::ModalDamping>& p)
{
    using physics::ModalDamping;
    p.choice("kind", &ModalDamping::kind, {"material", "ratio", "rayleigh"},
             "material takes what the cubes' material says, ratio the same share of critical "
             "damping for every mode, rayleigh the two numbers.")
        .param("ratio", &ModalDamping::ratio,
               "Share of critical damping: 0 rings for ever, 1 and more returns without a swing.",
               {.min = 0, .max = 1e6}, {"kind", {"ratio"}})
        .param("mass_damping", &ModalDamping::mass_damping,
               "Slows all modes alike; the damping is this plus stiffness_damping * omega^2.",
               {.min = 0, .unit = "1/s"}, {"kind", {"rayleigh"}})
        .param("stiffness_damping", &ModalDamping::stiffness_damping, "Slows high modes most.",
               {.min = 0, .unit = "s"}, {"kind", {"rayleigh"}});
}

void add_to(graph::Registry& registry)
{
    registry.add("Vibrate", 1, run)
        .summary("Lets a mesh vibrate in its modes, stepped exactly at any frame rate.")
        .input("model", &Inputs::model, "The modes, from Modes.")
        .inputs("forces", &Inputs::forces, "Gravity and point forces, constant within a frame.")
        .list("kicks", &Inputs::kicks, describe_kick, "Blows that start it swinging.")
        .param("gravity", &Inputs::gravity,
               "Acceleration that it sags under from the first frame on; zeros when the rest shape "
               "already hangs as it should.",
               {.unit = "m/s^2"})
        .param("base", &Inputs::base,
               "Where the pinned corners are moved to from rest; key it to shake the body.",
               {.unit = "m"})
        .block("damping", &Inputs::damping, describe_damping, "How fast the modes die out.")
        .param("amplitude", &Inputs::amplitude,
               "Exaggerates what is drawn, not the motion itself. Modes are straight lines: large "
               "swings swell.",
               {.min = 0})
        .param("dt", &Inputs::dt,
               "Seconds that pass in a frame; 0 is a frame's own time. Less is slow motion.",
               {.min = 0, .max = 1e9, .unit = "s"})
        .reads(graph::Variable::frame | graph::Variable::fps)
        .output("mesh", &Outputs::mesh, "The mesh as it stands, with displacement and speed.")
        .output("state", &Outputs::state, "The modes' coordinates and speeds.")
        .previous("state", &Inputs::last);
}

}  // namespace nodes::vibrate
