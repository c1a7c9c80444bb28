#include "physics/layered_bodies/layered_step.hpp"

#include "geometry/mesh/triangle_bvh.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/join_substances.hpp"
#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_loads.hpp"
#include "physics/layered_bodies/substance_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nodes::layered {

using geometry::Vec3;

struct Inputs {
    std::vector<graph::Wire<physics::LayeredPart>> parts;
    std::vector<graph::Wire<physics::Collider>> colliders;
    std::vector<graph::Wire<physics::Force>> forces;
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

static void warn_of_loose_nets(const std::vector<physics::LayeredPart>& parts,
                               const graph::Context& context)
{
    for (std::size_t b = 0; b < parts.size(); ++b) {
        const physics::Base& base = parts[b].body->base;
        if (base.kind != physics::BaseKind::net || !base.springs.empty()) continue;
        context.warn(fmt::format("body {} is a net without springs, so nothing holds its masses "
                                 "together: link it through Springs, with along = skeletons for "
                                 "example",
                                 b));
    }
}

// An open mesh has no inside, but layers need one to be pushed out of: they take what is behind its
// faces.
static void warn_of_bodies_behind(const Inputs& in, const physics::LayeredScene& scene,
                                  const graph::Context& context)
{
    for (std::size_t c = 0; c < in.colliders.size(); ++c) {
        const physics::Collider& collider = *in.colliders[c];
        if (!collider.sheet || !collider.tree) continue;
        for (std::size_t b = 0; b + in.colliders.size() < scene.parts.size(); ++b) {
            if (physics::is_told(scene.parts[b].body->base.kind)) continue;
            const std::vector<Vec3>& at = scene.states[b].position;
            const bool behind = std::any_of(at.begin(), at.end(), [&](const Vec3& p) {
                return collider.tree->closest(p).behind;
            });
            if (!behind) continue;
            context.warn(fmt::format(
                "body {} begins behind collider {} (both counted from 0), an open mesh, which "
                "layers take to be solid behind its faces: the body is pushed out to their front. "
                "Turn the faces over, or close the mesh",
                b, c));
        }
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    std::vector<physics::LayeredPart> parts;
    for (const auto& part : in.parts) parts.push_back(*part);
    parts = physics::join_substances(std::move(parts));
    for (const auto& collider : in.colliders) parts.push_back(physics::rigid_part(*collider));
    physics::check_rigid_bodies(parts, in.rigid_bodies);
    warn_of_loose_nets(parts, context);
    physics::LayeredWorld world{in.gravity, in.drag, in.rigid_bodies};
    for (const auto& force : in.forces) world.forces.push_back(*force);
    for (const auto& warning : physics::far_point_forces(parts, world.forces))
        context.warn(warning);
    Outputs out;
    out.scene = in.last
                    ? physics::advance(*in.last, parts, world, context.frame_seconds(), in.substeps)
                    : physics::start(parts);
    if (!in.last) warn_of_bodies_behind(in, out.scene, context);
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
        .summary("Simulates bodies coated by implicit layers: exact contact surfaces, controlled "
                 "volume, separation and fusion.")
        .inputs("parts", &Inputs::parts,
                "The bodies, from ImplicitLayer, Figure, Pose, Reach, Springs or Carry.")
        .inputs("colliders", &Inputs::colliders,
                "Rigid obstacles. An open mesh is solid behind its faces here: it stops what comes "
                "from its front.")
        .inputs("forces", &Inputs::forces,
                "Force fields, as they are at the end of a frame. Wind and point forces act on the "
                "surfaces of the layers; bodies with base = still, led by keyframes, Pose or "
                "Reach, feel none.")
        .param("gravity", &Inputs::gravity, "Acceleration of all bodies; zeros for none.",
               {.unit = "m/s^2"})
        .param("drag", &Inputs::drag,
               "Air drag: rate at which the velocity decays, as e^(-drag t). With 1, 37 % of it is "
               "left after a second.",
               {.min = 0, .unit = "1/s"})
        .param(
            "substeps", &Inputs::substeps,
            "Smallest number of steps per frame. Bodies that approach fast get more automatically.",
            {.min = 1, .max = 10'000})
        .choice("rigid_bodies", &Inputs::rigid_bodies, {"implicit", "bullet"},
                "Solver of rigid bodies and their hinges. implicit: one implicit step together "
                "with everything else; stable at any stiffness, with shorter steps while layers "
                "bounce. bullet: keeps swings and tumbling too, takes more steps automatically the "
                "stiffer the layers are, and supports rigid and still bodies only.")
        .reads(graph::Variable::fps)
        .output(
            "scene", &Outputs::scene,
            "State of all bodies; on the first frame, the initial state. For Render, Polygonize, "
            "WriteScene, Skin and Carried.")
        .output("volume_error", &Outputs::volume_error,
                "Largest relative error of volume among bodies with volume control.")
        .output("interpenetration", &Outputs::interpenetration,
                "Largest depth by which surfaces penetrate each other, as a share of the layer's "
                "thickness. A layer pressed so deep that it comes out on the other side of a thin "
                "body is not counted: use a stiffer layer or a thicker body.")
        .output("particles", &Outputs::particles, "Number of particles of soft substances.")
        .output("pieces", &Outputs::pieces,
                "Number of pieces of the soft substances. Particles whose radii of influence "
                "overlap belong to one piece, unless they have separated before.")
        .output("speed", &Outputs::speed,
                "Speed of the fastest frame of any body, m/s; those that keys move count too.")
        .previous("scene", &Inputs::last);
}

}  // namespace nodes::layered
