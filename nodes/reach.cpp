#include "physics/reach.hpp"

#include "graph/node_type.hpp"
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

// m, between the frames that are farthest apart along an axis, as drawn.
static double size_of(const physics::Base& base)
{
    geometry::Box box;
    for (const geometry::Transform& frame : base.frames) box.add(frame.translation());
    return box.size().maxCoeff();
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    const physics::Base& base = in.body->base;
    std::vector<double> start;
    if (in.last && in.last->frames.size() == base.frames.size()) {
        for (const physics::Hinge& hinge : base.hinges) {
            start.push_back(
                physics::hinge_angle(hinge, in.last->frames[hinge.a], in.last->frames[hinge.b]));
        }
    }
    std::vector<physics::ReachGoal> goals;
    for (const Goal& goal : in.goals) {
        goals.push_back({static_cast<std::uint32_t>(goal.frame), goal.point, goal.target});
    }
    physics::Reached reached = physics::reach(base, in.part->pose, goals, start);
    // From where it was it may go nowhere but against its limits; a jump is better than that.
    if (!start.empty() && reached.miss > 1e-3 * size_of(base)) {
        physics::Reached anew = physics::reach(base, in.part->pose, goals, {});
        if (anew.miss < 0.1 * reached.miss) reached = std::move(anew);
    }
    Outputs out{*in.part, reached.miss};
    out.part.body = in.body;
    out.part.frames = reached.frames;
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Reach", 1, run)
        .summary("Turns a figure's hinges so that points of it reach targets (inverse kinematics): "
                 "the figure is then moved by this alone.")
        .input("part", &Inputs::part, "A figure, from Figure; its frame 0 stays where it is put.")
        .list<Goal>(
            "goals", &Inputs::goals,
            [](graph::ParamsOf<Goal>& p) {
                p.param("frame", &Goal::frame, "The frame that carries the point.", {.min = 0})
                    .param("point", &Goal::point, "The point, where it is as the figure is drawn.",
                           {.unit = "m"})
                    .param("target", &Goal::target, "Where it should be; keyframe it to lead it.",
                           {.unit = "m"});
            },
            "What should be where. Goals that cannot all be met are missed evenly. A figure that "
            "is stuck against its limits starts anew from the pose it is drawn in.")
        .prepare("body", &Inputs::body, build, {"part"})
        .output("part", &Outputs::part, "The figure in its pose, for Layered.")
        .output("miss", &Outputs::miss, "How far the worst goal is missed, m.")
        .previous("part", &Inputs::last);
}

}  // namespace nodes::reach
