#include "physics/regions/chart_lines.hpp"

#include <algorithm>
#include <span>

namespace physics {

namespace {

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

}  // namespace

void add_chart_lines(const Lattice& lattice, const Chart& chart, LatticeRegions& regions)
{
    ChartLines(lattice, chart, regions).add();
}

}  // namespace physics
