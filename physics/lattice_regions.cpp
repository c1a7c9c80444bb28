#include "physics/lattice_regions.hpp"

#include "geometry/parallel.hpp"

#include <fmt/format.h>

#include <limits>
#include <numeric>
#include <unordered_set>

namespace physics {

namespace {

// A piece of the lattice in which no two particles share a place: a connected component, or the
// second, third ... copies in one. Particles are sorted by (z, y, x).
struct Chart {
    std::vector<std::uint32_t> particles;
};

std::uint32_t root_of(std::vector<std::uint32_t>& parent, std::uint32_t i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

std::vector<Chart> make_charts(const Lattice& lattice)
{
    const auto n = std::uint32_t(lattice.count());
    std::vector<std::uint32_t> parent(n);
    std::iota(parent.begin(), parent.end(), 0u);
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
            const auto a = root_of(parent, i), b = root_of(parent, j);
            parent[std::max(a, b)] = std::min(a, b);
        }
    }
    std::vector<std::uint32_t> order(n), root(n);
    for (std::uint32_t i = 0; i < n; ++i) root[i] = root_of(parent, i);
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

// Unbroken runs of particles along x, and where neighbouring runs are linked: reach in a box is
// found a run at a time.
struct Runs {
    struct Run {
        std::uint32_t first, length;  // into particle
        int x, y, z;                  // of its first particle
    };
    struct Seam {
        std::uint32_t run;
        int low, high;  // x, inclusive, of a stretch without a gap
    };
    std::vector<Run> run;
    std::vector<std::uint32_t> particle;
    std::vector<std::uint32_t> of;       // N, the run that holds a particle
    std::vector<std::uint32_t> seam_at;  // run + 1, into seam
    std::vector<Seam> seam;
};

Runs make_runs(const Lattice& lattice)
{
    const std::size_t n = lattice.count();
    Runs runs;
    runs.of.assign(n, none);
    std::vector<std::uint8_t> has_before(n, 0);
    for (const auto& next : lattice.next) {
        if (next[0] != none) has_before[next[0]] = 1;
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        if (has_before[i]) continue;
        const Vec3i& p = lattice.at[i];
        const auto first = std::uint32_t(runs.particle.size());
        for (std::uint32_t j = i; j != none; j = lattice.next[j][0]) {
            runs.of[j] = std::uint32_t(runs.run.size());
            runs.particle.push_back(j);
        }
        runs.run.push_back({first, std::uint32_t(runs.particle.size()) - first, p[0], p[1], p[2]});
    }
    std::vector<std::vector<Runs::Seam>> seams(runs.run.size());
    for (std::uint32_t r = 0; r < runs.run.size(); ++r) {
        const auto& run = runs.run[r];
        for (std::size_t d = 1; d < 3; ++d) {
            for (std::uint32_t k = 0; k < run.length; ++k) {
                const std::uint32_t j = lattice.next[runs.particle[run.first + k]][d];
                if (j == none) continue;
                const int x = run.x + int(k);
                const std::uint32_t other = runs.of[j];
                auto& mine = seams[r];
                if (!mine.empty() && mine.back().run == other && mine.back().high == x - 1) {
                    ++mine.back().high;
                    ++seams[other].back().high;
                } else {
                    mine.push_back({other, x, x});
                    seams[other].push_back({r, x, x});
                }
            }
        }
    }
    runs.seam_at.push_back(0);
    for (const auto& s : seams) {
        runs.seam.insert(runs.seam.end(), s.begin(), s.end());
        runs.seam_at.push_back(std::uint32_t(runs.seam.size()));
    }
    return runs;
}

// What links reach inside the box of half width w around one particle: pieces of runs.
class Reach {
public:
    struct Piece {
        std::uint32_t first, length;  // into Runs::particle
        std::uint32_t run;
    };

    Reach(const Runs& runs, int w) : runs_(runs), w_(w), seen_(runs.run.size(), none) {}

    // In no particular order; valid until the next call.
    std::span<const Piece> from(std::uint32_t particle, const Vec3i& at)
    {
        pieces_.clear();
        visit(runs_.of[particle], particle, at);
        for (std::size_t k = 0; k < pieces_.size(); ++k) {
            const std::uint32_t r = pieces_[k].run;
            for (std::uint32_t s = runs_.seam_at[r]; s < runs_.seam_at[r + 1]; ++s) {
                const auto& seam = runs_.seam[s];
                if (seam.low <= at[0] + w_ && seam.high >= at[0] - w_)
                    visit(seam.run, particle, at);
            }
        }
        return pieces_;
    }

private:
    void visit(std::uint32_t r, std::uint32_t particle, const Vec3i& at)
    {
        const auto& run = runs_.run[r];
        if (seen_[r] == particle || std::abs(run.y - at[1]) > w_ || std::abs(run.z - at[2]) > w_) {
            return;
        }
        seen_[r] = particle;
        const int low = std::max(run.x, at[0] - w_);
        const int high = std::min(run.x + int(run.length) - 1, at[0] + w_);
        pieces_.push_back(
            {run.first + std::uint32_t(low - run.x), std::uint32_t(high - low + 1), r});
    }

    const Runs& runs_;
    int w_;
    std::vector<std::uint32_t> seen_;  // the particle that last saw a run
    std::vector<Piece> pieces_;
};

// One region that is not its whole box.
struct Exception {
    std::uint32_t slot, particle;
    std::vector<Reach::Piece> pieces;  // by z, then by place
};

// Numbers what is the same alike, from 0 in the order that it is first seen.
class Numbering {
public:
    // `same(k)` says whether what has number k is this; a new number is count().
    template <class Same> std::uint32_t of(std::uint64_t hash, const Same& same)
    {
        if (2 * hash_.size() >= slot_.size()) grow();
        std::size_t at = place(hash);
        for (; slot_[at] != none; at = (at + 1) & (slot_.size() - 1)) {
            if (hash_[slot_[at]] == hash && same(slot_[at])) return slot_[at];
        }
        slot_[at] = std::uint32_t(hash_.size());
        hash_.push_back(hash);
        return slot_[at];
    }
    std::uint32_t count() const { return std::uint32_t(hash_.size()); }

private:
    std::size_t place(std::uint64_t hash) const { return hash & (slot_.size() - 1); }
    void grow()
    {
        slot_.assign(2 * slot_.size(), none);
        for (std::uint32_t k = 0; k < hash_.size(); ++k) {
            std::size_t at = place(hash_[k]);
            while (slot_[at] != none) at = (at + 1) & (slot_.size() - 1);
            slot_[at] = k;
        }
    }

    std::vector<std::uint64_t> hash_;
    std::vector<std::uint32_t> slot_ = std::vector<std::uint32_t>(1024, none);
};

std::uint64_t mixed(std::uint64_t hash, std::uint64_t with)
{
    hash = (hash ^ with) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 29;
}

// Lists one after another.
struct Lists {
    std::vector<std::uint32_t> at{0}, all;

    void end() { at.push_back(std::uint32_t(all.size())); }
    std::size_t count() const { return at.size() - 1; }
    std::span<const std::uint32_t> operator[](std::size_t k) const
    {
        return {all.begin() + at[k], all.begin() + at[k + 1]};
    }
};

// Which lists name each number below `count`, with with(list, place in it) of each, in their order.
template <class With> Lists transposed(const Lists& lists, std::size_t count, const With& with)
{
    Lists out;
    out.at.assign(count + 1, 0);
    for (const auto k : lists.all) ++out.at[k + 1];
    std::partial_sum(out.at.begin(), out.at.end(), out.at.begin());
    out.all.resize(lists.all.size());
    std::vector<std::uint32_t> next(out.at.begin(), out.at.end() - 1);
    for (std::uint32_t l = 0; l < lists.count(); ++l) {
        for (std::uint32_t i = lists.at[l]; i < lists.at[l + 1]; ++i) {
            out.all[next[lists.all[i]]++] = with(l, i - lists.at[l]);
        }
    }
    return out;
}

LatticeExceptions share_sums(const Lattice& lattice, const Runs& runs,
                             const std::vector<Exception>& exceptions)
{
    LatticeExceptions e;
    Numbering bar_numbers, plate_numbers;
    Lists bars, plates, regions;  // of particles, bars, plates
    std::vector<Reach::Piece> bar;
    std::vector<std::pair<int, std::uint32_t>> pieces;  // z and bar of an exception
    for (const Exception& x : exceptions) {
        pieces.clear();
        for (const auto& piece : x.pieces) {
            const auto k = bar_numbers.of(mixed(piece.first, piece.length), [&](std::uint32_t b) {
                return bar[b].first == piece.first && bar[b].length == piece.length;
            });
            if (k == bar.size()) {
                bar.push_back(piece);
                const auto first = runs.particle.begin() + piece.first;
                bars.all.insert(bars.all.end(), first, first + piece.length);
                bars.end();
            }
            pieces.emplace_back(runs.run[piece.run].z, k);
        }
        std::sort(pieces.begin(), pieces.end());
        for (std::size_t first = 0, last = 0; first < pieces.size(); first = last) {
            std::uint64_t hash = 0;
            for (; last < pieces.size() && pieces[last].first == pieces[first].first; ++last) {
                hash = mixed(hash, pieces[last].second);
            }
            const auto k = plate_numbers.of(hash, [&](std::uint32_t p) {
                const auto plate = plates[p];
                return plate.size() == last - first &&
                       std::equal(
                           plate.begin(), plate.end(), pieces.begin() + std::ptrdiff_t(first),
                           [](std::uint32_t b, const auto& piece) { return b == piece.second; });
            });
            if (k == plates.count()) {
                for (std::size_t i = first; i < last; ++i) plates.all.push_back(pieces[i].second);
                plates.end();
            }
            regions.all.push_back(k);
        }
        regions.end();
        e.region.push_back(x.slot);
    }
    e.bars = bar_numbers.count();
    e.plates = plate_numbers.count();

    e.child_at = {0};
    const auto add_children = [&](const Lists& lists, std::uint32_t first) {
        for (std::size_t k = 0; k < lists.count(); ++k) {
            for (const auto child : lists[k]) e.child.push_back(first + child);
            e.child_at.push_back(std::uint32_t(e.child.size()));
        }
    };
    add_children(bars, 0);
    add_children(plates, 0);
    add_children(regions, e.bars);
    for (std::uint32_t b = 0; b < e.bars; ++b) e.at.push_back(lattice.at[bars[b][0]]);
    for (std::uint32_t p = 0; p < e.plates; ++p) e.at.push_back(e.at[plates[p][0]]);
    for (const Exception& x : exceptions) e.at.push_back(lattice.at[x.particle]);

    const auto plates_of = transposed(plates, e.bars, [&](auto p, auto) { return e.bars + p; });
    const auto regions_of =
        transposed(regions, e.plates, [&](auto r, auto) { return e.bars + e.plates + r; });
    e.parent_at = plates_of.at;
    e.parent = plates_of.all;
    for (std::uint32_t p = 0; p < e.plates; ++p) {
        e.parent_at.push_back(std::uint32_t(plates_of.all.size()) + regions_of.at[p + 1]);
    }
    e.parent.insert(e.parent.end(), regions_of.all.begin(), regions_of.all.end());

    auto bars_of = transposed(bars, lattice.count(), [](auto b, auto k) { return b * 256 + k; });
    e.bar_at.push_back(0);
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        if (bars_of[i].empty()) continue;
        e.particle.push_back(i);
        e.bar_at.push_back(bars_of.at[i + 1]);
    }
    e.bar = std::move(bars_of.all);
    return e;
}

struct PlaceHash {
    std::size_t operator()(const Vec3i& p) const
    {
        std::uint64_t h = 0;
        for (int d = 0; d < 3; ++d) h = mixed(h, std::uint32_t(p[d]));
        return h;
    }
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
    std::vector<std::uint32_t> changes(runs.particle.size(), 0);
    for (std::size_t k = 1; k < changes.size(); ++k) {
        const bool same = charts.of(runs.particle[k]) == charts.of(runs.particle[k - 1]);
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
                    elsewhere |= charts.of(runs.particle[run.first]) != charts.of(r) ||
                                 changes[run.first] != changes[run.first + run.length - 1];
                    reached += run.length;
                }
                if (!elsewhere && reached == held[slot]) continue;
                found[p].push_back({std::uint32_t(slot), r, {pieces.begin(), pieces.end()}});
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

// The boxes of half width w around some particles.
class Boxes {
public:
    Boxes(const Lattice& lattice, std::span<const std::uint32_t> around, int w, bool flat)
    {
        const Vec3i reach(w, w, flat ? 0 : w);
        for (const auto i : around) {
            low_ = low_.cwiseMin(lattice.at[i] - reach);
            high_ = high_.cwiseMax(lattice.at[i] + reach);
        }
        if (around.empty()) return;
        const double places =
            (high_.cast<double>() - low_.cast<double>() + geometry::Vec3::Ones()).prod();
        if (places <= most_places) marked_.assign(std::size_t(places), 0);
        for (const auto i : around) {
            for (int z = -reach[2]; z <= reach[2]; ++z) {
                for (int y = -w; y <= w; ++y) {
                    const Vec3i at = lattice.at[i] + Vec3i(-w, y, z);
                    if (!marked_.empty()) {
                        std::fill_n(marked_.begin() + std::ptrdiff_t(place(at)), 2 * w + 1, 1);
                        continue;
                    }
                    for (int x = 0; x <= 2 * w; ++x) far_.insert(at + Vec3i(x, 0, 0));
                }
            }
        }
    }

    bool hold(const Vec3i& at) const
    {
        if ((at.array() < low_.array()).any() || (at.array() > high_.array()).any()) return false;
        return marked_.empty() ? far_.contains(at) : marked_[place(at)] != 0;
    }

private:
    static constexpr double most_places = 1 << 26;

    std::size_t place(const Vec3i& at) const
    {
        const Vec3i p = at - low_, n = high_ - low_ + Vec3i::Ones();
        return (std::size_t(p[2]) * std::size_t(n[1]) + std::size_t(p[1])) * std::size_t(n[0]) +
               std::size_t(p[0]);
    }

    Vec3i low_ = Vec3i::Constant(std::numeric_limits<int>::max());
    Vec3i high_ = Vec3i::Constant(std::numeric_limits<int>::min());
    std::vector<std::uint8_t> marked_;          // all places between low_ and high_
    std::unordered_set<Vec3i, PlaceHash> far_;  // or those in boxes that lie far apart
};

// The lattice with its axes in the order that lines run along.
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

}  // namespace

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

    const Runs runs = make_runs(lattice);
    const auto exceptions = find_exceptions(lattice, regions, runs, charts);
    regions.exceptions = share_sums(lattice, runs, exceptions);
    return regions;
}

LatticeRegions find_torn_regions(const Lattice& torn, const LatticeRegions& whole,
                                 std::span<const std::uint32_t> ends)
{
    const Lattice lattice = turned(torn, whole.axes);
    const Runs runs = make_runs(lattice);
    // Whoever held an end may have reached through it; links go both ways, so those are the
    // particles that are reached from it in the whole lattice, and all of them lie in its box.
    std::vector<std::uint8_t> again(whole.slots(), 0);
    for (const auto slot : whole.exceptions.region) again[slot] = 1;
    const Boxes near(lattice, ends, whole.half_width, whole.flat);
    std::vector<std::uint32_t> slots;
    for (std::uint32_t slot = 0; slot < whole.slots(); ++slot) {
        const std::uint32_t r = whole.particle[slot];
        if (r != none && (again[slot] || near.hold(lattice.at[r]))) slots.push_back(slot);
    }
    LatticeRegions regions = whole;
    std::vector<Exception> exceptions(slots.size());
    geometry::parallel_for(slots.size(), 512, [&](std::size_t begin, std::size_t end) {
        Reach reach(runs, whole.half_width);
        for (std::size_t k = begin; k < end; ++k) {
            const std::uint32_t r = whole.particle[slots[k]];
            const auto pieces = reach.from(r, lattice.at[r]);
            exceptions[k] = {slots[k], r, {pieces.begin(), pieces.end()}};
        }
    });
    regions.exceptions = share_sums(lattice, runs, exceptions);
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
