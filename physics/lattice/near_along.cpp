#include "physics/lattice/near_along.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/lattice/near_pairs.hpp"

#include <algorithm>

namespace physics {
namespace {

// N, the particles linked in -x, -y, -z or none.
std::vector<std::array<std::uint32_t, 3>> links_back(const Lattice& lattice)
{
    std::vector<std::array<std::uint32_t, 3>> back(lattice.count(), {none, none, none});
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (std::size_t d = 0; d < 3; ++d) {
            if (lattice.next[i][d] != none) back[lattice.next[i][d]][d] = i;
        }
    }
    return back;
}

// Goes along links from one particle after another.
class Walk {
public:
    Walk(const Lattice& lattice, const std::vector<std::array<std::uint32_t, 3>>& back)
        : lattice_(lattice), back_(back), met_(lattice.count(), none)
    {}

    // All at most `links` links away, itself first.
    const std::vector<std::uint32_t>& from(std::uint32_t start, int links)
    {
        found_.assign(1, start);
        met_[start] = start;
        std::size_t begin = 0;
        for (int link = 0; link < links; ++link) {
            const std::size_t end = found_.size();
            for (; begin < end; ++begin) {
                const std::uint32_t i = found_[begin];
                for (std::size_t d = 0; d < 3; ++d) {
                    for (const std::uint32_t j : {lattice_.next[i][d], back_[i][d]}) {
                        if (j == none || met_[j] == start) continue;
                        met_[j] = start;
                        found_.push_back(j);
                    }
                }
            }
        }
        return found_;
    }

private:
    const Lattice& lattice_;
    const std::vector<std::array<std::uint32_t, 3>>& back_;
    std::vector<std::uint32_t> met_;  // N, from which it was met last
    std::vector<std::uint32_t> found_;
};

}  // namespace

NearAlong::NearAlong(const Lattice& lattice, const std::vector<std::uint32_t>& side, int links,
                     double distance)
{
    const auto back = links_back(lattice);
    std::vector<char> is_side(lattice.count(), 0);
    std::vector<BodyPoint> points;
    for (const auto i : side) {
        is_side[i] = 1;
        points.push_back({lattice.at[i].cast<double>(), i, i, false});
    }
    std::vector<std::vector<std::uint32_t>> near(lattice.count());
    constexpr std::size_t walk_of = 2048;  // particles
    geometry::parallel_for(side.size(), walk_of, [&](std::size_t begin, std::size_t end) {
        Walk walk(lattice, back);
        for (std::size_t s = begin; s < end; ++s) {
            for (const auto j : walk.from(side[s], links)) {
                if (is_side[j] && j != side[s]) near[side[s]].push_back(j);
            }
        }
    });
    if (distance > 0) {
        const auto leave = [&](std::uint32_t a, std::uint32_t b) {
            near[a].push_back(b);
            near[b].push_back(a);
        };
        // Beside those that lie in one place over a slit, others rest just as far apart as they
        // touch: they would catch in each other.
        for (const auto& [a, b] : find_near_pairs(points, distance).pair) {
            leave(a, b);
            for (std::size_t d = 0; d < 3; ++d) {
                for (const std::uint32_t j : {lattice.next[b][d], back[b][d]}) {
                    if (j != none && is_side[j] && j != a) leave(a, j);
                }
                for (const std::uint32_t i : {lattice.next[a][d], back[a][d]}) {
                    if (i != none && is_side[i] && i != b) leave(i, b);
                }
            }
        }
    }
    at_.assign(1, 0);
    for (auto& own : near) {
        std::sort(own.begin(), own.end());
        near_.insert(near_.end(), own.begin(), std::unique(own.begin(), own.end()));
        at_.push_back(static_cast<std::uint32_t>(near_.size()));
    }
}

bool NearAlong::has(std::uint32_t a, std::uint32_t b) const
{
    return std::binary_search(near_.begin() + at_[a], near_.begin() + at_[a + 1], b);
}

std::size_t NearAlong::bytes() const
{
    return (at_.size() + near_.size()) * sizeof(std::uint32_t);
}

}  // namespace physics
