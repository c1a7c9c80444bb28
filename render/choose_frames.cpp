#include "render/choose_frames.hpp"

#include "geometry/base/parallel.hpp"
#include "render/contact_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <stdexcept>

namespace render {
namespace {

using Places = std::vector<std::size_t>;

double difference(const Image& a, const Image& b)
{
    if (a.width != b.width || a.height != b.height || a.rgba.size() != b.rgba.size()) {
        throw std::invalid_argument("the frames' pictures have different sizes");
    }
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i + 3 < a.rgba.size(); i += 4) {
        int most = 0;
        for (std::size_t k = i; k < i + 3; ++k) {
            most = std::max(most, std::abs(int(a.rgba[k]) - int(b.rgba[k])));
        }
        sum += std::uint64_t(most);
    }
    return double(sum) / std::max<double>(1, double(a.rgba.size()) / 4);
}

std::vector<double> summed(std::span<const double> changes)
{
    std::vector<double> sums;
    double sum = 0;
    for (std::size_t i = 0; i < changes.size(); ++i) {
        if (i > 0) sum += changes[i];
        sums.push_back(sum);
    }
    return sums;
}

// Between a and b, the place that parts the change there most evenly; none, where no place differs
// from both.
std::optional<std::size_t> parting(const std::vector<double>& sums, std::size_t a, std::size_t b)
{
    const double middle = 0.5 * (sums[a] + sums[b]);
    std::optional<std::size_t> best;
    for (std::size_t i = a + 1; i < b; ++i) {
        if (!(sums[i] > sums[a] && sums[i] < sums[b])) continue;
        if (!best || std::abs(sums[i] - middle) < std::abs(sums[*best] - middle)) best = i;
    }
    return best;
}

// Parts the greatest change again and again, until there are `count`.
void part_changes(Places& places, const std::vector<double>& sums, std::size_t count)
{
    while (places.size() < count) {
        std::optional<std::size_t> best;
        double greatest = 0;
        for (std::size_t k = 0; k + 1 < places.size(); ++k) {
            const double change = sums[places[k + 1]] - sums[places[k]];
            if (!(change > greatest)) continue;
            if (const auto place = parting(sums, places[k], places[k + 1])) {
                best = place, greatest = change;
            }
        }
        if (!best) return;
        places.insert(std::upper_bound(places.begin(), places.end(), *best), *best);
    }
}

Places spread(std::size_t all, std::size_t count)
{
    Places places;
    for (const int place : spread_frames(0, int(all) - 1, int(count))) {
        places.push_back(std::size_t(place));
    }
    return places;
}

// The first, the last, and where the value turns; of a plateau its first place.
Places turns_of(const std::vector<double>& values)
{
    Places turns{0};
    double way = 0;
    std::size_t turn = 0;  // where the value last changed to
    for (std::size_t i = 1; i < values.size(); ++i) {
        const double step = values[i] - values[i - 1];
        if (step == 0) continue;
        if (way * step < 0) turns.push_back(turn);
        way = step > 0 ? 1 : -1, turn = i;
    }
    if (turns.back() != values.size() - 1) turns.push_back(values.size() - 1);
    return turns;
}

void leave_out_least_swing(Places& turns, const std::vector<double>& values)
{
    std::size_t least = 0;
    double swing = INFINITY;
    for (std::size_t k = 0; k + 1 < turns.size(); ++k) {
        const double here = std::abs(values[turns[k + 1]] - values[turns[k]]);
        if (here < swing) swing = here, least = k;
    }
    const auto at = turns.begin() + std::ptrdiff_t(least);
    if (least == 0) {
        turns.erase(at + 1);
    } else if (least + 2 == turns.size()) {
        turns.erase(at);
    } else {
        turns.erase(at, at + 2);
    }
}

}  // namespace

std::vector<double> changes_of(std::span<const Image* const> pictures)
{
    std::vector<double> changes(pictures.size(), 0);
    geometry::parallel_for(pictures.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = std::max<std::size_t>(1, begin); i < end; ++i) {
            changes[i] = difference(*pictures[i - 1], *pictures[i]);
        }
    });
    return changes;
}

std::vector<std::size_t> spread_by_change(std::span<const double> changes, std::size_t count)
{
    const std::vector<double> sums = summed(changes);
    const std::size_t all = sums.size();
    if (all == 0 || !(sums.back() > 0)) return spread(all, count);
    if (count < 2 || all < 2) return {0};
    Places places{0};
    for (std::size_t k = 1; k + 1 < count; ++k) {
        const double aim = sums.back() * double(k) / double(count - 1);
        const auto above = std::lower_bound(sums.begin(), sums.end(), aim);
        std::size_t place = std::size_t(above - sums.begin());
        if (place > 0 && aim - sums[place - 1] < sums[place] - aim) {
            // The first of those that look alike.
            place =
                std::size_t(std::lower_bound(sums.begin(), above, sums[place - 1]) - sums.begin());
        }
        if (place > places.back() && sums[place] < sums.back()) places.push_back(place);
    }
    places.push_back(all - 1);
    part_changes(places, sums, count);
    return places;
}

std::vector<std::size_t> extremes_of(std::span<const double> values, std::size_t count)
{
    std::vector<double> finite(values.begin(), values.end());
    std::vector<double> changes(finite.size(), 0);
    const auto first =
        std::find_if(finite.begin(), finite.end(), [](double v) { return std::isfinite(v); });
    for (std::size_t i = 0; i < finite.size(); ++i) {
        if (!std::isfinite(finite[i])) {
            finite[i] = i > 0 ? finite[i - 1] : first != finite.end() ? *first : 0;
        }
        if (i > 0) changes[i] = std::abs(finite[i] - finite[i - 1]);
    }
    if (finite.empty()) return {};
    if (count < 2 || finite.size() < 2) return {0};
    Places turns = turns_of(finite);
    while (turns.size() > count) leave_out_least_swing(turns, finite);
    if (turns.size() == 2 && finite.size() > 2 && finite.front() == finite.back() &&
        std::all_of(changes.begin(), changes.end(), [](double c) { return c == 0; })) {
        return spread(finite.size(), count);
    }
    part_changes(turns, summed(changes), count);
    return turns;
}

}  // namespace render
