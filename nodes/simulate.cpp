#include "geometry/mesh/doubled_faces.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/simulate_bodies.hpp"
#include "nodes/simulate_body.hpp"
#include "nodes/simulate_doubts.hpp"
#include "nodes/simulate_faults.hpp"
#include "nodes/simulate_loads.hpp"
#include "nodes/simulate_options.hpp"
#include "nodes/simulate_plastic.hpp"
#include "nodes/simulate_upgrade.hpp"
#include "nodes/simulation_figures.hpp"
#include "nodes/wire_types.hpp"
#include "physics/body/collider_contact.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/body/following_forces.hpp"
#include "physics/body/overlaps.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/state/balls.hpp"
#include "physics/state/first_motion.hpp"
#include "physics/state/hold_matter.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

namespace nodes::simulate {

enum class Shape { given, equilibrium };

struct Inputs {
    std::vector<graph::Wire<geometry::Cubes>> cubes;
    std::vector<graph::Wire<physics::Pins>> pins;
    std::vector<graph::Wire<physics::Force>> forces;
    std::vector<graph::Wire<physics::Collider>> colliders;
    std::vector<graph::Wire<physics::Ball>> balls;
    std::vector<graph::Wire<physics::PartJoint>> joints;
    std::vector<graph::Wire<geometry::TriMesh>> surface;
    graph::Wire<physics::State> start;
    Method method = Method::bricks;
    physics::BrickOptions bricks;
    physics::SpringOptions springs;
    physics::LatticeOptions lattice;
    physics::ShellOptions shell;
    physics::PartContactOptions contact;
    double dt = 0;
    Vec3 gravity{0, -9.81, 0};
    Shape initial_shape = Shape::given;
    Vec3 initial_velocity{0, 0, 0};
    Vec3 initial_spin_degrees{0, 0, 0};
    std::vector<OneBody> bodies;
    FrameSteps step;
    std::shared_ptr<const Body> body;
    graph::Wire<physics::State> last;
};
struct Outputs {
    physics::State state;
};

static Body build(const Inputs& in)
{
    if (in.cubes.empty()) throw std::invalid_argument(no_cubes);
    if (!in.surface.empty() && in.surface.size() != in.cubes.size()) {
        throw std::invalid_argument(wrong_surfaces(in.surface.size(), in.cubes.size()));
    }
    const std::string told = in.method == Method::bricks ? "" : sheets_beside_solids(in.cubes);
    if (!told.empty()) throw std::invalid_argument(told);
    std::vector<physics::BodyModel> models;
    // A mesh and its back would enclose nothing, and be pushed twice.
    std::vector<std::optional<geometry::WithoutDoubled>> once;
    once.reserve(in.surface.size());
    for (std::size_t i = 0; i < in.cubes.size(); ++i) {
        const geometry::TriMesh* surface = in.surface.empty() ? nullptr : in.surface[i].get();
        if (surface) {
            check_surface(*in.cubes[i], *surface, i);
            const auto& found = once.emplace_back(geometry::without_doubled(*surface));
            if (found) surface = &found->mesh;
        }
        models.push_back({in.cubes[i].get(), surface});
    }
    MethodOptions options{in.bricks, in.springs, in.lattice, in.shell};
    options.bricks.contact = options.springs.contact = options.shell.contact = in.contact;
    for (const OneBody& body : in.bodies) options.bricks.rigid.push_back(body.rigid ? 1 : 0);
    return make_body(models, in.method, options, physics::number_models(in.cubes));
}

static double least_size(const Inputs& in)
{
    double least = in.cubes[0]->size;
    for (const auto& cubes : in.cubes) least = std::min(least, cubes->size);
    return least;
}

static std::size_t corner_count(const Inputs& in)
{
    std::size_t sum = 0;
    for (const auto& cubes : in.cubes) sum += cubes->corner_count();
    return sum;
}

static bool may_bend(const Inputs& in, const std::size_t& link)
{
    return link >= in.bodies.size() || !in.bodies[link].rigid;
}

// Warns of parameters and forces that have no effect.
static void warn_of_idle(const Inputs& in, const graph::Context& context)
{
    const auto own = [](const auto& cubes) { return !cubes->elements.empty(); };
    const bool calibrated = std::any_of(in.cubes.begin(), in.cubes.end(), own);
    if (calibrated && in.method == Method::bricks &&
        in.bricks.element == physics::BrickElement::one_point) {
        context.warn("bricks.element = one_point takes the calibrated stiffness of the cubes, but "
                     "lumps their mass, so that they vibrate at other rates: set it to "
                     "incompatible");
    }
    if (calibrated && in.method != Method::bricks) {
        context.warn("the calibrated stiffness of the cubes counts for method = bricks only: set "
                     "method = bricks, or stiffness = filled in Voxelize");
    }
    const auto* const body = std::get_if<physics::LatticeBody>(&in.body->is);
    if (!body) return;
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

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults;
    const std::size_t models = setting.links_of("cubes"), surfaces = setting.links_of("surface");
    if (surfaces > 0 && surfaces != models) {
        faults.push_back({"surface", wrong_surfaces(surfaces, models)});
    }
    if (in.bodies.size() > models) {
        faults.push_back({"bodies", wrong_bodies(in.bodies.size(), models)});
    }
    if (any_rigid(in.bodies)) {
        if (in.method != Method::bricks) faults.push_back({"method", no_rigid});
        if (in.step.integrator != physics::Integrator::implicit_euler) {
            faults.push_back({"step.integrator", rigid_step});
        }
        if (in.initial_shape == Shape::equilibrium) {
            faults.push_back({"initial_shape", no_rigid_equilibrium});
        }
    }
    if (in.method == Method::lattice && models > 1) {
        faults.push_back({"method", lattice_of_several});
    }
    const bool corners = in.method == Method::bricks || in.method == Method::springs;
    if (!corners && setting.links("joints")) faults.push_back({"joints", no_joints});
    if (in.method != Method::lattice && setting.links("balls")) {
        faults.push_back({"balls", no_balls});
    }
    if (in.initial_shape == Shape::equilibrium) {
        if (in.method != Method::bricks) faults.push_back({"initial_shape", no_equilibrium});
        if (!setting.links("pins") && !setting.links("colliders")) {
            faults.push_back({"initial_shape", no_support});
        }
    }
    return faults;
}

static physics::Loads gather_loads(const Inputs& in, const graph::Context& context)
{
    physics::Loads loads;
    std::vector<graph::Wire<physics::Pins>> pins;
    for (const auto& some : in.pins) {
        if (in.body->models.empty()) physics::check_held(*in.cubes.front(), some->matter);
        pins.push_back(physics::pins_of_all(some, in.body->models));
    }
    loads.pins = physics::merge_pins(pins, corner_count(in));
    if (in.method == Method::lattice || in.method == Method::shell) {
        const char* const who = in.method == Method::lattice ? "method lattice" : "method shell";
        physics::require_all_axes(loads.pins, who);
        physics::require_corners(loads.pins, who);
    }
    for (const auto& warning : physics::conflicting_pins(pins, 1e-3 * least_size(in))) {
        context.warn(warning);
    }
    for (const auto& text : told_of_clamps(in.cubes, in.pins, in.bodies)) context.warn(text);
    for (const auto& collider : in.colliders) loads.colliders.push_back(*collider);
    place_joints(in.cubes, in.body->models, in.joints, loads);
    return loads;
}

static void add_forces(const Inputs& in, const graph::Context& context, physics::Loads& loads)
{
    for (const auto& force : in.forces) {
        loads.forces.push_back(*force);
        place_surface(in.cubes, in.body->models, loads.forces.back());
    }
    for (const auto& text : told_of_high_pressure(in.cubes, in.forces)) context.warn(text);
    for (const auto& warning : physics::far_forces(in.cubes, loads.forces)) context.warn(warning);
    warn_of_idle(in, context);
    if (const auto idle = told_of_unused_error(in.step); !idle.empty()) context.warn(idle);
    physics::Force gravity{physics::Force::Kind::gravity, in.gravity};
    if (in.last) gravity.began_as({gravity.kind, in.last->gravity});
    if (gravity.before || !in.gravity.isZero(0)) loads.forces.push_back(gravity);
}

static void require_same_models(const Inputs& in, const physics::State& start)
{
    const std::size_t corners = corner_count(in);
    const auto same = [](const physics::StateModel& a, const physics::StateModel& b) {
        return a.mark == b.mark;
    };
    const auto& models = in.body->models;
    if (!start.models.empty() &&
        !std::equal(models.begin(), models.end(), start.models.begin(), start.models.end(), same)) {
        throw std::invalid_argument(
            "start state: it is of other bodies, or of the same in another order: link `cubes` as "
            "in the node that it comes from");
    }
    if (start.x.size() == corners && start.v.size() == corners) return;
    throw std::invalid_argument(fmt::format("start state: expected {} corners, found {}. Was it "
                                            "made with other cubes?",
                                            corners, start.x.size()));
}

// The velocities that the bodies start with, together and each of its own. They turn about the
// centres of the masses that they are simulated with, which of rigid ones are their surfaces'.
static void start_moving(const Inputs& in, physics::State& state)
{
    constexpr double degree = std::numbers::pi / 180;
    std::vector<double> mass;
    const auto take_masses = [&](const auto& body) {
        const physics::CornerBody& base = body.base;
        for (std::size_t k = 0; k < base.corners; ++k) mass.push_back(base.mass[base.slot_of(k)]);
    };
    std::visit(take_masses, in.body->is);
    std::size_t first = 0;
    for (std::size_t i = 0; i < in.bodies.size(); ++i) {
        const std::size_t count = in.cubes[i]->corner_count();
        physics::add_first_motion(state, first, std::span(mass).subspan(first, count),
                                  in.bodies[i].velocity, degree * in.bodies[i].spin_degrees);
        first += count;
    }
    physics::add_first_motion(state, 0, mass, in.initial_velocity,
                              degree * in.initial_spin_degrees);
}

static double seconds_of(const Inputs& in, const graph::Context& context)
{
    return in.dt > 0 ? in.dt : context.frame_seconds();
}

static physics::State first_state(const Inputs& in, const graph::Context& context,
                                  physics::Loads& loads)
{
    if (!in.start) {
        for (const auto& text : told_of_giants(in.cubes, in.gravity, seconds_of(in, context))) {
            context.warn(text);
        }
        for (const auto& warning :
             physics::buried(in.cubes, loads.pins, loads.colliders, in.surface)) {
            context.warn(warning);
        }
        const auto overlaps = [&](const auto& body) {
            return physics::told_of_overlaps(in.cubes, body.base, loads.joints);
        };
        for (const auto& warning : std::visit(overlaps, in.body->is)) context.warn(warning);
    }
    auto state =
        in.start ? *in.start : std::visit([](const auto& b) { return rest_state(b); }, in.body->is);
    require_same_models(in, state);
    // What held its points, held them in another simulation.
    state.grips.clear();
    state.holds.clear();
    state.reactions.clear();
    state.still_frames = 0;
    state.energy_owed = 0;
    for (auto& held : state.held_forces) held.force.setZero();
    if (in.start && in.method != Method::bricks) {  // which no other method knows
        state.stress.clear();
        state.energy.clear();
    }
    state.brick_mass = in.body->has_brick_mass();
    keep_own_plastic(in.body->is, context, state);
    if (in.start && state.plastic.empty()) {
        const auto at_rest = [](const auto& body) { return rest_state(body).plastic_strain; };
        state.plastic_strain = std::visit(at_rest, in.body->is);
    }
    if (in.method != Method::lattice) state.broken.clear();
    state.report = {};
    if (in.initial_shape == Shape::given) return state;
    const auto* const bricks = std::get_if<physics::BricksBody>(&in.body->is);
    if (!bricks) throw std::invalid_argument(no_equilibrium);
    add_forces(in, context, loads);
    state = physics::settle(*bricks, std::move(state), loads, in.step);
    for (const auto& warning : state.report.warnings) context.warn(warning);
    return state;
}

static void tell(const Inputs& in, const physics::State& state, const graph::Context& context)
{
    const auto* const bricks = std::get_if<physics::BricksBody>(&in.body->is);
    const Energies energy = bricks ? energies(*bricks, state, in.gravity) : Energies{};
    double edge = 0;
    for (const auto& cubes : in.cubes) edge = std::max(edge, cubes->size);
    const bool solved = in.method != Method::lattice;
    context.tell(simulation_figures(state, solved, in.step, energy, edge));
}

static void warn_of_bodies(const Inputs& in, const physics::Pins& pins, const physics::State& state,
                           const graph::Context& context)
{
    if (in.method != Method::bricks || in.initial_shape != Shape::given ||
        in.step.integrator != physics::Integrator::implicit_euler) {
        return;
    }
    for (const auto& hint : told_of_stiff(in.cubes, in.bodies, state, in.step.substeps)) {
        context.warn(hint);
    }
    for (const auto& text : told_of_torn_pins(in.cubes, in.bodies, pins, state)) context.warn(text);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.cubes.empty()) throw std::invalid_argument(no_cubes);
    if (!in.balls.empty() && in.method != Method::lattice) {
        throw std::invalid_argument(no_balls);
    }
    if (in.bodies.size() > in.cubes.size()) {
        throw std::invalid_argument(wrong_bodies(in.bodies.size(), in.cubes.size()));
    }
    std::vector<physics::Ball> balls;
    for (const auto& ball : in.balls) balls.push_back(*ball);
    if (in.method == Method::lattice) {
        for (const auto& force : in.forces) {
            physics::require_no_following({force.get(), 1}, "method lattice");
        }
    }
    physics::Loads loads = gather_loads(in, context);
    if (!in.last) {
        auto state = first_state(in, context, loads);
        start_moving(in, state);
        state.models = in.body->models;
        state.gravity = in.gravity;
        state.balls = physics::place_balls(balls);
        tell(in, state, context);
        return {std::move(state)};
    }
    if (in.last->x.size() != corner_count(in)) {
        throw std::invalid_argument(
            fmt::format("the number of cube corners changed from {} to {} between frames: voxelize "
                        "the mesh at rest, not the animated mesh",
                        in.last->x.size(), corner_count(in)));
    }
    loads.balls = std::move(balls);
    add_forces(in, context, loads);
    const double dt = seconds_of(in, context);
    auto last = *in.last;
    keep_own_plastic(in.body->is, context, last);
    auto state = std::visit(
        [&](const auto& body) { return advance(body, std::move(last), loads, dt, in.step); },
        in.body->is);
    for (const auto& warning : state.report.warnings) context.warn(warning);
    warn_of_bodies(in, loads.pins, state, context);
    state.models = in.body->models;
    state.gravity = in.gravity;
    tell(in, state, context);
    return {std::move(state)};
}

static void describe_methods(graph::NodeBuilder<Inputs, Outputs>& node)
{
    node.choice("method", &Inputs::method, {"bricks", "springs", "lattice", "shell"},
                "Method of simulation. bricks: finite elements that follow the material; sheets "
                "among several `cubes` move as by shell, and they and the solids push each other. "
                "springs: "
                "a mass-spring lattice with the material's stretch stiffness and Poisson's ratio "
                "1/4. lattice: shape matching, the fastest; it never diverges, but is for looks. "
                "Of the block step it uses substeps only. shell: a thin sheet that follows the "
                "material, for cloth, paper and sheet metal; the cubes come from Plane or Sheet. "
                "The mass of bricks is spread over each cube; "
                "the others, and bricks of one_point, put an eighth at each corner, so that a bar "
                "one cube thick resists "
                "turning about its length three times as much as it should.")
        .block("bricks", &Inputs::bricks, describe_bricks, "Options of the finite elements.",
               {"method", {"bricks"}})
        .block("springs", &Inputs::springs, describe_springs, "Options of the mass-spring lattice.",
               {"method", {"springs"}})
        .block("lattice", &Inputs::lattice, describe_lattice, "Options of lattice shape matching.",
               {"method", {"lattice"}})
        .block("shell", &Inputs::shell, describe_shell,
               "Options of the thin shell. With method = bricks, those of sheets beside solids.",
               {"method", {"shell", "bricks"}})
        .block("contact", &Inputs::contact, describe_part_contact,
               "Contact between parts of the model that no cubes link, and of sheets.",
               {"method", {"bricks", "springs", "shell"}});
}

static void describe_loads(graph::NodeBuilder<Inputs, Outputs>& node)
{
    node.inputs("pins", &Inputs::pins, "Corners that are held or moved.")
        .inputs(
            "forces", &Inputs::forces,
            "Force fields; they add up. What changes from frame to frame changes evenly within a "
            "frame. A step takes it as it is at the step's end, or in the middle with the "
            "midpoint rule: raise step.substeps where that counts.")
        .inputs("colliders", &Inputs::colliders, "Obstacles that the body cannot enter.")
        .inputs("balls", &Inputs::balls,
                "Rigid balls that move with the body and push back (method lattice only).")
        .inputs("joints", &Inputs::joints,
                "Places where two parts are kept together: ball joints, hinges and welds (methods "
                "bricks and springs).");
}

void add_to(graph::Registry& registry)
{
    auto node = registry.add("Simulate", 3, run);
    node.upgrade(1, bends_before, keep_bending).upgrade(2, one_step_before, keep_one_step);
    node.summary("Simulates a model of cubes under forces, pins and contact, frame by frame.",
                 {"solver", "sim", "fem", "soft body", "softbody", "vellum", "physics", "jelly",
                  "deformable"})
        .inputs("cubes", &Inputs::cubes,
                "The model at rest, with its materials. Several models are simulated together, as "
                "bodies that touch (not with method lattice): they may have cubes of different "
                "sizes. Embed, Measure, Pin and Render take the part of each from the one state "
                "by the cubes that they are linked to.",
                graph::Need::required);
    describe_loads(node);
    node.inputs(
            "surface", &Inputs::surface,
            "The original mesh at rest. Contact and wind act on it, embedded in the cubes; "
            "without it they act on the outside of the cubes. A face and its back count once. "
            "Bodies of bricks and springs touch "
            "each other at its closed pieces, and around open ones at the outside of the "
            "cubes. With several `cubes`, the mesh of each in the same order, or none. A Sheet, "
            "and a "
            "Plane beside solids, is touched at its own vertices, whatever its mesh.")
        .check(check)
        .input("start", &Inputs::start,
               "Initial state: the one of the first frame. That of another Simulate is where it "
               "begins, and not where it ends: to start from one that hangs or stands in "
               "equilibrium, take `initial_shape`. Without it the cubes start at rest.",
               graph::Need::optional);
    describe_methods(node);
    node.param("dt", &Inputs::dt,
               "Simulated seconds per frame; 0: the duration of a frame. Smaller values give slow "
               "motion.",
               {.min = 0, .max = 1e4, .unit = "s"})
        .param("gravity", &Inputs::gravity, "Acceleration of everything; zeros for none.",
               {.unit = "m/s^2"})
        .choice("initial_shape", &Inputs::initial_shape, {"given", "equilibrium"},
                "Shape in the first frame. given: the model at rest, or that of `start`. "
                "equilibrium: the shape in which the body is at rest under the forces, pins and "
                "colliders of the first frame (method bricks). Parts without pins lie on "
                "colliders then, or on each other.")
        .param("initial_velocity", &Inputs::initial_velocity,
               "Velocity that is added to the initial state.", {.unit = "m/s"})
        .param("initial_spin_degrees", &Inputs::initial_spin_degrees,
               "Angular velocity about the centre of mass, about x, y and z, that is added to the "
               "initial state.",
               {.unit = "deg/s"})
        .list("bodies", &Inputs::bodies, describe_body,
              "What is special about each of several `cubes`, in the order of their links.")
        .block("step", &Inputs::step, describe_step, "Time steps and solver.")
        .reads(graph::Variable::fps)
        .pace({graph::Pace::By::seconds_a_frame, "dt"})
        .bends("cubes", may_bend)
        .prepare("body", &Inputs::body, build,
                 {"cubes", "surface", "method", "bricks", "springs", "lattice", "shell", "contact",
                  "bodies"})
        .output("state", &Outputs::state,
                "Positions and velocities of the corners; on the first frame, the initial state.")
        .previous("state", &Inputs::last);
}

}  // namespace nodes::simulate
