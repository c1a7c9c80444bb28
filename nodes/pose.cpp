#include "graph/types/node_builder.hpp"
#include "nodes/led_pins.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/figure_pose.hpp"
#include "physics/layered_bodies/layered.hpp"

#include <fmt/format.h>

#include <numbers>

namespace nodes::pose {

using geometry::Vec3;

constexpr double radian = std::numbers::pi / 180;

struct HingeAngle {
    int hinge = 0;
    double degrees = 0;
};
struct JointValue {
    int joint = 0;
    Vec3 rotate_degrees{0, 0, 0};
    double first_degrees = 0, second_degrees = 0;
    double way = 0;
};

struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    std::vector<HingeAngle> hinges;
    std::vector<JointValue> joints;
    std::shared_ptr<const physics::LayeredBody> body;
};
struct Outputs {
    physics::LayeredPart part;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    body.base.kind = physics::BaseKind::still;
    return body;
}

static std::size_t index(int number, std::size_t count, const char* what)
{
    const auto i = static_cast<std::size_t>(number);
    if (i < count) return i;
    throw std::invalid_argument(
        fmt::format("the pose names {} {}, but the figure has {} of them, counted from 0", what,
                    number, count));
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const physics::Base& base = in.body->base;
    std::vector<double> angle(base.hinges.size(), 0);
    for (const HingeAngle& h : in.hinges) {
        angle[index(h.hinge, angle.size(), "hinge")] = h.degrees * radian;
    }
    std::vector<physics::JointPose> pose(base.joints.size());
    for (const JointValue& v : in.joints) {
        const std::size_t j = index(v.joint, pose.size(), "joint");
        const bool slider = base.joints[j].kind == physics::JointKind::slider;
        pose[j] = {radian * v.rotate_degrees, slider ? v.way : radian * v.first_degrees,
                   radian * v.second_degrees};
    }
    Outputs out{*in.part};
    leave_pins_out("Pose", out.part, context);
    out.part.body = in.body;
    out.part.frames = physics::figure_pose(base, in.part->pose, angle, pose);
    return out;
}

static void describe_angle(graph::ParamsOf<HingeAngle>& p)
{
    p.param("hinge", &HingeAngle::hinge, "Index of the hinge, counted from 0.", {.min = 0})
        .param("degrees", &HingeAngle::degrees,
               "Angle of the hinge; the pose as drawn is 0. Keyframe it to move the limb.",
               {.unit = "deg"});
}

static void describe_joint(graph::ParamsOf<JointValue>& p)
{
    p.param("joint", &JointValue::joint, "Index of the joint, counted from 0.", {.min = 0})
        .param("rotate_degrees", &JointValue::rotate_degrees,
               "Rotation of a ball joint about x, then y, then z, as drawn in its first frame.",
               {.unit = "deg"})
        .param("first_degrees", &JointValue::first_degrees,
               "Angle of a two-axis joint about the axis that its first frame carries.",
               {.unit = "deg"})
        .param("second_degrees", &JointValue::second_degrees,
               "Angle of a two-axis joint about the axis that its second frame carries.",
               {.unit = "deg"})
        .param("way", &JointValue::way, "Way of a slider; the pose as drawn is 0.", {.unit = "m"});
}

void add_to(graph::Registry& registry)
{
    registry.add("Pose", 1, run)
        .summary("Poses a figure by the angles of its hinges and joints: keyframe them to move it. "
                 "Nothing else moves the figure.",
                 {"forward kinematics", "fk", "animate", "walk", "keyframe"})
        .input("part", &Inputs::part,
               "The figure, from Figure. Its frame 0 is where translate and rotate_degrees of its "
               "ImplicitLayer put it; keyframe those to move the whole.")
        .list("hinges", &Inputs::hinges, describe_angle,
              "Angles of hinges. Those that are not listed stay as drawn. Limits do not hold them.")
        .list("joints", &Inputs::joints, describe_joint,
              "Values of joints. Those that are not listed stay as drawn.")
        .prepare("body", &Inputs::body, build, {"part"})
        .output("part", &Outputs::part, "The figure in its pose, for Layered.");
}

}  // namespace nodes::pose
