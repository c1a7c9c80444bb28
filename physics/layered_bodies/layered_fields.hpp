#pragma once

// The surfaces of a layered scene as fields, to be found along rays: the same fields that
// layered_mesh.hpp polygonizes.

#include "geometry/fields/iso_field.hpp"
#include "physics/layered_bodies/layered.hpp"

#include <functional>
#include <string>
#include <vector>

namespace physics {

// A body's surface as contacts deform it. Keeps what it needs of the moment.
struct LayeredField {
    geometry::IsoField field;
    std::function<double(const Vec3&)> compression;  // how far it is pressed, units of the field
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};        // linear RGB
    std::string name;
};

// One of each body that emits samples, in the order of layered_mesh's groups.
std::vector<LayeredField> layered_fields(const LayeredScene& scene);

}  // namespace physics
