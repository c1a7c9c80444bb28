#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace nodes::figure {

using geometry::Vec3;

constexpr double radian = std::numbers::pi / 180;

struct Hinge {
    int a = 0, b = 1;
    Vec3 point{0, 0, 0};
    Vec3 axis{0, 0, 1};
    double lowest_degrees = -180, highest_degrees = 180;
    double stiffness = 0, damping = 0, rest_degrees = 0;
};

struct Joint {
    physics::JointKind kind = physics::JointKind::ball;
    int a = 0, b = 1;
    Vec3 point{0, 0, 0};
    Vec3 axis{0, 1, 0}, second_axis{0, 0, 1};
    double cone_degrees = 180;
    double lowest = -1000, highest = 1000;
    double stiffness = 0, damping = 0;
};

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    std::vector<Hinge> hinges;
    std::vector<Joint> joints;
    std::shared_ptr<const physics::LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

// Throws where two hinges join the same two frames about different axes: neither could turn.
static void check_pairs(const std::vector<Hinge>& hinges)
{
    for (std::size_t i = 0; i < hinges.size(); ++i) {
        for (std::size_t j = i + 1; j < hinges.size(); ++j) {
            const Hinge &p = hinges[i], &q = hinges[j];
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

static void add_joint(const Joint& j, std::size_t number, physics::Base& base)
{
    if (j.lowest > j.highest) {
        throw std::invalid_argument(
            fmt::format("joint {} (counted from 1): expected lowest to be at most highest, found "
                        "{} and {}",
                        number + 1, j.lowest, j.highest));
    }
    physics::Joint& joint = physics::add_joint(
        base, j.kind, j.a < 0 ? physics::Joint::world : static_cast<std::uint32_t>(j.a),
        static_cast<std::uint32_t>(j.b), j.point, j.axis, j.second_axis);
    joint.stiffness = j.stiffness;
    joint.damping = j.damping;
    if (j.kind == physics::JointKind::ball && j.cone_degrees < 180) {
        joint.cone = j.cone_degrees * radian;
    }
    if (j.kind == physics::JointKind::slider && (j.lowest > -1000 || j.highest < 1000)) {
        joint.lowest = j.lowest;
        joint.highest = j.highest;
    }
}

static physics::LayeredBody build(const Inputs& in)
{
    check_pairs(in.hinges);
    physics::LayeredBody body = *in.part->body;
    for (const Hinge& j : in.hinges) {
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
    for (std::size_t i = 0; i < in.joints.size(); ++i) add_joint(in.joints[i], i, body.base);
    return body;
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{*in.part};
    out.part.body = in.body;
    return out;
}

static void describe_joint(graph::ParamsOf<Joint>& p)
{
    p.choice(
         "kind", &Joint::kind, {"ball", "slider", "two_axis"},
         "What the joint allows. ball: all rotations about the point. slider: translation along "
         "the axis. two_axis: rotation about two axes, as a universal joint.")
        .param("a", &Joint::a, "Index of the first frame; -1: the world, fixed in space.",
               {.min = -1})
        .param("b", &Joint::b, "Index of the second frame.", {.min = 0})
        .param("point", &Joint::point, "Point of the joint, in the pose as drawn.", {.unit = "m"})
        .param("axis", &Joint::axis,
               "Direction in the pose as drawn: middle of a ball's cone, way of a slider, or axis "
               "of two that the first frame carries.")
        .param("second_axis", &Joint::second_axis,
               "The axis of two that the second frame carries, at a right angle to the other.", {},
               {"kind", {"two_axis"}})
        .param("cone_degrees", &Joint::cone_degrees,
               "Largest angle between the axis as either frame carries it; 180 for no limit.",
               {.min = 0, .max = 180, .unit = "deg"}, {"kind", {"ball"}})
        .param("lowest", &Joint::lowest, "Lower limit of the way; the pose as drawn is 0.",
               {.min = -1000, .max = 1000, .unit = "m"}, {"kind", {"slider"}})
        .param("highest", &Joint::highest, "Upper limit of the way.",
               {.min = -1000, .max = 1000, .unit = "m"}, {"kind", {"slider"}})
        .param("stiffness", &Joint::stiffness,
               "Force (slider, N/m) or torque (others, N m/rad) towards the pose as drawn, per "
               "metre or radian of deviation.",
               {.min = 0})
        .param("damping", &Joint::damping,
               "Force (slider, N s/m) or torque (others, N m s/rad) against the motion, per metre "
               "or radian per second.",
               {.min = 0});
}

void add_to(graph::Registry& registry)
{
    registry.add("Figure", 1, run)
        .summary("Joins the frames of a rigid body by hinges and other joints, as the limbs of a "
                 "figure.",
                 {"ragdoll", "skeleton", "rig", "hinge", "joint", "character", "armature", "bones"})
        .input(
            "part", &Inputs::part,
            "A body with a frame for each limb, and base = rigid. For Pose and Reach, which lead "
            "it, base = still does too.")
        .list<Hinge>(
            "hinges", &Inputs::hinges,
            [](graph::ParamsOf<Hinge>& p) {
                p.param("a", &Hinge::a, "Index of the first frame.", {.min = 0})
                    .param("b", &Hinge::b,
                           "Index of the second frame. The hinge angle is that of b relative to a, "
                           "about the axis by the right-hand rule.",
                           {.min = 0})
                    .param("point", &Hinge::point, "A point on the axis, in the pose as drawn.",
                           {.unit = "m"})
                    .param("axis", &Hinge::axis, "Direction of the axis, in the pose as drawn.")
                    .param("lowest_degrees", &Hinge::lowest_degrees,
                           "Lower limit of the hinge angle; the pose as drawn is 0.",
                           {.min = -180, .max = 180, .unit = "deg"})
                    .param("highest_degrees", &Hinge::highest_degrees,
                           "Upper limit of the hinge angle.",
                           {.min = -180, .max = 180, .unit = "deg"})
                    .param("stiffness", &Hinge::stiffness,
                           "Torque towards rest_degrees per radian of deviation.",
                           {.min = 0, .unit = "N m/rad"})
                    .param("damping", &Hinge::damping,
                           "Torque against the rotation, per radian per second.",
                           {.min = 0, .unit = "N m s/rad"})
                    .param("rest_degrees", &Hinge::rest_degrees,
                           "Rest angle: the stiffness pulls the hinge towards it.",
                           {.min = -180, .max = 180, .unit = "deg"});
            },
            "The hinges, each between two frames.")
        .list("joints", &Inputs::joints, describe_joint,
              "Joints other than hinges, each between two frames or one frame and the world. "
              "Reach knows hinges only.")
        .prepare("body", &Inputs::body, build, {"part", "hinges", "joints"})
        .output("part", &Outputs::part, "The jointed body, for Layered, Pose or Reach.");
}

}  // namespace nodes::figure
