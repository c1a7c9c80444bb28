#pragma once

// What is linked to Render as the surfaces, lines and balls of a scene, in their colours.

#include "nodes/render_inputs.hpp"
#include "physics/state/state_models.hpp"
#include "render/cube_quantity.hpp"
#include "render/legend.hpp"
#include "render/marker.hpp"
#include "render/mesh_surface.hpp"

#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace nodes::render {

// Whether what is linked beside the meshes is coloured by the attribute.
inline bool others_have(const Inputs& in, const std::string& attribute)
{
    return (in.cubes && in.cube.draw == CubeParams::Draw::solid && in.cube.by_attribute) ||
           (in.layers && attribute == layers_attribute);
}

// What is coloured by the attribute of `colour`.
struct Coloured {
    Meshes meshes;  // all that are linked; with their displacements, where these are asked for
    std::optional<geometry::Attribute> cubes;  // of their shell, where they are drawn by it
};

inline Coloured coloured(const Inputs& in)
{
    const std::string& attribute = in.colour.attribute;
    const bool moved =
        in.colour.by == ::render::Paint::By::attribute && attribute == "displacement";
    Coloured out{moved ? with_displacements(in.mesh, in.rest.get()) : in.mesh, std::nullopt};
    if (in.cubes && in.cube.draw == CubeParams::Draw::solid && in.cube.by_attribute &&
        !::render::is_category(attribute)) {
        out.cubes = ::render::cube_quantity(attribute, *in.cubes, *in.shell,
                                            physics::state_of(in.state, *in.cubes).get());
    }
    return out;
}

// One scale for all that has the attribute, in whatever order it is linked.
inline void add_legend(::render::Scene& scene, const Inputs& in, const Coloured& coloured)
{
    const bool by_attribute = in.colour.by == ::render::Paint::By::attribute;
    const geometry::Attribute pressed{layers_attribute, "1", {0, 1}};
    ColourParams colour = in.colour;
    std::vector<const geometry::Attribute*> all;
    for (const auto& mesh : by_attribute ? coloured.meshes : Meshes{}) {
        const auto* const values = find_attribute(*mesh, in.colour.attribute);
        if (values) all.push_back(values);
    }
    if (in.layers && by_attribute && in.colour.attribute == layers_attribute) {
        // What is pressed most lies inside a contact: the colours of all frames are the same.
        all.push_back(&pressed);
        if (colour.range == ColourParams::Range::percentile) {
            colour.range = ColourParams::Range::fit;  // these ends are no sample
        }
    }
    if (coloured.cubes) all.push_back(&*coloured.cubes);
    if (!all.empty()) scene.legend = legend_for(colour, all);
}

inline void add_meshes(::render::Scene& scene, const Inputs& in, const Meshes& meshes)
{
    const std::string& attribute = in.colour.attribute;
    const bool by_attribute = in.colour.by == ::render::Paint::By::attribute;
    // A floor beside a body that has the attribute is drawn in its material.
    const bool some = by_attribute && (any_has(meshes, attribute) || others_have(in, attribute));
    for (std::size_t m = 0; m < meshes.size(); ++m) {
        const auto& linked = in.mesh[m];
        const auto before = mesh_before(in.motion_blur, in.mesh, in.before, m);
        ::render::Surface surface;
        surface.layout = in.layout;
        surface.mesh = meshes[m];
        surface.before = before;
        if (in.colour.by == ::render::Paint::By::checker && !linked->triangles().empty()) {
            surface.mesh = in_checkers(in.colour, surface.mesh, in.rest.get());
        }
        surface.paint.by = some && !has_attribute(*meshes[m], attribute)
                               ? ::render::Paint::By::material
                               : in.colour.by;
        surface.paint.colour = in.colour.constant;
        surface.paint.attribute = attribute;
        if (by_attribute && has_attribute(*meshes[m], attribute)) {
            surface.paint.scale = scene.legend->scale;
        }
        if (linked->triangles().empty()) {
            // Of the cloud at rest, so that its points keep their size.
            const auto radius = static_cast<float>(
                in.show.point_size > 0
                    ? in.show.point_size / 2
                    : 0.0025 * geometry::bounds(in.rest ? *in.rest : *linked).diagonal());
            scene.balls.push_back(::render::cloud_balls(*surface.mesh, surface.paint, radius));
            if (before) scene.balls.back().before = before->positions;
            continue;
        }
        if (in.show.edges) {
            scene.lines.push_back(::render::edge_lines(*linked));
            if (before) scene.lines.back().before = ::render::edge_lines(*before).ends;
        }
        scene.surfaces.push_back(std::move(surface));
    }
}

inline void add_layers(::render::Scene& scene, const Inputs& in)
{
    if (!in.layers) return;
    scene.fields = layer_surfaces(*in.layers);
    const bool by_attribute = in.colour.by == ::render::Paint::By::attribute;
    for (::render::FieldSurface& surface : scene.fields) {
        surface.paint = {in.colour.by, in.colour.constant, in.colour.attribute, {}};
        if (by_attribute && scene.legend) surface.paint.scale = scene.legend->scale;
    }
}

inline void add_cubes(::render::Scene& scene, const Inputs& in,
                      const std::optional<geometry::Attribute>& by)
{
    if (!in.cubes || in.cube.draw == CubeParams::Draw::none) return;
    const auto state = physics::state_of(in.state, *in.cubes);
    const auto x = state ? state->x : geometry::corner_positions(*in.cubes);
    if (in.cube.draw == CubeParams::Draw::wire) {
        scene.lines.push_back(::render::cube_lines(*in.shell, x));
        scene.lines.back().colour = {0.01f, 0.03f, 0.06f};
        return;
    }
    using By = ::render::Paint::By;
    ::render::Surface surface;
    surface.layout = in.shell->layout;
    auto mesh = std::make_shared<geometry::TriMesh>(
        ::render::solid_cubes(*in.shell, x, static_cast<float>(in.cube.scale)));
    if (by) {
        mesh->attributes.push_back(*by);
        surface.paint = {By::attribute, in.colour.constant, by->name, scene.legend->scale};
    } else if (in.cube.by_attribute || !in.cubes->component.empty()) {
        ::render::colour_by_category(
            *mesh, ::render::cube_quantity(in.cube.by_attribute ? in.colour.attribute : "component",
                                           *in.cubes, *in.shell, state.get()));
        surface.paint.by = By::vertex_colour;
    } else {
        surface.paint.by = By::constant;
        surface.paint.colour = ::render::linear_from_srgb(::render::category_colour(0));
    }
    surface.mesh = std::move(mesh);
    scene.surfaces.push_back(std::move(surface));
}

inline void add_points(::render::Scene& scene, const Inputs& in)
{
    if (!in.points) return;
    ::render::Balls balls;
    balls.centres = in.points->positions;
    balls.radius = static_cast<float>(in.show.point_size / 2);
    if (in.show.point_size == 0) {
        balls.radius = static_cast<float>(0.0025 * ::render::bounds(scene).diagonal());
        if (scene.surfaces.empty() && scene.lines.empty()) {
            geometry::Box box;
            for (const auto& p : balls.centres) {
                if (p.allFinite()) box.add(p.cast<double>());
            }
            balls.radius = static_cast<float>(0.0025 * box.diagonal());
        }
    }
    for (const auto matter : in.points->matter) {
        balls.colours.push_back(::render::linear_from_srgb(::render::category_colour(matter)));
    }
    if (balls.colours.size() != balls.centres.size()) balls.colours = {Vec3f(0.3f, 0.5f, 0.7f)};
    scene.balls.push_back(std::move(balls));
}

}  // namespace nodes::render
