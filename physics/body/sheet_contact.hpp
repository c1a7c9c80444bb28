#pragma once

// Contact of sheets with themselves and with each other: points against triangles, and edges
// against edges (Bridson, Fedkiw, Anderson. Robust treatment of collisions, contact and friction
// for cloth animation. SIGGRAPH 2002). With the weights w of the four points and the normal n from
// the one towards the other,
//   g = n . sum w_a x_a - thickness
// is the gap that a touch keeps open (plane_touch.hpp): half of the thickness on either side of
// what is drawn.
//
//   cells in boxes along their way -> pairs of cells -> points and triangles, edges and edges
//     -> how they stand at the start, at the end, or where they meet on the way -> plane
//
// Which side is kept apart from which is told, in this order, by the grip that the step before
// left there or beside it in the same sheet, by where they stand at the start when they are near,
// by the way that they come through each other, and by where they stand at the end. What has been
// pressed through by a fast motion is therefore pushed back to where it came from.
//
// Points of one part that lie within twice the thickness at rest, or share a triangle, do not
// touch; nor do its cells within two of each other that face the same way.
// Points that come to a rim from the side, in the plane of the sheet, meet no triangle: sheets that
// lie in one plane and meet rim to rim are not kept apart.

#include "physics/body/corner_body.hpp"
#include "physics/body/plane_touch.hpp"
#include "physics/body/sheet_cells.hpp"

#include <vector>

namespace physics {

// A step in which corners go from x0 to x1, by slot, four numbers each.
struct SheetStep {
    const double* x0;
    const double* x1;
    double dt = 0;                   // s
    const std::vector<Grip>& grips;  // that it began with
};

// The deepest grip of the point of a touch beside what it touches: within two cells in the same
// sheet, with a normal within 60 degrees. Null where there is none.
const Grip* grip_beside(const CornerBody& body, const std::vector<Grip>& grips,
                        const PlaneTouch& touch);

// Whether two cells are of one sheet of a body, and within two of each other along it.
bool are_beside(const CornerBody& body, const SheetCells& cells, std::uint32_t a, std::uint32_t b);

// A tree of the same shape as at rest, around where its items are now.
geometry::BoxTree fitted(const geometry::BoxTree& tree, const std::vector<geometry::Box3f>& boxes);

// The planes of all that meets or comes near, in_order(), without those that are `known`. `body`
// has sheets.
std::vector<PlaneTouch> find_sheet_touches(const CornerBody& body, const SheetStep& step,
                                           const std::vector<PlaneTouch>& known = {});

}  // namespace physics
