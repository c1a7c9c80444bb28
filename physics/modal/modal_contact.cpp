#include "physics/modal/modal_contact.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/collider_contact.hpp"
#include "physics/modal/oscillator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace physics {
namespace {

// A vertex that would be inside of a collider.
struct VertexStop {
    std::uint32_t vertex = 0;
    double gap = 0;             // m, where `base` has the modes
    std::vector<double> along;  // k, phi_k . n
    double gives = 0;           // m / (N s)
    double impulse = 0;         // N s
};

Vec3 place_of(const StoppedModes& modes, std::span<const double> q, const Vec3& base,
              std::uint32_t v)
{
    Vec3 p = modes.rest.positions[v].cast<double>() + base;
    for (std::size_t k = 0; k < q.size(); ++k) p += q[k] * modes.shape[k][v].cast<double>();
    return p;
}

class Stops {
public:
    // `start`: q when the step begins.
    Stops(const StoppedModes& modes, const ModalContactStep& step, std::span<const double> start)
        : modes_(modes), step_(step), start_(start.begin(), start.end())
    {
        const geometry::Box box = geometry::bounds(modes.rest);
        for (const Collider& collider : step.colliders) {
            posed_.push_back(
                pose_collider(collider, step.end, step.frame, 0.01 * box.diagonal(), step.first));
        }
    }

    // Takes up the vertices that are inside where the modes are at q. Returns the deepest, m.
    double find(const std::vector<double>& q)
    {
        const std::size_t n = modes_.rest.positions.size();
        std::vector<Touch> worst(n);
        geometry::parallel_for(n, 512, [&](std::size_t begin, std::size_t end) {
            for (std::size_t v = begin; v < end; ++v) {
                const auto number = static_cast<std::uint32_t>(v);
                const Vec3 p = place_of(modes_, q, step_.base, number);
                const Vec3 from = place_of(modes_, start_, step_.base - step_.way, number);
                for (const PosedCollider& collider : posed_) {
                    const Touch at = touch(collider, p, (p - from) / step_.h, step_.h);
                    if (at.gap < worst[v].gap) worst[v] = at;
                }
            }
        });
        double deepest = 0;
        for (std::uint32_t v = 0; v < n; ++v) {
            if (!(worst[v].gap < 0)) continue;
            deepest = std::max(deepest, -worst[v].gap);
            add(v, worst[v], q);
        }
        return deepest;
    }

    // Changes the modes' velocities so that no vertex that is known is inside; `a`: a_k, `q`: at
    // the end of the step, which follows.
    void solve(const std::vector<double>& a, std::vector<double>& q, std::span<double> q_dot)
    {
        constexpr int most = 200;
        constexpr double enough = 1e-9;
        for (VertexStop& stop : all_) {
            stop.gives = 0;
            for (std::size_t k = 0; k < a.size(); ++k) {
                stop.gives += a[k] * stop.along[k] * stop.along[k];
            }
        }
        for (int round = 0; round < most; ++round) {
            double change = 0;
            for (VertexStop& stop : all_) change = std::max(change, visit(a, stop, q, q_dot));
            if (!(change > enough)) break;
        }
    }

private:
    void add(std::uint32_t v, const Touch& at, const std::vector<double>& q)
    {
        VertexStop stop{v, at.gap, std::vector<double>(q.size()), 0, 0};
        double moved = 0;
        for (std::size_t k = 0; k < q.size(); ++k) {
            stop.along[k] = modes_.shape[k][v].cast<double>().dot(at.normal);
            moved += stop.along[k] * q[k];
        }
        stop.gap -= moved;  // with the modes at 0
        all_.push_back(std::move(stop));
    }

    // Returns by how much the vertex moves, m.
    static double visit(const std::vector<double>& a, VertexStop& stop, std::vector<double>& q,
                        std::span<double> q_dot)
    {
        if (!(stop.gives > 0)) return 0;
        double gap = stop.gap;
        for (std::size_t k = 0; k < q.size(); ++k) gap += stop.along[k] * q[k];
        const double before = stop.impulse;
        stop.impulse = std::max(0.0, before - gap / stop.gives);
        const double more = stop.impulse - before;
        for (std::size_t k = 0; k < q.size(); ++k) {
            q_dot[k] += stop.along[k] * more;
            q[k] += a[k] * stop.along[k] * more;
        }
        return std::abs(more) * stop.gives;
    }

    const StoppedModes& modes_;
    const ModalContactStep& step_;
    std::vector<double> start_;
    std::vector<PosedCollider> posed_;
    std::vector<VertexStop> all_;
};

}  // namespace

double step_on_colliders(const StoppedModes& modes, const ModalContactStep& step,
                         std::span<double> q, std::span<double> q_dot)
{
    const std::size_t count = modes.omega_sq.size();
    std::vector<OscillatorStep> swing;
    std::vector<double> end(count), a(count);
    for (std::size_t k = 0; k < count; ++k) {
        swing.push_back(oscillator_step(modes.omega_sq[k], modes.damping[k], step.h));
        double at = q[k], speed = q_dot[k];
        swing[k].apply(at, speed, step.load[k]);
        end[k] = at;
        a[k] = swing[k].x_of_v;
    }
    // Vertices that others push inside are taken up in the next round.
    constexpr int rounds = 3;
    constexpr double enough = 1e-7;  // m
    Stops stops(modes, step, q);
    double deepest = stops.find(end);
    for (int round = 0; deepest > enough && round < rounds; ++round) {
        stops.solve(a, end, q_dot);
        deepest = stops.find(end);
    }
    for (std::size_t k = 0; k < count; ++k) swing[k].apply(q[k], q_dot[k], step.load[k]);
    return deepest;
}

int contact_steps(std::span<const double> omega_sq, double dt)
{
    constexpr double most = 2000;
    const double fastest =
        omega_sq.empty() ? 0 : std::sqrt(*std::max_element(omega_sq.begin(), omega_sq.end()));
    const double steps = std::max(8.0, std::ceil(dt * fastest));
    if (steps <= most) return static_cast<int>(steps);
    throw std::invalid_argument(fmt::format(
        "on colliders a mode of {:.4g} Hz takes {:.0f} steps in {:.3g} s, more than {:.0f}. Find "
        "fewer modes (Modes, count), or unlink the colliders",
        fastest / (2 * std::numbers::pi), steps, dt, most));
}

}  // namespace physics
