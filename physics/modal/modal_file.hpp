#pragma once

// Modes of a mesh as a plain text file, so that they can be played without the cubes and the solver
// that found them, or come from another program:
//
//   aspic-modes 1
//   vertices 4                                   of the mesh, in its order
//   modes 2
//   mode 1.6154 0.02 1  0.3 2.1 0                frequency (Hz), damping (1/s), modal mass m (kg),
//   0 0 0                                        sum of mass * shape (kg): how gravity and a moved
//   0 0.1 0                                      base drive it; then the shape at each vertex
//   ...
//
// The equation of a mode is m (q'' + damping q' + (2 pi frequency)^2 q) = f, with x = X + q shape.
// Numbers are apart by spaces or line ends. What stands behind # on a line is a comment.

#include "physics/modal/vibrate.hpp"

#include <string_view>

namespace physics {

// The file of a model; numbers are exact. Shapes are scaled to modal masses of 1 kg.
std::string modal_file(const ModalModel& model);

// The model of a file for the mesh. Normals change as those of the faces around them. Throws
// std::runtime_error saying what was expected and found, and where.
ModalModel read_modal_file(std::string_view bytes, std::shared_ptr<const geometry::TriMesh> mesh);

}  // namespace physics
