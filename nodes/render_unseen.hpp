#pragma once

// What Render says of what its picture does not show.

#include "graph/types/context.hpp"
#include "nodes/render_view.hpp"
#include "render/camera.hpp"
#include "render/scene.hpp"
#include "render/text.hpp"

#include <fmt/format.h>

namespace nodes::render {

// Whether the floor hides part of `drawn`, which it was placed under as it is at rest.
inline bool floor_hides(const GroundParams& ground, const ::render::Scene& scene,
                        const geometry::Box& drawn, bool by_collider)
{
    if (ground.kind != GroundParams::Kind::under || by_collider || !scene.ground) return false;
    return *scene.ground - drawn.lo.y() > 0.05 * scene.stage.diagonal();
}

// Warns of letters that come out as boxes.
inline void warn_of_boxes(const ::render::Scene& scene, const graph::Context& context)
{
    std::string words = scene.label;
    if (scene.legend) words += scene.legend->title + scene.legend->note;
    for (const auto& note : scene.notes) words += note.text;
    const std::string boxes = ::render::without_glyphs(words);
    if (boxes.empty()) return;
    context.warn(fmt::format("pictures have no glyphs for {}: each is drawn as a box. They have "
                             "Latin and Greek letters",
                             boxes));
}

// Warns of a picture that can show nothing of `drawn`, the bounds of what is linked, or not all.
// `file`: the camera is that of a file.
inline void warn_of_unseen(CameraParams::Kind kind, bool file, const GroundParams& ground,
                           double aspect, const ::render::Scene& scene,
                           const ::render::Camera& camera, geometry::Box drawn, bool by_collider,
                           const graph::Context& context)
{
    for (const auto& balls : scene.balls) {
        drawn.lo.array() -= double(balls.radius);
        drawn.hi.array() += double(balls.radius);
    }
    if (drawn.empty()) return;
    if (!::render::may_see(camera, drawn, aspect)) {
        context.warn(file ? "no linked mesh lies in the picture: see that `unit`, `up` and "
                            "`start` of ReadCamera are those of the file, or unlink `view`"
                     : kind == CameraParams::Kind::look_at
                         ? "no linked mesh lies in the picture: turn camera.target to it, "
                           "or let the camera fit it"
                         : "no linked mesh lies in the picture any more: the camera fits "
                           "where it is at rest; link its MotionBounds to `shot`, or choose "
                           "look_at for camera.kind");
    } else if (floor_hides(ground, scene, drawn, by_collider)) {
        context.warn(fmt::format(
            "the ground hides what lies below it: it is at {:.3g} m, under what is linked as it is "
            "at rest. Link the Ground on which the mesh falls to `colliders`; or else link the "
            "MotionBounds of the mesh to `shot`, or set ground.kind = none, or at with a height",
            *scene.ground));
    }
}

}  // namespace nodes::render
