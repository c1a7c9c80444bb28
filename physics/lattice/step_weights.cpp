#include "physics/lattice/step_weights.hpp"

#include "physics/lattice/torn_regions.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

// The largest share of a particle, see membrane.hpp: with regions as stiff as they get steps stay
// below the limit of 4, and leave room for damping.
constexpr double most_membrane = 2;

// beta at least, where a region's pull to its volume is above a half; 0 below a quarter, and linear
// between. Without, single cubes turned inside out gain energy without bound within 1e5 steps, in
// 26 of 120 random starts; with it none of 360.
constexpr double least_damping = 0.02;

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

// s^2 as given or of the material. Regions of a plane in space resist bending, and of stretch only
// what is left to them.
double rate_sq_of(const FrameState& step, std::size_t s)
{
    const bool material = step.options.stiffness == Stiffness::material;
    const double stretch =
        material ? double(step.matched->rate_sq[s]) : step.options.rate * step.options.rate;
    if (!bends_in_space(step)) return stretch;
    return step.options.bend * (material ? double(step.matched->bend_sq[s]) : stretch);
}

// Of a region's bends within it and of its stretch the larger.
double stiffest_rate_sq(const FrameState& step, std::size_t s)
{
    const bool apart =
        !step.matched->stretch.empty() && step.options.stiffness == Stiffness::material;
    return rate_sq_of(step, s) * (apart ? std::max(1.0, double(step.matched->stretch[s])) : 1.0);
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

// Where a particle is at rest, in lattice steps.
Vec3 steps_from_first(const FrameState& step, std::size_t i)
{
    const double* const rest = step.body.base.rest.data();
    const Vec3 away = Eigen::Map<const Vec3>(rest + 4 * i) - Eigen::Map<const Vec3>(rest);
    return (away / step.body.base.h).array().round();
}

// Of the slots that `which` says, where particles weigh `mass`.
template <class T>
void find_own_twist(StepState<T>& step, const std::vector<float>& mass,
                    const std::function<bool(std::size_t)>& which)
{
    const LatticeRegions& regions = step.matched->regions;
    const auto place = [&](std::size_t i) {
        const Vec3 steps = steps_from_first(step, i);
        return std::array{steps[regions.axes[0]], steps[regions.axes[1]]};
    };
    find_twist(regions, mass, place, which, step.own_twist);
    step.twist = step.own_twist.data();
}

// Likewise for solids.
template <class T>
void find_own_volume(StepState<T>& step, const std::vector<float>& mass,
                     const std::function<bool(std::size_t)>& which)
{
    const auto place = [&](std::size_t i) { return steps_from_first(step, i); };
    find_volume<T>(step.matched->regions, mass, place, which, step.own_volume);
    step.volume = step.own_volume.data();
}

template <class T> void take_volume(StepState<T>& step)
{
    step.volume = nullptr;
    if (step.matched->volume.empty() || step.options.stiffness != Stiffness::material) return;
    if constexpr (std::is_same_v<T, float>) {
        step.volume = step.matched->volume.data();
    } else {
        find_own_volume(step, step.matched->mass, [](std::size_t) { return true; });
    }
}

// Where regions weigh pins by more.
template <class T>
void find_pinned_volume(StepState<T>& step, const std::function<bool(std::size_t)>& with_pin)
{
    if constexpr (std::is_same_v<T, float>) {
        const auto& pins = step.loads.pins.corner;
        PinnedVolume* const kept =
            step.held_regions || !step.body.pinned ? nullptr : &step.body.pinned->volume;
        step.pinned_volume = kept ? kept->find(pins) : nullptr;
        if (!step.pinned_volume) {
            step.own_volume = step.matched->volume;
            find_own_volume(step, step.with_pins, with_pin);
            step.pinned_volume = std::make_shared<const std::vector<RegionVolume<float>>>(
                std::move(step.own_volume));
            if (kept) kept->keep(pins, step.pinned_volume);
        }
        step.volume = step.pinned_volume->data();
    } else {
        find_own_volume(step, step.with_pins, with_pin);
    }
}

// Likewise, or a region at rest would seem strained.
void find_pinned_spread(FrameState& step, const std::vector<float>& mass,
                        const std::function<bool(std::size_t)>& with_pin)
{
    const auto& pins = step.loads.pins.corner;
    PinnedSpread* const kept =
        step.held_regions || !step.body.pinned ? nullptr : &step.body.pinned->spread;
    step.pinned_spread = kept ? kept->find(pins) : nullptr;
    if (!step.pinned_spread) {
        const auto place = [&](std::size_t i) { return steps_from_first(step, i); };
        std::vector<float> own = step.matched->inverse_spread;
        find_inverse_spread(step.matched->regions, mass, place, with_pin, own);
        step.pinned_spread = std::make_shared<const std::vector<float>>(std::move(own));
        if (kept) kept->keep(pins, step.pinned_spread);
    }
    step.inverse_spread = step.pinned_spread->data();
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
    const auto with_pin = [&](std::size_t s) { return holds[s] != 0; };
    if (bends_in_space(step)) {
        if constexpr (std::is_same_v<T, float>) step.own_twist = step.matched->twist;
        find_own_twist(step, step.with_pins, with_pin);
    }
    if (step.volume) find_pinned_volume(step, with_pin);
    if (step.plastic) find_pinned_spread(step, step.with_pins, with_pin);
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

// How strongly a region pulls: alpha to its rotation, k, against stretch beside it, S, and of a
// solid to its volume, K.
struct Pull {
    double rotation = 0, stretch = 0, volume = 0;
    double poisson = 0, acts = 0;  // the material's, and what steps can bear of it
    double asked_sq = 0;           // of rate and volume, where all of it can be borne
};

// The largest nu at which k + K is 1 and E = k (1 + g nu) is still the region's, of alpha `e`:
//   e (1 + nu) = (1 + g nu) (1 - 2 nu)
double most_poisson_of(double e, double g)
{
    const double b = e + 2 - g, c = e - 1;
    return g > 0 ? (-b + std::sqrt(b * b - 8 * g * c)) / (4 * g) : -c / b;
}

template <class T> Pull pull_of(const StepState<T>& step, std::size_t s)
{
    if (step.matched->regions.particle[s] == none) return {};
    const double e = rate_sq_of(step, s) * step.dt * step.dt;
    Pull out{std::min(1.0, e)};
    out.asked_sq = e;
    if (!step.volume || !(step.volume[s].scale > 0)) return out;
    const double nu = double(step.matched->poisson[s]), g = double(step.matched->volume_gain[s]);
    out.poisson = out.acts = nu;
    if (!step.matched->stretch.empty()) {
        const double stiff = e * double(step.matched->stretch[s]);  // of E
        out.asked_sq = std::max(e, stiff / (1 - 2 * nu));
        if (out.asked_sq > 1) {
            out.acts = stiff < 1 ? std::min(nu, most_poisson_of(stiff, 1)) : 0;
        }
        const double straight = std::min(1.0, stiff / (1 + out.acts));
        out.stretch = straight - out.rotation;
        out.volume = straight * 3 * out.acts / (1 - 2 * out.acts);
        return out;
    }
    out.asked_sq = e / (1 + g * nu) * (1 + nu) / (1 - 2 * nu);
    if (out.asked_sq > 1) out.acts = e < 1 ? std::min(nu, most_poisson_of(e, g)) : 0;
    out.rotation = std::min(1.0, e / (1 + g * out.acts));
    out.volume = out.rotation * 3 * out.acts / (1 - 2 * out.acts);
    return out;
}

// Of all regions: the largest rate, alpha, pull to volume and alpha asked for, and sums.
struct Pulls {
    double rate_sq = 0, share = 0, volume = 0, asked_sq = 0;
    double poisson = 0, acts = 0, count = 0;

    Pulls operator+(const Pulls& o) const
    {
        return {std::max(rate_sq, o.rate_sq),
                std::max(share, o.share),
                std::max(volume, o.volume),
                std::max(asked_sq, o.asked_sq),
                poisson + o.poisson,
                acts + o.acts,
                count + o.count};
    }
};
template <class T> Pulls all_pulls(const StepState<T>& step)
{
    const auto of_piece = [&](std::size_t begin, std::size_t end) {
        Pulls sum;
        for (std::size_t s = begin; s < end; ++s) {
            if (step.matched->regions.particle[s] == none) continue;
            const Pull pull = pull_of(step, s);
            sum = sum + Pulls{stiffest_rate_sq(step, s),
                              pull.rotation + std::max(pull.stretch, 0.0) + pull.volume,
                              pull.volume,
                              pull.asked_sq,
                              pull.poisson,
                              pull.acts,
                              1};
        }
        return sum;
    };
    return geometry::ordered_sum<Pulls>(step.matched->regions.slots(), particles_a_task, {},
                                        of_piece);
}

template <class T> void weigh_regions(StepState<T>& step)
{
    const std::size_t slots = step.matched->regions.slots();
    step.weight.resize(slots);
    step.volume_share.resize(step.volume ? slots : 0);
    step.stretch_share.resize(step.volume && !step.matched->stretch.empty() ? slots : 0);
    const double scale = step.stiffness > 0 ? 1 / step.stiffness : 0;
    for_each_below(slots, [&](std::size_t s) {
        const Pull pull = pull_of(step, s);
        step.weight[s] = T(pull.rotation * scale);
        if (step.volume) {
            step.volume_share[s] = pull.rotation > 0 ? T(pull.volume / pull.rotation) : T(0);
        }
        if (!step.stretch_share.empty()) {
            step.stretch_share[s] = pull.rotation > 0 ? T(pull.stretch / pull.rotation) : T(0);
        }
    });
    for_each_below(step.membrane_share.size(),
                   [&](std::size_t c) { step.membrane_share[c] *= T(scale); });
}

}  // namespace

template <class T> void use_regions(StepState<T>& step)
{
    find_held_regions(step);
    step.sums.partial.resize(4 * step.matched->regions.partial.nodes());
    step.inverse_spread = step.matched->inverse_spread.data();
    const bool bends = bends_in_space(step);
    if (bends) take_twist(step);
    take_volume(step);
    weigh_pins(step);
    const Pulls all = all_pulls(step);
    step.resolved = std::sqrt(all.rate_sq) * step.dt;
    step.resolved_volume = std::sqrt(all.asked_sq);
    step.poisson = all.count > 0 ? all.poisson / all.count : 0;
    step.poisson_acts = all.count > 0 ? all.acts / all.count : 0;
    const double stiffest = bends ? share_membrane(step) : 0;
    step.stiffness = all.share + stiffest;
    step.tau = step.body.damping + step.options.damping;
    const double damped = std::max(all.rate_sq, all.share / (step.dt * step.dt));
    step.damped_by = damped * step.dt + stiffest / step.dt;
    // Steps are stable below stiffness + 2 damping = 4.
    step.damping = step.tau > 0
                       ? std::min(-std::expm1(-step.tau * step.damped_by), (4 - step.stiffness) / 3)
                       : 0;
    step.tau_acts = step.damping > 0 ? step.damping / step.damped_by : 0;
    const double least = least_damping * std::clamp(4 * all.volume - 1, 0.0, 1.0);
    step.damping = std::max(step.damping, least);
    weigh_regions(step);
    sum_weights(step);
}

template void use_regions(StepState<float>&);
template void use_regions(StepState<double>&);

}  // namespace physics
