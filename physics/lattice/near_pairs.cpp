#include "physics/lattice/near_pairs.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/math/joined.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace physics {

namespace {

// Places in a grid of cells as wide as contact reaches, a row of cells along x after the other.
// Rows are found by a hash; one bucket may hold several.
struct Entry {
    Eigen::Array3i cell;
    BodyPoint point;
};
struct Rows {
    std::vector<Entry> entries;
    std::vector<std::uint32_t> at;  // buckets + 1, into entries

    std::uint32_t bucket(int y, int z) const
    {
        const std::uint32_t h = std::uint32_t(y) * 0x9e3779b1u ^ std::uint32_t(z) * 0x85ebca77u;
        return (h ^ h >> 15) & std::uint32_t(at.size() - 2);
    }
};

bool in_front(const Eigen::Array3i& a, const Eigen::Array3i& b)
{
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

Rows sort_into_rows(const std::vector<Entry>& places)
{
    Rows rows;
    std::size_t buckets = 16;
    while (buckets < places.size() / 4) buckets *= 2;
    rows.at.assign(buckets + 1, 0);
    std::vector<std::uint32_t> bucket(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        bucket[i] = rows.bucket(places[i].cell[1], places[i].cell[2]);
        ++rows.at[bucket[i] + 1];
    }
    for (std::size_t b = 0; b < buckets; ++b) rows.at[b + 1] += rows.at[b];
    rows.entries.resize(places.size());
    std::vector<std::uint32_t> next(rows.at.begin(), rows.at.end() - 1);
    for (std::size_t i = 0; i < places.size(); ++i) rows.entries[next[bucket[i]]++] = places[i];
    geometry::parallel_for(buckets, 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            std::sort(rows.entries.begin() + rows.at[b], rows.entries.begin() + rows.at[b + 1],
                      [](const Entry& p, const Entry& q) {
                          if (in_front(p.cell, q.cell)) return true;
                          return !in_front(q.cell, p.cell) && p.point.particle < q.point.particle;
                      });
        }
    });
    return rows;
}

// Entries of the row at cells (y, z).
std::pair<const Entry*, const Entry*> row_at(const Rows& rows, int y, int z)
{
    const std::uint32_t b = rows.bucket(y, z);
    const Entry *const low = rows.entries.data() + rows.at[b], *const high = rows.entries.data() +
                                                                             rows.at[b + 1];
    const auto before = [](const Entry& e, const std::pair<int, int>& row) {
        return std::pair(e.cell[2], e.cell[1]) < row;
    };
    const Entry* const first = std::lower_bound(low, high, std::pair(z, y), before);
    return {first, std::lower_bound(first, high, std::pair(z, y + 1), before)};
}

// Pairs of entries begin .. end with all others in the cells next to their own, each pair once:
// from their own row those behind, and all of four of the eight rows around. Two ends of what is
// next to an entry move along each row with it.
std::vector<NearPairs::Pair> pairs_of(const Rows& rows, std::size_t begin, std::size_t end,
                                      double reach, bool own)
{
    std::vector<NearPairs::Pair> found;
    std::size_t count = 0;
    const double reach_sq = reach * reach;
    const auto bodies_touch_themselves = unsigned(own);
    // Who is near is hard to foresee: without branches it takes a third of the time.
    const auto add = [&](const BodyPoint& mine, const Entry* from, const Entry* to) {
        const std::size_t most = count + std::size_t(to - from);
        if (found.size() < most) found.resize(2 * most);
        for (const Entry* e = from; e < to; ++e) {
            const BodyPoint& other = e->point;
            found[count] = {mine.particle, other.particle};
            count += std::size_t(unsigned((mine.at - other.at).squaredNorm() < reach_sq) &
                                 (bodies_touch_themselves | unsigned(mine.body != other.body)) &
                                 unsigned(!(mine.pinned & other.pinned)));
        }
    };
    const Entry* const last = rows.entries.data() + end;
    for (const Entry* first = rows.entries.data() + begin; first < last;) {
        const int y = first->cell[1], z = first->cell[2];
        const Entry* const row_end = row_at(rows, y, z).second;
        const Entry* const stop = std::min(row_end, last);
        const Entry* high = first;
        for (const Entry* mine = first; mine < stop; ++mine) {
            while (high < row_end && high->cell[0] <= mine->cell[0] + 1) ++high;
            add(mine->point, mine + 1, high);
        }
        constexpr int around[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};  // y, z
        for (const auto& [dy, dz] : around) {
            auto [from, row_last] = row_at(rows, y + dy, z + dz);
            const Entry* to = from;
            for (const Entry* mine = first; mine < stop; ++mine) {
                while (from < row_last && from->cell[0] < mine->cell[0] - 1) ++from;
                to = std::max(to, from);
                while (to < row_last && to->cell[0] <= mine->cell[0] + 1) ++to;
                add(mine->point, from, to);
            }
        }
        first = stop;
    }
    found.resize(count);
    return found;
}

// Indices of `count` things by key, those of equal key in the order that `order` has them.
std::vector<std::uint32_t> sorted_by(const std::vector<std::uint32_t>& order, std::size_t keys,
                                     const auto& key)
{
    std::vector<std::uint32_t> at(keys + 1, 0), out(order.size());
    for (const auto i : order) ++at[key(i) + 1];
    for (std::size_t k = 0; k < keys; ++k) at[k + 1] += at[k];
    for (const auto i : order) out[at[key(i)]++] = i;
    return out;
}

// Steps of this size go through all of `count` things, and far from one to the next.
std::uint32_t far_step(std::uint32_t count)
{
    std::uint32_t step = 1 + std::uint32_t(0.38 * count);
    while (std::gcd(step, count) != 1) ++step;
    return step;
}

// Pairs into groups, groups into colours: each takes the first that neither of its bodies has yet.
// `body` is that of each particle.
NearPairs grouped(const std::vector<NearPairs::Pair>& found, const std::vector<std::uint32_t>& body)
{
    constexpr int most_colours = 63;
    NearPairs out;
    if (found.empty()) return out;
    std::uint32_t bodies = 0;
    for (const auto b : body) bodies = std::max(bodies, b + 1);
    const auto bodies_of = [&](std::uint32_t i) {
        const std::uint32_t a = body[found[i].a], b = body[found[i].b];
        return std::pair(std::min(a, b), std::max(a, b));
    };
    std::vector<std::uint32_t> order(found.size());
    std::iota(order.begin(), order.end(), 0u);
    order = sorted_by(order, bodies, [&](std::uint32_t i) { return bodies_of(i).second; });
    order = sorted_by(order, bodies, [&](std::uint32_t i) { return bodies_of(i).first; });

    struct Group {
        std::uint32_t begin, end, colour;
    };
    std::vector<Group> groups;
    std::vector<std::uint64_t> taken(bodies, 0);
    std::uint32_t colours = 0;
    for (std::uint32_t begin = 0, end = 0; begin < order.size(); begin = end) {
        const auto [a, b] = bodies_of(order[begin]);
        while (end < order.size() && bodies_of(order[end]) == std::pair(a, b)) ++end;
        const auto colour =
            std::uint32_t(std::min(most_colours, std::countr_one(taken[a] | taken[b])));
        taken[a] |= std::uint64_t{1} << colour;
        taken[b] |= std::uint64_t{1} << colour;
        colours = std::max(colours, colour + 1);
        groups.push_back({begin, end, colour});
    }
    out.last_alone = colours == most_colours + 1;
    std::vector<std::uint32_t> by_colour(groups.size());
    std::iota(by_colour.begin(), by_colour.end(), 0u);
    std::ranges::stable_sort(by_colour, std::less(), [&](std::uint32_t g) {
        return std::pair(groups[g].colour, ~(groups[g].end - groups[g].begin));
    });
    out.pair.reserve(found.size());
    out.group_at.push_back(0);
    for (std::size_t g = 0; g < by_colour.size(); ++g) {
        const Group& group = groups[by_colour[g]];
        while (out.colour_at.size() <= group.colour) out.colour_at.push_back(std::uint32_t(g));
        // Not those of one particle after the other: each would wait for the one before.
        const std::uint32_t count = group.end - group.begin, step = far_step(count);
        for (std::uint32_t k = 0, at = 0; k < count; ++k, at = (at + step) % count) {
            out.pair.push_back(found[order[group.begin + at]]);
        }
        out.group_at.push_back(std::uint32_t(out.pair.size()));
    }
    out.colour_at.push_back(std::uint32_t(by_colour.size()));
    return out;
}

}  // namespace

NearPairs find_near_pairs(const std::vector<BodyPoint>& points, double reach,
                          const NearAlongBody& along)
{
    constexpr std::size_t grain = 512;
    std::vector<Entry> places(points.size());
    geometry::parallel_for(points.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Eigen::Array3d cell = (points[i].at / reach).array().floor();
            places[i] = {cell.max(-1e9).min(1e9).cast<int>(), points[i]};
        }
    });
    const Rows rows = sort_into_rows(places);
    std::uint32_t particles = 0;
    for (const BodyPoint& p : points) particles = std::max(particles, p.particle + 1);
    std::vector<std::uint32_t> body(particles, 0);
    for (const BodyPoint& p : points) body[p.particle] = p.body;
    std::vector<std::vector<NearPairs::Pair>> found((points.size() + grain - 1) / grain);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            found[g] = pairs_of(rows, g * grain, std::min(points.size(), (g + 1) * grain), reach,
                                bool(along));
            if (!along) continue;
            std::erase_if(found[g], [&](const NearPairs::Pair& pair) {
                return body[pair.a] == body[pair.b] && along(pair.a, pair.b);
            });
        }
    });
    return grouped(joined(found), body);
}

}  // namespace physics
