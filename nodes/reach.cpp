#include "physics/layered_bodies/inverse_kinematics.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/led_pins.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::reach {

using geometry::Vec3;

struct Goal {
    int frame = 1;
    Vec3 point{0, 0, 0};
    Vec3 target{0, 0, 0};
};
struct Inputs {
    graph::Wire<physics::LayeredPart> part;
    std::vector<Goal> goals;
    std::shared_ptr<const physics::LayeredBody> body;
    graph::Wire<physics::LayeredPart> last;
};
struct Outputs {
    physics::LayeredPart part;
    double miss = 0;
};

static physics::LayeredBody build(const Inputs& in)
{
    physics::LayeredBody body = *in.part->body;
    body.base.kind = physics::BaseKind::still;
    return body;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const physics::Base& base = in.body->base;
    std::vector<double> start;
    if (in.last && in.last->frames.size() == base.frames.size()) {
        for (const physics::Hinge& hinge : base.hinges) {
            start.push_back(
                physics::hinge_angle(hinge, in.last->frames[hinge.a], in.last->frames[hinge.b]));
        }
    }
    std::vector<physics::PoseGoal> goals;
    for (const Goal& goal : in.goals) {
        goals.push_back({static_cast<std::uint32_t>(goal.frame), goal.point, goal.target});
    }
    physics::SolvedPose reached = physics::inverse_kinematics(base, in.part->pose, goals, start);
    // From the last pose the solver may be stuck against hinge limits: then a jump is better.
    if (!start.empty() && reached.miss > 1e-3 * physics::figure_size(base, goals)) {
        physics::SolvedPose anew = physics::inverse_kinematics(base, in.part->pose, goals, {});
        if (anew.miss < 0.1 * reached.miss) reached = std::move(anew);
    }
    Outputs out{*in.part, reached.miss};
    leave_pins_out("Reach", out.part, context);
    out.part.body = in.body;
    out.part.frames = reached.frames;
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Reach", 1, run)
        .summary("Poses a figure by inverse kinematics: turns its hinges so that points of it "
                 "reach targets. Nothing else moves the figure.",
                 {"inverse kinematics", "ik"})
        .input("part", &Inputs::part,
               "The figure, from Figure. Its frame 0 stays where it is placed.")
        .list<Goal>(
            "goals", &Inputs::goals,
            [](graph::ParamsOf<Goal>& p) {
                p.param("frame", &Goal::frame, "Index of the frame that carries the point.",
                        {.min = 0})
                    .param("point", &Goal::point, "The point, in the pose as drawn.", {.unit = "m"})
                    .param("target", &Goal::target,
                           "Target of the point; keyframe it to lead the figure.", {.unit = "m"});
            },
            "The points and their targets. If not all targets can be reached, the error is shared "
            "evenly. A figure that is stuck against its limits starts again from the pose as "
            "drawn.")
        .prepare("body", &Inputs::body, build, {"part"})
        .output("part", &Outputs::part, "The figure in its pose, for Layered.")
        .output("miss", &Outputs::miss, "Largest distance of a point from its target, m.")
        .previous("part", &Inputs::last);
}

}  // namespace nodes::reach
