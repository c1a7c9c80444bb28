#pragma once

// A mesh carried by a sheet (cubes/sheet.hpp). Each vertex goes with the nearest place B of the
// sheet at rest, by its shares l_i in a triangle, and what it stands off from there turns and
// stretches as the sheet does around:
//
//   B = sum_i l_i X_i,   b = sum_i l_i x_i,   x = b + F (X - B),   F = sum_i l_i F_i
//   F_i = mean over triangles around corner i, by their area at rest, of
//         [x1 - x0, x2 - x0, n] [X1 - X0, X2 - X0, N]^-1
//   normal = cof(F) N / |cof(F) N|
//
// n and N are unit normals, so the sheet keeps its thickness however far it stretches. Vertices on
// the sheet stay on it, a rigid motion is that of all vertices, and since F runs on smoothly from
// triangle to triangle, so do normals.

#include "geometry/embed/bind.hpp"

#include <span>

namespace geometry {

// Puts positions and normals of `rest`, as a sheet's corners at x (K, m) carry it, into `out`,
// which has room for them. A triangle that has collapsed has no normal and takes no part in the
// means; a corner without others has the mean of those next to it, or else stays as it was at rest.
// In double precision but for what is stored.
void carry_with_sheet(const Binding& binding, const TriMesh& rest, const Cubes& sheet,
                      std::span<const Vec3> x, TriMesh& out);

}  // namespace geometry
