#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered.hpp"

#include <fmt/format.h>

#include <numbers>

namespace nodes::figure {

using geometry::Vec3;

constexpr double radian = std::numbers::pi / 180;

struct Joint {
    int a = 0, b = 1;
    Vec3 point{0, 0, 0};
    Vec3 axis{0, 0, 1};
    double lowest_degrees = -180, highest_degrees = 180;
    double stiffness = 0, damping = 0, rest_degrees = 0;
};

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    std::vector<Joint> hinges;
    std::shared_ptr<const physics::LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    for (const Joint& j : in.hinges) {
        if (j.lowest_degrees > j.highest_degrees) {
            throw std::invalid_argument(fmt::format(
                "hinge {} of {}: expected lowest_degrees below highest_degrees, found "
                "{} and {}",
                &j - in.hinges.data() + 1, in.hinges.size(), j.lowest_degrees, j.highest_degrees));
        }
        physics::add_hinge(body.base, static_cast<std::uint32_t>(j.a),
                           static_cast<std::uint32_t>(j.b), j.point, j.axis);
        physics::Hinge& hinge = body.base.hinges.back();
        hinge.lowest = j.lowest_degrees * radian;
        hinge.highest = j.highest_degrees * radian;
        hinge.stiffness = j.stiffness;
        hinge.damping = j.damping;
        hinge.rest = j.rest_degrees * radian;
    }
    return body;
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{*in.part};
    out.part.body = in.body;
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Figure", 1, run)
        .summary("Joins the frames of a rigid body by hinges, as the limbs of a figure.")
        .input("part", &Inputs::part, "A body of base = rigid with a frame a limb.")
        .list<Joint>(
            "hinges", &Inputs::hinges,
            [](graph::ParamsOf<Joint>& p) {
                p.param("a", &Joint::a, "One frame.", {.min = 0})
                    .param("b", &Joint::b, "The other; its angle is counted from a.", {.min = 0})
                    .param("point", &Joint::point, "A point of the hinge, as drawn.", {.unit = "m"})
                    .param("axis", &Joint::axis, "Its direction, as drawn.")
                    .param("lowest_degrees", &Joint::lowest_degrees,
                           "It stops here; the figure as drawn is at 0.",
                           {.min = -180, .max = 180, .unit = "deg"})
                    .param("highest_degrees", &Joint::highest_degrees, "And here.",
                           {.min = -180, .max = 180, .unit = "deg"})
                    .param("stiffness", &Joint::stiffness,
                           "Torque towards rest_degrees for each radian away.",
                           {.min = 0, .unit = "N m/rad"})
                    .param("damping", &Joint::damping, "Torque against each radian a second.",
                           {.min = 0, .unit = "N m s/rad"})
                    .param("rest_degrees", &Joint::rest_degrees, "Where the stiffness draws it.",
                           {.min = -180, .max = 180, .unit = "deg"});
            },
            "The hinges.")
        .prepare("body", &Inputs::body, build, {"part", "hinges"})
        .output("part", &Outputs::part, "The jointed body.");
}

}  // namespace nodes::figure
