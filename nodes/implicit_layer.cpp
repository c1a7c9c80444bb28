#include "geometry/mesh/transform.hpp"
#include "graph/document/json.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace nodes::implicit_layer {

using geometry::Vec3;
using physics::BaseKind;
using physics::LayeredBody;
using physics::LayerMatter;
using physics::Substance;
using physics::VolumeControl;

struct Muscle {
    int skeleton = 0;
    double inflation = 1;
};

// A frame whose mass and inertia are told.
struct OwnMass {
    int frame = 0;
    double mass = 0;
    Vec3 inertia{0, 0, 0};
    Vec3 products{0, 0, 0};
};

// Frames that are held: one, or those within a sphere.
struct PinParams {
    int frame = -1;
    Vec3 position{0, 0, 0};
    double radius = 0.1;
    Vec3 translate{0, 0, 0};
};

enum class Carrier { still, rigid, particles, net };

struct Inputs {
    graph::Wire<geometry::ImplicitLayer> layer;
    Carrier base = Carrier::rigid;
    double density = 1000;
    double mass = 0;
    double seed_spacing = 0.02;
    LayerMatter matter;
    VolumeControl volume;
    Substance substance;
    std::vector<OwnMass> own_masses;
    std::vector<PinParams> pins;
    Vec3 translate{0, 0, 0};
    Vec3 rotate_degrees{0, 0, 0};
    Vec3 velocity{0, 0, 0};
    Vec3 spin_degrees{0, 0, 0};
    double inflation = 1;
    std::vector<Muscle> muscles;
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};
    std::shared_ptr<const LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

// Throws std::invalid_argument where a number is no frame's.
static std::size_t checked_frame(int frame, const LayeredBody& body, const char* what)
{
    const auto f = static_cast<std::size_t>(frame);
    const std::size_t frames = physics::mass_count(body.base);
    if (f < frames) return f;
    throw std::invalid_argument(fmt::format("{} names frame {}, but the body has {} frames, "
                                            "counted from 0: name one of those",
                                            what, frame, frames));
}

// The tensor of a frame, or throws where no rigid thing has it: each of its principal moments is at
// most the sum of the others.
static geometry::Mat3 inertia_of(const OwnMass& own)
{
    geometry::Mat3 I = own.inertia.asDiagonal();
    I(0, 1) = I(1, 0) = own.products.x();
    I(1, 2) = I(2, 1) = own.products.y();
    I(2, 0) = I(0, 2) = own.products.z();
    const Vec3 principal = Eigen::SelfAdjointEigenSolver<geometry::Mat3>(I).eigenvalues();
    if (principal[0] > 0 && principal[2] <= (principal[0] + principal[1]) * (1 + 1e-9)) return I;
    throw std::invalid_argument(fmt::format(
        "own_masses: the inertia of frame {} has the principal moments {:.4g}, {:.4g} and {:.4g} "
        "kg m^2; expected moments above 0 of which none is more than the sum of the other two",
        own.frame, principal[0], principal[1], principal[2]));
}

static void set_own_masses(const Inputs& in, LayeredBody& body)
{
    for (const OwnMass& own : in.own_masses) {
        const std::size_t f = checked_frame(own.frame, body, "an entry of own_masses");
        if (own.mass > 0) {
            body.base.inertia[f] *= own.mass / body.base.mass[f];
            body.base.mass[f] = own.mass;
        }
        if (!own.inertia.isZero(0) || !own.products.isZero(0)) {
            body.base.inertia[f] = inertia_of(own);
        }
    }
}

static LayeredBody build(const Inputs& in)
{
    geometry::ImplicitLayer layer = *in.layer;
    LayerMatter matter = in.matter;
    if (in.base == Carrier::particles && in.substance.separates) {
        physics::let_separate(layer, matter);
    }
    constexpr BaseKind kinds[] = {BaseKind::still, BaseKind::rigid, BaseKind::particles};
    LayeredBody body =
        in.base == Carrier::net
            ? physics::make_net_body(std::move(layer), in.density, in.seed_spacing)
            : physics::make_layered_body(std::move(layer), kinds[std::size_t(in.base)], in.density,
                                         in.seed_spacing);
    double total = 0;
    for (const double mass : body.base.mass) total += mass;
    if (in.mass > 0 && total > 0) {
        for (double& mass : body.base.mass) mass *= in.mass / total;
        for (geometry::Mat3& inertia : body.base.inertia) inertia *= in.mass / total;
    }
    if (in.base != Carrier::still) set_own_masses(in, body);
    body.matter = matter;
    body.control = in.volume;
    if (in.base != Carrier::net) body.base.substance = in.substance;
    return body;
}

// Warns of particles that start too close to each other, as random points do: they fly apart.
static void warn_of_crowding(const LayeredBody& body, const graph::Context& context)
{
    if (body.base.kind != physics::BaseKind::particles) return;
    const double wanted = body.base.substance.rest_distance;
    const auto& frames = body.base.frames;
    if (!(body.base.substance.stiffness > 0) || frames.size() > 20'000) return;
    double nearest = wanted;
    for (std::size_t p = 0; p < frames.size(); ++p) {
        for (std::size_t q = p + 1; q < frames.size(); ++q) {
            nearest = std::min(nearest, (frames[p].translation() - frames[q].translation()).norm());
        }
    }
    if (nearest > 0.6 * wanted) return;
    context.warn(fmt::format("particles start {:.2g} m apart, but substance.rest_distance is "
                             "{:.2g} m: pairs this close fly apart in the first step. Spread the "
                             "particles more evenly, or set rest_distance to {:.2g} m or less",
                             nearest, wanted, nearest / 0.6));
}

static void warn_of_restitution(const Inputs& in, const graph::Context& context)
{
    if (in.matter.restitution == LayerMatter{}.restitution) return;
    if (in.matter.rigid) {
        context.warn("matter.restitution has no effect, because matter.rigid is true: set "
                     "matter.bounce instead");
    } else if (in.base == Carrier::particles || in.base == Carrier::net) {
        context.warn(fmt::format(
            "matter.restitution has no effect, because base is {}: only layers with base = rigid "
            "or still bounce. Set base to rigid, or leave restitution at 1",
            in.base == Carrier::net ? "net" : "particles"));
    }
}

// Frames as they are drawn that the pins hold.
static std::vector<physics::HeldFrame> held_frames(const Inputs& in, const graph::Context& context)
{
    std::vector<physics::HeldFrame> held;
    if (in.pins.empty()) return held;
    if (in.base == Carrier::still) {
        context.warn("pins have no effect, because base is still: the body moves by translate and "
                     "rotate_degrees only. Set base to rigid, particles or net");
        return held;
    }
    const std::span frames(in.body->base.frames.data(), physics::mass_count(in.body->base));
    for (const PinParams& pin : in.pins) {
        const std::size_t before = held.size();
        if (pin.frame >= 0) {
            const std::size_t f = checked_frame(pin.frame, *in.body, "a pin");
            held.push_back({static_cast<std::uint32_t>(f), pin.translate});
            continue;
        }
        for (std::uint32_t f = 0; f < frames.size(); ++f) {
            if ((frames[f].translation() - pin.position).norm() > pin.radius) continue;
            held.push_back({f, pin.translate});
        }
        if (held.size() > before) continue;
        context.warn(fmt::format("a pin holds nothing: no frame, as drawn, is within {:.3g} m of "
                                 "({:.3g}, {:.3g}, {:.3g}). Raise its radius, or name a frame",
                                 pin.radius, pin.position.x(), pin.position.y(), pin.position.z()));
    }
    return held;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    physics::LayeredPart part;
    part.body = in.body;
    part.held = held_frames(in, context);
    part.pose = geometry::placement(in.translate, in.rotate_degrees, Vec3::Ones(), Vec3::Zero());
    part.velocity = in.velocity;
    part.spin = in.spin_degrees * (std::numbers::pi / 180);
    part.inflation = in.inflation;
    const std::size_t skeletons = in.body->layer.skeletons.size();
    for (const Muscle& muscle : in.muscles) {
        const auto s = static_cast<std::size_t>(muscle.skeleton);
        if (s >= skeletons) {
            throw std::invalid_argument(fmt::format(
                "a muscle names skeleton {}, but the layer has {} skeletons, counted from 0", s,
                skeletons));
        }
        part.muscle.resize(skeletons, 1);
        part.muscle[s] *= muscle.inflation;
    }
    const bool inflates =
        in.inflation != 1 || std::any_of(in.muscles.begin(), in.muscles.end(),
                                         [](const Muscle& m) { return m.inflation != 1; });
    if (inflates && in.volume.proportional == 0) {
        context.warn("inflation has no effect, because volume.proportional is 0 (volume control is "
                     "off): set it to 10, for example");
    }
    warn_of_crowding(*in.body, context);
    warn_of_restitution(in, context);
    part.colour = in.colour;
    return {std::move(part)};
}

static void describe_matter(graph::ParamsOf<LayerMatter>& p)
{
    p.param("stiffness", &LayerMatter::stiffness,
            "Contact pressure per unit of field by which the layer is compressed.",
            {.min = 0, .unit = "Pa"})
        .param("friction", &LayerMatter::friction,
               "Viscous friction: traction per unit of sliding speed. Along a collider it is at "
               "most the collider's coefficient times the pressure. Raise it for bodies that must "
               "not creep: they creep at their tangential load divided by it.",
               {.min = 0, .unit = "Pa s/m"})
        .param(
            "restitution", &LayerMatter::restitution,
            "Coefficient of restitution of a soft layer between bodies with base = rigid or still: "
            "share of the speed of an impact that they part with, besides what friction takes. 0 "
            "for clay, 0.5 for wood, 1 loses nothing. Two layers share the loss as they share the "
            "compression. Slow impacts do not bounce: those below 0.4 m/s at 2 substeps of 24 "
            "frames per second, and less with more substeps.",
            {.min = 0, .max = 1})
        .param("bulge_width", &LayerMatter::bulge_width,
               "Distance from the surface of what the layer touches up to which the layer bulges.",
               {.min = 0, .unit = "m"})
        .param("bulge_height", &LayerMatter::bulge_height,
               "Height of the bulge, as a share of the largest compression between the two bodies.",
               {.min = 0, .max = 10})
        .param("rigid", &LayerMatter::rigid,
               "Whether the layer is rigid: it does not deform, and others take its shape where "
               "they touch. Rigid layers stop each other.")
        .param(
            "bounce", &LayerMatter::bounce,
            "Bounce of a rigid layer that hits a rigid layer or a collider: its speed afterwards "
            "as a share of that before. Of two layers the larger value counts.",
            {.min = 0, .max = 1})
        .param("self_contact", &LayerMatter::self_contact,
               "Whether skeletons of this body that do not blend with each other collide.");
}

static void describe_substance(graph::ParamsOf<Substance>& p)
{
    p.param("name", &Substance::name,
            "Name of the substance. Layered joins bodies whose substances have the same name into "
            "one body, in the place of the first, and their pieces fuse by fusion_threshold. Each "
            "joined body lowers the index of later bodies by one. They need the same matter, "
            "volume and substance. Empty: a substance of its own.")
        .param("separates", &Substance::separates,
               "Whether pieces that come apart collide from then on, and blend again by fusion "
               "only. If on, Skeletons' blend = sum acts as smooth_groups in which all skeletons "
               "are of one part, and matter.self_contact is on. If off, both are as set: with "
               "blend = sum, pieces blend wherever they meet.")
        .param("stiffness", &Substance::stiffness,
               "Scale k of the forces that hold particles at their rest distance r0: "
               "k ((r0/r)^8 - (r0/r)^4) W, W = (1 - (r / (reach r0))^2)^2.",
               {.min = 0, .unit = "N"})
        .param("rest_distance", &Substance::rest_distance,
               "Distance between particles at which the forces vanish.", {.min = 1e-9, .unit = "m"})
        .param("friction", &Substance::friction,
               "Friction between particles in reach: force per relative velocity.",
               {.min = 0, .unit = "N s/m"})
        .param("reach", &Substance::reach,
               "Range of the forces between particles, in rest distances.", {.min = 1, .max = 100})
        .param("fusion_threshold", &Substance::fusion_threshold,
               "Contact pressure above which parts fuse. Parts that have separated fuse in no "
               "other way while `separates` is on.",
               {.min = 0, .unit = "Pa"})
        .param("fusion_time", &Substance::fusion_time, "Time for two skeletons to blend fully.",
               {.min = 0, .unit = "s"});
}

static void describe_volume(graph::ParamsOf<VolumeControl>& p)
{
    p.param("proportional", &VolumeControl::proportional,
            "Gain of the volume controller: the rate at which an error of volume is "
            "corrected. 0 turns volume control off.",
            {.min = 0, .unit = "1/s"})
        .param("derivative", &VolumeControl::derivative,
               "Share of the volume change by motion that is compensated in advance: 1 "
               "keeps up with steady motion, 0 lags behind it.",
               {.min = 0, .max = 2});
}

static void describe_muscle(graph::ParamsOf<Muscle>& p)
{
    p.param("skeleton", &Muscle::skeleton, "Index of the skeleton, counted from 0.", {.min = 0})
        .param("inflation", &Muscle::inflation,
               "Target volume of its territory, as a multiple of the rest volume; it "
               "multiplies the body's inflation. Keyframe it to flex.",
               {.min = 0.05, .max = 20});
}

static void describe_own_mass(graph::ParamsOf<OwnMass>& p)
{
    p.param("frame", &OwnMass::frame, "Index of the frame, counted from 0.", {.min = 0})
        .param("mass", &OwnMass::mass, "Its mass; 0: as density or `mass` say.",
               {.min = 0, .unit = "kg"})
        .param("inertia", &OwnMass::inertia,
               "Moments of inertia Ixx, Iyy and Izz about its centre of mass, along the axes of "
               "the world as it is drawn. Zeros here and in `products`: those of its shape, as "
               "heavy as its mass.",
               {.min = 0, .unit = "kg m^2"})
        .param("products", &OwnMass::products,
               "Elements Ixy, Iyz and Izx of the tensor of inertia: Ixy = -(integral of x y dm).",
               {.unit = "kg m^2"});
}

static void describe_pin(graph::ParamsOf<PinParams>& p)
{
    p.param("frame", &PinParams::frame,
            "Index of the frame that is held, counted from 0; -1: by place.", {.min = -1})
        .param("position", &PinParams::position,
               "Centre of the sphere in which frames, as drawn, are held: a particle's centre, a "
               "rigid body's centre of mass.",
               {.unit = "m"})
        .param("radius", &PinParams::radius, "Radius of that sphere.", {.min = 0, .unit = "m"})
        .param("translate", &PinParams::translate,
               "Translation of what is held from where the body's translate and rotate_degrees "
               "have it; keyframe it to pull.",
               {.unit = "m"});
}

// Version 2: what came apart blended again where Skeletons' blend was sum.
static void keep_blending(graph::Json& node)
{
    graph::Json* const params = node.find("params");
    const graph::Json* const base = params ? params->find("base") : nullptr;
    if (!base || !base->text() || *base->text() != "particles") return;
    graph::Json* const substance = graph::put_missing(*params, "substance", graph::Json::Object());
    if (substance) graph::put_missing(*substance, "separates", false);
}

// Version 1: volume.derivative was 0 by default and had no upper limit.
static void keep_derivative(graph::Json& node)
{
    graph::Json* const params = node.find("params");
    graph::Json* const volume = params ? params->find("volume") : nullptr;
    if (!volume) return;
    graph::Json* const derivative = graph::put_missing(*volume, "derivative", 0.0);
    if (derivative && derivative->number() && *derivative->number() > 2) derivative->is = 2.0;
}

// Where the body begins, and what moves it.
static void describe_motion(graph::NodeBuilder<Inputs, Outputs>& node)
{
    node.list("own_masses", &Inputs::own_masses, describe_own_mass,
              "Frames with a mass and an inertia of their own, in place of those that density or "
              "`mass` give them. Particles and masses of a net have no inertia.",
              {"base", {"rigid", "particles", "net"}})
        .list("pins", &Inputs::pins, describe_pin,
              "Frames that are held, or moved as keyed: neither contact nor force moves them. A "
              "rigid body turns with rotate_degrees only. Needs rigid_bodies = implicit in "
              "Layered.",
              {"base", {"rigid", "particles", "net"}})
        .param("translate", &Inputs::translate,
               "Translation from where the body is drawn; keyframe it to move a still body.",
               {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "Rotation about the world's origin: about x, then y, then z.", {.unit = "deg"})
        .param("velocity", &Inputs::velocity, "Initial velocity.", {.unit = "m/s"})
        .param("spin_degrees", &Inputs::spin_degrees,
               "Initial spin of the whole body about its centre of mass, around x, y and z.",
               {.unit = "deg/s"});
}

void add_to(graph::Registry& registry)
{
    auto node = registry.add("ImplicitLayer", 3, run);
    node.summary("Coats a base structure with an implicit layer: makes a body for Layered.")
        .upgrade(1,
                 "the default of volume.derivative was 0, and it had no upper limit; it is at most "
                 "2 now",
                 keep_derivative)
        .upgrade(2,
                 "pieces of base = particles that came apart blended again where Skeletons' blend "
                 "was sum: substance.separates is off in these documents",
                 keep_blending)
        .input("layer", &Inputs::layer, "The skeletons of the layer, from Skeletons.")
        .choice("base", &Inputs::base, {"still", "rigid", "particles", "net"},
                "What carries the layer. still: the body moves only by translate and "
                "rotate_degrees. rigid: each frame is a rigid body. particles: each frame is a "
                "particle of a soft substance. net: a mass-spring net. The points of point, "
                "segment and triangle skeletons are masses, points at one place are one mass, and "
                "skeletons stretch with their masses; Springs joins these. Its frames are the "
                "masses, numbered as their places first come in the list of skeletons.")
        .param("density", &Inputs::density,
               "Density: mass per volume of the skeletons' territories.",
               {.min = 1e-9, .unit = "kg/m^3"})
        .param("mass", &Inputs::mass,
               "Mass of the whole body, shared as density would share it; 0: by density.",
               {.min = 0, .unit = "kg"})
        .param(
            "seed_spacing", &Inputs::seed_spacing,
            "Distance between the samples of the surface that detect contacts and measure volumes.",
            {.min = 1e-9, .unit = "m"})
        .block("matter", &Inputs::matter, describe_matter, "Properties of the layer in contact.")
        .block("volume", &Inputs::volume, describe_volume,
               "Volume control: keeps the volume of each skeleton's territory.")
        .block("substance", &Inputs::substance, describe_substance, "Forces between particles.",
               {"base", {"particles"}});
    describe_motion(node);
    node.param("inflation", &Inputs::inflation,
               "Target volume, as a multiple of the rest volume; keyframe it to breathe. It "
               "needs `volume.proportional` above 0, 10 for example. The surface moves by at most "
               "half the layer's thickness.",
               {.min = 0.05, .max = 20})
        .list("muscles", &Inputs::muscles, describe_muscle,
              "Skeletons with a target volume of their own.")
        .colour("colour", &Inputs::colour, "Colour of the body in the mesh.")
        .prepare("body", &Inputs::body, build,
                 {"layer", "base", "density", "mass", "seed_spacing", "matter", "volume",
                  "substance", "own_masses"})
        .output("part", &Outputs::part, "The body, for Layered, Figure, Springs or Carry.");
}

}  // namespace nodes::implicit_layer
