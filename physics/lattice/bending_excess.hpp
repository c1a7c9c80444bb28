#pragma once

// How much stiffer a lattice is in bending than its material: regions resist bending on their own,
// so thin bodies that stretch rightly bend too stiffly.

#include "physics/lattice/lattice_body.hpp"

namespace physics {

// For each linked body, how much stiffer the lattice is in bending than its material: the ratio of
// what a slight bend of its longest axis towards its shortest costs,
//   U = 1/2 sum E V kappa^2 (c^2 + h^2 / 12)   against   -1/2 sum m u . a,
// a the acceleration that the lattice answers the displacement u = kappa (a^2 / 2 e3 - a c e1) with
// (a, c along the principal axes e1, e3 of E V; the h^2 / 12 is what a cube has in itself). By N.
std::vector<double> bending_excess(const geometry::Cubes& cubes, const LatticeBody& body,
                                   const std::vector<std::uint32_t>& piece);

}  // namespace physics
