#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered.hpp"

#include <fmt/format.h>

#include <algorithm>
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

// Throws where two hinges join the same two frames about different axes: neither could turn.
static void check_pairs(const std::vector<Joint>& hinges)
{
    for (std::size_t i = 0; i < hinges.size(); ++i) {
        for (std::size_t j = i + 1; j < hinges.size(); ++j) {
            const Joint &p = hinges[i], &q = hinges[j];
            if (std::minmax(p.a, p.b) != std::minmax(q.a, q.b)) continue;
            const Vec3 along = p.axis.normalized();
            constexpr double parallel = 1e-6, coincident = 1e-6;
            const bool one_axis = along.cross(q.axis.normalized()).norm() < parallel &&
                                  along.cross(q.point - p.point).norm() < coincident;
            if (one_axis) continue;
            throw std::invalid_argument(fmt::format(
                "hinges {} and {} of {} both join frames {} and {}, about different axes: together "
                "they let neither turn. Put a small frame between them, with one hinge to each",
                i + 1, j + 1, hinges.size(), p.a, p.b));
        }
    }
}

static physics::LayeredBody build(const Inputs& in)
{
    check_pairs(in.hinges);
    physics::LayeredBody body = *in.part->body;
    for (const Joint& j : in.hinges) {
        if (j.lowest_degrees > j.highest_degrees) {
            throw std::invalid_argument(fmt::format("hinge {} of {}: expected lowest_degrees to be "
                                                    "at most highest_degrees, found {} and {}",
                                                    &j - in.hinges.data() + 1, in.hinges.size(),
                                                    j.lowest_degrees, j.highest_degrees));
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
        .summary("Joins the frames of a rigid body by hinges, as the limbs of a figure.",
                 {"ragdoll", "skeleton", "rig", "hinge", "joint", "character", "armature", "bones"})
        .input("part", &Inputs::part, "A body with base = rigid and a frame for each limb.")
        .list<Joint>(
            "hinges", &Inputs::hinges,
            [](graph::ParamsOf<Joint>& p) {
                p.param("a", &Joint::a, "Index of the first frame.", {.min = 0})
                    .param("b", &Joint::b,
                           "Index of the second frame. The hinge angle is that of b relative to a.",
                           {.min = 0})
                    .param("point", &Joint::point, "A point on the axis, in the pose as drawn.",
                           {.unit = "m"})
                    .param("axis", &Joint::axis, "Direction of the axis, in the pose as drawn.")
                    .param("lowest_degrees", &Joint::lowest_degrees,
                           "Lower limit of the hinge angle; the pose as drawn is 0.",
                           {.min = -180, .max = 180, .unit = "deg"})
                    .param("highest_degrees", &Joint::highest_degrees,
                           "Upper limit of the hinge angle.",
                           {.min = -180, .max = 180, .unit = "deg"})
                    .param("stiffness", &Joint::stiffness,
                           "Torque towards rest_degrees per radian of deviation.",
                           {.min = 0, .unit = "N m/rad"})
                    .param("damping", &Joint::damping,
                           "Torque against the rotation, per radian per second.",
                           {.min = 0, .unit = "N m s/rad"})
                    .param("rest_degrees", &Joint::rest_degrees,
                           "Rest angle: the stiffness pulls the hinge towards it.",
                           {.min = -180, .max = 180, .unit = "deg"});
            },
            "The hinges, each between two frames.")
        .prepare("body", &Inputs::body, build, {"part", "hinges"})
        .output("part", &Outputs::part, "The jointed body, for Layered or Reach.");
}

}  // namespace nodes::figure
