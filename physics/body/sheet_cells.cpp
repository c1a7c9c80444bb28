#include "physics/body/sheet_cells.hpp"

namespace physics {

std::size_t SheetCells::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return sizeof *this + of(cell, place, beside_at, beside, model, triangle, edge, point, point_at,
                             edge_at, thickness, stiffness, tree.nodes, tree.items);
}

}  // namespace physics
