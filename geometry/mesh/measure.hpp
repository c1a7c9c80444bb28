#pragma once

// Numbers that say something about a mesh: what expectations and studies look at.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// Whether x is to replace `largest` in a search for the worst: not-a-number is worse than any
// number, and nothing is worse than it.
inline bool exceeds(double x, double largest)
{
    return !(x <= largest) && largest == largest;
}

// A sentence where the mesh lies so far from the origin that single precision, which coordinates
// are kept in, rounds it by more than a thousandth of its size; else empty. It ends with `remedy`.
std::string far_from_origin(const TriMesh& mesh,
                            const char* remedy = "move the mesh to the origin before this step");

// Sum of the triangles' areas. m^2.
double surface_area(const TriMesh& mesh);

// Volume enclosed by a closed mesh wound outwards, by the divergence theorem; for an open mesh it
// is the sum of signed cones over the centre of its bounds. m^3.
double enclosed_volume(const TriMesh& mesh);

// How far each vertex of `mesh` is from where it stands in `rest`. Throws std::invalid_argument
// when the two have different numbers of vertices.
struct Displacement {
    double largest = 0, mean = 0, rms = 0;  // m
    std::size_t where = 0;                  // vertex of the largest
};
Displacement displacement(const TriMesh& mesh, const TriMesh& rest);

// Displacement of the vertex whose rest position is nearest to `point`. m.
Vec3 displacement_at(const TriMesh& mesh, const TriMesh& rest, const Vec3& point);

// Largest length of an edge of `mesh` over its rest length. Edges shorter than `ignore` of the
// bounds' diagonal at rest do not count: in a sliver any motion is a large ratio.
double largest_stretch(const TriMesh& mesh, const TriMesh& rest, double ignore = 1e-3);

// Least and greatest coordinate of the vertices along the unit vector `direction`. m; {0, 0} for an
// empty mesh.
std::array<double, 2> extent(const TriMesh& mesh, const Vec3& direction);

// Least, greatest and mean of some values. 0 of none; not-a-number where a value is.
struct Spread {
    double least = 0, most = 0, mean = 0;
};

// Of an attribute over the vertices. Throws std::invalid_argument that names the attributes there
// are.
Spread attribute_spread(const TriMesh& mesh, const std::string& name);

// The first position that is not finite: "vertex 3 is at (inf, 0, 0)"; empty when all are.
std::string what_place_is_not_finite(const TriMesh& mesh);

// The first position, normal or attribute that is no finite number: "vertex 3 is at (inf, 0, 0)";
// empty when all are finite.
std::string what_is_not_finite(const TriMesh& mesh);
inline bool all_finite(const TriMesh& mesh)
{
    return what_is_not_finite(mesh).empty();
}

}  // namespace geometry
