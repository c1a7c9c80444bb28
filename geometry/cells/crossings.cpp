#include "geometry/cells/crossings.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <limits>

namespace geometry {
namespace {

// Where edge ab passes height w: its v and u there.
struct OnEdge {
    double v, u;
};
OnEdge at_height(const Vec3& a, const Vec3& b, double w)
{
    const Vec3 &lo = a.z() <= b.z() ? a : b, &hi = a.z() <= b.z() ? b : a;
    const double t = (w - lo.z()) / (hi.z() - lo.z());
    return {lo.y() + t * (hi.y() - lo.y()), lo.x() + t * (hi.x() - lo.x())};
}

// Calls emit(w row, crossing) for each row that the triangle crosses. Corners as (u, v, w).
template <class Emit> void scan(const Vec3& a, const Vec3& b, const Vec3& c, const Emit& emit)
{
    const int w0 = first_centre(std::min({a.z(), b.z(), c.z()}));
    const int w1 = first_centre(std::max({a.z(), b.z(), c.z()}));
    for (int w = w0; w < w1; ++w) {
        const double height = w + 0.5;
        const bool above_a = a.z() > height, above_b = b.z() > height, above_c = c.z() > height;
        OnEdge up{}, down{};
        if (above_a != above_b) (above_b ? up : down) = at_height(a, b, height);
        if (above_b != above_c) (above_c ? up : down) = at_height(b, c, height);
        if (above_c != above_a) (above_a ? up : down) = at_height(c, a, height);
        const int sign = up.v < down.v ? 1 : -1;
        const OnEdge &from = sign > 0 ? up : down, &to = sign > 0 ? down : up;
        const int v0 = first_centre(from.v), v1 = first_centre(to.v);
        const double slope = v0 < v1 ? (to.u - from.u) / (to.v - from.v) : 0;
        for (int v = v0; v < v1; ++v) {
            emit(w, Crossing{from.u + (v + 0.5 - from.v) * slope, v, sign});
        }
    }
}

}  // namespace

LineOffset line_offset(const LatticeMesh& mesh)
{
    return is_closed(mesh) ? LineOffset{} : LineOffset{0.06, -0.05};
}

Crossings find_crossings(const LatticeMesh& mesh, const Axes& axes, int per_cell)
{
    const double scale = per_cell;
    const LineOffset off = line_offset(mesh);
    std::vector<Vec3> turned(mesh.positions.size());
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (std::size_t v = 0; v < turned.size(); ++v) {
        const Vec3& p = mesh.positions[v];
        turned[v] = {p[axes.u], scale * (p[axes.v] - off.v), scale * (p[axes.w] - off.w)};
    }
    for (const Triangle& t : mesh.triangles) {
        for (const std::uint32_t v : t) {
            lo = std::min(lo, turned[v].z());
            hi = std::max(hi, turned[v].z());
        }
    }
    Crossings out;
    if (!(lo <= hi)) return out;
    out.first_layer = first_centre(lo);
    const auto layers = static_cast<std::size_t>(std::max(0, first_centre(hi) - out.first_layer));
    out.layer.assign(layers + 1, 0);
    struct Placed {
        Crossing crossing;
        int layer;
    };
    std::vector<Placed> placed;
    for (const auto& [a, b, c] : mesh.triangles) {
        scan(turned[a], turned[b], turned[c], [&](int w, const Crossing& crossing) {
            placed.push_back({crossing, w - out.first_layer});
            ++out.layer[static_cast<std::size_t>(w - out.first_layer) + 1];
        });
    }
    for (std::size_t k = 0; k < layers; ++k) out.layer[k + 1] += out.layer[k];
    std::vector<std::size_t> next(out.layer.begin(), out.layer.end());
    out.all.resize(placed.size());
    for (const Placed& p : placed) out.all[next[static_cast<std::size_t>(p.layer)]++] = p.crossing;
    parallel_for(layers, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            std::sort(out.all.begin() + static_cast<std::ptrdiff_t>(out.layer[k]),
                      out.all.begin() + static_cast<std::ptrdiff_t>(out.layer[k + 1]),
                      [](const Crossing& p, const Crossing& q) {
                          return p.v != q.v ? p.v < q.v : p.u != q.u ? p.u < q.u : p.sign < q.sign;
                      });
        }
    });
    return out;
}

}  // namespace geometry
