#include "physics/bricks/dissection.hpp"

#include "geometry/base/stop.hpp"

#include <algorithm>
#include <limits>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::no_index;

struct Plane {
    int axis = -1;  // none
    int at = 0;
};

// Corners below a plane, above it and on it.
struct Parted {
    std::span<std::uint32_t> below, above, on;
};

// Puts `corners` in that order; those of a kind stay in theirs.
Parted part_at(const Plane& plane, const Cubes& cubes, std::span<std::uint32_t> corners)
{
    const auto place = [&](std::uint32_t k) { return cubes.corner[k][plane.axis]; };
    const auto first = corners.begin(), last = corners.end();
    const auto is_below = [&](std::uint32_t k) { return place(k) < plane.at; };
    const auto is_above = [&](std::uint32_t k) { return place(k) > plane.at; };
    const auto low = std::stable_partition(first, last, is_below);
    const auto high = std::stable_partition(low, last, is_above);
    const auto a = std::size_t(low - first), b = std::size_t(high - first);
    return {corners.first(a), corners.subspan(a, b - a), corners.subspan(b)};
}

class Dissector {
public:
    Dissector(const Cubes& cubes, const std::vector<char>& left_out, std::size_t uncut)
        : cubes_(cubes), uncut_(uncut), list_(cubes.corner_count(), left_out)
    {}

    FrontList run()
    {
        std::vector<std::uint32_t> corners = list_.taken;
        if (!corners.empty()) cut(corners);
        return std::move(list_);
    }

private:
    // The front of the last cut of `corners`; its children first.
    std::uint32_t cut(std::span<std::uint32_t> corners)
    {
        geometry::stop_if_asked();
        const Plane plane = corners.size() > uncut_ ? thinnest_plane(corners) : Plane{};
        if (plane.axis < 0) return list_.add(corners, {});
        const Parted parted = part_at(plane, cubes_, corners);
        const auto below = cut(parted.below);
        const auto above = cut(parted.above);
        return list_.add(parted.on, {below, above});
    }

    // Of planes with at least a third of the corners on either side, the one with fewest corners;
    // none where no plane parts them so.
    Plane thinnest_plane(std::span<const std::uint32_t> corners)
    {
        Plane best;
        double best_cost = std::numeric_limits<double>::infinity();
        const auto n = static_cast<double>(corners.size());
        for (int axis = 0; axis < 3; ++axis) {
            std::int64_t lo = std::numeric_limits<std::int64_t>::max(), hi = -lo;
            for (const auto k : corners) {
                lo = std::min<std::int64_t>(lo, cubes_.corner[k][axis]);
                hi = std::max<std::int64_t>(hi, cubes_.corner[k][axis]);
            }
            // Few corners far apart would make a long list of empty planes.
            if (hi - lo > 64 * static_cast<std::int64_t>(corners.size())) continue;
            on_plane_.assign(static_cast<std::size_t>(hi - lo + 1), 0);
            for (const auto k : corners) {
                ++on_plane_[static_cast<std::size_t>(cubes_.corner[k][axis] - lo)];
            }
            double below = 0;
            for (std::size_t p = 0; p < on_plane_.size(); ++p) {
                const double here = on_plane_[p], above = n - below - here;
                const double uneven = std::abs(below - above) / n;
                // A cut of s corners costs s^2; what it leaves on the larger side is cut again.
                const double cost = here * (1 + 4 * uneven * uneven) + 0.01 * uneven;
                if (below > 0 && above > 0 && uneven < 0.6 && cost < best_cost) {
                    best_cost = cost;
                    best = {axis, static_cast<int>(lo + static_cast<std::int64_t>(p))};
                }
                below += here;
            }
        }
        return best;
    }

    const Cubes& cubes_;
    std::size_t uncut_;
    FrontList list_;
    std::vector<int> on_plane_;
};

void place_corners(const ElementCorners& elements, const std::vector<std::uint32_t>& place,
                   Front& front)
{
    for (const auto c : front.cubes) {
        auto& at = front.corner_at.emplace_back();
        for (std::size_t a = 0; a < 8; ++a) at[a] = place[elements[c][a]];
    }
}

}  // namespace

Dissection dissect(const Cubes& cubes, const std::vector<char>& left_out, double most,
                   std::size_t uncut)
{
    FrontList list = Dissector(cubes, left_out, uncut).run();
    return with_borders(std::move(list.fronts), list.front_of, cubes.corners, most);
}

Dissection with_borders(std::vector<Front> fronts, const std::vector<std::uint32_t>& front_of,
                        const ElementCorners& elements, double most)
{
    Dissection out;
    out.fronts = std::move(fronts);
    // An element enters where the first of its corners is eliminated.
    geometry::StopCheck stop;
    for (std::uint32_t c = 0; c < elements.size(); ++c) {
        stop();
        std::uint32_t first = no_index;
        for (const auto k : elements[c]) first = std::min(first, front_of[k]);
        if (first != no_index) out.fronts[first].cubes.push_back(c);
    }

    // The border: what elements and children bring in that is eliminated later, in that order.
    std::vector<std::uint32_t> place(front_of.size(), no_index);  // in the front at hand
    for (std::uint32_t f = 0; f < out.fronts.size(); ++f) {
        geometry::stop_if_asked();
        Front& front = out.fronts[f];
        std::uint32_t next = 0;
        for (const auto k : front.pivots) place[k] = next++;
        const auto meet = [&](std::uint32_t k) {
            if (front_of[k] == no_index || place[k] != no_index) return;
            place[k] = 0;  // met; its place comes after sorting
            front.border.push_back(k);
        };
        for (const auto c : front.cubes) {
            for (const auto k : elements[c]) meet(k);
        }
        for (const auto child : front.children) {
            for (const auto k : out.fronts[child].border) meet(k);
        }
        std::sort(front.border.begin(), front.border.end(), [&](auto a, auto b) {
            return std::pair(front_of[a], a) < std::pair(front_of[b], b);
        });
        for (const auto k : front.border) place[k] = next++;
        place_corners(elements, place, front);
        const auto p = static_cast<double>(front.pivots.size());
        const auto b = static_cast<double>(front.border.size());
        front.entries = p * (p + b);
        out.products += p * (p * p / 6 + b * p / 2 + b * b / 2);
        for (const auto child : front.children) {
            Front& below = out.fronts[child];
            below.parent = f;
            front.entries += below.entries;
            for (const auto k : below.border) below.in_parent.push_back(place[k]);
        }
        for (const auto k : front.pivots) place[k] = no_index;
        for (const auto k : front.border) place[k] = no_index;
        if (front.entries > most) return {};
    }
    for (std::uint32_t f = 0; f < out.fronts.size(); ++f) {
        if (out.fronts[f].parent != no_index) continue;
        out.roots.push_back(f);
        out.entries += out.fronts[f].entries;
    }
    if (out.entries > most) return {};
    return out;
}

void order_for_elimination(const Cubes& cubes, std::span<std::uint32_t> corners)
{
    if (corners.size() <= 16) return;
    geometry::Vec3i lo = cubes.corner[corners[0]], hi = lo;
    for (const auto k : corners) {
        lo = lo.cwiseMin(cubes.corner[k]);
        hi = hi.cwiseMax(cubes.corner[k]);
    }
    Plane plane{0, 0};
    // in 64 bits: cells may lie anywhere
    (hi.cast<std::int64_t>() - lo.cast<std::int64_t>()).maxCoeff(&plane.axis);
    if (hi[plane.axis] == lo[plane.axis]) return;  // copies at one place
    const auto coordinate = [&](std::uint32_t k) { return cubes.corner[k][plane.axis]; };
    const auto middle = corners.begin() + std::ptrdiff_t(corners.size() / 2);
    std::nth_element(corners.begin(), middle, corners.end(), [&](auto a, auto b) {
        return std::pair(coordinate(a), a) < std::pair(coordinate(b), b);
    });
    plane.at = coordinate(*middle);
    const Parted parted = part_at(plane, cubes, corners);
    order_for_elimination(cubes, parted.below);
    order_for_elimination(cubes, parted.above);
    // The plane's corners are cut as well, as long as they are not all there is.
    if (parted.on.size() < corners.size()) order_for_elimination(cubes, parted.on);
}

}  // namespace physics
