#include "physics/bricks/part_groups.hpp"

#include "physics/bricks/held_corners.hpp"

namespace physics {

PartGroups::PartGroups(const Stage& stage)
    : held(axes_of_parts(stage.frame.loads.pins, stage.frame.body)), sets(held.size())
{
    add(stage, stage.contacts);
    add_touching(stage);
}

// Rigid parts of a stack touch each other before they press.
void PartGroups::add_touching(const Stage& stage)
{
    constexpr double just = 1e-3;  // sizes of the touch
    const CornerBody& body = stage.frame.body;
    if (stage.rigid.none()) return;
    const auto is_rigid = [&](std::uint32_t slot) {
        return stage.rigid.of_corner(slot) != RigidBodies::not_rigid;
    };
    for (const PlaneTouch& touch : stage.touches) {
        if (touch.count <= 8 || !(touch.gap(stage.began.data()) < just * touch.size)) continue;
        if (!is_rigid(touch.corners[0]) || !is_rigid(touch.corners[8])) continue;
        sets.join(body.part_of(touch.corners[0]), body.part_of(touch.corners[8]));
    }
}

void PartGroups::add(const Stage& stage, const std::vector<PointContact>& contacts)
{
    const CornerBody& body = stage.frame.body;
    for (const PointContact& c : contacts) {
        const std::uint32_t part = body.part_of(c.corners[0]);
        if (c.count > 8)
            sets.join(part, body.part_of(c.corners[8]));
        else
            held[part] = all_axes;
    }
}

std::vector<std::uint8_t> PartGroups::with_all(const std::vector<std::uint8_t>& of)
{
    std::vector<std::uint8_t> out(of.size(), 0);
    for (std::uint32_t p = 0; p < of.size(); ++p) out[sets.root(p)] |= of[p];
    for (std::uint32_t p = 0; p < of.size(); ++p) out[p] = out[sets.root(p)];
    return out;
}

}  // namespace physics
