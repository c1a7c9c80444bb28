#pragma once

// What Render draws beside the body itself: where it was at rest, and what acts on it.

#include "geometry/cubes/cubes.hpp"
#include "graph/types/param_builder.hpp"
#include "graph/types/value.hpp"
#include "nodes/render_view.hpp"
#include "render/marker.hpp"
#include "render/stage.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace nodes::render {

struct ShowParams {
    bool pins = true, forces = true, force_values = false, colliders = true;
    double collider_opacity = 1, ghost = 0;
    bool edges = false, glass = false;
    double point_size = 0;
};

inline void describe(graph::ParamsOf<ShowParams>& p)
{
    p.param("pins", &ShowParams::pins, "Whether linked pins are marked.")
        .param("forces", &ShowParams::forces, "Whether linked forces are drawn as arrows.")
        .param("force_values", &ShowParams::force_values,
               "Whether the tips of these arrows have numbers: how strong a force, a torque, a "
               "wind or a gravity is.")
        .param("colliders", &ShowParams::colliders, "Whether linked colliders are drawn.")
        .param("collider_opacity", &ShowParams::collider_opacity,
               "Opacity of linked colliders, so that what lies behind them is seen; below 1 they "
               "cast no shadow (but as `glass`), and cost what a ghost costs. Clear things that "
               "cut through each other are sorted in each pixel down to four layers.",
               {0, 1})
        .param("ghost", &ShowParams::ghost,
               "Opacity of `rest`, drawn as a pale shell around the deformed meshes; 0 draws none. "
               "At `standard`, anything clear makes pictures take up to 1.7 times as long.",
               {0, 1})
        .param("glass", &ShowParams::glass,
               "Whether clear things, by their materials or as colliders, look like glass: shadows "
               "as light as they are clear, and a mirror image of sky, floor and key light, the "
               "stronger the more obliquely they are seen. Their shadows are neither coloured nor "
               "gathered to bright spots.")
        .param("edges", &ShowParams::edges, "Whether the edges of the meshes' faces are drawn.")
        .param("point_size", &ShowParams::point_size,
               "Diameter of linked points, and of those of meshes without faces; 0 chooses it by "
               "the size of the stage.",
               {0, 1e9, "m"});
}

// The mesh at rest as a clear shell around those that have as many vertices, which keep the colours
// that a legend explains; none where all of `meshes` lie where it does.
inline void add_ghost(::render::Scene& scene, const ShowParams& show,
                      const graph::Wire<geometry::TriMesh>& rest,
                      const std::vector<graph::Wire<geometry::TriMesh>>& meshes,
                      const std::shared_ptr<const ::render::SurfaceLayout>& layout)
{
    if (show.ghost == 0 || !rest || rest->triangles().empty()) return;
    const bool moved = std::any_of(meshes.begin(), meshes.end(), [&](const auto& mesh) {
        return mesh->positions != rest->positions;
    });
    if (!moved && !meshes.empty()) return;
    for (::render::Surface& surface : scene.surfaces) {
        const bool same = surface.mesh->positions.size() == rest->positions.size();
        if (same) surface.kind = ::render::Surface::Kind::body;
    }
    scene.surfaces.push_back(::render::ghost(rest, static_cast<float>(show.ghost)));
    scene.surfaces.back().layout = layout;
}

// N: what an arrow of half the greatest length stands for.
inline double weight_of(const geometry::Cubes* cubes)
{
    if (!cubes) return 1;
    double weight = 0;
    for (const double m : cubes->mass) weight += 9.81 * m;
    return weight;
}

// What acts on a body.
struct LinkedLoads {
    const std::vector<graph::Wire<physics::Pins>>& pins;
    const std::vector<graph::Wire<physics::Force>>& forces;
    const std::vector<graph::Wire<physics::Collider>>& colliders;
};

// Sized for the stage, and for `cubes` where they are linked. A level plane is left to the ground
// that is drawn under the stage.
inline void add_loads(::render::Scene& scene, const ShowParams& show, const LinkedLoads& loads,
                      const geometry::Cubes* cubes, GroundParams::Kind ground)
{
    if (show.pins) {
        const double radius = cubes ? 0.16 * cubes->size : 0.004 * scene.stage.diagonal();
        for (const auto& pins : loads.pins) {
            scene.balls.push_back(::render::pin_marks(*pins, radius));
        }
    }
    if (show.forces) {
        const double weight = weight_of(cubes);
        for (const auto& force : loads.forces) {
            for (auto& mark : ::render::force_marks(*force, scene.stage, weight)) {
                scene.surfaces.push_back(std::move(mark));
            }
            if (!show.force_values) continue;
            auto note = ::render::force_note(*force, scene.stage, weight);
            if (note) scene.notes.push_back(std::move(*note));
        }
    }
    if (!show.colliders || show.collider_opacity == 0) return;
    for (const auto& collider : loads.colliders) {
        if (ground == GroundParams::Kind::under && ::render::is_level_plane(*collider)) continue;
        auto mark = ::render::collider_mark(*collider, scene.stage);
        if (!mark) continue;
        mark->opacity *= static_cast<float>(show.collider_opacity);
        if (show.collider_opacity < 1 && !show.glass) mark->shadow = false;
        scene.surfaces.push_back(std::move(*mark));
    }
}

}  // namespace nodes::render
