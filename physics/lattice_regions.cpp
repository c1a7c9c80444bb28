#include "physics/lattice_regions.hpp"

#include "geometry/parallel.hpp"
#include "geometry/sets.hpp"
#include "physics/shared_sums.hpp"

#include <fmt/format.h>

#include <numeric>

namespace physics {

namespace {

// A piece of the lattice in which no two particles share a place: a connected component, or the
// second, third ... copies in one. Particles are sorted by (z, y, x).
struct Chart {
    std::vector<std::uint32_t> particles;
};

std::vector<Chart> make_charts(const Lattice& lattice)
{
    const auto n = std::uint32_t(lattice.count());
    geometry::Sets sets(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        for (int d = 0; d < 3; ++d) {
            const std::uint32_t j = lattice.next[i][std::size_t(d)];
            if (j == none) continue;
            if (j >= n || lattice.at[j] - lattice.at[i] != Vec3i::Unit(d)) {
                throw std::invalid_argument(fmt::format(
                    "expected particle {} to link to its neighbour along axis {}, found "
                    "particle {}",
                    i, d, j));
            }
            sets.join(i, j);
        }
    }
    const std::vector<std::uint32_t> root = sets.roots();
    std::vector<std::uint32_t> order(n);
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) {
        const Vec3i& p = lattice.at[i];
        return std::tuple(root[i], p[2], p[1], p[0], i);
    };
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
    std::vector<Chart> charts;
    std::size_t first = 0;  // chart of the component's first copies
    std::size_t copy = 0;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const bool fresh = k == 0 || root[order[k]] != root[order[k - 1]];
        if (fresh) first = charts.size();
        copy = !fresh && lattice.at[order[k]] == lattice.at[order[k - 1]] ? copy + 1 : 0;
        if (first + copy == charts.size()) charts.emplace_back();
        charts[first + copy].particles.push_back(order[k]);
    }
    return charts;
}

// One line for each maximal set of windows no more than 2w apart, so that no item is in two lines.
// `windows` and `items` are (position, index) in ascending order of position; absent windows in
// between become dead ones. Every item has a window in reach.
using Place = std::pair<int, std::uint32_t>;
template <class Number>
void add_lines(LatticeLines& lines, int w, std::span<const Place> windows,
               std::span<const Place> items, const Number& number)
{
    std::size_t item = 0;
    for (std::size_t begin = 0; begin < windows.size();) {
        std::size_t end = begin + 1;
        while (end < windows.size() && windows[end].first - windows[end - 1].first <= 2 * w) ++end;
        const int p0 = windows[begin].first, p1 = windows[end - 1].first;
        LatticeLines::Line line{};
        line.window = lines.windows;
        line.windows = std::uint32_t(p1 - p0 + 1);
        line.item = std::uint32_t(lines.items.size());
        std::size_t next = begin;
        for (int p = p0; p <= p1; ++p) {
            if (windows[next].first == p) {
                number(windows[next++].second, lines.windows);
            } else {
                lines.dead.push_back(lines.windows);
            }
            ++lines.windows;
        }
        int position = 0;
        for (; item < items.size() && items[item].first <= p1 + w; ++item) {
            const int q = items[item].first;
            if (line.items == 0) {
                line.lead = q - p0;
                position = q;
            }
            for (; position < q; ++position, ++line.items) lines.items.push_back(none);
            lines.items.push_back(items[item].second);
            ++line.items;
            ++position;
        }
        lines.lines.push_back(line);
        begin = end;
    }
}

// Marks within w of a set bit along one axis of a plane of bits; stride 1 is x.
void dilate(const std::vector<std::uint8_t>& in, std::vector<std::uint8_t>& out, std::size_t count,
            std::size_t stride, std::size_t lines, std::size_t line_stride, std::size_t w)
{
    out.assign(in.size(), 0);
    for (std::size_t l = 0; l < lines; ++l) {
        std::size_t until = 0;  // bits before this one are marked
        for (std::size_t i = 0; i < count; ++i) {
            if (!in[l * line_stride + i * stride]) continue;
            const std::size_t to = std::min(count, i + w + 1);
            for (std::size_t k = std::max(until, i < w ? 0 : i - w); k < to; ++k) {
                out[l * line_stride + k * stride] = 1;
            }
            until = to;
        }
    }
}

// The bars, plates and regions of one chart, a slice z at a time. A bar is wanted where it is not
// empty and some plate in its column along y needs it, a plate where it is not empty and some
// region in its column along z does.
class ChartLines {
public:
    ChartLines(const Lattice& lattice, const Chart& chart, LatticeRegions& regions)
        : lattice_(lattice), chart_(chart), regions_(regions), w_(regions.half_width)
    {
        lo_ = hi_ = lattice.at[chart.particles[0]];
        for (const auto i : chart.particles) {
            lo_ = lo_.cwiseMin(lattice.at[i]);
            hi_ = hi_.cwiseMax(lattice.at[i]);
        }
        nx_ = std::size_t(hi_[0] - lo_[0] + 1);
        ny_ = std::size_t(hi_[1] - lo_[1] + 1);
    }

    void add()
    {
        std::vector<std::uint32_t> in_reach(nx_ * ny_, 0);  // particles of a column within w
        std::vector<std::uint8_t> some(nx_ * ny_), bars, plates, near;
        std::size_t entering = 0, here = 0, leaving = 0;
        const auto& all = chart_.particles;
        const auto z_of = [&](std::size_t k) { return lattice_.at[all[k]][2]; };
        for (int z = lo_[2]; z <= hi_[2]; ++z) {
            for (; entering < all.size() && z_of(entering) <= z + w_; ++entering) {
                ++in_reach[cell(all[entering])];
            }
            for (; leaving < all.size() && z_of(leaving) < z - w_; ++leaving) {
                --in_reach[cell(all[leaving])];
            }
            const std::size_t begin = here;
            while (here < all.size() && z_of(here) == z) ++here;
            if (begin == here) continue;

            const std::size_t w = std::size_t(w_);
            std::fill(some.begin(), some.end(), std::uint8_t{0});
            for (std::size_t k = begin; k < here; ++k) some[cell(all[k])] = 1;
            dilate(some, bars, nx_, 1, ny_, nx_, w);
            for (std::size_t i = 0; i < some.size(); ++i) some[i] = in_reach[i] > 0;
            dilate(some, near, ny_, nx_, nx_, 1, w);
            dilate(bars, plates, ny_, nx_, nx_, 1, w);
            for (std::size_t i = 0; i < some.size(); ++i) {
                bars[i] &= near[i];
                plates[i] &= some[i];
            }
            add_slice(z, {all.begin() + std::ptrdiff_t(begin), all.begin() + std::ptrdiff_t(here)},
                      bars, plates);
        }
        if (regions_.flat) {
            name_plates();
        } else {
            add_columns();
        }
    }

private:
    std::size_t cell(std::uint32_t i) const
    {
        const Vec3i p = lattice_.at[i] - lo_;
        return std::size_t(p[1]) * nx_ + std::size_t(p[0]);
    }

    void add_slice(int z, std::span<const std::uint32_t> particles,
                   const std::vector<std::uint8_t>& bars, const std::vector<std::uint8_t>& plates)
    {
        std::vector<Place> windows, items;
        bar_.assign(nx_ * ny_, none);
        std::size_t k = 0;
        for (std::size_t y = 0; y < ny_; ++y) {
            windows.clear();
            items.clear();
            for (; k < particles.size() && cell(particles[k]) < (y + 1) * nx_; ++k) {
                items.emplace_back(int(cell(particles[k]) - y * nx_), particles[k]);
            }
            for (std::size_t x = 0; x < nx_; ++x) {
                if (bars[y * nx_ + x]) windows.emplace_back(int(x), std::uint32_t(x));
            }
            add_lines(regions_.x, w_, windows, items,
                      [&](std::uint32_t x, std::uint32_t bar) { bar_[y * nx_ + x] = bar; });
        }
        for (std::size_t x = 0; x < nx_; ++x) {
            windows.clear();
            items.clear();
            for (std::size_t y = 0; y < ny_; ++y) {
                const std::size_t c = y * nx_ + x;
                if (plates[c]) windows.emplace_back(int(y), std::uint32_t(y));
                if (bar_[c] != none) items.emplace_back(int(y), bar_[c]);
            }
            add_lines(regions_.y, w_, windows, items, [&](std::uint32_t y, std::uint32_t plate) {
                plates_.push_back({x * ny_ + y, z, plate});
            });
        }
        // Thin slices make up a slab together.
        auto& slabs = regions_.slabs;
        const std::size_t all = slabs.size();
        const std::uint32_t before = all < 2 ? 0 : slabs[all - 2].x_lines;
        const auto first_bar = [&](std::uint32_t line) {
            return line < regions_.x.lines.size() ? regions_.x.lines[line].window
                                                  : regions_.x.windows;
        };
        if (all == 0 || first_bar(slabs.back().x_lines) - first_bar(before) >= least_bars)
            slabs.emplace_back();
        slabs.back() = {std::uint32_t(regions_.x.lines.size()),
                        std::uint32_t(regions_.y.lines.size())};
    }

    static constexpr std::uint32_t least_bars = 1024;

    // On a plane: a plate is the region of the particle in its middle.
    void name_plates()
    {
        std::vector<std::uint32_t> at(nx_ * ny_, none);
        for (const auto i : chart_.particles) at[cell(i)] = i;
        regions_.particle.resize(regions_.y.windows, none);
        for (const Place3& plate : plates_) {
            regions_.particle[plate.index] = at[plate.column % ny_ * nx_ + plate.column / ny_];
        }
    }

    void add_columns()
    {
        std::vector<Place3> particles;
        for (const auto i : chart_.particles) {
            const Vec3i p = lattice_.at[i] - lo_;
            particles.push_back(
                {std::size_t(p[0]) * ny_ + std::size_t(p[1]), lattice_.at[i][2], i});
        }
        std::sort(particles.begin(), particles.end());
        std::sort(plates_.begin(), plates_.end());
        std::vector<Place> windows, items;
        std::size_t plate = 0;
        for (std::size_t begin = 0, end = 0; begin < particles.size(); begin = end) {
            const std::size_t column = particles[begin].column;
            windows.clear();
            items.clear();
            for (; end < particles.size() && particles[end].column == column; ++end) {
                windows.emplace_back(particles[end].z, particles[end].index);
            }
            for (; plate < plates_.size() && plates_[plate].column <= column; ++plate) {
                items.emplace_back(plates_[plate].z, plates_[plate].index);
            }
            add_lines(regions_.z, w_, windows, items, [&](std::uint32_t i, std::uint32_t slot) {
                regions_.particle.resize(slot + 1, none);
                regions_.particle[slot] = i;
            });
        }
    }

    struct Place3 {
        std::size_t column;
        int z;
        std::uint32_t index;
        auto operator<=>(const Place3&) const = default;
    };

    const Lattice& lattice_;
    const Chart& chart_;
    LatticeRegions& regions_;
    int w_;
    Vec3i lo_, hi_;
    std::size_t nx_, ny_;
    std::vector<std::uint32_t> bar_;  // of the slice, by cell
    std::vector<Place3> plates_;
};

// Charts, and what of them tells that a region holds all of its box.
class ChartExtents {
public:
    ChartExtents(const Lattice& lattice, const std::vector<Chart>& charts, int w)
        : lattice_(lattice), w_(w), of_(lattice.count()), loose_(lattice.count(), 0)
    {
        for (std::uint32_t c = 0; c < charts.size(); ++c) {
            const Vec3i& any = lattice.at[charts[c].particles[0]];
            auto& [low, high] = extent_.emplace_back(any, any);
            for (const auto i : charts[c].particles) {
                of_[i] = c;
                low = low.cwiseMin(lattice.at[i]);
                high = high.cwiseMax(lattice.at[i]);
            }
        }
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            for (int d = 0; d < 3; ++d) {
                const std::uint32_t j = lattice.next[i][std::size_t(d)];
                if (j == none) {
                    if (lattice.at[i][d] < extent_[of_[i]].second[d]) loose_[i] = 1;
                } else if (of_[i] != of_[j]) {
                    loose_[i] = loose_[j] = 1;
                }
            }
        }
    }

    std::uint32_t of(std::uint32_t i) const { return of_[i]; }

    // Whether there might be a place beside this particle that it is not linked to. A box that is
    // full of others hangs together.
    bool is_loose(std::uint32_t i) const { return loose_[i] != 0; }

    // How many places the box around a particle has, within its chart.
    std::size_t places(std::uint32_t i) const
    {
        const auto& [low, high] = extent_[of_[i]];
        std::size_t count = 1;
        for (int d = 0; d < 3; ++d) {
            const int at = lattice_.at[i][d];
            count *= std::size_t(std::min(high[d], at + w_) - std::max(low[d], at - w_) + 1);
        }
        return count;
    }

private:
    const Lattice& lattice_;
    int w_;
    std::vector<std::uint32_t> of_;
    std::vector<std::uint8_t> loose_;
    std::vector<std::pair<Vec3i, Vec3i>> extent_;
};

// One region that is not its whole box.
struct Exception {
    std::uint32_t slot, particle;
    std::vector<Reach::Piece> pieces;  // by z, then by place
};

// Regions whose reach is not all that its chart has in the box.
std::vector<Exception> find_exceptions(const Lattice& lattice, const LatticeRegions& regions,
                                       const Runs& runs, const std::vector<Chart>& all_charts)
{
    const ChartExtents charts(lattice, all_charts, regions.half_width);
    // How many particles of a region's chart its box holds, and how many of them are loose: a sum
    // over all regions as if there were no exceptions.
    RegionSums<double> sums(regions);
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        sums.particles[i] = {1, charts.is_loose(i) ? 1.0 : 0.0, 0, 0};
    }
    std::vector<std::uint32_t> held(regions.slots());
    constexpr std::uint32_t all_places = none;
    collect<double>(regions, sums, [&](std::size_t first, std::span<const Quad<double>> slots) {
        for (std::size_t k = 0; 4 * k < slots.size(); ++k) {
            const Quad<double>& sum = slots[4 * k];
            const std::uint32_t r = regions.particle[first + k];
            const bool is_full = r != none && sum[1] == 0 && sum[0] == double(charts.places(r));
            held[first + k] = is_full ? all_places : std::uint32_t(sum[0]);
        }
    });
    // How often the chart has changed along the runs up to each of their particles.
    const auto in_runs = runs.particles();
    std::vector<std::uint32_t> changes(in_runs.size(), 0);
    for (std::size_t k = 1; k < changes.size(); ++k) {
        const bool same = charts.of(in_runs[k]) == charts.of(in_runs[k - 1]);
        changes[k] = changes[k - 1] + (same ? 0 : 1);
    }
    constexpr std::size_t piece = 4096;
    std::vector<std::vector<Exception>> found((regions.slots() + piece - 1) / piece);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        Reach reach(runs, regions.half_width);
        for (std::size_t p = begin; p < end; ++p) {
            for (std::size_t slot = p * piece; slot < std::min(regions.slots(), (p + 1) * piece);
                 ++slot) {
                const std::uint32_t r = regions.particle[slot];
                if (r == none || held[slot] == all_places) continue;
                std::uint32_t reached = 0;
                bool elsewhere = false;
                const auto pieces = reach.from(r, lattice.at[r]);
                for (const auto& run : pieces) {
                    elsewhere |= charts.of(in_runs[run.first]) != charts.of(r) ||
                                 changes[run.first] != changes[run.first + run.length - 1];
                    reached += run.length;
                }
                if (!elsewhere && reached == held[slot]) continue;
                Exception fresh{std::uint32_t(slot), r, {pieces.begin(), pieces.end()}};
                std::sort(fresh.pieces.begin(), fresh.pieces.end());
                found[p].push_back(std::move(fresh));
            }
        }
    });
    std::vector<Exception> all;
    for (auto& list : found) {
        all.insert(all.end(), std::make_move_iterator(list.begin()),
                   std::make_move_iterator(list.end()));
    }
    return all;
}

}  // namespace

Lattice turned(const Lattice& lattice, const std::array<int, 3>& axes)
{
    Lattice out;
    for (const Vec3i& p : lattice.at) out.at.emplace_back(p[axes[0]], p[axes[1]], p[axes[2]]);
    for (const auto& next : lattice.next) {
        out.next.push_back(
            {next[std::size_t(axes[0])], next[std::size_t(axes[1])], next[std::size_t(axes[2])]});
    }
    return out;
}

LatticeRegions find_regions(const Lattice& given, int half_width, int flat_axis)
{
    if (half_width < 1 || half_width > 64) {
        throw std::invalid_argument(
            fmt::format("expected a half width of regions from 1 to 64, found {}", half_width));
    }
    LatticeRegions regions;
    regions.half_width = half_width;
    regions.particles = given.count();
    regions.flat = flat_axis >= 0;
    if (regions.flat) regions.axes = {(flat_axis + 1) % 3, (flat_axis + 2) % 3, flat_axis};
    const Lattice lattice = turned(given, regions.axes);
    if (regions.flat) {
        for (const auto& next : lattice.next) {
            if (next[2] != none) {
                throw std::invalid_argument("expected a plane without links along its flat axis");
            }
        }
    }
    const std::vector<Chart> charts = make_charts(lattice);
    for (const Chart& chart : charts) ChartLines(lattice, chart, regions).add();
    regions.particle.resize(regions.flat ? regions.y.windows : regions.z.windows, none);

    const Runs runs(lattice);
    SharedSums sums(regions.flat ? 1 : 2 * std::size_t(half_width) + 1);
    const auto exceptions = find_exceptions(lattice, regions, runs, charts);
    std::vector<SharedSums::Region> exceptional;
    for (const Exception& x : exceptions) exceptional.push_back({x.slot, x.particle});
    sums.add(exceptional);
    for (const Exception& x : exceptions) sums.set(x.slot, x.pieces);
    regions.exceptions = sums.table(runs.particles(), {lattice.at, {0, 1, 2}});
    return regions;
}

std::vector<std::uint32_t> count_holders(const LatticeRegions& regions)
{
    RegionSums<double> sums(regions);
    spread<double>(regions, sums, [](std::size_t, std::span<Quad<double>> slots) {
        for (std::size_t k = 0; k < slots.size(); k += 4) slots[k] = {1, 0, 0, 0};
    });
    std::vector<std::uint32_t> held_by;
    for (const auto& count : sums.particles) {
        held_by.push_back(std::uint32_t(std::lround(count[0])));
    }
    return held_by;
}

}  // namespace physics
