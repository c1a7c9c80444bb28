#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/part_joint.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace nodes::joint {

using geometry::Vec3;
using physics::PartJointKind;

struct Inputs {
    std::vector<graph::Wire<geometry::Cubes>> cubes;
    PartJointKind kind = PartJointKind::ball;
    Vec3 position{0, 0, 0};
    Vec3 axis{0, 1, 0};
    double size = 0;
    double reach = 0;
};
struct Outputs {
    physics::PartJoint joint;
};

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults;
    if (const std::size_t links = setting.links_of("cubes"); links > 2) {
        faults.push_back({"cubes", fmt::format("a joint joins two parts, found {} links: link the "
                                               "two models, or the one that has both parts",
                                               links)});
    }
    if (in.kind == PartJointKind::hinge && in.axis.isZero(0)) {
        faults.push_back({"axis", "a hinge turns about its axis: expected one that is not (0, 0, "
                                  "0), as (0, 1, 0) for a door"});
    }
    return faults;
}

static void warn_of_others(std::size_t others, const Vec3& p, const graph::Context& context)
{
    if (others == 0) return;
    context.warn(fmt::format(
        "{} of `cubes` also {} cubes at ({:.4g}, {:.4g}, {:.4g}), and {} not joined: move "
        "position to where two parts alone meet, or join the others by a Joint of their own",
        others == 1 ? "one more part" : fmt::format("{} more parts", others),
        others == 1 ? "has" : "have", p.x(), p.y(), p.z(), others == 1 ? "is" : "are"));
}

static void warn_of_width(const Inputs& in, const physics::JointDoubts& doubts,
                          const graph::Context& context)
{
    for (std::size_t side = 0; side < 2; ++side) {
        if (!doubts.too_wide(side)) continue;
        const double edge = in.cubes[std::min(side, in.cubes.size() - 1)]->size;
        context.warn(fmt::format(
            "size = {:.3g} m reaches {:.3g} m beyond part {}, whose cubes have edges of {:.3g} m. "
            "Unless it is rigid, its outermost cubes bend and it hangs loose: set a smaller size, "
            "or 0 for four edges of the smaller cubes",
            in.size, doubts.outside[side] * edge, side + 1, edge));
    }
}

static void warn_of_loose(const physics::JointDoubts& doubts, const graph::Context& context)
{
    if (doubts.loose == 0) return;
    context.warn(fmt::format("{} of {} parts of `cubes` {} glued to none, as no other comes within "
                             "reach: raise reach, or leave {} out of `cubes`",
                             doubts.loose, doubts.parts, doubts.loose == 1 ? "is" : "are",
                             doubts.loose == 1 ? "it" : "them"));
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    physics::JointDoubts doubts;
    Outputs out{
        physics::make_joint(in.cubes, {in.kind, in.position, in.axis, in.size, in.reach}, &doubts)};
    warn_of_others(doubts.others, in.position, context);
    warn_of_width(in, doubts, context);
    warn_of_loose(doubts, context);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Joint", 1, run)
        .summary("Keeps two parts together at a place by a ball joint, a hinge or a weld, or glues "
                 "parts wherever they touch.",
                 {"constraint", "hinge", "ball joint", "weld", "glue", "attach", "rope", "chain",
                  "ragdoll", "pin constraint", "rigid body constraint"})
        .inputs(
            "cubes", &Inputs::cubes,
            "The cubes at rest of the parts. Two links: the nearest part of each is joined. "
            "One: its two nearest parts. Glue: all parts of one link, or each part of the first "
            "with each of the second. A part is what cubes are that hang together.",
            graph::Need::required)
        .check(check)
        .choice("kind", &Inputs::kind, {"ball", "hinge", "weld", "glue"},
                "What the parts may do. ball: turn freely about the position. hinge: turn about an "
                "axis through it. weld: nothing, at the position. glue: nothing, wherever their "
                "cubes touch or overlap. A joint neither rubs nor breaks. Parts that overlap at "
                "rest do not collide; others do, also beside a joint.")
        .param("position", &Inputs::position,
               "Where the joint is, in the rest shape of both parts.", {.unit = "m"},
               {"kind", {"ball", "hinge", "weld"}})
        .param("axis", &Inputs::axis, "Direction of the axis at rest, of any length.", {},
               {"kind", {"hinge"}})
        .param("size", &Inputs::size,
               "Length of the hinge, or diagonal of the cube whose corners are welded, centred on "
               "the position; 0: four edges of the smaller cubes. A longer hinge twists less in "
               "soft parts, as long as it is within both.",
               {.min = 0, .unit = "m"}, {"kind", {"hinge", "weld"}})
        .param(
            "reach", &Inputs::reach,
            "Largest distance from the position to the cubes of either part; 0: the edge of "
            "one of its cubes. Of glue: between corners of one part and cubes of the other; 0: a "
            "quarter of the smaller edge, and at most two of it. What is between is bridged "
            "rigidly.",
            {.min = 0, .unit = "m"})
        .output("joint", &Outputs::joint, "The joint, for input `joints` of Simulate.");
}

}  // namespace nodes::joint
