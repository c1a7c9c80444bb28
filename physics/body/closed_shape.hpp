#pragma once

// A closed mesh in place of one that may be open: of any mesh, however broken.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace physics {

// What stands for the cubes `of` (ascending) in contact, if `mesh` (of some models' triangles, m,
// at rest) is their surface: its pieces that have an inside, with caps on holes of up to a
// twentieth of their area, and the outside of those cubes that hold none of these, or more of the
// others by area. Of a mesh without such pieces, the outside of all the cubes.
//
//      ......          dots: cubes; a closed box, and a sheet that stands on it
//      : |  :
//    +---|------+      the sheet gets two cubes, the box keeps its faces
//    +----------+
geometry::TriMesh closed_shape(geometry::TriMesh mesh, const geometry::Cubes& cubes,
                               std::span<const std::uint32_t> of);

// The outside of the cubes `of`: faces that only one of them has, two triangles each.
geometry::TriMesh outside_of(const geometry::Cubes& cubes, std::span<const std::uint32_t> of);

}  // namespace physics
