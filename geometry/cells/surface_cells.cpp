// A triangle and a cube miss each other when one of 13 axes separates them:
//   Akenine-Moller. Fast 3D triangle-box overlap testing. Journal of Graphics Tools 6(1), 2001.
// Nine of the axes lie in a coordinate plane, so they are edge tests of the triangle's three flat
// projections, and each test is linear in the cell's coordinates:
//   Schwarz, Seidel. Fast parallel surface and solid voxelization on GPUs. SIGGRAPH Asia 2010.
// So nothing is tested cell by cell. Along a row each test admits an interval of cells, and
//   cells in row (y, z) = xy interval(y)  and  xz interval(z)  and  plane interval(y, z),
//   y in yz interval(z).
// Work follows rows that the triangle meets, not its bounding box.
//
// One edge of a projection, from a to b, normal n turned inward; cell (i, j) is not outside when
//   max over the cell of n.(s - a) = n_u i + n_v j + max(n_u, 0) + max(n_v, 0) - n.a >= 0
// and on equality the maximum must belong to the cell: it lies on an upper face when n has a
// positive component. For a cube's interior it never does.

#include "geometry/cells/surface_cells.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cells/cell_masks.hpp"
#include "geometry/mesh/mesh.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

struct Interval {
    int lo, hi;  // both included; empty when lo > hi

    void meet(const Interval& other)
    {
        lo = std::max(lo, other.lo);
        hi = std::min(hi, other.hi);
    }
};

// gu i + gv j + gw k + c >= least
struct Linear {
    double gu = 0, gv = 0, gw = 0, c = 0;
    double least = 0;  // 0, or the smallest positive number where equality does not count

    // 1 / gu, and how near to a whole number a solution must be tried out: needed for long rows.
    double inverse = 0, doubt = 0;

    void exclude_equality() { least = std::numeric_limits<double>::denorm_min(); }
    void ready(double magnitude)
    {
        inverse = 1 / gu;  // infinite when unused
        doubt = 1e-9 + 1e-14 * magnitude * std::abs(inverse);
    }
    double rest(double j, double k) const { return gv * j + gw * k + c; }
    bool holds(double i, double rest) const { return gu * i + rest >= least; }

    // The i in 0..n-1 where it holds, given rest = gv j + gw k + c.
    Interval solve(double rest, int n) const
    {
        if (gu == 0) return holds(0, rest) ? Interval{0, n - 1} : Interval{0, -1};
        const double t = std::clamp(-rest * inverse, -1.0, static_cast<double>(n));
        int below = static_cast<int>(t + 1) - 1;  // floor
        const double over = t - below;
        if (over < doubt || over > 1 - doubt) {
            if (over > 0.5) ++below;
            const bool at = holds(below, rest);
            return gu > 0 ? Interval{at ? below : below + 1, n - 1}
                          : Interval{0, at ? below : below - 1};
        }
        return gu > 0 ? Interval{below + 1, n - 1} : Interval{0, below};
    }
};

// Rows up to this long are walked in from both ends, longer ones solved for.
constexpr int short_row = 6;

// The part of `cells` where all tests hold; what holds for two cells holds between them.
template <std::size_t N>
void trim(const std::array<Linear, N>& tests, const std::array<double, N>& rest, Interval& cells,
          int n)
{
    if (cells.hi - cells.lo >= short_row) {
        for (std::size_t k = 0; k < N; ++k) cells.meet(tests[k].solve(rest[k], n));
        return;
    }
    const auto hold = [&](int i) {
        bool all = true;
        for (std::size_t k = 0; k < N; ++k) all &= tests[k].holds(i, rest[k]);
        return all;
    };
    while (cells.lo <= cells.hi && !hold(cells.lo)) ++cells.lo;
    while (cells.lo < cells.hi && !hold(cells.hi)) --cells.hi;
}

// The three edge tests of the projection on axes u and v, as intervals in u for each v.
struct Projection {
    std::array<Linear, 3> edges;

    Projection(const std::array<Vec3, 3>& p, int u, int v, CellShape shape, int cells)
    {
        const double turn =
            (p[1][u] - p[0][u]) * (p[2][v] - p[0][v]) - (p[1][v] - p[0][v]) * (p[2][u] - p[0][u]);
        const double sign = turn < 0 ? -1 : 1;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 &a = p[k], &b = p[(k + 1) % 3];
            Linear& e = edges[k];
            e.gu = -sign * (b[v] - a[v]);
            e.gv = sign * (b[u] - a[u]);
            const double at = e.gu * a[u] + e.gv * a[v];
            e.c = std::max(e.gu, 0.0) + std::max(e.gv, 0.0) - at;
            const bool point = e.gu == 0 && e.gv == 0;
            if (!point && (shape == CellShape::interior || e.gu > 0 || e.gv > 0))
                e.exclude_equality();
            if (cells > short_row) e.ready(std::abs(e.c) + std::abs(at));
        }
    }

    Interval row(int j, int n) const
    {
        Interval cells{0, n - 1};
        trim(edges, {edges[0].rest(j, 0), edges[1].rest(j, 0), edges[2].rest(j, 0)}, cells, n);
        return cells;
    }
};

class TriangleScan {
public:
    TriangleScan(CellSet& out, CellShape shape) : out_(out), shape_(shape) {}

    void add(const Vec3& a, const Vec3& b, const Vec3& c)
    {
        const Vec3 min = a.cwiseMin(b).cwiseMin(c), max = a.cwiseMax(b).cwiseMax(c);
        const Vec3i lo = cell_of(min);
        Vec3i hi = cell_of(max);
        if (shape_ == CellShape::interior) {  // a cell that is only reached is not entered
            for (int k = 0; k < 3; ++k) hi[k] -= hi[k] == max[k];
        }
        const Vec3i n = hi - lo + Vec3i::Ones();
        if ((n.array() < 1).any()) return;  // it lies in a face
        // Inside one row the triangle, connected, meets every cell between its ends.
        if (n.y() == 1 && n.z() == 1) return out_.insert_run(lo.x(), hi.x(), lo.y(), lo.z());
        if (n.maxCoeff() <= SmallTriangles::reach) {
            small_.add(a, b, c, lo, n);
            if (small_.count == SmallTriangles::most) finish();
            return;
        }
        const Vec3 base = lo.cast<double>();
        const std::array<Vec3, 3> p{a - base, b - base, c - base};
        if (n.z() == 1) return flat_rows(p, lo, n);
        rows(p, lo, n);
    }

    // Most triangles of a fine mesh are small and wait for others like them: the same tests on
    // several at a time. To be called after the last.
    void finish()
    {
        find_cells(small_, shape_ == CellShape::interior);
        for (std::size_t i = 0; i < small_.count; ++i) {
            out_.insert_layers(small_.lo[i], small_.n[i].z(), small_.layer[0] + i,
                               SmallTriangles::most);
        }
        small_.count = 0;
    }

private:
    // One layer thick: the projection alone decides.
    void flat_rows(const std::array<Vec3, 3>& p, const Vec3i& lo, const Vec3i& n)
    {
        const Projection xy(p, 0, 1, shape_, n.x());
        for (int y = 0; y < n.y(); ++y) emit(xy.row(y, n.x()), lo, y, 0);
    }

    void rows(const std::array<Vec3, 3>& p, const Vec3i& lo, const Vec3i& n)
    {
        const Projection yz(p, 1, 2, shape_, n.y());
        if (n.x() == 1) {
            for (int z = 0; z < n.z(); ++z) {
                const Interval ys = yz.row(z, n.y());
                for (int y = ys.lo; y <= ys.hi; ++y) emit({0, 0}, lo, y, z);
            }
            return;
        }
        const Projection xz(p, 0, 2, shape_, n.x());
        if (n.y() == 1) {
            for (int z = 0; z < n.z(); ++z) emit(xz.row(z, n.x()), lo, 0, z);
            return;
        }
        const Projection xy(p, 0, 1, shape_, n.x());
        xy_.resize(static_cast<std::size_t>(n.y()));
        for (int y = 0; y < n.y(); ++y) xy_[static_cast<std::size_t>(y)] = xy.row(y, n.x());
        const std::array<Linear, 2> plane = both_sides(p, n.x());
        for (int z = 0; z < n.z(); ++z) {
            const Interval ys = yz.row(z, n.y()), xs = xz.row(z, n.x());
            for (int y = ys.lo; y <= ys.hi; ++y) {
                Interval cells = xy_[static_cast<std::size_t>(y)];
                cells.meet(xs);
                trim(plane, {plane[0].rest(y, z), plane[1].rest(y, z)}, cells, n.x());
                emit(cells, lo, y, z);
            }
        }
    }

    // The cube must reach both sides of the triangle's plane, as two tests.
    std::array<Linear, 2> both_sides(const std::array<Vec3, 3>& p, int cells) const
    {
        const Vec3 normal = (p[1] - p[0]).cross(p[2] - p[0]);
        const auto side = [&](const Vec3& g) {
            const double at = g.dot(p[0]);
            Linear test{g.x(), g.y(), g.z(), g.cwiseMax(0.0).sum() - at};
            if (!g.isZero(0) && (shape_ == CellShape::interior || (g.array() > 0).any())) {
                test.exclude_equality();
            }
            if (cells > short_row) {
                test.ready(g.cwiseAbs().dot(p[0].cwiseAbs()) + g.cwiseAbs().sum());
            }
            return test;
        };
        return {side(normal), side(-normal)};
    }

    void emit(const Interval& x, const Vec3i& lo, int y, int z)
    {
        if (x.lo <= x.hi) {
            out_.insert_run(lo.x() + x.lo, lo.x() + x.hi, lo.y() + y, lo.z() + z);
        }
    }

    CellSet& out_;
    CellShape shape_;
    std::vector<Interval> xy_;  // kept between triangles
    SmallTriangles small_;      // not yet in out_
};

}  // namespace

CellSet surface_cells(const LatticeMesh& mesh, CellShape shape, std::size_t limit)
{
    // A set for each thread; their union does not depend on who did what.
    constexpr std::size_t enough = 8192;  // triangles for a thread
    const std::size_t threads = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    const std::size_t parts = std::clamp<std::size_t>(mesh.triangles.size() / enough, 1,
                                                      std::max<std::size_t>(threads, 1));
    const std::size_t each = (mesh.triangles.size() + parts - 1) / parts;
    std::vector<CellSet> sets(parts, CellSet(limit));
    const auto scan_parts = [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            TriangleScan scan(sets[i], shape);
            const std::size_t last = std::min((i + 1) * each, mesh.triangles.size());
            StopCheck check;
            for (std::size_t t = i * each; t < last; ++t) {
                check();
                const auto& [a, b, c] = mesh.triangles[t];
                scan.add(mesh.positions[a], mesh.positions[b], mesh.positions[c]);
            }
            scan.finish();
        }
    };
    parallel_for(parts, 1, scan_parts);
    for (std::size_t i = 1; i < parts; ++i) sets[0].unite(sets[i]);
    return std::move(sets[0]);
}

}  // namespace geometry
