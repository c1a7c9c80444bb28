#pragma once

// Glue: parts that are kept together wherever their cubes touch or overlap, by the corners of one
// in cubes of the other, as tied contact does with the vertices of the finer mesh.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/loads.hpp"

#include <memory>
#include <span>

namespace physics {

// What was glued.
struct Glued {
    std::size_t parts = 0;  // of all models
    std::size_t loose = 0;  // of these, those that are glued to no other
};

// Of two models each part of the first with each of the second; of one, all of its parts. Of two
// parts those corners count that lie within `reach` m of a cube of the other (0: a quarter of the
// edge of the smaller cubes), and of the two sides that with more corners, as that of smaller cubes
// has. Throws std::invalid_argument where no two parts come so near, and for a reach above two
// edges: what is farther out is no longer told by the cubes that it is nearest to.
PartJoint make_glue(std::span<const std::shared_ptr<const geometry::Cubes>> models, double reach,
                    Glued* glued = nullptr);

}  // namespace physics
