#pragma once

// Which cubes hang together.

#include "geometry/cubes/cubes.hpp"

namespace geometry {

// What joins two cubes: a shared face (6 neighbours), edge (18) or corner (26).
enum class Connectivity { face, edge, corner };

struct Components {
    std::vector<std::uint32_t> label;  // C, 0 = largest
    std::vector<std::size_t> cubes;    // of each component
    std::vector<double> mass;          // of each, kg
    std::size_t count() const { return cubes.size(); }
};

enum class Largest { by_count, by_mass };

// Groups cubes that are joined by shared corners: four for a face, two for an edge. Triangles of a
// sheet have two in common at a side, which is both. The largest component comes first, of equal
// ones that which has the first cube.
Components find_components(const Cubes& cubes, Connectivity connectivity,
                           Largest largest = Largest::by_count);

// The cube nearest to p, and how far its box, or a sheet's triangle, is from p, 0 inside. Of pieces
// (Cubes::part) it is their quarters that count, and of those as near, the fullest cube.
// Precondition: count() > 0.
struct NearestCube {
    std::uint32_t cube = 0;
    double distance = 0;  // m
};
NearestCube nearest_cube(const Cubes& cubes, const Vec3& p);

}  // namespace geometry
