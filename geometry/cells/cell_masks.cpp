// A triangle a lane: the tests of all cells of its box, one cell of every triangle at a time.

#include "geometry/cells/cell_masks.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "geometry/cells/cell_masks.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace geometry {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::CappedTag<double, SmallTriangles::reach>;
using V = hn::Vec<D>;
using M = hn::Mask<D>;
using Bits = hn::Rebind<std::uint64_t, D>;
using B = hn::Vec<Bits>;

HWY_INLINE V positive(V x)
{
    return hn::Max(x, hn::Zero(D()));
}

// The least value that passes: 0, or where equality does not count the smallest number above.
HWY_INLINE V least(M closed)
{
    return hn::IfThenElse(closed, hn::Zero(D()),
                          hn::Set(D(), std::numeric_limits<double>::denorm_min()));
}

// gu i + gv j + c >= least
struct Edge {
    V gu, gv, c, least;
};

// The three edges of a projection, corners (u[k], v[k]).
HWY_INLINE void edges_of(const V (&u)[3], const V (&v)[3], bool interior, Edge (&out)[3])
{
    const D d;
    const V turn = hn::Sub(hn::Mul(hn::Sub(u[1], u[0]), hn::Sub(v[2], v[0])),
                           hn::Mul(hn::Sub(v[1], v[0]), hn::Sub(u[2], u[0])));
    const V zero = hn::Zero(d);
    const M clockwise = hn::Lt(turn, zero);
    for (int k = 0; k < 3; ++k) {
        const int next = k < 2 ? k + 1 : 0;
        const V du = hn::Sub(u[next], u[k]), dv = hn::Sub(v[next], v[k]);
        const V gu = hn::IfThenElse(clockwise, dv, hn::Neg(dv));
        const V gv = hn::IfThenElse(clockwise, hn::Neg(du), du);
        const V at = hn::Add(hn::Mul(gu, u[k]), hn::Mul(gv, v[k]));
        M closed = hn::And(hn::Eq(gu, zero), hn::Eq(gv, zero));  // a point
        if (!interior) {
            closed = hn::Or(closed, hn::And(hn::Le(gu, zero), hn::Le(gv, zero)));
        }
        out[k] = {gu, gv, hn::Sub(hn::Add(positive(gu), positive(gv)), at), least(closed)};
    }
}

// Calls pass(i, j, mask) for each cell of a projection, mask: lanes whose triangle covers it.
template <class Pass>
HWY_INLINE void project(const V (&u)[3], const V (&v)[3], bool interior, int ni, int nj,
                        const Pass& pass)
{
    const D d;
    Edge edges[3];
    edges_of(u, v, interior, edges);
    for (int j = 0; j < nj; ++j) {
        V rest[3];
        for (int k = 0; k < 3; ++k) {
            rest[k] = hn::Add(hn::Mul(edges[k].gv, hn::Set(d, j)), edges[k].c);
        }
        for (int i = 0; i < ni; ++i) {
            const V at = hn::Set(d, i);
            M all = hn::Ge(hn::Add(hn::Mul(edges[0].gu, at), rest[0]), edges[0].least);
            for (int k = 1; k < 3; ++k) {
                all = hn::And(all,
                              hn::Ge(hn::Add(hn::Mul(edges[k].gu, at), rest[k]), edges[k].least));
            }
            pass(i, j, all);
        }
    }
}

HWY_INLINE B bits_where(M mask, std::uint64_t bits)
{
    const Bits d;
    return hn::IfThenElseZero(hn::RebindMask(d, mask), hn::Set(d, bits));
}

// The triangle's plane against a cell, from one side: g . (i, j, k) + c >= least.
struct Side {
    V g[3], c, least;

    HWY_INLINE Side(const V (&normal)[3], const V (&a)[3], bool interior)
    {
        const D d;
        const V zero = hn::Zero(d);
        c = zero;
        V at = zero;
        M closed = hn::Eq(zero, zero), none = closed;
        for (int k = 0; k < 3; ++k) {
            g[k] = normal[k];
            c = hn::Add(c, positive(g[k]));
            at = hn::Add(at, hn::Mul(g[k], a[k]));
            closed = hn::And(closed, hn::Le(g[k], zero));
            none = hn::And(none, hn::Eq(g[k], zero));
        }
        c = hn::Sub(c, at);
        least = HWY_NAMESPACE::least(interior ? none : closed);
    }
    HWY_INLINE V row(int j, int k) const
    {
        const D d;
        return hn::Add(hn::Add(hn::Mul(g[1], hn::Set(d, j)), hn::Mul(g[2], hn::Set(d, k))), c);
    }
    HWY_INLINE M reaches(int i, V row) const
    {
        return hn::Ge(hn::Add(hn::Mul(g[0], hn::Set(D(), i)), row), least);
    }
};

HWY_INLINE V product_difference(V a, V b, V c, V d)
{
    return hn::Sub(hn::Mul(a, b), hn::Mul(c, d));
}

// Lanes from `first` on.
void find_some(SmallTriangles& t, std::size_t first, bool interior)
{
    const D d;
    const Bits bits;
    Vec3i n = Vec3i::Ones();
    for (std::size_t i = first; i < std::min(first + hn::Lanes(d), t.count); ++i) {
        n = n.cwiseMax(t.n[i]);
    }
    V p[3][3];  // by axis, then corner
    for (int k = 0; k < 3; ++k) {
        for (int axis = 0; axis < 3; ++axis) p[axis][k] = hn::LoadU(d, t.p[3 * k + axis] + first);
    }
    B xy = hn::Zero(bits), xs_of_z[SmallTriangles::reach], ys_of_z[SmallTriangles::reach];
    for (int z = 0; z < n.z(); ++z) xs_of_z[z] = ys_of_z[z] = hn::Zero(bits);
    constexpr std::uint64_t row = 0xff, column = 0x0101010101010101;
    project(p[0], p[1], interior, n.x(), n.y(), [&](int x, int y, M mask) HWY_ATTR {
        xy = hn::Or(xy, bits_where(mask, std::uint64_t{1} << (8 * y + x)));
    });
    xy = hn::And(xy, hn::LoadU(bits, t.box + first));
    project(p[0], p[2], interior, n.x(), n.z(), [&](int x, int z, M mask) HWY_ATTR {
        xs_of_z[z] = hn::Or(xs_of_z[z], bits_where(mask, column << x));
    });
    project(p[1], p[2], interior, n.y(), n.z(), [&](int y, int z, M mask) HWY_ATTR {
        ys_of_z[z] = hn::Or(ys_of_z[z], bits_where(mask, row << (8 * y)));
    });

    V e[3], f[3], a[3];
    for (int k = 0; k < 3; ++k) {
        e[k] = hn::Sub(p[k][1], p[k][0]);
        f[k] = hn::Sub(p[k][2], p[k][0]);
        a[k] = p[k][0];
    }
    const V up[3] = {product_difference(e[1], f[2], e[2], f[1]),
                     product_difference(e[2], f[0], e[0], f[2]),
                     product_difference(e[0], f[1], e[1], f[0])};
    const V down[3] = {hn::Neg(up[0]), hn::Neg(up[1]), hn::Neg(up[2])};
    const Side above(up, a, interior), below(down, a, interior);
    for (int z = 0; z < n.z(); ++z) {
        const B flat = hn::And(xy, hn::And(xs_of_z[z], ys_of_z[z]));
        B crossed = hn::Zero(bits);
        for (int y = 0; y < n.y(); ++y) {
            const V row_above = above.row(y, z), row_below = below.row(y, z);
            for (int x = 0; x < n.x(); ++x) {
                const M mask = hn::And(above.reaches(x, row_above), below.reaches(x, row_below));
                crossed = hn::Or(crossed, bits_where(mask, std::uint64_t{1} << (8 * y + x)));
            }
        }
        hn::StoreU(hn::And(flat, crossed), bits, t.layer[z] + first);
    }
}

void find_all(SmallTriangles& triangles, bool interior)
{
    for (std::size_t i = 0; i < triangles.count; i += hn::Lanes(D())) {
        find_some(triangles, i, interior);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace geometry
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace geometry {

HWY_EXPORT(find_all);

void SmallTriangles::add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3i& first,
                         const Vec3i& cells)
{
    constexpr std::uint64_t column = 0x0101010101010101;
    const std::size_t i = count++;
    lo[i] = first;
    n[i] = cells;
    box[i] = column * ((1u << cells.x()) - 1) & ~std::uint64_t{0} >> (64 - 8 * cells.y());
    const Vec3 base = first.cast<double>();
    for (int k = 0; k < 3; ++k) {
        p[k][i] = a[k] - base[k];
        p[3 + k][i] = b[k] - base[k];
        p[6 + k][i] = c[k] - base[k];
    }
}

void find_cells(SmallTriangles& triangles, bool interior)
{
    // Lanes beyond the last triangle repeat it.
    for (std::size_t i = triangles.count; i > 0 && i < SmallTriangles::most && i % 8 != 0; ++i) {
        for (auto& coordinate : triangles.p) coordinate[i] = coordinate[i - 1];
        triangles.box[i] = triangles.box[i - 1];
    }
    HWY_DYNAMIC_DISPATCH(find_all)(triangles, interior);
}

}  // namespace geometry
#endif
