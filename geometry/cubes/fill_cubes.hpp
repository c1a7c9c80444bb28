#pragma once

// Mass, fill and material of cubes, from the bits of material that lie in each.

#include "geometry/cubes/cubes.hpp"

#include <span>

namespace geometry {

// What becomes of pieces of material that one cell holds.
enum class NearPieces {
    merge,  // one cube holds them all: gaps narrower than a cube are mended
    apart,  // each has a cube of its own (pieces.hpp)
};

// What every voxelization ends with.
struct VoxelOptions {
    std::size_t max_cubes = 4'000'000;      // more is an error, met before the memory is taken
    double min_fill = 0.02;                 // no cube is lighter and softer than one filled so far
    double total_mass = 0;                  // kg; not 0: masses are scaled to this sum
    NearPieces pieces = NearPieces::merge;  // of meshes
    double join = 0;                        // m; pieces as near are not kept apart (pieces.hpp)
};

// A bit of material in a cube.
struct Deposit {
    std::uint32_t cube = 0;
    std::uint16_t matter = 0;
    double volume = 0;  // m^3
};

// Fills in mass, fill, material and damping of cubes that have their cells and corners. Of
// the materials in one cube, stiffness and Poisson ratio are averaged by volume and each damping by
// what it damps, mass or stiffness; `matter` is the one with most mass. A cube without a deposit
// takes after the first of its 26 neighbours that has one.
//   fill = min(1, max(min_fill, sum of volumes / size^3)),   mass = sum of density volume
// What min_fill adds to the mass is taken from all in proportion, so that the total is kept.
// Sums run in the order of the deposits.
void fill_cubes(Cubes& cubes, std::span<const Matter> matters, std::span<const Deposit> deposits,
                const VoxelOptions& options);

}  // namespace geometry
