#include "physics/bricks/dissection.hpp"

#include "geometry/base/stop.hpp"

#include <algorithm>
#include <numeric>

namespace physics {
namespace {

using geometry::Vec3;

class PlaceDissector {
public:
    PlaceDissector(const ElementCorners& elements, std::span<const Vec3> places,
                   const std::vector<char>& left_out, std::size_t uncut)
        : elements_(elements), places_(places), uncut_(uncut), list_(places.size(), left_out),
          half_(places.size(), 0), start_(places.size() + 1, 0)
    {
        for (const auto& corners : elements) {
            for (const auto k : corners) ++start_[k + 1];
        }
        std::partial_sum(start_.begin(), start_.end(), start_.begin());
        elements_at_.resize(start_.back());
        std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
        for (std::uint32_t e = 0; e < elements.size(); ++e) {
            for (const auto k : elements[e]) elements_at_[next[k]++] = e;
        }
    }

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
        if (corners.size() <= uncut_) return list_.add(corners, {});
        const auto low = halve(corners);
        for (const auto k : low) half_[k] = 1;
        const auto high = corners.subspan(low.size());
        for (const auto k : high) half_[k] = 2;
        // What parts them goes to the end: of the half in which it is less.
        const auto meeting = [&](std::uint32_t k) { return meets_other(k); };
        const auto low_meets = std::count_if(low.begin(), low.end(), meeting);
        const auto high_meets = std::count_if(high.begin(), high.end(), meeting);
        const char parting = low_meets < high_meets ? 1 : 2;
        std::vector<std::uint32_t> kept[3];
        for (const auto k : corners) {
            const auto half = static_cast<std::size_t>(half_[k]);
            kept[half_[k] == parting && meets_other(k) ? 0 : half].push_back(k);
        }
        for (const auto k : corners) half_[k] = 0;
        if (kept[1].empty() || kept[2].empty()) return list_.add(corners, {});
        const auto below = cut(kept[1]);
        const auto above = cut(kept[2]);
        return list_.add(kept[0], {below, above});
    }

    // Puts the lower half along the longest side of their bounds first.
    std::span<std::uint32_t> halve(std::span<std::uint32_t> corners) const
    {
        Vec3 lo = places_[corners[0]], hi = lo;
        for (const auto k : corners) {
            lo = lo.cwiseMin(places_[k]);
            hi = hi.cwiseMax(places_[k]);
        }
        Eigen::Index axis = 0;
        (hi - lo).maxCoeff(&axis);
        const std::size_t half = corners.size() / 2;
        std::nth_element(corners.begin(), corners.begin() + std::ptrdiff_t(half), corners.end(),
                         [&](auto a, auto b) {
                             return std::pair(places_[a][axis], a) < std::pair(places_[b][axis], b);
                         });
        return corners.first(half);
    }

    bool meets_other(std::uint32_t k) const
    {
        const auto other = static_cast<char>(3 - half_[k]);
        for (auto at = start_[k]; at < start_[k + 1]; ++at) {
            for (const auto l : elements_[elements_at_[at]]) {
                if (half_[l] == other) return true;
            }
        }
        return false;
    }

    const ElementCorners& elements_;
    std::span<const Vec3> places_;
    std::size_t uncut_;
    FrontList list_;
    std::vector<char> half_;            // K, 1 and 2 in the parts at hand, else 0
    std::vector<std::uint32_t> start_;  // K + 1, into elements_at_
    std::vector<std::uint32_t> elements_at_;
};

}  // namespace

Dissection dissect(const ElementCorners& elements, std::span<const Vec3> places,
                   const std::vector<char>& left_out, double most, std::size_t uncut)
{
    FrontList list = PlaceDissector(elements, places, left_out, uncut).run();
    return with_borders(std::move(list.fronts), list.front_of, elements, most);
}

}  // namespace physics
