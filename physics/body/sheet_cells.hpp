#pragma once

// What sheets need to know of themselves to touch (sheet_contact.hpp): the two triangles of each
// cell as plane_mesh() draws them, or its one, their sides, and what each point stands for.

#include "geometry/base/box_tree.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace physics {

struct SheetCells {
    double friction = 0.5, bounce = 0;
    bool self = false;                  // cells of one model touch each other
    double thinnest = 0, thickest = 0;  // m
    double reach = 0;                   // m, from which on what comes near is kept apart
    // Points of touches are numbered from there: slots, and behind all slots edges.
    std::uint32_t first_number = 0;
    // C, slots: (0, 0), (1, 0), (0, 1), (1, 1); of a triangle, the last is the third again.
    std::vector<std::array<std::uint32_t, 4>> cell;
    std::vector<geometry::Vec3i> place;  // C, on the grid of its model
    // Of triangles, the cells within two of each along the sheet, ascending: C + 1 into beside;
    // both empty where all models are planes.
    std::vector<std::uint32_t> beside_at, beside;
    std::vector<std::uint32_t> model;  // C
    std::vector<std::array<std::uint32_t, 3>>
        triangle;  // 2 C, cell by cell, all the same way round; one without area names a slot twice
    std::vector<std::array<std::uint32_t, 2>> edge;  // sides of triangles, cell by cell
    // C + 1: each point and each edge is one cell's own, into `point` and `edge`.
    std::vector<std::uint32_t> point;
    std::vector<std::uint32_t> point_at, edge_at;
    std::vector<float> thickness, stiffness;  // K, m; N/m, of what rests
    geometry::BoxTree tree;                   // of the cells at rest

    std::size_t bytes() const;
};

}  // namespace physics
