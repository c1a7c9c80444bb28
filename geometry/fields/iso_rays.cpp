#include "geometry/fields/iso_rays.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace geometry {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A ray on its way through the grid, a cell at a time.
//   Amanatides, Woo. A fast voxel traversal algorithm for ray tracing. Eurographics 1987.
struct CellWalk {
    Vec3i at = Vec3i::Zero(), step = Vec3i::Zero();
    Vec3 next = Vec3::Zero();   // t at which the ray leaves the cell across each axis
    Vec3 delta = Vec3::Zero();  // t from one such place to the next
    double in = 0;              // t at which it came into the cell

    double out() const { return next.minCoeff(); }
};

// Puts the walk into the grid's first cell on the ray. False when the ray passes by.
bool start(const IsoCells& cells, const Ray& ray, CellWalk& walk)
{
    if (cells.bounds.empty()) return false;
    double begin = ray.begin, end = ray.end;
    for (int k = 0; k < 3; ++k) {
        if (ray.direction[k] == 0) {
            if (ray.origin[k] < cells.bounds.lo[k] || ray.origin[k] > cells.bounds.hi[k]) {
                return false;
            }
            continue;
        }
        const double a = (cells.bounds.lo[k] - ray.origin[k]) / ray.direction[k];
        const double b = (cells.bounds.hi[k] - ray.origin[k]) / ray.direction[k];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    if (!(begin < end)) return false;
    const Vec3 p = ray.origin + begin * ray.direction;
    walk.in = begin;
    for (int k = 0; k < 3; ++k) {
        const double place = (p[k] - cells.lo[k]) / cells.cell;
        walk.at[k] = static_cast<int>(
            std::clamp(std::floor(place), 0.0, static_cast<double>(cells.dims[k] - 1)));
        const double d = ray.direction[k];
        walk.step[k] = d < 0 ? -1 : 1;
        walk.delta[k] = d == 0 ? infinity : cells.cell / std::abs(d);
        const double face = cells.lo[k] + cells.cell * (walk.at[k] + (d < 0 ? 0 : 1));
        walk.next[k] = d == 0 ? infinity : std::max((face - ray.origin[k]) / d, begin);
    }
    return true;
}

// To the next cell; false when that is outside the grid.
bool advance(const IsoCells& cells, CellWalk& walk)
{
    int axis = 0;
    walk.in = walk.next.minCoeff(&axis);
    walk.at[axis] += walk.step[axis];
    walk.next[axis] += walk.delta[axis];
    return walk.at[axis] >= 0 && walk.at[axis] < cells.dims[axis];
}

struct Sample {
    double t = 0, f = 0, slope = 0;  // slope: df/dt
    Vec3 gradient = Vec3::Zero();
};

// What becomes of a ray with its next sample.
enum class Phase : std::uint8_t { enter, march, peak, refine, done };

struct Marcher {
    Phase phase = Phase::done;
    std::uint32_t ray = 0;
    double t = 0;                 // where the next sample is taken
    double sign = 0;              // 1: it started outside, -1: inside; 0: not known yet
    double speed = 1, least = 0;  // length of the direction; t that is within the tolerance
    int rounds = 0;
    CellWalk walk;
    Sample a, b;  // the last two; a bracket; the ends of a peak
    Sample resume;
};

class Tracer {
public:
    Tracer(const IsoCells& cells, std::span<const Ray> rays, std::span<RayHit> hits)
        : cells_(cells), rays_(rays), hits_(hits)
    {}

    bool begin(std::uint32_t ray, double tolerance, Marcher& m) const
    {
        m = {};
        m.ray = ray;
        m.speed = rays_[ray].direction.norm();
        m.least = tolerance / m.speed;
        if (!start(cells_, rays_[ray], m.walk)) return false;
        if (m.walk.in > rays_[ray].begin) m.sign = 1;  // all that the surface encloses is in there
        return to_crossed(m);
    }

    Vec3 place(const Marcher& m) const
    {
        return rays_[m.ray].origin + m.t * rays_[m.ray].direction;
    }

    void take(Marcher& m, double f, const Vec3& gradient) const
    {
        if (m.sign == 0) m.sign = f >= touching ? -1 : 1;
        Sample s{m.t, m.sign * f, m.sign * gradient.dot(rays_[m.ray].direction), gradient};
        switch (m.phase) {
        case Phase::enter:
            if (s.f >= -touching) return hit(m, s.t, s);
            m.a = m.b = s;
            return go_on(m);
        case Phase::march:
            m.a = m.b;
            m.b = s;
            if (s.f >= 0) return close_in(m);
            if (may_peak(m.a, m.b)) {
                m.resume = m.b;
                m.rounds = 0;
                return climb(m);
            }
            return go_on(m);
        case Phase::peak:
            return take_peak(m, s);
        case Phase::refine:
            (s.f < 0 ? m.a : m.b) = s;
            return refine(m);
        case Phase::done:
            return;
        }
    }

private:
    static constexpr double touching = 1e-10;  // of the field: no more than rounding

    double slope(const Marcher& m) const
    {
        return static_cast<double>(cells_.slope[cells_.index(m.walk.at)]) * m.speed;
    }

    // To the next cell that the surface may pass, where the next sample is its entry.
    bool to_crossed(Marcher& m) const
    {
        while (!(cells_.slope[cells_.index(m.walk.at)] > 0)) {
            if (!advance(cells_, m.walk)) return false;
        }
        if (!(m.walk.in < rays_[m.ray].end)) return false;
        m.phase = Phase::enter;
        m.t = m.walk.in;
        return true;
    }

    void leave(Marcher& m) const
    {
        if (!to_crossed(m)) m.phase = Phase::done;
    }

    // Onward from m.b, which is outside.
    void go_on(Marcher& m) const
    {
        const Sample& from = m.b;
        // Newton's step from outside that is as good as none.
        if (from.slope > 0 && -from.f < m.least * from.slope) {
            return hit(m, from.t - from.f / from.slope, from);
        }
        double t = from.t, budget = -from.f, leap = 0;
        for (;;) {
            const double L = slope(m), stay = m.walk.out() - t;
            leap = static_cast<double>(cells_.leap[cells_.index(m.walk.at)]);
            if (budget - leap < L * stay) {
                t += std::max(0.0, budget - leap) / L;
                break;
            }
            if (stay > 0) budget -= L * stay;
            t = std::max(t, m.walk.out());
            if (!advance(cells_, m.walk) || t >= rays_[m.ray].end) {
                m.phase = Phase::done;
                return;
            }
            if (!(cells_.slope[cells_.index(m.walk.at)] > 0)) return leave(m);
        }
        const double newton = from.slope > 0 ? from.t - from.f / from.slope : infinity;
        // Where f may jump, no slope tells of a thin sheet: smaller steps do.
        const double h = (leap > 0 ? 1.0 / 16 : 0.25) * cells_.cell / m.speed;
        const double to = std::max({t, std::min(newton, t + h), from.t + m.least});
        m.phase = Phase::march;
        m.t = std::min(to, rays_[m.ray].end);
        // As far as the cells are crossed; at the last one's far side the next sample.
        while (m.walk.out() < m.t) {
            CellWalk on = m.walk;
            if (!advance(cells_, on) || !(cells_.slope[cells_.index(on.at)] > 0)) {
                m.t = m.walk.out();
                break;
            }
            m.walk = on;
        }
        if (m.t > from.t) return;
        m.t = from.t;  // it stands at its end: nothing is left between
        if (!advance(cells_, m.walk)) {
            m.phase = Phase::done;
            return;
        }
        leave(m);
    }

    // Whether lines four times as steep as the tangents of a and b, both outside, meet above the
    // surface's level between them.
    static bool may_peak(const Sample& a, const Sample& b)
    {
        if (!(a.slope > 0 && b.slope < 0)) return false;
        const double dt = b.t - a.t;
        const double x = (b.f - 4 * b.slope * dt - a.f) / (4 * (a.slope - b.slope));
        return a.f + 4 * a.slope * x >= 0;
    }

    // The next sample is taken where the cubic through a and b is highest.
    void climb(Marcher& m) const
    {
        const double dt = m.b.t - m.a.t;
        const double c1 = m.a.slope * dt;
        const double c2 = 3 * (m.b.f - m.a.f) - (2 * m.a.slope + m.b.slope) * dt;
        const double c3 = 2 * (m.a.f - m.b.f) + (m.a.slope + m.b.slope) * dt;
        const double root = std::sqrt(std::max(0.0, c2 * c2 - 3 * c3 * c1));
        double s = c1 / (root - c2);
        if (!(s > 0.02 && s < 0.98)) s = 0.5;
        m.phase = Phase::peak;
        m.t = m.a.t + s * dt;
    }

    void take_peak(Marcher& m, const Sample& s) const
    {
        if (s.f >= 0) {
            m.b = s;
            return close_in(m);
        }
        (s.slope > 0 ? m.a : m.b) = s;
        if (may_peak(m.a, m.b) && m.b.t - m.a.t > m.least && ++m.rounds < 30) return climb(m);
        m.b = m.resume;
        go_on(m);
    }

    void close_in(Marcher& m) const
    {
        m.rounds = 0;
        m.phase = Phase::refine;
        refine(m);
    }

    // Newton's step from the nearer end of the bracket; where that leads out of it, or is slow,
    // the chord's crossing, or the middle.
    void refine(Marcher& m) const
    {
        const Sample& near = -m.a.f < m.b.f ? m.a : m.b;
        const double width = m.b.t - m.a.t;
        double t = near.slope > 0 ? near.t - near.f / near.slope : infinity;
        const bool newton = t >= m.a.t && t <= m.b.t;
        if (!newton) t = m.a.t + width * m.a.f / (m.a.f - m.b.f);
        if (++m.rounds > 4 && m.rounds % 2 == 0) t = m.a.t + 0.5 * width;
        if ((newton && std::abs(t - near.t) < m.least) || width < m.least || m.rounds > 100) {
            return hit(m, std::clamp(t, m.a.t, m.b.t), near);
        }
        m.t = t;
    }

    void hit(Marcher& m, double t, const Sample& at) const
    {
        m.phase = Phase::done;
        if (t > rays_[m.ray].end) return;
        const double size = at.gradient.norm();
        hits_[m.ray].t = t;
        hits_[m.ray].normal =
            size > 0 ? Vec3(-at.gradient / size) : Vec3(-m.sign * rays_[m.ray].direction / m.speed);
    }

    const IsoCells& cells_;
    std::span<const Ray> rays_;
    std::span<RayHit> hits_;
};

}  // namespace

void trace(const IsoField& field, const IsoCells& cells, std::span<const Ray> rays,
           double tolerance, std::span<RayHit> hits)
{
    assert(rays.size() == hits.size());
    thread_local std::vector<Marcher> open;
    thread_local FieldBlock block;
    thread_local BlockValues values;
    const Tracer tracer(cells, rays, hits);
    std::fill(hits.begin(), hits.end(), RayHit{});
    std::uint32_t waiting = 0;
    open.clear();
    const auto count = static_cast<std::uint32_t>(rays.size());
    for (;;) {
        // Rays that are done make room for those that wait.
        std::size_t left = 0;
        for (std::size_t i = 0; i < open.size(); ++i) {
            if (open[i].phase == Phase::done) continue;
            if (left != i) open[left] = open[i];
            ++left;
        }
        open.resize(left);
        while (waiting < count && open.size() < FieldBlock::capacity) {
            Marcher m;
            if (tracer.begin(waiting++, tolerance, m)) open.push_back(m);
        }
        if (open.empty()) return;
        block.count = 0;
        for (const Marcher& m : open) block.add(tracer.place(m));
        block.pad();
        field.ask(block, values);
        for (std::size_t i = 0; i < open.size(); ++i) {
            tracer.take(open[i], values.f[i], values.gradient(i));
        }
    }
}

}  // namespace geometry
