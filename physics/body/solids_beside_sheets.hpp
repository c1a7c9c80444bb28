#pragma once

// What sheets need to know of the solids that are simulated with them to touch these: the closed
// shape of each solid part, and which cube carries each place of it. Where the shapes are in a step
// is found by posed_solids.hpp.

#include "geometry/base/box_tree.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/corner_body.hpp"
#include "physics/body/sheet_cells.hpp"

#include <array>
#include <memory>
#include <vector>

namespace physics {

// A solid part at rest.
struct SolidShape {
    geometry::TriMesh mesh;             // closed, m
    std::vector<std::uint32_t> cube;    // V, that carries each vertex
    std::vector<geometry::Vec3> local;  // V, its place there, 0..1 in the cube
    PartGrid grid;
    double thinnest = 0;               // m, the least side of its bounds
    double stiffness = 0;              // Pa, Young's modulus times fill, the largest of its cubes
    std::vector<std::uint32_t> cubes;  // of the part, ascending
    geometry::BoxTree tree;            // of their cells, by place in `cubes`
};

struct SolidsBesideSheets {
    double friction = 0.5, bounce = 0;
    std::uint32_t first_sheet = 0;       // slot; those before are of solids
    std::uint32_t first_sheet_cell = 0;  // of the body's skin
    double sheet_stiffness = 0;          // Pa, the largest of the sheets' Young's moduli
    std::shared_ptr<const SheetCells> cells;
    std::vector<SolidShape> solid;                      // by part
    std::vector<std::array<std::uint32_t, 8>> corners;  // C, slots
    std::vector<geometry::Vec3i> cell;                  // C

    std::size_t bytes() const;
};

// What carries a place of a solid: corners (slots) and their weights.
struct CarriedPlace {
    std::array<std::uint32_t, 8> corners{};
    std::array<double, 8> weight{};
};
// Of a place at rest, m.
CarriedPlace carried_place(const SolidsBesideSheets& solids, std::size_t solid,
                           const geometry::Vec3& at_rest);

// What gives way where a sheet of `own` stiffness (Pa) touches one of so many colliders, of which
// the last are the solids of a body that has any: the softer of both.
double softer_of(const CornerBody& body, std::size_t colliders, std::uint32_t other, double own);

// `body` is made of the same models, which are all solids.
SolidsBesideSheets make_solids_beside_sheets(const BodyModels& models, const CornerBody& body,
                                             const PartContactOptions& options);

}  // namespace physics
