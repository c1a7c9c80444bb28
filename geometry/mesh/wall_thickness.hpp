#pragma once

// How thick the walls of a solid are: from points spread over its surface straight inward to the
// opposite wall. The shape diameter without its cone of rays:
// Shapira, Shamir, Cohen-Or. Consistent mesh partitioning and skeletonisation using the shape
// diameter function. The Visual Computer 24(4), 2008.

#include "geometry/mesh/pieces.hpp"

#include <limits>

namespace geometry {

struct WallSample {
    Vec3 point = Vec3::Zero();                                   // m, on the surface
    Vec3 inward = Vec3::Zero();                                  // unit, against the face's normal
    double thickness = std::numeric_limits<double>::infinity();  // m; infinite: beyond the reach
    std::uint32_t triangle = 0;
};

// `count` points, evenly spread by area in the order of the triangles; none where there is no area.
// Their thickness is not known yet.
std::vector<WallSample> wall_points(const TriMesh& mesh, std::size_t count);

// Finds the thickness of the wall at each where it is at most `reach` (m). Faces nearer than
// `least` (m) are not opposite walls: models for drawing often have all faces twice, back to back.
// What is inward is told by the orientation of the faces; in a piece that is turned inside out as a
// whole the samples are turned round. The same for any number of threads.
void find_thickness(const TriMesh& mesh, const Pieces& pieces, double least, double reach,
                    std::vector<WallSample>& samples);

}  // namespace geometry
