#pragma once

// Makes the shapes of a body's parts (part_shapes.hpp) from its cubes and surface.

#include "geometry/mesh/mass_properties.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/body/corner_body.hpp"
#include "physics/body/part_shapes.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace physics {

// A part's shape is that of its triangles of its model's surface, closed by closed_shape.hpp. It
// has three points on each triangle, near the corners, and on each of those that wide triangles are
// cut into; of points crowded into a quarter of a cube and facing the same way, their mean stands
// for all. `body` is made of the same models.
PartShapes make_part_shapes(const BodyModels& models, const CornerBody& body,
                            const PartContactOptions& options);

// The same without points: what is told of the parts by others' points.
PartShapes make_outlines(const BodyModels& models, const CornerBody& body);

// visit(part, its closed shape) for each part of all models, which are solids; parts ascend.
void for_closed_shapes(const BodyModels& models, const CornerBody& body,
                       const std::function<void(std::uint32_t, geometry::TriMesh)>& visit);

// What the shape of each rigid part encloses, at 1 kg/m^3; 0 of models without a surface, and of
// other parts.
std::vector<geometry::MassProperties> solids_of_rigid_parts(const BodyModels& models,
                                                            const CornerBody& body);

// The shapes where contact is on and the body has parts; else null. Cubes of a plane have no
// inside: null for them.
std::shared_ptr<const PartShapes> shapes_that_touch(const BodyModels& models,
                                                    const CornerBody& body,
                                                    const PartContactOptions& options);

}  // namespace physics
