#pragma once

// The shapes of a scene as vertices, indices and batches of a draw list. Opaque triangles, lines
// and balls keep the order in which they are added; transparent triangles are sorted from far to
// near when all are there.

#include "render/draw_list.hpp"
#include "render/scene.hpp"

namespace render {

// A list while it is filled.
struct Gathering {
    struct ClearTriangle {
        float depth;
        geometry::Triangle corners;
        std::uint32_t style;  // into styles
    };

    DrawList& list;
    Vec3f towards_eye, centre;         // world
    float reach;                       // m from the centre: what lies beyond takes no part
    std::vector<ClearTriangle> clear;  // all transparent triangles so far
    std::vector<Batch> styles;         // how those of each surface are drawn
    std::vector<Box> clear_bounds;     // m, of those of each surface
};

// `list.units` must be set.
Gathering start_gathering(DrawList& list, const Vec3& towards_eye);

// `number` counts the surfaces from 0, for warnings. These throw std::invalid_argument for a
// missing attribute, and for colours that are neither one nor as many as there are balls.
void add_surface(Gathering& all, const Surface& surface, std::size_t number);
void add_lines(Gathering& all, const Lines& lines);
void add_balls(Gathering& all, const Balls& balls);

// Sorts what is transparent into `list.clear`.
void finish_gathering(Gathering& all);

}  // namespace render
