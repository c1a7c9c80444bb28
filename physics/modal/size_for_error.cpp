#include "physics/modal/size_for_error.hpp"

#include "physics/modal/modes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace physics {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Two directions of bending and a twist, of a bar.
constexpr int vibrations = 3;

struct Limit {
    double value = 0;
    double uncertainty = 0;
    double order = 0;
};

// Of stiffnesses at sizes h, 2h, 4h.
Limit limit_of(const std::array<double, 3>& k)
{
    // Cubes converge with order 2 at best: what seems faster has only begun to. Bodies without
    // corners that go in have order 2, those with them 1 at least: what seems slower comes from how
    // full outer cubes happen to be.
    constexpr double least_seen = 0.5, least = 1, best = 2;
    constexpr double noise = 1e-6;  // of eigenvalues
    const double last = k[0] - k[1], before = k[1] - k[2];
    const double largest_change = std::max(std::abs(last), std::abs(before));
    if (largest_change <= noise * k[0]) return {k[0], std::abs(last), best};
    if (last == 0) return {k[0], 0.25 * largest_change, best};
    if (!(before / last > std::exp2(least_seen))) return {k[0], largest_change, 0};
    const double seen = std::log2(before / last), order = std::clamp(seen, least, best);
    const double step = last / (std::exp2(order) - 1);
    if (!(k[0] + step > 0)) return {k[0], largest_change, 0};
    return {k[0] + step, (seen < least ? 0.5 : 0.25) * std::abs(step), order};
}

TriedSize tried_size(const geometry::Cubes& cubes)
{
    TriedSize out{cubes.size, cubes.count(), {}, infinity};
    ModeSettings settings;
    settings.count = vibrations;
    const Modes modes = lowest_modes(cubes, {}, settings);
    if (modes.omega_sq.size() != vibrations) return out;
    out.omega_sq = modes.omega_sq;
    return out;
}

std::vector<Limit> limits_of(std::span<const TriedSize> finest)
{
    std::vector<Limit> limits;
    for (std::size_t v = 0; v < vibrations; ++v) {
        limits.push_back(
            limit_of({finest[2].omega_sq[v], finest[1].omega_sq[v], finest[0].omega_sq[v]}));
    }
    return limits;
}

double error_of(double omega_sq, const Limit& limit)
{
    return (std::abs(omega_sq - limit.value) + limit.uncertainty) / limit.value;
}

double error_of(const TriedSize& tried, const std::vector<Limit>& limits)
{
    if (tried.omega_sq.empty()) return infinity;
    double error = 0;
    for (std::size_t v = 0; v < vibrations; ++v) {
        error = std::max(error, error_of(tried.omega_sq[v], limits[v]));
    }
    return error;
}

class Search {
public:
    Search(const std::function<std::optional<geometry::Cubes>(double)>& cubes_of,
           const SizeSearch& search)
        : cubes_of_(cubes_of), search_(search)
    {}

    SizeForError run()
    {
        for (double size = search_.start; !found() && fits(); size /= 2) {
            const auto cubes = cubes_of_(size);
            if (!cubes) break;
            out_.tried.push_back(tried_size(*cubes));
            estimate();
        }
        // Where few are allowed, coarser ones tell at least an order.
        for (int coarser = 0; !out_.tried.empty() && out_.tried.size() < 3 && coarser < 2;
             ++coarser) {
            const auto cubes = cubes_of_(2 * out_.tried.front().size);
            if (!cubes) break;
            out_.tried.insert(out_.tried.begin(), tried_size(*cubes));
            estimate();
        }
        if (is_far_to_foretell()) try_one_more();
        choose();
        return std::move(out_);
    }

private:
    bool found() const
    {
        return !limits_.empty() && out_.tried.back().size <= search_.finest_needed &&
               out_.tried.back().error <= search_.error;
    }

    // Whether cubes of half the size are few enough, as the last halving lets expect.
    bool fits() const
    {
        const auto& tried = out_.tried;
        if (tried.empty()) return true;
        const double last = double(tried.back().cubes);
        const double growth =
            tried.size() < 2 ? 8 : std::min(8.0, last / double(tried[tried.size() - 2].cubes));
        return growth * last <= double(search_.most_tried);
    }

    // m, that the order promises from the finest that was tried.
    double promised() const
    {
        const TriedSize& last = out_.tried.back();
        return last.size * std::pow(search_.error / last.error, 1 / order());
    }
    double order() const { return out_.order > 0 ? out_.order : 1; }

    // Whether more cubes are promised than half the finest size takes.
    bool is_far_to_foretell() const
    {
        if (limits_.empty() || out_.tried.back().size > search_.finest_needed) return false;
        return !found() && promised() < 0.5 * out_.tried.back().size;
    }

    // That size, where its cubes are not too many.
    void try_one_more()
    {
        const TriedSize& last = out_.tried.back();
        if (8 * last.cubes > std::min(search_.most_at_last, search_.most)) return;
        const auto cubes = cubes_of_(0.5 * last.size);
        if (!cubes) return;
        out_.tried.push_back(tried_size(*cubes));
        estimate();
    }

    void estimate()
    {
        limits_.clear();
        const std::size_t n = out_.tried.size();
        if (n < 3) return;
        const std::span finest(&out_.tried[n - 3], 3);
        for (const TriedSize& t : finest) {
            if (t.omega_sq.empty()) return;
        }
        limits_ = limits_of(finest);
        for (TriedSize& t : out_.tried) t.error = error_of(t, limits_);
        for (std::size_t v = 0; v < vibrations; ++v) {
            const double error = error_of(out_.tried[n - 1].omega_sq[v], limits_[v]);
            if (error != out_.tried[n - 1].error) continue;
            out_.order = limits_[v].order;
            out_.vibration = v;
        }
    }

    void choose()
    {
        auto& tried = out_.tried;
        if (tried.empty()) return;
        // The coarsest from which on all that are finer are good enough as well.
        std::size_t best = tried.size();
        while (best > 0 && tried[best - 1].error <= search_.error) --best;
        out_.reached = found();
        if (!out_.reached) {
            out_.size = tried.back().size;
            out_.error = tried.back().error;
            foretell();
            return;
        }
        out_.size = tried[best].size;
        out_.error = tried[best].error;
        if (best > 0) try_between(out_.size * std::sqrt(2.0));
    }

    // Halving the size makes eight times the cubes: one in between may do, too.
    void try_between(double size)
    {
        const auto cubes = cubes_of_(size);
        if (!cubes) return;
        const double error = error_of(tried_size(*cubes), limits_);
        if (error > search_.error) return;
        out_.size = size;
        out_.error = error;
    }

    // What the order promises beyond the sizes that were tried, as far as cubes may be so many.
    void foretell()
    {
        if (limits_.empty() || !(out_.error > search_.error) || out_.size > search_.finest_needed) {
            return;
        }
        const double tried = out_.size, error = out_.error, wanted = promised();
        out_.foretold = true;
        double size = finest_allowed();
        if (wanted >= size && cubes_of_(wanted)) {
            out_.size = wanted;
            out_.error = search_.error;
            out_.reached = true;
            return;
        }
        out_.would_do = wanted;
        // The estimate of a count is right within some per cent.
        constexpr double coarser = 1.05;
        while (size < tried && !cubes_of_(size)) size *= coarser;
        out_.size = std::min(size, tried);
        out_.foretold = size < tried;
        out_.error = error * std::pow(out_.size / tried, order());
    }

    // m, of as many cubes as are allowed, if the counts n of the two finest that were tried grow as
    // those of a volume and its surface: n = a / h^3 + b / h^2.
    double finest_allowed() const
    {
        const TriedSize &last = out_.tried.back(), &before = out_.tried[out_.tried.size() - 2];
        const double n = double(last.cubes);
        const double of_volume = std::clamp(2 * n - 8 * double(before.cubes), 0.0, n);
        double low = 1e-3, high = 1;  // of the last size
        for (int i = 0; i < 40; ++i) {
            const double h = std::sqrt(low * high);
            const double count = of_volume / (h * h * h) + (n - of_volume) / (h * h);
            (count > double(search_.most) ? low : high) = h;
        }
        return high * last.size;
    }

    const std::function<std::optional<geometry::Cubes>(double)>& cubes_of_;
    const SizeSearch& search_;
    std::vector<Limit> limits_;  // of the three finest sizes
    SizeForError out_;
};

}  // namespace

SizeForError size_for_error(const std::function<std::optional<geometry::Cubes>(double)>& cubes_of,
                            const SizeSearch& search)
{
    return Search(cubes_of, search).run();
}

}  // namespace physics
