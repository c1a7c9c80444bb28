#pragma once

// The lines of a file as bodies: tubes.

#include "geometry/io/assimp_messages.hpp"

namespace geometry {

// Turns every line of the scene into a closed tube of eight sides, whose cross-section has the area
// of a circle of this diameter (in the file's unit), and which node transforms do not thicken.
// Tubes that follow each other overlap: each ends in a cap at the ends of its line. Lines of no
// length and of vertices that are not there or not finite are left as they are.
void add_line_tubes(ImportedScene& scene, double diameter);

}  // namespace geometry
