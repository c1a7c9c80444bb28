#include "geometry/transform.hpp"
#include "graph/json.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered.hpp"

#include <fmt/format.h>

#include <algorithm>

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

struct Inputs {
    graph::Wire<geometry::ImplicitLayer> layer;
    BaseKind base = BaseKind::rigid;
    double density = 1000;
    double seed_spacing = 0.02;
    LayerMatter matter;
    VolumeControl volume;
    Substance substance;
    Vec3 translate{0, 0, 0};
    Vec3 rotate_degrees{0, 0, 0};
    Vec3 velocity{0, 0, 0};
    double inflation = 1;
    std::vector<Muscle> muscles;
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};
    std::shared_ptr<const LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

static LayeredBody build(const Inputs& in)
{
    LayeredBody body = physics::make_layered_body(*in.layer, in.base, in.density, in.seed_spacing);
    body.matter = in.matter;
    body.control = in.volume;
    body.base.substance = in.substance;
    return body;
}

// Particles that start too near to each other, as points at random do, fly apart at once.
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
    context.warn(fmt::format("particles start {:.2g} m apart where substance.rest_distance is "
                             "{:.2g} m: such pairs fly apart at once. Spread them more evenly, or "
                             "give them a rest_distance of {:.2g} m or less",
                             nearest, wanted, nearest / 0.6));
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    physics::LayeredPart part;
    part.body = in.body;
    part.pose = geometry::placement(in.translate, in.rotate_degrees, Vec3::Ones(), Vec3::Zero());
    part.velocity = in.velocity;
    part.inflation = in.inflation;
    const std::size_t skeletons = in.body->layer.skeletons.size();
    for (const Muscle& muscle : in.muscles) {
        const auto s = static_cast<std::size_t>(muscle.skeleton);
        if (s >= skeletons) {
            throw std::invalid_argument(fmt::format(
                "a muscle is skeleton {} of a layer that has {}; they are counted from 0", s,
                skeletons));
        }
        part.muscle.resize(skeletons, 1);
        part.muscle[s] *= muscle.inflation;
    }
    const bool inflates =
        in.inflation != 1 || std::any_of(in.muscles.begin(), in.muscles.end(),
                                         [](const Muscle& m) { return m.inflation != 1; });
    if (inflates && in.volume.proportional == 0) {
        context.warn("inflation does nothing while volume.proportional is 0, which is off: give it "
                     "10 per second, say");
    }
    warn_of_crowding(*in.body, context);
    part.colour = in.colour;
    return {std::move(part)};
}

static void describe_matter(graph::ParamsOf<LayerMatter>& p)
{
    p.param("stiffness", &LayerMatter::stiffness,
            "Pressure of the layer for each unit of field that it is compressed by.",
            {.min = 0, .unit = "Pa"})
        .param(
            "friction", &LayerMatter::friction,
            "Traction on a contact for each metre a second of relative velocity; along a collider "
            "no more than its own coefficient of the pressure. What should stay where it lies "
            "wants much: it creeps by the traction that it needs over this.",
            {.min = 0, .unit = "Pa s/m"})
        .param("bulge_width", &LayerMatter::bulge_width,
               "How far beyond a contact the layer bulges.", {.min = 0, .unit = "m"})
        .param("bulge_height", &LayerMatter::bulge_height,
               "Height of the bulge as a share of the largest compression.", {.min = 0, .max = 10})
        .param("rigid", &LayerMatter::rigid,
               "It does not deform: others take its shape where they touch it.")
        .param("self_contact", &LayerMatter::self_contact,
               "Skeletons that do not blend with each other collide.");
}

static void describe_substance(graph::ParamsOf<Substance>& p)
{
    p.param("stiffness", &Substance::stiffness,
            "Scale of the force that holds particles at their distance.", {.min = 0, .unit = "N"})
        .param("rest_distance", &Substance::rest_distance, "The distance they seek.",
               {.min = 1e-9, .unit = "m"})
        .param("friction", &Substance::friction,
               "Force against the relative velocity of particles in reach.",
               {.min = 0, .unit = "N s/m"})
        .param("reach", &Substance::reach,
               "How far particles act on each other, in rest distances.", {.min = 1, .max = 100})
        .param("fusion_threshold", &Substance::fusion_threshold,
               "Parts that press harder than this fuse; what came apart never does otherwise.",
               {.min = 0, .unit = "Pa"})
        .param("fusion_time", &Substance::fusion_time,
               "How long two skeletons take to blend fully.", {.min = 0, .unit = "s"});
}

// Version 1 did not meet changes in advance unless told to, and took any share.
static void keep_derivative(graph::Json& node)
{
    graph::Json* const params = node.find("params");
    graph::Json* const volume = params ? params->find("volume") : nullptr;
    if (!volume) return;
    graph::Json* const derivative = graph::put_missing(*volume, "derivative", 0.0);
    if (derivative && derivative->number() && *derivative->number() > 2) derivative->is = 2.0;
}

void add_to(graph::Registry& registry)
{
    registry.add("ImplicitLayer", 2, run)
        .summary("Coats a base structure with an implicit layer: a body for Layered.")
        .upgrade(1, "unless said, volume.derivative was 0; it is at most 2 now", keep_derivative)
        .input("layer", &Inputs::layer, "Its skeletons, from Skeletons.")
        .choice("base", &Inputs::base, {"still", "rigid", "particles"},
                "What carries the layer. still moves only by translate and rotate_degrees; each "
                "frame of rigid is a rigid body; each frame of particles a particle of a soft "
                "substance.")
        .param("density", &Inputs::density,
               "Mass for each volume that the skeletons' territories hold.",
               {.min = 1e-9, .unit = "kg/m^3"})
        .param("seed_spacing", &Inputs::seed_spacing,
               "Distance between the samples of the surface that find contacts and volumes.",
               {.min = 1e-9, .unit = "m"})
        .block("matter", &Inputs::matter, describe_matter, "How it behaves in contact.")
        .block<VolumeControl>(
            "volume", &Inputs::volume,
            [](graph::ParamsOf<VolumeControl>& p) {
                p.param("proportional", &VolumeControl::proportional,
                        "How fast an error of volume is mended; 0 leaves volume "
                        "alone.",
                        {.min = 0, .unit = "1/s"})
                    .param("derivative", &VolumeControl::derivative,
                           "Share of the change by motion that is met in advance: 1 keeps up with "
                           "steady motion, 0 lags behind it.",
                           {.min = 0, .max = 2});
            },
            "Keeps the volume of each skeleton's territory.")
        .block("substance", &Inputs::substance, describe_substance,
               "How particles act on each other.", {"base", {"particles"}})
        .param("translate", &Inputs::translate,
               "Moves the body from where it is drawn; keyframed, a still body follows.",
               {.unit = "m"})
        .param("rotate_degrees", &Inputs::rotate_degrees,
               "Turns it about the world's origin, about x, then y, then z.", {.unit = "deg"})
        .param("velocity", &Inputs::velocity, "What it starts with.", {.unit = "m/s"})
        .param("inflation", &Inputs::inflation,
               "The volume it seeks, as a share of its own; keyframe it to breathe. The surface "
               "moves by at most half the layer's thickness.",
               {.min = 0.05, .max = 20})
        .list<Muscle>(
            "muscles", &Inputs::muscles,
            [](graph::ParamsOf<Muscle>& p) {
                p.param("skeleton", &Muscle::skeleton, "Which, counted from 0.", {.min = 0})
                    .param("inflation", &Muscle::inflation,
                           "The volume that its territory seeks, as a share of its own, besides "
                           "the body's; keyframe it to flex.",
                           {.min = 0.05, .max = 20});
            },
            "Skeletons whose volume changes by itself.")
        .colour("colour", &Inputs::colour, "Its colour in the mesh.")
        .prepare("body", &Inputs::body, build,
                 {"layer", "base", "density", "seed_spacing", "matter", "volume", "substance"})
        .output("part", &Outputs::part, "The body, for Layered or Figure.");
}

}  // namespace nodes::implicit_layer
