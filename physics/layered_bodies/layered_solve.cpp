#include "physics/layered_bodies/layered_solve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// What may change of v: still frames keep their velocity, led ones their spin.
Vec6 free_part(const LayeredSystem& system, std::size_t f, Vec6 v)
{
    if (system.kind[f] == BaseKind::still) v.setZero();
    if (system.kind[f] == BaseKind::led) v.tail<3>().setZero();
    return v;
}

// y = A x. Frames that are carried go along in x, whatever it has for them.
void multiply(LayeredSystem& system, std::vector<Vec6>& x, std::vector<Vec6>& y)
{
    take_along(system.carried, x);
    for (std::size_t f = 0; f < x.size(); ++f) y[f] = system.diagonal[f] * x[f];
    for (const SystemPair& pair : system.pairs) {
        y[pair.a] += pair.off * x[pair.b];
        y[pair.b] += pair.off.transpose() * x[pair.a];
    }
    for (const SystemStop& stop : system.stops) {
        if (!stop.held) continue;
        const double pull = stop.stiffness * stop.speed(x);
        y[stop.a] += pull * stop.along_a;
        y[stop.b] += pull * stop.along_b;
    }
    hand_on(system.carried, y);
    add_elastic(system.carriers, x, y);
    for (std::size_t f = 0; f < x.size(); ++f) y[f] = free_part(system, f, y[f]);
}

// With the stops that are held, by conjugate gradients preconditioned by the frames' own blocks.
std::vector<Vec6> solve_held(LayeredSystem& system, Report& report)
{
    const std::size_t n = system.velocity.size();
    std::vector<Mat6> blocks = system.diagonal;
    std::vector<Vec6> right = system.right;
    for (const SystemStop& stop : system.stops) {
        if (!stop.held) continue;
        const double miss = stop.stiffness * (stop.speed(system.velocity) + stop.room);
        blocks[stop.a] += stop.stiffness * stop.along_a * stop.along_a.transpose();
        blocks[stop.b] += stop.stiffness * stop.along_b * stop.along_b.transpose();
        right[stop.a] -= miss * stop.along_a;
        right[stop.b] -= miss * stop.along_b;
    }
    hand_on(system.carried, right);
    hand_on_blocks(system.carried, blocks);
    add_to_corner_blocks(system.carriers, blocks);
    std::vector<Eigen::LDLT<Mat6>> own;
    for (std::size_t f = 0; f < n; ++f) {
        if (system.kind[f] == BaseKind::led) {  // turns as told
            blocks[f].topRightCorner<3, 3>().setZero();
            blocks[f].bottomLeftCorner<3, 3>().setZero();
            blocks[f].bottomRightCorner<3, 3>().setIdentity();
        }
        if (system.kind[f] == BaseKind::carried) blocks[f].setIdentity();
        own.emplace_back(blocks[f]);
        right[f] = free_part(system, f, right[f]);
    }
    std::vector<Vec6> x(n, Vec6::Zero()), r = right, z(n), p(n), Ap(n);
    const auto dot = [&](const std::vector<Vec6>& u, const std::vector<Vec6>& v) {
        double sum = 0;
        for (std::size_t f = 0; f < n; ++f) sum += u[f].dot(v[f]);
        return sum;
    };
    for (std::size_t f = 0; f < n; ++f) p[f] = z[f] = free_part(system, f, own[f].solve(r[f]));
    double rz = dot(r, z);
    const double goal = 1e-20 * rz;
    int iteration = 0;
    for (; rz > goal && rz > 1e-290 && iteration < 1000; ++iteration) {
        multiply(system, p, Ap);
        const double alpha = rz / dot(p, Ap);
        for (std::size_t f = 0; f < n; ++f) {
            x[f] += alpha * p[f];
            r[f] -= alpha * Ap[f];
            z[f] = free_part(system, f, own[f].solve(r[f]));
        }
        const double next = dot(r, z);
        for (std::size_t f = 0; f < n; ++f) p[f] = z[f] + next / rz * p[f];
        rz = next;
    }
    report.iterations += iteration;
    if (rz > 1e-12 * std::abs(goal) * 1e20) report.converged = false;
    return x;
}

// By how much a stop has room left after dv; below 0: passed. m/s
double beyond(const LayeredSystem& system, const SystemStop& stop, const std::vector<Vec6>& dv)
{
    return stop.speed(system.velocity) + stop.speed(dv) + stop.room;
}

// Holds the stops that would be passed and lets the others go; whether that changes which are held.
bool hold_passed(LayeredSystem& system, const std::vector<Vec6>& dv)
{
    bool changed = false;
    for (SystemStop& stop : system.stops) {
        const bool passed = beyond(system, stop, dv) < 0;
        changed |= passed != stop.held;
        stop.held = passed;
    }
    return changed;
}

// What solve() minimises.
double potential(LayeredSystem& system, const std::vector<Vec6>& dv)
{
    if (system.stops.empty()) return 0;
    double sum = 0;
    for (std::size_t f = 0; f < dv.size(); ++f) {
        sum += dv[f].dot(0.5 * system.diagonal[f] * dv[f] - system.right[f]);
    }
    for (const SystemPair& pair : system.pairs) sum += dv[pair.a].dot(pair.off * dv[pair.b]);
    if (!system.carriers.empty()) {
        std::vector<Vec6> pull(dv.size(), Vec6::Zero());
        add_elastic(system.carriers, dv, pull);
        for (std::size_t f = 0; f < dv.size(); ++f) sum += 0.5 * dv[f].dot(pull[f]);
    }
    for (const SystemStop& stop : system.stops) {
        const double miss = std::min(0.0, beyond(system, stop, dv));
        sum += 0.5 * stop.stiffness * miss * miss;
    }
    return sum;
}

}  // namespace

std::vector<Vec6> solve(LayeredSystem& system, Report& report)
{
    merge_pairs(system);
    hand_on(system.carried, system.right);
    for (std::size_t f = 0; f < system.velocity.size(); ++f) {
        system.right[f] = free_part(system, f, system.right[f]);
        if (system.kind[f] == BaseKind::particles) system.right[f].tail<3>().setZero();
    }
    std::vector<Vec6> dv = solve_held(system, report);
    constexpr int most_rounds = 30;
    double now = potential(system, dv);
    for (int round = 0; round < most_rounds && hold_passed(system, dv); ++round) {
        const std::vector<Vec6> end = solve_held(system, report);
        std::vector<Vec6> next = end;
        double after = potential(system, next);
        for (double share = 0.5; after > now && share > 1e-3; share *= 0.5) {
            for (std::size_t f = 0; f < dv.size(); ++f) {
                next[f] = dv[f] + share * (end[f] - dv[f]);
            }
            after = potential(system, next);
        }
        dv = std::move(next);
        now = after;
    }
    return dv;
}

void SpentLayers::take(const LayeredSystem& system)
{
    std::set<std::pair<std::uint32_t, std::uint32_t>> now;
    for (const SystemStop& stop : system.stops) {
        if (stop.held && stop.body != geometry::no_index) now.emplace(stop.body, stop.other);
    }
    if (!bodies_) {
        bodies_ = std::move(now);
    } else {
        std::erase_if(*bodies_, [&](const auto& pair) { return !now.contains(pair); });
    }
}

void SpentLayers::tell(std::vector<LayeredState>& states) const
{
    if (!bodies_) return;
    for (const auto& [body, other] : *bodies_) {
        states[body].report.warnings.push_back(fmt::format(
            "The layer of body {} is pressed down to its skeleton by body {}, which the skeleton "
            "stops, and which may stay in the layer. Raise matter.stiffness, or the layer's "
            "thickness.",
            body, other));
    }
}

}  // namespace physics
