#include "geometry/mesh/measure.hpp"
#include "geometry/cubes/components.hpp"
#include "geometry/cubes/local_matter.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/measure_faults.hpp"
#include "nodes/units.hpp"
#include "nodes/wire_types.hpp"
#include "physics/body/plane_touch.hpp"
#include "physics/bricks/rigid_pins.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/state_models.hpp"
#include "render/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace nodes::measure {

// The index of a quantity in the table below.
enum class What {};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh, rest;
    graph::Wire<geometry::Cubes> cubes, against;
    graph::Wire<physics::State> state;
    graph::Wire<physics::Pins> pins;
    graph::Wire<render::Image> image;
    What what = What{6};  // displacement_max, as the table says
    geometry::Vec3 point{0, 0, 0};
    geometry::Vec3 direction{0, 1, 0};
    int collider = 0;
    std::shared_ptr<const physics::State> whole;  // the state of all bodies, as it is linked
    std::string attribute = "displacement";
};
struct Outputs {
    double value = 0;
};

static std::string not_linked(const char* port)
{
    return fmt::format("this quantity needs the input '{}', which is not linked", port);
}

template <class T> static const T& linked(const graph::Wire<T>& wire, const char* port)
{
    if (!wire) {
        throw std::invalid_argument(not_linked(port));
    }
    return *wire;
}

// The linked inputs; each throws std::invalid_argument if it is not linked.
static const geometry::TriMesh& mesh(const Inputs& in)
{
    return linked(in.mesh, "mesh");
}
static const geometry::TriMesh& rest(const Inputs& in)
{
    return linked(in.rest, "rest");
}
static const geometry::Cubes& cubes(const Inputs& in)
{
    return linked(in.cubes, "cubes");
}
static const physics::State& state(const Inputs& in)
{
    return linked(in.state, "state");
}
static const render::Image& image(const Inputs& in)
{
    return linked(in.image, "image");
}

static geometry::Vec3 direction(const Inputs& in)
{
    if (in.direction.isZero(0)) {
        throw std::invalid_argument("expected a direction that is not 0");
    }
    return in.direction.normalized();
}

static double along(const Inputs& in, const geometry::Vec3& v)
{
    return v.dot(direction(in));
}

static physics::MassMoments moments(const Inputs& in)
{
    return physics::mass_moments(state(in), cubes(in));
}

// Whether it is more than the first state of a simulation.
static bool has_gone(const physics::State& state)
{
    return state.report.steps > 0 || state.report.slept;
}

// Of each cube, once there has been a step: at rest there is none. Of a sheet beside solids it is
// not known.
static const std::vector<float>& of_cubes(const Inputs& in, const std::vector<float>& numbers,
                                          const char* what)
{
    const bool unknown = std::any_of(numbers.begin(), numbers.end(),
                                     [](float number) { return std::isnan(number); });
    if (unknown || (numbers.empty() && has_gone(state(in)))) {
        throw std::invalid_argument(
            fmt::format("the state has no {}: only method bricks of Simulate knows it, and that of "
                        "solids alone. Link `cubes` of a solid",
                        what));
    }
    return numbers;
}

static physics::PinForce pin_force(const Inputs& in)
{
    const physics::State& of = state(in);
    const bool several = in.whole && !in.whole->models.empty();
    if (several && in.pins && in.cubes && in.pins->cubes != physics::mark_of(*in.cubes)) {
        throw std::invalid_argument("the pins are of other cubes than those of the input 'cubes': "
                                    "link the Pin of these cubes");
    }
    physics::PinForce out = physics::pin_force(of, in.pins.get(), in.point);
    if (in.pins) {
        const physics::PinForce rigid = physics::rigid_pin_force(of, *in.pins, in.point);
        out.force += rigid.force, out.torque += rigid.torque, out.pins += rigid.pins;
    }
    // A Pin that has let go holds nothing, and so do all where each has.
    if (out.pins == 0 && in.pins && !in.pins->empty() && has_gone(of)) {
        throw std::invalid_argument("none of the corners or points of `pins` was held in the "
                                    "simulation: link the Pin that Simulate has");
    }
    return out;
}

static geometry::Vec3 contact_force(const Inputs& in)
{
    const physics::State& whole = linked(in.whole, "state");
    physics::ContactOf of;
    of.collider = in.collider;
    if (whole.models.empty()) {
        if (in.against) throw std::invalid_argument("`against` needs a state of several bodies");
    } else {
        if (in.cubes) of.body = &physics::model_of(whole, *in.cubes);
        if (in.against) of.another = &physics::model_of(whole, *in.against);
    }
    return physics::contact_force(whole, of);
}

// An attribute of the mesh, or of the cubes where no mesh is linked.
static geometry::Spread attribute(const Inputs& in)
{
    if (in.mesh) return geometry::attribute_spread(*in.mesh, in.attribute);
    return geometry::value_spread(cubes(in), in.attribute);
}

// A quantity: its name in documents, its unit, the inputs that it needs, and how it is measured.
struct Quantity {
    const char *name, *unit;
    std::array<const char*, 2> needs;
    double (*measure)(const Inputs&);
};

constexpr Quantity quantities[] = {
    {"vertices", "", {"mesh"}, [](const Inputs& in) { return double(mesh(in).positions.size()); }},
    {"triangles",
     "",
     {"mesh"},
     [](const Inputs& in) { return double(mesh(in).triangles().size()); }},
    {"area", "m^2", {"mesh"}, [](const Inputs& in) { return geometry::surface_area(mesh(in)); }},
    {"volume",
     "m^3",
     {"mesh"},
     [](const Inputs& in) { return geometry::enclosed_volume(mesh(in)); }},
    {"lowest",
     "m",
     {"mesh"},
     [](const Inputs& in) { return geometry::extent(mesh(in), direction(in))[0]; }},
    {"highest",
     "m",
     {"mesh"},
     [](const Inputs& in) { return geometry::extent(mesh(in), direction(in))[1]; }},
    {"displacement_max",
     "m",
     {"mesh", "rest"},
     [](const Inputs& in) { return geometry::displacement(mesh(in), rest(in)).largest; }},
    {"displacement_mean",
     "m",
     {"mesh", "rest"},
     [](const Inputs& in) { return geometry::displacement(mesh(in), rest(in)).mean; }},
    {"displacement_at",
     "m",
     {"mesh", "rest"},
     [](const Inputs& in) {
         return geometry::displacement_at(mesh(in), rest(in), in.point).dot(direction(in));
     }},
    {"stretch_max",
     "",
     {"mesh", "rest"},
     [](const Inputs& in) { return double(geometry::largest_stretch(mesh(in), rest(in))); }},
    {"mesh_finite",
     "",
     {"mesh"},
     [](const Inputs& in) { return geometry::all_finite(mesh(in)) ? 1.0 : 0.0; }},
    {"cubes", "", {"cubes"}, [](const Inputs& in) { return double(cubes(in).count()); }},
    {"components",
     "",
     {"cubes"},
     [](const Inputs& in) {
         if (!cubes(in).component.empty()) return double(geometry::component_count(cubes(in)));
         const auto found = geometry::find_components(cubes(in), geometry::Connectivity::face,
                                                      geometry::Largest::by_count);
         return double(found.count());
     }},
    {"mass", "kg", {"cubes"}, [](const Inputs& in) { return geometry::total_mass(cubes(in)); }},
    {"speed_max",
     "m/s",
     {"state"},
     [](const Inputs& in) { return physics::largest_speed(state(in)); }},
    {"kinetic_energy",
     "J",
     {"cubes", "state"},
     [](const Inputs& in) { return physics::kinetic_energy(state(in), cubes(in)); }},
    {"elastic_energy",
     "J",
     {"state"},
     [](const Inputs& in) {
         double sum = 0;
         for (const float e : of_cubes(in, state(in).energy, "elastic energy")) sum += double(e);
         return sum;
     }},
    {"stress_max",
     "Pa",
     {"state"},
     [](const Inputs& in) {
         float most = 0;
         for (const float s : of_cubes(in, state(in).stress, "stress")) most = std::max(most, s);
         return double(most);
     }},
    {"plastic_strain_max",
     "",
     {"state"},
     [](const Inputs& in) {
         float most = 0;
         for (const float s : state(in).plastic_strain) most = std::max(most, s);
         return double(most);
     }},
    {"momentum",
     "kg m/s",
     {"cubes", "state"},
     [](const Inputs& in) { return along(in, moments(in).momentum); }},
    {"angular_momentum",
     "kg m^2/s",
     {"cubes", "state"},
     [](const Inputs& in) { return along(in, moments(in).angular); }},
    {"centre_of_mass",
     "m",
     {"cubes", "state"},
     [](const Inputs& in) { return along(in, moments(in).centre); }},
    {"moment_of_inertia",
     "kg m^2",
     {"cubes", "state"},
     [](const Inputs& in) { return along(in, moments(in).inertia * direction(in)); }},
    {"reaction_force",
     "N",
     {"state"},
     [](const Inputs& in) { return along(in, pin_force(in).force); }},
    {"reaction_torque",
     "N m",
     {"state"},
     [](const Inputs& in) { return along(in, pin_force(in).torque); }},
    {"contact_force",
     "N",
     {"state"},
     [](const Inputs& in) { return along(in, contact_force(in)); }},
    {"contact_depth",
     "m",
     {"state"},
     [](const Inputs& in) {
         const physics::State& whole = linked(in.whole, "state");
         return std::max(physics::deepest_of(whole.holds), physics::deepest_of(whole.grips));
     }},
    {"converged",
     "",
     {"state"},
     [](const Inputs& in) { return state(in).report.converged ? 1.0 : 0.0; }},
    {"iterations",
     "",
     {"state"},
     [](const Inputs& in) { return double(state(in).report.iterations); }},
    {"brightness",
     "",
     {"image"},
     [](const Inputs& in) { return double(render::mean_brightness(image(in))); }},
    {"coverage",
     "",
     {"image"},
     [](const Inputs& in) { return double(render::coverage(image(in))); }},
    {"attribute_min", "", {}, [](const Inputs& in) { return attribute(in).least; }},
    {"attribute_max", "", {}, [](const Inputs& in) { return attribute(in).most; }},
    {"attribute_mean", "", {}, [](const Inputs& in) { return attribute(in).mean; }},
};

static_assert(std::string_view(quantities[6].name) == "displacement_max");

static std::vector<std::string> names()
{
    std::vector<std::string> out;
    for (const Quantity& quantity : quantities) out.emplace_back(quantity.name);
    return out;
}

// The unit of the quantity of this name; empty: it has none, or is not known.
static std::string_view unit_of_quantity(std::string_view name)
{
    for (const Quantity& quantity : quantities) {
        if (name == quantity.name) return quantity.unit;
    }
    return {};
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults;
    const Quantity& quantity = quantities[static_cast<std::size_t>(in.what)];
    const std::string_view name = quantity.name;
    if (name.starts_with("attribute_") && !setting.links("mesh") && !setting.links("cubes")) {
        faults.push_back({"what", "an attribute needs the input 'mesh' or 'cubes', and neither is "
                                  "linked"});
    }
    if (in.collider > 0 && setting.links("against")) {
        faults.push_back({"collider", "either one collider pushes or the body of the input "
                                      "'against': set collider to 0, or unlink that"});
    }
    for (const graph::LinkedNode& source : setting.sources) {
        const std::string none = no_such_collider(name, in.collider, source);
        if (!none.empty()) faults.push_back({"collider", none});
        const std::string why = not_of_simulation(name, source);
        if (!why.empty()) faults.push_back({"what", why});
        const std::string off = of_rigid(name, source);
        if (!off.empty()) faults.push_back({"what", off, true});
    }
    for (const char* need : quantity.needs) {
        if (need && !setting.links(need)) faults.push_back({"what", not_linked(need)});
    }
    return faults;
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Inputs own = in;
    own.whole = in.state;
    if (in.pins && in.state && !in.cubes) {
        own.pins = physics::pins_of_all(in.pins, in.state->models);
    }
    if (in.cubes) own.state = physics::state_of(in.state, *in.cubes);
    return {quantities[static_cast<std::size_t>(in.what)].measure(own)};
}

// Of the choice `what`.
constexpr const char* what_text =
    "The quantity to measure. Of `mesh`: vertices, triangles, area (m^2), volume (m^3), "
    "lowest and highest (coordinate along `direction`, m), mesh_finite (1 or 0). Of `mesh` "
    "against `rest`: displacement_max and displacement_mean (m), displacement_at (m, along "
    "`direction`), stretch_max (largest edge length over its rest length). Of `cubes`: cubes "
    "(their number), "
    "components (sets of cubes that hang together, by faces or as ConnectedComponent found "
    "them), mass (kg). Of `state`: speed_max (m/s), elastic_energy (J) and stress_max "
    "(Pa, von Mises), of method bricks, plastic_strain_max (that rest shapes have come to for "
    "good; 0 where nothing has yielded), reaction_force (N, of pins on the body, along "
    "`direction`, the mean over the frame; 0 while nothing is held; not of method lattice), "
    "reaction_torque (N m, of the same forces where the pins are at the end of the frame, about "
    "the axis along `direction` through `point`), "
    "contact_force (N, on the body of `cubes` by all that it touches, along `direction`: "
    "pushes and friction, the mean over the frame, without impacts that bounce), "
    "contact_depth (m, the deepest point of any body in what it touches), converged (1 "
    "where the forces balanced within step.tolerance after every step, else 0: with "
    "step.newton_iterations = 1, steps are linear, and impacts and fast turns give 0 "
    "without a warning), iterations. Of `state` and `cubes`: kinetic_energy (J), momentum "
    "(kg m/s) and "
    "centre_of_mass (m) along `direction`, angular_momentum (kg m^2/s) and "
    "moment_of_inertia (kg m^2) about the axis along `direction` through the centre of "
    "mass: these two by the inertia of the cubes, which is off by what `accuracy` tells of it for "
    "rigid bodies, as they move by that of their surfaces. Of `image`: brightness (mean luma, 0 to "
    "1), "
    "coverage (share of pixels that differ from the first pixel of their row). Of `mesh`, "
    "or of `cubes` if no mesh is linked: attribute_min, attribute_max and attribute_mean "
    "(over vertices, or by the volume that fills cubes).";

void add_to(graph::Registry& registry)
{
    registry.add("Measure", 1, run)
        .summary("Measures a mesh, cubes, a state or an image as one number, for `expect` blocks "
                 "and studies.",
                 {"attribute", "statistics", "volume of", "print", "assert"})
        .input("mesh", &Inputs::mesh, "The mesh to measure.", graph::Need::optional)
        .input("rest", &Inputs::rest, "The same mesh at rest, for displacements and stretch.",
               graph::Need::optional)
        .input("cubes", &Inputs::cubes, "The cubes to measure.", graph::Need::optional)
        .input("against", &Inputs::against,
               "The cubes of the one body that pushes, for contact_force; without a link, all "
               "bodies and colliders push.",
               graph::Need::optional)
        .input("state", &Inputs::state, "The simulation's state to measure.", graph::Need::optional)
        .input("pins", &Inputs::pins,
               "The pins whose force to measure; without a link, all of the simulation.",
               graph::Need::optional)
        .input("image", &Inputs::image, "The image to measure.", graph::Need::optional)
        .choice("what", &Inputs::what, names(), what_text)
        .param("point", &Inputs::point,
               "Where to measure. displacement_at: in the rest shape; the nearest vertex counts. "
               "reaction_torque: a point of the axis.",
               {.unit = "m"}, {"what", {"displacement_at", "reaction_torque"}})
        .param("direction", &Inputs::direction,
               "Direction along which, or about which, to measure.", {},
               {"what",
                {"displacement_at", "lowest", "highest", "momentum", "angular_momentum",
                 "centre_of_mass", "moment_of_inertia", "reaction_force", "reaction_torque",
                 "contact_force"}})
        .param("collider", &Inputs::collider,
               "Which of Simulate's `colliders` pushes, counted from 1; 0: all of them, and other "
               "bodies.",
               {.min = 0, .max = 1e6}, {"what", {"contact_force"}})
        .param("attribute", &Inputs::attribute,
               "Name of the attribute. Of cubes: young, density, poisson, mass_damping, "
               "stiffness_damping, fill, of a Plane or a Sheet thickness, or one of their own.",
               {}, {"what", {"attribute_min", "attribute_max", "attribute_mean"}})
        .check(check)
        .output("value", &Outputs::value, "The measured number.");
}

}  // namespace nodes::measure

std::string nodes::unit_of(const graph::Node& node)
{
    return unit_of_linked(graph::LinkedNode{{}, node.name, node.type, &node.params});
}

std::string nodes::unit_of_linked(const graph::LinkedNode& node)
{
    if (node.type->name != "Measure") return {};
    return std::string(measure::unit_of_quantity(node.text("what")));
}
