#pragma once

// What every method that moves the corners of cubes knows of its body: masses, the rest shape, and
// the surface that colliders and wind touch. Vectors over corners are kept in slots, an order of
// the method's own, with four numbers each (the fourth is 0), padded to whole runs of 16 numbers.
// What is the same for all corners is not kept.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/body/body_models.hpp"
#include "physics/body/contact_surface.hpp"
#include "physics/body/part_shapes.hpp"
#include "physics/body/sheet_cells.hpp"
#include "physics/math/aligned_memory.hpp"

#include <memory>
#include <vector>

namespace physics {

using geometry::Vec3;

class ShapesOnDemand;
struct SolidsBesideSheets;

struct CornerBody {
    double h = 0;              // m, least edge of a cube
    double greatest_edge = 0;  // m
    std::size_t models = 1;
    std::size_t corners = 0;          // K
    std::size_t numbers = 0;          // length of a vector over corners, >= 4 K
    std::vector<std::uint32_t> slot;  // K, of each corner; empty: slots are the corners themselves

    std::vector<double> mass;          // K by slot, kg
    std::vector<double> mass_damping;  // K by slot, kg/s; empty: none
    std::vector<std::uint32_t> part;   // K by slot: corners of one part hang together by cubes;
                                       // empty: all do
    std::size_t parts = 0;
    std::vector<std::uint8_t> rigid;  // of each part, whether it keeps its shape; empty: none does
    std::vector<double> part_edge;    // m, edge of the cubes of each part; empty: h
    bool on_lattice = true;           // each corner rests on a lattice of its model's
    Aligned<double> rest;             // numbers, m
    ContactSurface skin;
    std::shared_ptr<const PartShapes> shapes;          // null: parts do not touch each other
    std::shared_ptr<const ShapesOnDemand> outlines;    // as edges of colliders meet them; or null
    std::shared_ptr<const SheetCells> sheets;          // null: nor do sheets
    std::shared_ptr<const SolidsBesideSheets> solids;  // null: sheets and solids do not touch

    std::size_t slot_of(std::size_t corner) const { return slot.empty() ? corner : slot[corner]; }
    double damping_of(std::size_t at) const { return mass_damping.empty() ? 0 : mass_damping[at]; }
    std::uint32_t part_of(std::size_t at) const { return part.empty() ? 0 : part[at]; }
    double edge_at(std::size_t at) const { return part_edge.empty() ? h : part_edge[part_of(at)]; }

    std::size_t bytes() const;
};

// `slot` numbers the corners 0 .. K, or is empty. Throws std::invalid_argument when the cubes are
// no body: lengths that do not fit, sizes, masses or moduli that are not finite or out of range.
CornerBody make_corner_body(const BodyModels& models, std::vector<std::uint32_t> slot);

// Of one model. `surface` may be null: then the cubes' own outside is the surface. A body that
// `tears` has a surface within.
CornerBody make_corner_body(const geometry::Cubes& cubes, std::vector<std::uint32_t> slot,
                            const geometry::TriMesh* surface, bool tears = false);

// Corner by corner to slot by slot, padded.
Aligned<double> by_slot(const CornerBody& body, const std::vector<Vec3>& x);

// Numbers in a vector over k corners.
constexpr std::size_t padded_numbers(std::size_t k)
{
    return (4 * k + 15) / 16 * 16;
}

}  // namespace physics
