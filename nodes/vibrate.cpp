#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

namespace nodes::vibrate {

using geometry::Vec3;

// A blow and its frame.
struct KickParams {
    int frame = 1;
    Vec3 position{0, 0, 0};
    Vec3 impulse{0, -1, 0};
    double radius = 0.1;
};

struct Inputs {
    graph::Wire<physics::ModalModel> model;
    std::vector<graph::Wire<physics::Force>> forces;
    std::vector<graph::Wire<physics::Collider>> colliders;
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

// In the first frame. Kicks after the last one are no mistake: a shorter range shows part of a
// scene.
static void warn_of_early_kicks(const std::vector<KickParams>& kicks, const graph::Context& context)
{
    for (const auto& k : kicks) {
        if (k.frame >= context.frame()) continue;
        context.warn(fmt::format("the kick at frame {} has no effect, because the frames begin at "
                                 "{}: set kicks[].frame to {} or later",
                                 k.frame, context.frame(), context.frame()));
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    physics::ModalState state;
    if (in.last) {
        std::vector<physics::Force> forces;
        for (const auto& force : in.forces) forces.push_back(*force);
        forces.push_back({physics::Force::Kind::gravity, in.gravity});
        const double dt = in.dt > 0 ? in.dt : context.frame_seconds();
        std::vector<physics::Collider> colliders;
        for (const auto& collider : in.colliders) colliders.push_back(*collider);
        state = advance(*in.model, *in.last, {forces, in.base, colliders}, in.damping, dt);
    } else {
        state = rest_state(*in.model);
        state.base = in.base;
        warn_of_early_kicks(in.kicks, context);
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
    p.param("frame", &KickParams::frame,
            "Frame of the blow: motion starts after it. One before the first frame has no effect.")
        .param("position", &KickParams::position, "Point that is hit, in the rest shape.",
               {.unit = "m"})
        .param("impulse", &KickParams::impulse, "Impulse, with its direction.", {.unit = "N s"})
        .param("radius", &KickParams::radius,
               "Distance within which vertices share the impulse, the nearest most. If there are "
               "none, the nearest vertex takes all of it.",
               {.min = 0, .unit = "m"});
}

static void describe_damping(graph::ParamsOf<physics::ModalDamping>& p)
{
    using physics::ModalDamping;
    p.choice("kind", &ModalDamping::kind, {"material", "ratio", "rayleigh"},
             "Source of the damping. material: the damping of the cubes' material. ratio: the same "
             "damping ratio for all modes. rayleigh: the two coefficients below.")
        .param("ratio", &ModalDamping::ratio,
               "Damping ratio: 0 rings for ever; 1 and more returns without oscillating.",
               {.min = 0, .max = 1e6}, {"kind", {"ratio"}})
        .param("mass_damping", &ModalDamping::mass_damping,
               "Damping that is equal for all modes. The total is mass_damping + stiffness_damping "
               "* omega^2.",
               {.min = 0, .unit = "1/s"}, {"kind", {"rayleigh"}})
        .param("stiffness_damping", &ModalDamping::stiffness_damping,
               "Damping that grows with the square of a mode's frequency.", {.min = 0, .unit = "s"},
               {"kind", {"rayleigh"}});
}

void add_to(graph::Registry& registry)
{
    registry.add("Vibrate", 1, run)
        .summary("Vibrates a mesh in its modes, stepped exactly at any frame rate.")
        .input("model", &Inputs::model, "The modes, from Modes.")
        .inputs("forces", &Inputs::forces,
                "Gravity, point forces and wind, all through a frame as they are at its end.")
        .inputs("colliders", &Inputs::colliders,
                "Obstacles that stop the vertices of the mesh, without friction: what throws the "
                "body back is its own elasticity. A frame takes a step for each radian of the "
                "highest mode, eight at least. With an `amplitude` above 1, what is drawn may "
                "enter an obstacle.")
        .list("kicks", &Inputs::kicks, describe_kick, "Impulses that start vibrations.")
        .param("gravity", &Inputs::gravity,
               "Acceleration under which the model sags from the first frame on; zeros if the rest "
               "shape already includes the sag.",
               {.unit = "m/s^2"})
        .param("base", &Inputs::base,
               "Displacement of the pinned corners from rest; keyframe it to shake the body.",
               {.unit = "m"})
        .block("damping", &Inputs::damping, describe_damping, "Damping of the modes.")
        .param(
            "amplitude", &Inputs::amplitude,
            "Factor by which the drawn motion is exaggerated; the simulated motion is unchanged. "
            "Modes move vertices along straight lines, so large amplitudes swell the shape.",
            {.min = 0})
        .param("dt", &Inputs::dt,
               "Simulated seconds per frame; 0: the duration of a frame. Smaller values give slow "
               "motion.",
               {.min = 0, .max = 1e9, .unit = "s"})
        .reads(graph::Variable::frame | graph::Variable::fps)
        .pace({graph::Pace::By::seconds_a_frame, "dt"})
        .output("mesh", &Outputs::mesh,
                "The vibrating mesh, with the attributes displacement and speed.")
        .output("state", &Outputs::state, "Coordinates and velocities of the modes.")
        .previous("state", &Inputs::last);
}

}  // namespace nodes::vibrate
