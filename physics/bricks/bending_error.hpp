#pragma once

// How much too stiff in bending the cubes make the walls of a solid.
//
// The cubes stand for a wall of thickness t. Along a line across it, each cube that the line passes
// has its share of the full stiffness (stiffness_share, filled) over its whole edge h, so the wall
// is smeared out. Bending grows with the second moment of the stiffness across the wall:
//   S0 = int f ds,   V = int f s^2 ds / S0 - (int f s ds / S0)^2,   factor = V / (t^2 / 12)
// A wall that is aligned with the grid and whole cubes thick gives 1; one of a single cube, partly
// filled, (h / t)^2; one whose outer cubes are half full, 1 + 3 (h / t)^2 nearly. A tilted wall
// gives 1 + 2 (h / t)^2 on average, as filling the cubes and having the same stiffness in all of
// each add a variance of h^2 / 12 each. Between these lie the sections that the wall's long side
// runs through one after another: they bend in series, so that the soft ones count more. Where the
// long side lies along the grid, all sections are alike.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <optional>
#include <string>

namespace physics {

// A part of a mesh, a considerable share of which is at most 12 cubes thick.
struct ThinPart {
    std::string name;               // "'seat'": its group; "piece 2"; empty: the whole mesh
    double thickness = 0;           // m, the median of its thin walls
    geometry::Vec3 where{0, 0, 0};  // m, a point of its surface where it is so thick
    double share = 0;               // 0..1, of its surface that is so thin
    double factor = 1;              // stiffness in bending, model over solid
    double slenderness = 0;         // length across all of its thin walls, over the thickness
};

// What the walls of a mesh are.
struct WallOptions {
    bool solid = true;     // measured inward; false: sheets, of the thickness below
    double thickness = 0;  // m, of sheets; 0: unknown, nothing is said about them
};

// Of parts that are thicker than is looked at, the stiffness in bending is at most this.
inline constexpr double bending_of_thick = 1.02;

// The parts that are looked at, the one that is most wrong first, also those that are right. What
// is not among them is thicker than 12 cubes, is no wall, or is too small a part. The factor is for
// the cubes' incompatible element. The same for any number of threads.
std::vector<ThinPart> thin_parts(const geometry::TriMesh& mesh, const geometry::Cubes& cubes,
                                 const WallOptions& walls);

// The thinnest wall of a mesh that no cubes are made of yet: the part whose thinnest quarter of
// surface is thinnest, as the mesh's thin_parts would be found by cubes of its size. `share` and
// `factor` say nothing. Pieces that are open have no walls; nothing where all are.
std::optional<ThinPart> thinnest_wall(const geometry::TriMesh& mesh);

// A wall of this thickness is at most 20 % too stiff in such cubes, however it lies in the grid: 1
// + 2 (h / t)^2 is 1.13. m, two digits.
double size_for_wall(double thickness);

}  // namespace physics
