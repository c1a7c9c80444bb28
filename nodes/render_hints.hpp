#pragma once

// What Render says before a cook of pictures that are hardly meant: a floor on which nothing lands,
// a camera that swims.

#include "graph/types/node_type.hpp"
#include "nodes/render_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>
#include <variant>
#include <vector>

namespace nodes::render {

// A simulation whose bodies fall, and nothing holds them or lies below them.
inline bool falls_freely(const graph::LinkedNode& node)
{
    if (node.type->name != "Simulate") return false;
    for (const char* input : {"pins", "colliders"}) {
        if (node.links(input)) return false;
    }
    const graph::ParamValue* const gravity = node.param("gravity");
    const auto* const g = gravity ? std::get_if<std::array<double, 3>>(&gravity->is) : nullptr;
    return g && (*g)[1] < 0;
}

// A floor at a height that was stated. One that is `under` the stage goes with what is drawn.
inline graph::Faults hint_of_floor(const GroundParams& ground,
                                   const std::vector<graph::LinkedNode>& upstream)
{
    if (ground.kind != GroundParams::Kind::at) return {};
    const auto sim = std::find_if(upstream.begin(), upstream.end(), falls_freely);
    if (sim == upstream.end()) return {};
    return {{"ground.kind",
             fmt::format("a floor is drawn, on which nothing lands: '{}' has gravity, but neither "
                         "colliders nor pins. Link a Ground to its 'colliders', or set "
                         "ground.kind = none",
                         sim->node),
             true}};
}

// The first node that moves what is drawn, with a time of its own, as Simulate, Vibrate and
// ReadState. Layers have no mesh at rest.
inline const graph::LinkedNode* moving_node(const std::vector<graph::LinkedNode>& upstream)
{
    const auto moves = [](const graph::LinkedNode& node) {
        const graph::Pace& pace = node.type->pace;
        return !pace.param.empty() && pace.by == graph::Pace::By::seconds_a_frame;
    };
    const auto at = std::find_if(upstream.begin(), upstream.end(), moves);
    return at == upstream.end() ? nullptr : &*at;
}

// What holds the view of a Render from frame to frame.
struct Held {
    bool camera = false;  // stands where it is, or at what is linked
    bool floor = false;   // lies under what is linked
};

inline graph::Faults hint_of_moving_view(const GroundParams& ground, const Held& held, int frames,
                                         const std::vector<graph::LinkedNode>& upstream)
{
    const graph::LinkedNode* const moving = frames < 2 ? nullptr : moving_node(upstream);
    if (!moving) return {};
    if (!held.camera) {
        return {{"camera.kind",
                 fmt::format("the camera fits what is drawn at each frame, so that it moves and "
                             "the scale changes as '{}' moves that: link the mesh at rest to "
                             "'rest', or its MotionBounds to 'shot', which holds all frames",
                             moving->node),
                 true}};
    }
    if (held.floor || ground.kind != GroundParams::Kind::under) return {};
    return {
        {"ground.kind",
         fmt::format("the floor lies under what is drawn at each frame, so that it moves up and "
                     "down as '{}' moves that: link the mesh at rest to 'rest', or its "
                     "MotionBounds to 'shot', or set ground.kind = at",
                     moving->node),
         true}};
}

}  // namespace nodes::render
