#pragma once

// Where lines along one axis cross the triangles of a mesh: all lines of a grid at once.
//
//        w                      Lines run along u through the middles of the rows (v, w), four by
//        |  . . . .             four of them through each cell for fine ones. Each triangle leaves
//        |  . . . .   u         a signed crossing on every line that passes through it: +1 where a
//        |  . . . .  /          line going up along u enters by its front, -1 by its back.
//        +---------- v
//
//   w_left(u) = sum of signs at u' < u,    w_right(u) = -sum of signs at u' > u
//
// Each triangle is scan-converted in the plane across the axis. The ends of a scan line are
// computed from an edge's two vertices alone, in an order of their own, so the triangles on both
// sides of an edge agree to the last bit on which rows are whose: on a closed mesh the crossings of
// every row balance exactly, whatever rounding does.

#include "geometry/cells/inside.hpp"
#include "geometry/cells/voxel_grid.hpp"

#include <cmath>
#include <cstdlib>

namespace geometry {

// Rays run along u through rows (v, w): x, y, z in cyclic order, so that signs agree.
struct Axes {
    int u, v, w;
    explicit Axes(int axis) : u(axis), v((axis + 1) % 3), w((axis + 2) % 3) {}
};

struct Crossing {
    double u;  // in cells
    int v;     // row
    int sign;
};

// Crossings layer by layer of equal w row, each sorted by (v, u).
struct Crossings {
    int first_layer = 0;
    std::vector<std::size_t> layer;  // starts, and the end of the last
    std::vector<Crossing> all;

    std::span<const Crossing> in_layer(int w) const
    {
        const int i = w - first_layer;
        if (i < 0 || i + 1 >= static_cast<int>(layer.size())) return {};
        const auto k = static_cast<std::size_t>(i);
        return std::span(all).subspan(layer[k], layer[k + 1] - layer[k]);
    }
};

// First whole number whose centre (i + 1/2) is not below x.
inline int first_centre(double x)
{
    return static_cast<int>(std::ceil(x - 0.5));
}

// How far lines lie off the middles of their rows, in cells.
//
// Two mirrored halves of a model often leave a slit where they meet, and a grid over the model has
// rows whose middles lie in it, so that lines there would pass between all faces. Lines of open
// meshes are moved off by more than half of such a slit. They are moved up along v and down along
// w: of the three axes' lines through a point near a plane across an axis, one stays and the other
// two go to either side, so that what two of them say is as before.
struct LineOffset {
    double v = 0, w = 0;
};
LineOffset line_offset(const LatticeMesh& mesh);

// Crossings of the lines v = (row + 1/2) / per_cell + offset, w likewise.
Crossings find_crossings(const LatticeMesh& mesh, const Axes& axes, int per_cell);

inline int sign_of(int x)
{
    return (x > 0) - (x < 0);
}

// What the two rays along a line vote at a point with `left` crossings (their sum for winding,
// their number for parity) on one side, of `total` on the line.
inline int two_votes(Inside rule, int left, int total)
{
    if (rule == Inside::parity) return (left & 1) + ((total - left) & 1);
    return sign_of(left) + sign_of(left - total);
}

inline int weight(Inside rule, const Crossing& c)
{
    return rule == Inside::parity ? 1 : c.sign;
}

}  // namespace geometry
