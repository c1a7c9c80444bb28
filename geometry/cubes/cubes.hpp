#pragma once

// The deformable model of the first family: tiny cubes of equal size with shared corners.
// James, Barbic, Twigg. Squashing cubes: automating deformable model construction for graphics.
// SIGGRAPH 2004 sketches.

#include "geometry/base/vec.hpp"
#include "geometry/cubes/matter.hpp"

#include <array>
#include <vector>

namespace geometry {

// A number of the user's own in each cube: how worn, how hot, which weight.
struct CubeAttribute {
    std::string name;
    std::string unit;
    std::vector<double> values;  // C
};

// A finite element that is a cube's own: lower triangles of symmetric matrices, row by row.
struct OwnElement {
    // 24 x 24, for a Young's modulus of 1 Pa and an edge of 1 m: corner a's x, y, z at 3a, 3a + 1,
    // 3a + 2.
    std::array<float, 300> stiffness{};
    std::array<float, 36> mass{};  // 8 x 8 corners, for 1 kg; the same for x, y and z
};

// Whether the corners of a cell are those of a triangle (sheet.hpp).
inline bool is_triangle(const std::array<std::uint32_t, 8>& k)
{
    return k[2] == k[3] && k[0] == k[4] && k[0] != k[1];
}

// Cube c fills origin + size * (cell[c] .. cell[c] + 1). Corner number a of a cube, a = 0..7, lies
// at cell + ((a & 1), (a >> 1 & 1), (a >> 2 & 1)):
//
//         2 -------- 3
//        /|         /|        y
//       6 -------- 7 |        |
//       | |        | |        |
//       | 0 -------|-1        +---- x
//       |/         |/        /
//       4 -------- 5        z
//
// Corners a and b are the ends of an edge along axis d when a ^ b is 1 << d. Cubes are sorted by
// (z, y, x); corners are numbered in the same order of their own coordinates. Nothing asserts that
// a cell holds one cube only: cubes that share a cell but no corners are copies for geometry that
// must not be joined (pieces.hpp). cube_finder.hpp tells which of them holds a place.
struct Cubes {
    double size = 0;  // m, edge of a cube
    Vec3 origin = Vec3::Zero();

    std::vector<Vec3i> cell;                            // C
    std::vector<std::array<std::uint32_t, 8>> corners;  // C, into corner
    std::vector<Vec3i> corner;                          // K, lattice coordinates
    // K, m, where corners rest that are on no lattice: the vertices of a sheet (sheet.hpp), whose
    // cells and lattice coordinates are about where they are, in any order. Empty: on the lattice.
    std::vector<Vec3> place;

    std::vector<double> mass;               // C, kg
    std::vector<double> fill;               // C, 0..1, share of the cube that holds material
    std::vector<double> young;              // C, Pa, of the material itself (not scaled by fill)
    std::vector<double> poisson;            // C
    std::vector<double> mass_damping;       // C, 1/s
    std::vector<double> stiffness_damping;  // C, s
    std::vector<std::uint16_t> matter;      // C, into matters: the one with most mass in the cube
    std::vector<Matter> matters;
    std::vector<std::uint32_t> component;  // C, 0 = largest; empty until components were sought
    // C, the quarters of its cell that the cube's material lies in (cells/sub_cells.hpp); empty
    // where all cubes that touch share their corners, and each stands for all of its cell.
    std::vector<std::uint64_t> part;
    std::vector<CubeAttribute> attributes;  // any number, each name once
    // C, into elements, or no_index where stiffness and mass are those of a whole cube in the share
    // of the fill; both empty where no cube has its own (physics/modal/calibrate.hpp).
    std::vector<std::uint32_t> own;
    std::vector<OwnElement> elements;

    std::size_t count() const { return cell.size(); }
    std::size_t corner_count() const { return corner.size(); }
    bool is_own(std::size_t c) const;
    bool is_sheet() const { return !place.empty(); }
    Vec3 corner_position(std::size_t i) const
    {
        return place.empty() ? Vec3(origin + size * corner[i].cast<double>()) : place[i];
    }
};

// Numbers the corners: fills `corner` and `corners` from `cell`, which must be sorted by (z, y, x)
// and hold no cell twice.
void number_corners(Cubes& cubes);

// Cubes of one matter, full of it, at `cells` in any order; a cell named twice gives one cube.
Cubes solid_cubes(std::vector<Vec3i> cells, double size, const Matter& matter = {},
                  const Vec3& origin = Vec3::Zero());

// Only the cubes c with keep[c] != 0, and only the corners they have; both keep their order.
Cubes kept(const Cubes& cubes, const std::vector<std::uint8_t>& keep);

// Rest positions of all corners. K, m.
std::vector<Vec3> corner_positions(const Cubes& cubes);

// What share of the mass of cube c its corners have: an eighth each, or what its own element says.
std::array<double, 8> corner_shares(const Cubes& cubes, std::size_t c);

// Throws std::invalid_argument where `own` and `elements` do not fit the cubes and each other.
void check_elements(const Cubes& cubes);

// Mass at each corner, of all its cubes. K, kg.
std::vector<double> corner_masses(const Cubes& cubes);

// Mass of all cubes together. kg.
double total_mass(const Cubes& cubes);

// Number of components that were found; 0 when none were sought yet.
std::size_t component_count(const Cubes& cubes);

}  // namespace geometry
