#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/balls.hpp"
#include "physics/bricks.hpp"
#include "physics/contact.hpp"
#include "physics/far_forces.hpp"
#include "physics/lattice.hpp"
#include "physics/pins.hpp"
#include "physics/springs.hpp"
#include "physics/start.hpp"

#include <variant>

namespace nodes::simulate {

using geometry::Vec3;

enum class Method { bricks, springs, lattice };

// One alternative a method, in order of Method.
struct Body {
    std::variant<physics::BricksBody, physics::SpringsBody, physics::LatticeBody> is;

    std::size_t bytes() const
    {
        return std::visit([](const auto& body) { return body.bytes(); }, is);
    }
};

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    std::vector<graph::Wire<physics::Pins>> pins;
    std::vector<graph::Wire<physics::Force>> forces;
    std::vector<graph::Wire<physics::Collider>> colliders;
    std::vector<graph::Wire<physics::Ball>> balls;
    graph::Wire<geometry::TriMesh> surface;
    graph::Wire<physics::State> start;
    Method method = Method::bricks;
    physics::BrickOptions bricks;
    physics::SpringOptions springs;
    physics::LatticeOptions lattice;
    double dt = 0;
    Vec3 gravity{0, -9.81, 0};
    Vec3 initial_velocity{0, 0, 0};
    Vec3 initial_spin_degrees{0, 0, 0};
    physics::StepOptions step;
    std::shared_ptr<const Body> body;
    graph::Wire<physics::State> last;
};
struct Outputs {
    physics::State state;
};

static Body build(const Inputs& in)
{
    switch (in.method) {
    case Method::bricks:
        return {physics::make_bricks(*in.cubes, in.bricks, in.surface.get())};
    case Method::springs:
        return {physics::make_springs(*in.cubes, in.springs, in.surface.get())};
    case Method::lattice:
        return {physics::make_lattice(*in.cubes, in.lattice, in.surface.get())};
    }
    throw std::logic_error("Simulate: a method without a body");
}

// Warns of what is set and can do nothing.
static void warn_of_idle(const Inputs& in, const graph::Context& context)
{
    const auto* const body = std::get_if<physics::LatticeBody>(&in.body->is);
    if (!body) return;
    if (body->flat_axis < 0 && in.lattice.bend != 1) {
        context.warn("lattice.bend is for planes, and does nothing to these cubes: stiffness here "
                     "is that of the material, or a rate");
    }
    if (in.lattice.plane != physics::PlaneMotion::in_plane) return;
    for (std::size_t i = 0; i < in.forces.size(); ++i) {
        const physics::Force& force = *in.forces[i];
        Vec3 within = force.force;
        within[body->flat_axis] = 0;
        if (force.kind != physics::Force::Kind::point || force.force.isZero(0)) continue;
        if (within.norm() > 1e-9 * force.force.norm()) continue;
        context.warn("point force " + std::to_string(i + 1) + " of " +
                     std::to_string(in.forces.size()) +
                     " pushes across the plane, which moves within itself only, and does nothing: "
                     "turn it, or choose space for lattice.plane");
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (!in.balls.empty() && in.method != Method::lattice) {
        throw std::invalid_argument("rigid balls need method lattice: choose it, or unlink them");
    }
    std::vector<physics::Ball> balls;
    for (const auto& ball : in.balls) balls.push_back(*ball);
    physics::Loads loads;
    loads.pins = physics::merge_pins(in.pins, in.cubes->corner_count());
    for (const auto& collider : in.colliders) loads.colliders.push_back(*collider);
    if (!in.last) {
        if (!in.start) {
            for (const auto& warning : physics::buried(*in.cubes, loads.pins, loads.colliders)) {
                context.warn(warning);
            }
        }
        auto state = in.start
                         ? *in.start
                         : std::visit([](const auto& b) { return rest_state(b); }, in.body->is);
        physics::set_off(state, *in.cubes, in.initial_velocity,
                         in.initial_spin_degrees * (std::numbers::pi / 180));
        state.balls = physics::place_balls(balls);
        return {std::move(state)};
    }
    if (in.last->x.size() != in.cubes->corner_count()) {
        throw std::invalid_argument(fmt::format(
            "the cubes have {} corners at this frame and had {} at the last, but it moves the same "
            "cubes all along: voxelize what keeps its shape, as the model before it is moved",
            in.cubes->corner_count(), in.last->x.size()));
    }
    loads.balls = std::move(balls);
    for (const auto& force : in.forces) loads.forces.push_back(*force);
    for (const auto& warning : physics::far_forces(*in.cubes, loads.forces)) context.warn(warning);
    warn_of_idle(in, context);
    if (!in.gravity.isZero(0)) {
        loads.forces.push_back({physics::Force::Kind::gravity, in.gravity});
    }
    const double dt = in.dt > 0 ? in.dt : context.frame_seconds();
    auto state = std::visit(
        [&](const auto& body) { return advance(body, *in.last, loads, dt, in.step); }, in.body->is);
    for (const auto& warning : state.report.warnings) context.warn(warning);
    return {std::move(state)};
}

static void describe_bricks(graph::ParamsOf<physics::BrickOptions>& p)
{
    p.choice("element", &physics::BrickOptions::element, {"incompatible", "trilinear"},
             "incompatible bends rightly even one cube thick; trilinear is up to a third too "
             "stiff in bending and only here to compare.")
        .choice("weighting", &physics::BrickOptions::weighting, {"filled", "full"},
                "filled gives a partly filled cube that share of the stiffness, full all of it.");
}

static void describe_springs(graph::ParamsOf<physics::SpringOptions>& p)
{
    p.param("bending", &physics::SpringOptions::bending,
            "Share of the stiffness along the axes that is carried by springs over two cubes, "
            "which resist bending.",
            {.min = 0, .max = 0.9});
}

static void describe_plastic(graph::ParamsOf<physics::PlasticOptions>& p)
{
    using physics::PlasticOptions;
    p.param("yield", &PlasticOptions::yield,
            "The strain of a region beyond which its shape at rest gives way; 0: never.",
            {.min = 0, .max = 10})
        .param("flow", &PlasticOptions::flow, "How fast it gives way.",
               {.min = 0, .max = 1e6, .unit = "1/s"})
        .param("limit", &PlasticOptions::limit, "How far it may, as a strain.",
               {.min = 0, .max = 0.95});
}

static void describe_contact(graph::ParamsOf<physics::BodyContactOptions>& p)
{
    using physics::BodyContactOptions;
    p.param("on", &BodyContactOptions::on,
            "Whether bodies that are not linked push each other away.")
        .param("distance", &BodyContactOptions::distance,
               "Between their corners, which touch as balls; 0: the cubes' edge.",
               {.min = 0, .unit = "m"})
        .param("friction", &BodyContactOptions::friction, "Coulomb coefficient between them.",
               {.min = 0, .max = 100});
}

static void describe_lattice(graph::ParamsOf<physics::LatticeOptions>& p)
{
    using physics::LatticeOptions;
    p.param(
         "half_width", &LatticeOptions::half_width,
         "How far a region of cubes that keep their shape together reaches, in cubes each way: "
         "wider is stiffer and smoother, at the same cost. With the stiffness from the material "
         "no wider than a tenth of a beam's length or a sixteenth of a sheet's: at twice that it "
         "bends a third too far.",
         {.min = 1, .max = 64})
        .choice("stiffness", &LatticeOptions::stiffness, {"material", "rate"},
                "material takes the stiffness from Young's modulus, as far as regions and substeps "
                "can give it (Poisson's ratio acts as 0); rate takes the number below.")
        .choice("calibrate", &LatticeOptions::calibrate, {"bending", "stretch"},
                "What the stiffness from the material is right for: a bend of the whole body, or "
                "long waves of stretch. Thin bodies can't have both.",
                {"stiffness", {"material"}})
        .param(
            "rate", &LatticeOptions::rate,
            "How fast a region pulls its cubes back, whatever the step: 0 not at all, very large "
            "as stiff as the method gets.",
            {.min = 0, .unit = "1/s"}, {"stiffness", {"rate"}})
        .param(
            "bend", &LatticeOptions::bend,
            "Of a plane: how much it resists bending, as a multiple of what its thickness gives, "
            "or with a rate, of how it resists stretch. It resists stretch at least as much: with "
            "half width w a plane thicker than w cells is too stiff in its plane. "
            "Within w cells of a free rim it resists bending less than it should; a rim that is to "
            "be clamped should be held w cells deep, one row of corners alone is a hinge. A push "
            "on a single corner makes a dimple of w cells, deeper the wider regions are. Corners "
            "that leave their neighbours by more than 2.5 cells a substep heat it up; a warning "
            "says so.",
            {.min = 0})
        .param("damping", &LatticeOptions::damping,
               "Damping in proportion to stiffness, on top of the material's own: a vibration of "
               "frequency f is damped by the share pi f damping of critical.",
               {.min = 0, .unit = "s"})
        .choice("weighting", &LatticeOptions::weighting, {"filled", "full"},
                "filled gives a partly filled cube that share of the stiffness, full all of it.")
        .choice("plane", &LatticeOptions::plane, {"space", "in_plane"},
                "Of a plane: whether it moves in space (folds, flips, rolls) or strictly in its "
                "plane.")
        .block<physics::PlasticOptions>("plastic", &LatticeOptions::plastic, describe_plastic,
                                        "Whether the shape at rest gives way for good.")
        .param("tear", &LatticeOptions::tear,
               "The strain at which a link between neighbouring corners breaks: 1 is twice its "
               "length. 0: never. Embed cuts meshes along such a tear.",
               {.min = 0, .max = 1000})
        .block<physics::BodyContactOptions>("contact", &LatticeOptions::contact, describe_contact,
                                            "Whether bodies that are not linked collide.")
        .choice("precision", &LatticeOptions::precision, {"single", "full"},
                "Of the sums over regions; motion is kept in double precision either way.");
}

static void describe_step(graph::ParamsOf<physics::StepOptions>& p)
{
    p.choice("integrator", &physics::StepOptions::integrator,
             {"implicit_euler", "implicit_midpoint", "sdirk2"},
             "implicit_euler is the most robust and damps vibration that the steps cannot follow; "
             "implicit_midpoint damps nothing; sdirk2 is accurate and damps only what the steps "
             "cannot follow, at twice the cost.")
        .param("substeps", &physics::StepOptions::substeps,
               "Steps a frame: more follow fast motion and vibration better.",
               {.min = 1, .max = physics::most_substeps})
        .param("tolerance", &physics::StepOptions::tolerance,
               "How much of the forces at work may be left unbalanced when a step ends.",
               {.min = 1e-12, .max = 0.1})
        .param("newton_iterations", &physics::StepOptions::newton_iterations,
               "Linearisations a step: 1 is enough for most; more for large deformation at large "
               "steps.",
               {.min = 1, .max = 100})
        .param("contact_iterations", &physics::StepOptions::contact_iterations,
               "Solves a step, at most, while it is found out which points touch.",
               {.min = 1, .max = 1000})
        .param("solver_iterations", &physics::StepOptions::solver_iterations,
               "Conjugate gradient iterations a solve, at most.", {.min = 1, .max = 1'000'000});
}

void add_to(graph::Registry& registry)
{
    registry.add("Simulate", 1, run)
        .summary("Moves the corners of cubes under forces, pins and contact, a frame at a time.")
        .input("cubes", &Inputs::cubes, "The model: where it is at rest and what it is made of.")
        .inputs("pins", &Inputs::pins, "Corners that are held or moved.")
        .inputs("forces", &Inputs::forces, "Force fields, all together.")
        .inputs("colliders", &Inputs::colliders, "What the body may not enter.")
        .inputs("balls", &Inputs::balls,
                "Rigid balls that move with it and push back (method lattice).")
        .input("surface", &Inputs::surface,
               "The original mesh at rest: contact and wind act on it, embedded in the cubes. "
               "Without it they act on the outside of the cubes.",
               graph::Need::optional)
        .input("start", &Inputs::start,
               "The state to start from; without it the cubes start at rest.",
               graph::Need::optional)
        .choice("method", &Inputs::method, {"bricks", "springs", "lattice"},
                "bricks are finite elements that follow the material; springs a mass-spring "
                "lattice with its stretch and Poisson ratio 1/4; lattice is shape matching, the "
                "fastest, which never fails and is for looks: of the step it needs only the "
                "substeps.")
        .block("bricks", &Inputs::bricks, describe_bricks, "Of the finite elements.",
               {"method", {"bricks"}})
        .block("springs", &Inputs::springs, describe_springs, "Of the mass-spring lattice.",
               {"method", {"springs"}})
        .block("lattice", &Inputs::lattice, describe_lattice, "Of lattice shape matching.",
               {"method", {"lattice"}})
        .param("dt", &Inputs::dt,
               "Seconds that pass in a frame; 0 is a frame's own time. Less is slow motion.",
               {.min = 0, .max = 1e4, .unit = "s"})
        .param("gravity", &Inputs::gravity, "Acceleration of everything; zeros for none.",
               {.unit = "m/s^2"})
        .param("initial_velocity", &Inputs::initial_velocity,
               "Added to the velocity that the body starts with.", {.unit = "m/s"})
        .param("initial_spin_degrees", &Inputs::initial_spin_degrees,
               "Angular velocity about the centre of mass that the body starts with, about x, y "
               "and z.",
               {.unit = "deg/s"})
        .block("step", &Inputs::step, describe_step, "How time steps are taken and solved.")
        .reads(graph::Variable::fps)
        .prepare("body", &Inputs::body, build,
                 {"cubes", "surface", "method", "bricks", "springs", "lattice"})
        .output("state", &Outputs::state,
                "Where the corners are and how fast they move; on the first frame, the start.")
        .previous("state", &Inputs::last);
}

}  // namespace nodes::simulate
