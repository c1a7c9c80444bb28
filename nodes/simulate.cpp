#include "geometry/cubes/plane.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/body/collider_contact.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/state/balls.hpp"
#include "physics/state/first_motion.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <variant>

namespace nodes::simulate {

using geometry::Vec3;

enum class Method { bricks, springs, lattice };
enum class Shape { given, equilibrium };

// One alternative per method, in the order of Method.
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
    physics::PartContactOptions contact;
    double dt = 0;
    Vec3 gravity{0, -9.81, 0};
    Shape initial_shape = Shape::given;
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
    physics::BrickOptions bricks = in.bricks;
    physics::SpringOptions springs = in.springs;
    bricks.contact = springs.contact = in.contact;
    switch (in.method) {
    case Method::bricks:
        return {physics::make_bricks(*in.cubes, bricks, in.surface.get())};
    case Method::springs:
        return {physics::make_springs(*in.cubes, springs, in.surface.get())};
    case Method::lattice:
        return {physics::make_lattice(*in.cubes, in.lattice, in.surface.get())};
    }
    throw std::logic_error("Simulate: a method without a body");
}

// Warns of parameters and forces that have no effect.
static void warn_of_idle(const Inputs& in, const graph::Context& context)
{
    const auto* const body = std::get_if<physics::LatticeBody>(&in.body->is);
    if (!body) {
        if (in.contact.on && in.contact.self && geometry::flat_axis(*in.cubes) >= 0) {
            context.warn("contact.self has no effect, because these cubes are a plane: planes do "
                         "not collide with themselves");
        }
        return;
    }
    const auto bounces = [](const auto& collider) { return collider->bounce > 0; };
    if (std::any_of(in.colliders.begin(), in.colliders.end(), bounces)) {
        context.warn("bounce of colliders has no effect with method = lattice: set method = "
                     "bricks, or bounce = 0");
    }
    if (body->flat_axis < 0 && in.lattice.bend != 1) {
        context.warn("lattice.bend has no effect, because these cubes are not a plane: their "
                     "stiffness comes from the material or the rate");
    }
    if (in.lattice.plane != physics::PlaneMotion::in_plane) return;
    for (std::size_t i = 0; i < in.forces.size(); ++i) {
        const physics::Force& force = *in.forces[i];
        Vec3 within = force.force;
        within[body->flat_axis] = 0;
        if (force.kind != physics::Force::Kind::point || force.force.isZero(0)) continue;
        if (within.norm() > 1e-9 * force.force.norm()) continue;
        context.warn(
            fmt::format("point force {} of {} has no effect: it pushes across the plane, which "
                        "moves within itself only. Turn the force, or set lattice.plane = space",
                        i + 1, in.forces.size()));
    }
}

constexpr const char* no_balls =
    "rigid balls need method = lattice: change the method, or unlink the input 'balls'";

constexpr const char* no_equilibrium =
    "an equilibrium needs method = bricks: change the method, or set initial_shape = given";
constexpr const char* no_pins =
    "an equilibrium needs pins, because a free body falls for ever: link a Pin node to the input "
    "'pins', or set initial_shape = given";

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults;
    if (in.method != Method::lattice && setting.links("balls")) {
        faults.push_back({"balls", no_balls});
    }
    if (in.initial_shape == Shape::equilibrium) {
        if (in.method != Method::bricks) faults.push_back({"initial_shape", no_equilibrium});
        if (!setting.links("pins")) faults.push_back({"initial_shape", no_pins});
    }
    return faults;
}

static physics::Loads gather_loads(const Inputs& in, const graph::Context& context)
{
    physics::Loads loads;
    loads.pins = physics::merge_pins(in.pins, in.cubes->corner_count());
    for (const auto& warning : physics::conflicting_pins(in.pins, 1e-3 * in.cubes->size)) {
        context.warn(warning);
    }
    for (const auto& collider : in.colliders) loads.colliders.push_back(*collider);
    return loads;
}

static void add_forces(const Inputs& in, const graph::Context& context, physics::Loads& loads)
{
    for (const auto& force : in.forces) loads.forces.push_back(*force);
    for (const auto& warning : physics::far_forces(*in.cubes, loads.forces)) context.warn(warning);
    warn_of_idle(in, context);
    if (!in.gravity.isZero(0)) {
        loads.forces.push_back({physics::Force::Kind::gravity, in.gravity});
    }
}

static physics::State first_state(const Inputs& in, const graph::Context& context,
                                  physics::Loads& loads)
{
    if (!in.start) {
        for (const auto& warning : physics::buried(*in.cubes, loads.pins, loads.colliders)) {
            context.warn(warning);
        }
    }
    auto state =
        in.start ? *in.start : std::visit([](const auto& b) { return rest_state(b); }, in.body->is);
    // What held its points, held them in another simulation.
    state.grips.clear();
    state.holds.clear();
    if (in.initial_shape == Shape::given) return state;
    const auto* const bricks = std::get_if<physics::BricksBody>(&in.body->is);
    if (!bricks) throw std::invalid_argument(no_equilibrium);
    if (loads.pins.corner.empty()) throw std::invalid_argument(no_pins);
    add_forces(in, context, loads);
    state = physics::settle(*bricks, std::move(state), loads, in.step);
    for (const auto& warning : state.report.warnings) context.warn(warning);
    return state;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (!in.balls.empty() && in.method != Method::lattice) {
        throw std::invalid_argument(no_balls);
    }
    std::vector<physics::Ball> balls;
    for (const auto& ball : in.balls) balls.push_back(*ball);
    physics::Loads loads = gather_loads(in, context);
    if (!in.last) {
        auto state = first_state(in, context, loads);
        physics::add_first_motion(state, *in.cubes, in.initial_velocity,
                                  in.initial_spin_degrees * (std::numbers::pi / 180));
        state.balls = physics::place_balls(balls);
        return {std::move(state)};
    }
    if (in.last->x.size() != in.cubes->corner_count()) {
        throw std::invalid_argument(
            fmt::format("the number of cube corners changed from {} to {} between frames: voxelize "
                        "the mesh at rest, not the animated mesh",
                        in.last->x.size(), in.cubes->corner_count()));
    }
    loads.balls = std::move(balls);
    add_forces(in, context, loads);
    const double dt = in.dt > 0 ? in.dt : context.frame_seconds();
    auto state = std::visit(
        [&](const auto& body) { return advance(body, *in.last, loads, dt, in.step); }, in.body->is);
    for (const auto& warning : state.report.warnings) context.warn(warning);
    return {std::move(state)};
}

static void describe_bricks(graph::ParamsOf<physics::BrickOptions>& p)
{
    p.choice("element", &physics::BrickOptions::element, {"incompatible", "trilinear"},
             "incompatible: right in bending even one cube thick. trilinear: up to a third too "
             "stiff in bending; for comparison only.")
        .choice("weighting", &physics::BrickOptions::weighting, {"filled", "full"},
                "filled: a partly filled cube has that share of the stiffness. full: it has all of "
                "it.");
}

static void describe_springs(graph::ParamsOf<physics::SpringOptions>& p)
{
    p.param("bending", &physics::SpringOptions::bending,
            "Share of the stiffness along the axes that is carried by springs across two cubes, "
            "which resist bending.",
            {.min = 0, .max = 0.9});
}

static void describe_plastic(graph::ParamsOf<physics::PlasticOptions>& p)
{
    using physics::PlasticOptions;
    p.param("yield", &PlasticOptions::yield,
            "Strain of a region above which its rest shape changes for good (it yields); 0: never.",
            {.min = 0, .max = 10})
        .param("flow", &PlasticOptions::flow,
               "Rate at which the rest shape changes above the yield strain.",
               {.min = 0, .max = 1e6, .unit = "1/s"})
        .param("limit", &PlasticOptions::limit, "Largest change of the rest shape, as a strain.",
               {.min = 0, .max = 0.95});
}

static void describe_part_contact(graph::ParamsOf<physics::PartContactOptions>& p)
{
    using physics::PartContactOptions;
    p.param(
         "on", &PartContactOptions::on,
         "Whether parts of the model that no cubes link collide. Cubes of a plane do not, nor do "
         "parts that overlap at rest.")
        .param("self", &PartContactOptions::self,
               "Whether each part also collides with itself where it folds. Cubes less than three "
               "cubes apart along the part do not. The search takes about 1 ms per 1,000 cubes "
               "and step.")
        .param("friction", &PartContactOptions::friction,
               "Coulomb coefficient of friction between them.", {.min = 0, .max = 100})
        .param("bounce", &PartContactOptions::bounce,
               "Share of the speed of an impact that they separate with (coefficient of "
               "restitution). Slow impacts do not bounce.",
               {.min = 0, .max = 1});
}

static void describe_contact(graph::ParamsOf<physics::BodyContactOptions>& p)
{
    using physics::BodyContactOptions;
    p.param("on", &BodyContactOptions::on, "Whether bodies that are not linked collide.")
        .param("distance", &BodyContactOptions::distance,
               "Distance between corners at which they touch, as balls; 0: the edge of a cube.",
               {.min = 0, .unit = "m"})
        .param("friction", &BodyContactOptions::friction,
               "Coulomb coefficient of friction between them.", {.min = 0, .max = 100});
}

static void describe_lattice(graph::ParamsOf<physics::LatticeOptions>& p)
{
    using physics::LatticeOptions;
    p.param("half_width", &LatticeOptions::half_width,
            "Half width of a region, in cubes. A region is a group of cubes that keeps its shape: "
            "wider regions are stiffer and smoother, at the same cost. With stiffness = material "
            "it should be at most a tenth of a beam's length, or a sixteenth of a sheet's: at "
            "twice that, the body bends a third too far.",
            {.min = 1, .max = 64})
        .choice("stiffness", &LatticeOptions::stiffness, {"material", "rate"},
                "Source of the stiffness. material: Young's modulus, as far as regions and "
                "substeps can represent it (Poisson's ratio acts as 0). rate: the parameter rate.")
        .choice("calibrate", &LatticeOptions::calibrate, {"bending", "stretch"},
                "What the stiffness from the material is calibrated for. bending: a bend of the "
                "whole body. stretch: long waves of stretch. A thin body cannot match both.",
                {"stiffness", {"material"}})
        .param("rate", &LatticeOptions::rate,
               "Rate at which a region pulls its cubes back, whatever the time step. 0: not at "
               "all; very large: as stiff as the method allows.",
               {.min = 0, .unit = "1/s"}, {"stiffness", {"rate"}})
        .param(
            "bend", &LatticeOptions::bend,
            "Bending stiffness of a plane: a multiple of what its thickness gives or, with "
            "stiffness = rate, of its stretch stiffness. Its stretch stiffness is at least as "
            "large: with half width w, a plane thicker than w cells is too stiff in its plane. "
            "Within w cells of a free rim, the bending stiffness is too small. To clamp a rim, pin "
            "it w cells deep; pinning one row of corners makes a hinge. A force on a single corner "
            "makes a dimple of w cells, deeper for wider regions. Corners that move away from "
            "their neighbours by more than 2.5 cells per substep add energy; a warning reports it.",
            {.min = 0})
        .param("damping", &LatticeOptions::damping,
               "Damping proportional to stiffness, in addition to that of the material. The "
               "damping ratio of a vibration of frequency f is pi f damping.",
               {.min = 0, .unit = "s"})
        .choice(
            "weighting", &LatticeOptions::weighting, {"filled", "full"},
            "filled: a partly filled cube has that share of the stiffness. full: it has all of it.")
        .choice("plane", &LatticeOptions::plane, {"space", "in_plane"},
                "Motion of a plane. space: it moves in space (folds, flips, rolls). in_plane: it "
                "moves within its plane only.")
        .block<physics::PlasticOptions>(
            "plastic", &LatticeOptions::plastic, describe_plastic,
            "Plastic deformation: a permanent change of the rest shape.")
        .param("tear", &LatticeOptions::tear,
               "Strain at which a link between neighbouring corners breaks: 1 is twice its length, "
               "0: never. Embed cuts meshes along the tear.",
               {.min = 0, .max = 1000})
        .block<physics::BodyContactOptions>("contact", &LatticeOptions::contact, describe_contact,
                                            "Contact between bodies that are not linked.")
        .choice("precision", &LatticeOptions::precision, {"single", "full"},
                "Precision of the sums over regions. Motion is always in double precision.");
}

static void describe_step(graph::ParamsOf<physics::StepOptions>& p)
{
    p.choice("integrator", &physics::StepOptions::integrator,
             {"implicit_euler", "implicit_midpoint", "sdirk2"},
             "implicit_euler: the most robust; damps vibration that the steps cannot resolve. "
             "implicit_midpoint: no damping. sdirk2: accurate; damps only what the steps cannot "
             "resolve, at twice the cost. A step in which the body hits something is one of "
             "implicit_euler, whatever is chosen.")
        .param("substeps", &physics::StepOptions::substeps,
               "Steps per frame. More steps resolve fast motion and vibration better.",
               {.min = 1, .max = physics::most_substeps})
        .param("tolerance", &physics::StepOptions::tolerance,
               "Tolerance: the share of the acting forces that may be left unbalanced at the end "
               "of a step.",
               {.min = 1e-12, .max = 0.1})
        .param("newton_iterations", &physics::StepOptions::newton_iterations,
               "Newton iterations per step. 1 is enough for most scenes; use more for large "
               "deformation with large steps.",
               {.min = 1, .max = 100})
        .param("contact_iterations", &physics::StepOptions::contact_iterations,
               "Largest number of solves per step to find which points are in contact.",
               {.min = 1, .max = 1000})
        .param("solver_iterations", &physics::StepOptions::solver_iterations,
               "Largest number of conjugate gradient iterations per solve.",
               {.min = 1, .max = 1'000'000});
}

void add_to(graph::Registry& registry)
{
    registry.add("Simulate", 1, run)
        .summary("Simulates a model of cubes under forces, pins and contact, frame by frame.",
                 {"solver", "sim", "fem", "soft body", "softbody", "vellum", "physics", "jelly",
                  "deformable"})
        .input("cubes", &Inputs::cubes, "The model at rest, with its materials.")
        .inputs("pins", &Inputs::pins, "Corners that are held or moved.")
        .inputs("forces", &Inputs::forces, "Force fields; they add up.")
        .inputs("colliders", &Inputs::colliders, "Obstacles that the body cannot enter.")
        .inputs("balls", &Inputs::balls,
                "Rigid balls that move with the body and push back (method lattice only).")
        .input("surface", &Inputs::surface,
               "The original mesh at rest. Contact and wind act on it, embedded in the cubes; "
               "without it they act on the outside of the cubes.",
               graph::Need::optional)
        .check(check)
        .input("start", &Inputs::start, "Initial state. Without it the cubes start at rest.",
               graph::Need::optional)
        .choice("method", &Inputs::method, {"bricks", "springs", "lattice"},
                "Method of simulation. bricks: finite elements that follow the material. springs: "
                "a mass-spring lattice with the material's stretch stiffness and Poisson's ratio "
                "1/4. lattice: shape matching, the fastest; it never diverges, but is for looks. "
                "Of the block step it uses substeps only. The mass of bricks is spread over each "
                "cube; springs and lattice put an eighth at each corner, so that a bar one cube "
                "thick resists turning about its length three times as much as it should.")
        .block("bricks", &Inputs::bricks, describe_bricks, "Options of the finite elements.",
               {"method", {"bricks"}})
        .block("springs", &Inputs::springs, describe_springs, "Options of the mass-spring lattice.",
               {"method", {"springs"}})
        .block("lattice", &Inputs::lattice, describe_lattice, "Options of lattice shape matching.",
               {"method", {"lattice"}})
        .block("contact", &Inputs::contact, describe_part_contact,
               "Contact between parts of the model that no cubes link.",
               {"method", {"bricks", "springs"}})
        .param("dt", &Inputs::dt,
               "Simulated seconds per frame; 0: the duration of a frame. Smaller values give slow "
               "motion.",
               {.min = 0, .max = 1e4, .unit = "s"})
        .param("gravity", &Inputs::gravity, "Acceleration of everything; zeros for none.",
               {.unit = "m/s^2"})
        .choice("initial_shape", &Inputs::initial_shape, {"given", "equilibrium"},
                "Shape in the first frame. given: the model at rest, or that of `start`. "
                "equilibrium: the shape in which the body hangs still under the forces, pins and "
                "colliders of the first frame (method bricks; each part needs a pin).")
        .param("initial_velocity", &Inputs::initial_velocity,
               "Velocity that is added to the initial state.", {.unit = "m/s"})
        .param("initial_spin_degrees", &Inputs::initial_spin_degrees,
               "Angular velocity about the centre of mass, about x, y and z, that is added to the "
               "initial state.",
               {.unit = "deg/s"})
        .block("step", &Inputs::step, describe_step, "Time steps and solver.")
        .reads(graph::Variable::fps)
        .prepare("body", &Inputs::body, build,
                 {"cubes", "surface", "method", "bricks", "springs", "lattice", "contact"})
        .output("state", &Outputs::state,
                "Positions and velocities of the corners; on the first frame, the initial state.")
        .previous("state", &Inputs::last);
}

}  // namespace nodes::simulate
