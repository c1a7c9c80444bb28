#include "physics/layered.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::layered {

using geometry::Vec3;

struct Inputs {
    std::vector<graph::Wire<physics::LayeredPart>> parts;
    std::vector<graph::Wire<physics::Collider>> colliders;
    Vec3 gravity{0, -9.81, 0};
    double drag = 0;
    int substeps = 2;
    physics::RigidBodies rigid_bodies = physics::RigidBodies::implicit;
    graph::Wire<physics::LayeredScene> last;
};
struct Outputs {
    physics::LayeredScene scene;
    double volume_error = 0, interpenetration = 0, speed = 0;
    double particles = 0, pieces = 0;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    std::vector<physics::LayeredPart> parts;
    for (const auto& part : in.parts) parts.push_back(*part);
    for (const auto& collider : in.colliders) parts.push_back(physics::rigid_part(*collider));
    physics::check_rigid_bodies(parts, in.rigid_bodies);
    Outputs out;
    out.scene = in.last ? physics::advance(*in.last, parts, {in.gravity, in.drag, in.rigid_bodies},
                                           context.frame_seconds(), in.substeps)
                        : physics::start(parts);
    for (const auto& state : out.scene.states) {
        for (const auto& warning : state.report.warnings) context.warn(warning);
    }
    out.volume_error = physics::volume_error(out.scene);
    out.interpenetration = physics::interpenetration(out.scene);
    out.particles = static_cast<double>(physics::particle_count(out.scene));
    out.pieces = static_cast<double>(physics::piece_count(out.scene));
    out.speed = physics::fastest(out.scene);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Layered", 1, run)
        .summary("Moves bodies coated by implicit layers a frame at a time: exact contact "
                 "surfaces, controlled volume, separation and fusion.")
        .inputs("parts", &Inputs::parts, "The bodies, from ImplicitLayer or Figure.")
        .inputs("colliders", &Inputs::colliders, "Rigid things that they touch.")
        .param("gravity", &Inputs::gravity, "Acceleration of everything; zeros for none.",
               {.unit = "m/s^2"})
        .param("drag", &Inputs::drag, "Share of the speed that the air takes in a second.",
               {.min = 0, .unit = "1/s"})
        .param("substeps", &Inputs::substeps,
               "Steps a frame, at least: what comes on fast gets more by itself.",
               {.min = 1, .max = 10'000})
        .choice(
            "rigid_bodies", &Inputs::rigid_bodies, {"implicit", "bullet"},
            "Who moves rigid bodies and their hinges: `implicit`, one step with all else, stable "
            "at any stiffness, which swallows bounces; or `bullet`, which keeps bounces, swings "
            "and tumbling, takes more steps by itself the stiffer the layers are, and knows "
            "rigid and still bodies only.")
        .reads(graph::Variable::fps)
        .output("scene", &Outputs::scene,
                "Where all bodies are; on the first frame, the start. For Polygonize.")
        .output("volume_error", &Outputs::volume_error,
                "Largest relative error of volume among bodies that control theirs.")
        .output("interpenetration", &Outputs::interpenetration,
                "How deep surfaces stand inside each other at worst, as a share of the layer's "
                "thickness. It does not see what comes out beyond a body that is thinner than the "
                "layer is pressed: stiffen the layer, or thicken the body.")
        .output("particles", &Outputs::particles,
                "How many particles of soft substances there are.")
        .output("pieces", &Outputs::pieces,
                "How many pieces the soft substances are in: particles whose spheres of influence "
                "overlap hold together, unless they once came apart.")
        .output("speed", &Outputs::speed, "Of the fastest frame, m/s.")
        .previous("scene", &Inputs::last);
}

}  // namespace nodes::layered
