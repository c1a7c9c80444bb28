#include "physics/lattice/step_weights.hpp"

#include "physics/lattice/torn_regions.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

// The largest share of a particle, see membrane.hpp: with regions as stiff as they get steps stay
// below the limit of 4, and leave room for damping.
constexpr double most_membrane = 2;

// The pieces that held links join, and which of them have pins.
void find_pieces(FrameState& step)
{
    step.torn_pieces = step.held_regions ? std::make_shared<const LinkedPieces>(linked_pieces(
                                               step.body.torn->lattice(), step.state.broken))
                                         : nullptr;
    step.pieces = step.torn_pieces ? step.torn_pieces.get() : &step.body.pieces;
    const std::vector<std::uint32_t>& piece = step.pieces->of;
    step.piece_mass.assign(step.pieces->count, 0);
    for (std::size_t i = 0; i < step.n;) {
        double sum = 0;  // task by task, as momentum is summed
        const std::size_t first = i,
                          end = std::min(step.n, (i / particles_a_task + 1) * particles_a_task);
        for (; i < end && piece[i] == piece[first]; ++i) sum += step.body.base.mass[i];
        step.piece_mass[piece[first]] += sum;
    }
    step.is_pinned.assign(step.pieces->count, 0);
    for (const auto k : step.loads.pins.corner) step.is_pinned[piece[k]] = 1;
    step.rest.assign(step.pieces->count, {});
}

// The regions without the links that are broken, and what else a break changes.
void find_held_regions(FrameState& step)
{
    const std::vector<std::uint32_t>& broken = step.state.broken;
    step.held_regions =
        step.body.torn && !broken.empty() ? step.body.torn->find(step.body.whole, broken) : nullptr;
    step.matched = step.held_regions ? step.held_regions.get() : &step.body.whole;
    step.torn_skin.reset();
    if (step.touches && step.held_regions) {
        step.torn_skin.emplace(step.body.base.skin, step.body.torn->lattice(), broken,
                               step.body.base.h);
    }
    step.torn_corners =
        broken.empty() ? std::vector<std::uint8_t>{} : torn_corners(step.body.membrane, broken);
    find_pieces(step);
}

// What of the membrane's stiffness steps this long can bear, dt^2 E V / h^2 of each cell, less
// what regions resist too. Returns the largest share of a particle.
template <class T> double share_membrane(StepState<T>& step)
{
    const Membrane& membrane = step.body.membrane;
    const double w = step.matched->regions.half_width;
    const double m2 = mean_square_place(w), bent = 3 * (mean_fourth_place(w) - m2 * m2) / m2;
    const bool material = step.options.stiffness == Stiffness::material;
    const double rate_sq = std::min(step.options.rate * step.options.rate, 1e200);
    std::vector<double> share(membrane.cells());
    for_each_below(share.size(), [&](std::size_t c) {
        const double bend = step.options.bend * (material ? double(membrane.bend[c]) / bent : 1);
        const double stiffness =
            material ? double(membrane.stiffness[c]) : rate_sq * m2 * double(membrane.mass[c]);
        share[c] = bend < 1 ? (1 - bend) * stiffness * step.dt * step.dt : 0;
    });
    step.membrane_share.clear();
    if (!(largest_of(share.size(), [&](std::size_t c) { return share[c]; }) > 0)) return 0;

    std::vector<double> sum = sum_at_corners(membrane, share, step.n);
    for_each_below(step.n, [&](std::size_t i) { sum[i] *= 2 / step.body.base.mass[i]; });
    const double largest = largest_of(step.n, [&](std::size_t i) { return sum[i]; });
    step.resolved = std::max(step.resolved, std::sqrt(largest / most_membrane));
    step.membrane_share.resize(share.size());
    const auto bear = [&](std::size_t c, const Membrane::Cell& cell) {
        double most = 0;
        for (const auto k : cell) most = std::max(most, sum[k]);
        step.membrane_share[c] =
            T(most > most_membrane ? share[c] * (most_membrane / most) : share[c]);
    };
    geometry::parallel_for(
        membrane.strip.size(), membrane_strips_a_task,
        [&](std::size_t begin, std::size_t end) { membrane.for_each_cell(begin, end, bear); });
    return std::min(largest, most_membrane);
}

// Of the slots that `which` says, where particles weigh `mass`.
template <class T>
void find_own_twist(StepState<T>& step, const std::vector<float>& mass,
                    const std::function<bool(std::size_t)>& which)
{
    const LatticeRegions& regions = step.matched->regions;
    const auto steps_from_first = [&](std::size_t i) {
        std::array<double, 2> out;
        for (std::size_t d = 0; d < 2; ++d) {
            const double* const rest = step.body.base.rest.data() + regions.axes[d];
            out[d] = std::round((rest[4 * i] - rest[0]) / step.body.base.h);
        }
        return out;
    };
    find_twist(regions, mass, steps_from_first, which, step.own_twist);
    step.twist = step.own_twist.data();
}

// That of the body, or as exact as the sums are.
template <class T> void take_twist(StepState<T>& step)
{
    if constexpr (std::is_same_v<T, float>) {
        step.twist = step.matched->twist.data();
    } else {
        find_own_twist(step, step.matched->mass, [](std::size_t) { return true; });
    }
}

// A wall that holds corners goes on behind them, where the lattice may end. So regions weigh
// them by more, until what is held in the region of each counts as much as what is not: 2w
// times, for one layer of corners at the end of a beam. Without, the end gives way, and
// cantilevers sag by up to three times as much.
template <class T> void weigh_pins(StepState<T>& step)
{
    const auto& pins = step.loads.pins.corner;
    if (pins.empty()) return;
    const LatticeRegions& regions = step.matched->regions;
    step.with_pins = step.matched->mass;
    auto& f = step.sums.particles;
    for_each_below(step.n,
                   [&](std::size_t i) { f[i] = Quad<T>(T(step.body.base.mass[i]), 0, 0, 0); });
    for (const auto k : pins) f[k] = Quad<T>(0, T(step.body.base.mass[k]), 0, 0);
    std::vector<float> times(step.n, 1.0f);
    std::vector<std::uint8_t> holds(regions.slots(), 0);
    collect<T>(regions, step.sums, [&](std::size_t first, std::span<const Quad<T>> slots) {
        for (std::size_t s = first; s < first + slots.size() / 4; ++s) {
            const Quad<T>& sum = slots[4 * (s - first)];
            if (!(sum[1] > 0)) continue;  // without a particle it is 0
            times[regions.particle[s]] = float(sum[0] / sum[1]);
            holds[s] = 1;
        }
    });
    const auto most = 2.0f * float(regions.half_width);
    const float least = bends_in_space(step) ? 2.0f : 1.0f;
    for (const auto k : pins) {
        step.with_pins[k] = step.matched->mass[k] * std::clamp(times[k], least, most);
    }
    if (!bends_in_space(step)) return;
    if constexpr (std::is_same_v<T, float>) step.own_twist = step.matched->twist;
    find_own_twist(step, step.with_pins, [&](std::size_t s) { return holds[s] != 0; });
}

// Sums of weights over the regions that hold each particle: they do not change with motion.
template <class T> void sum_weights(StepState<T>& step)
{
    spread<T>(step.matched->regions, step.sums, [&](std::size_t first, std::span<Quad<T>> slots) {
        for (std::size_t k = 0; 4 * k < slots.size(); ++k) slots[4 * k][0] = step.weight[first + k];
    });
    const auto& g = step.sums.particles;
    step.held_weight.resize(step.n);
    for_each_below(step.n, [&](std::size_t i) { step.held_weight[i] = g[i][0]; });
}

}  // namespace

template <class T> void use_regions(StepState<T>& step)
{
    find_held_regions(step);
    step.sums.partial.resize(4 * step.matched->regions.partial.nodes());
    const bool material = step.options.stiffness == Stiffness::material;
    const std::size_t slots = step.matched->regions.slots();
    const bool bends = bends_in_space(step);
    // Regions of a plane in space resist bending, and of stretch only what is left to them.
    const auto rate_sq = [&](std::size_t s) {
        const double stretch =
            material ? double(step.matched->rate_sq[s]) : step.options.rate * step.options.rate;
        if (!bends) return stretch;
        return step.options.bend * (material ? double(step.matched->bend_sq[s]) : stretch);
    };
    const double largest = largest_of(slots, [&](std::size_t s) {
        return step.matched->regions.particle[s] != none ? rate_sq(s) : 0;
    });
    step.resolved = std::sqrt(largest) * step.dt;
    const double stiffest = bends ? share_membrane(step) : 0;
    step.stiffness = share_of(largest, step.dt) + stiffest;
    const double tau = step.body.damping + step.options.damping;
    // Steps are stable below stiffness + 2 damping = 4.
    step.damping = tau > 0 ? std::min(-std::expm1(-tau * (largest * step.dt + stiffest / step.dt)),
                                      (4 - step.stiffness) / 3)
                           : 0;

    if (bends) take_twist(step);
    weigh_pins(step);
    step.weight.resize(slots);
    const double scale = step.stiffness > 0 ? 1 / step.stiffness : 0;
    for_each_below(slots, [&](std::size_t s) {
        const bool some = step.matched->regions.particle[s] != none;
        step.weight[s] = some ? T(share_of(rate_sq(s), step.dt) * scale) : T(0);
    });
    for_each_below(step.membrane_share.size(),
                   [&](std::size_t c) { step.membrane_share[c] *= T(scale); });
    sum_weights(step);
}

template void use_regions(StepState<float>&);
template void use_regions(StepState<double>&);

}  // namespace physics
