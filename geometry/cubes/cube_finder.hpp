#pragma once

// Which cube holds a place, for cubes of which several may lie in one cell.

#include "geometry/cells/cell_set.hpp"
#include "geometry/cubes/cubes.hpp"

namespace geometry {

class CubeFinder {
public:
    // The cubes must outlive the finder.
    explicit CubeFinder(const Cubes& cubes) : cubes_(&cubes), index_(cubes.cell) {}
    // The same, when a set of just their cells is at hand.
    CubeFinder(CellSet set, const Cubes& cubes) : cubes_(&cubes), index_(std::move(set), cubes.cell)
    {}

    // The cube of the cell that holds a place in lattice coordinates; no_index where it is in no
    // cube's cell. Of pieces (Cubes::part) it is the one whose quarters are nearest: of the cell,
    // or of a neighbouring cell where that piece is within a thousandth of a cube.
    std::uint32_t find(const Vec3& at) const;

    // The same, or of cubes in the 26 cells around the nearest; no_index where there is none.
    std::uint32_t find_near(const Vec3& at) const;

    CellIndex::Found in_cell(const Vec3i& cell) const { return index_.find(cell); }

private:
    struct Nearest {
        std::uint32_t cube;
        double distance_sq;  // in cubes
    };
    void look_in(const Vec3i& cell, const Vec3& at, Nearest& best) const;

    const Cubes* cubes_;
    CellIndex index_;
};

// From a place to the quarters `part` (Cubes::part) of a cell at the origin, squared, in cubes.
double quarters_distance_sq(std::uint64_t part, const Vec3& at);

// Whether the quarters `part` (Cubes::part) of a cell hold the place `at`, 0..1 in the cell; where
// it is outside, the place in the cell that is nearest to it.
bool quarters_hold(std::uint64_t part, const Vec3& at);

// Whether two cubes have a corner in common, as neighbours of one piece do.
bool share_a_corner(const Cubes& cubes, std::size_t a, std::size_t b);

// The smallest box around what a cube holds, in lattice coordinates: its quarters, or all of it.
Box held_box(const Cubes& cubes, std::size_t cube);

}  // namespace geometry
