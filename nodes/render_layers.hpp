#pragma once

// The bodies of a Layered scene as surfaces that Render finds along rays.

#include "geometry/fields/iso_extent.hpp"
#include "physics/layered_bodies/layered_fields.hpp"
#include "render/scene.hpp"

#include <utility>
#include <vector>

namespace nodes::render {

// Of the one attribute that they have.
inline constexpr const char* layers_attribute = "compression";

inline std::vector<::render::FieldSurface> layer_surfaces(const physics::LayeredScene& scene)
{
    std::vector<::render::FieldSurface> surfaces;
    for (physics::LayeredField& layer : physics::layered_fields(scene)) {
        ::render::FieldSurface& surface = surfaces.emplace_back();
        surface.cells = geometry::iso_cells(layer.field);
        surface.extent = geometry::surface_box(layer.field, surface.cells);
        surface.field = std::move(layer.field);
        surface.material.name = layer.name;
        surface.material.colour = layer.colour;
        surface.attribute = layers_attribute;
        surface.value = std::move(layer.compression);
    }
    return surfaces;
}

}  // namespace nodes::render
