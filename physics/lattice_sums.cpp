#include "physics/lattice_regions.hpp"

#include "geometry/parallel.hpp"

namespace physics {

namespace {

// Items a task handles: some 100 us.
constexpr std::size_t entries_a_task = 512;

// Window sums of `channels` numbers along one line, windows and items as in LatticeLines. One of
// the channels gets its moment about the window's place too. load(position) points at an item's
// channels, or is null for none; store(place, sums, moment) takes the answer. `suffix` has room for
// (2w + 1) (channels + 1). moment_of -1: no moments.
template <int channels, int moment_of, class T, class Load, class Store>
inline void slide(int w, int windows, int lead, int items, Quad<T>* suffix, const Load& load,
                  const Store& store)
{
    const int length = 2 * w + 1;
    const Quad<T> zero = Quad<T>::Zero();
    const T reach = T(w);
    for (int first = 0; first < windows; first += length) {
        const int base = first - w;  // the block's first position
        const int stored = std::min(length, windows - first);
        const int low = std::max(0, lead - base), high = std::min(length, lead + items - base);

        // Suffix sums: from position base + j to the block's end, moments about base + j.
        Quad<T> sum[channels], moment = zero;
        for (auto& s : sum) s = zero;
        const auto keep = [&](int j) {
            Quad<T>* const to = suffix + j * (channels + 1);
            for (int c = 0; c < channels; ++c) to[c] = sum[c];
            to[channels] = moment;
        };
        for (int j = stored - 1; j >= std::max(high, 0); --j) keep(j);
        for (int j = high - 1; j >= low; --j) {
            if constexpr (moment_of >= 0) moment += sum[moment_of];
            if (const Quad<T>* const from = load(base + j)) {
                for (int c = 0; c < channels; ++c) sum[c] += from[c];
            }
            if (j < stored) keep(j);
        }
        for (int j = std::min(low, length) - 1; j >= 0; --j) {
            if constexpr (moment_of >= 0) moment += sum[moment_of];
            if (j < stored) keep(j);
        }

        // And prefix sums of the next block up to position first + t + w, moments about that.
        for (auto& s : sum) s = zero;
        moment = zero;
        for (int t = 0; t < stored; ++t) {
            if (t > 0) {
                const int position = base + length + t - 1;
                if constexpr (moment_of >= 0) moment -= sum[moment_of];
                if (position >= lead && position < lead + items) {
                    if (const Quad<T>* const from = load(position)) {
                        for (int c = 0; c < channels; ++c) sum[c] += from[c];
                    }
                }
            }
            const Quad<T>* const rest = suffix + t * (channels + 1);
            Quad<T> total[channels];
            for (int c = 0; c < channels; ++c) total[c] = rest[c] + sum[c];
            if constexpr (moment_of >= 0) {
                const Quad<T> about =
                    rest[channels] + moment + reach * (sum[moment_of] - rest[moment_of]);
                store(first + t, total, about);
            } else {
                store(first + t, total, zero);
            }
        }
    }
}

// The same for narrow windows, item by item: with few items a block its bookkeeping costs more than
// the additions it saves.
template <int w, int channels, int moment_of, class T, class Load, class Store>
inline void slide_item_by_item(int windows, int lead, int items, const Load& load,
                               const Store& store)
{
    constexpr int length = 2 * w + 1;
    Quad<T> nothing[channels];
    for (auto& n : nothing) n.setZero();
    const auto item = [&](int position) -> const Quad<T>* {
        if (position < lead || position >= lead + items) return nothing;
        const Quad<T>* const from = load(position);
        return from ? from : nothing;
    };
    const Quad<T>* near[length];
    for (int d = 1; d < length; ++d) near[d] = item(d - 1 - w);
    for (int place = 0; place < windows; ++place) {
        for (int d = 1; d < length; ++d) near[d - 1] = near[d];
        near[length - 1] = item(place + w);
        Quad<T> total[channels];
        for (int c = 0; c < channels; ++c) {
            total[c] = near[0][c];
            for (int d = 1; d < length; ++d) total[c] += near[d][c];
        }
        Quad<T> about = Quad<T>::Zero();
        if constexpr (moment_of >= 0) {
            for (int d = 1; d <= w; ++d) {
                about += T(d) * (near[w + d][moment_of] - near[w - d][moment_of]);
            }
        }
        store(place, total, about);
    }
}

// Whichever is faster. `suffix` as slide() wants it.
template <int channels, int moment_of, class T, class Load, class Store>
inline void sum_windows(int w, int windows, int lead, int items, Quad<T>* suffix, const Load& load,
                        const Store& store)
{
    if (w == 1) {
        slide_item_by_item<1, channels, moment_of, T>(windows, lead, items, load, store);
    } else if (w == 2) {
        slide_item_by_item<2, channels, moment_of, T>(windows, lead, items, load, store);
    } else {
        slide<channels, moment_of, T>(w, windows, lead, items, suffix, load, store);
    }
}

// From items of `channels` quads to windows of one more, the moment of the first channel.
template <int channels, class T>
void collect_lines(const LatticeLines& along, int w, const Quad<T>* items, Quad<T>* windows)
{
    geometry::parallel_for(
        along.lines.size(), entries_a_task / 8, [&](std::size_t begin, std::size_t end) {
            std::vector<Quad<T>> suffix(std::size_t((2 * w + 1) * (channels + 1)));
            for (std::size_t l = begin; l < end; ++l) {
                const auto& line = along.lines[l];
                const std::uint32_t* const index = along.items.data() + line.item;
                Quad<T>* const out = windows + std::size_t(line.window) * (channels + 1);
                sum_windows<channels, 0, T>(
                    w, int(line.windows), line.lead, int(line.items), suffix.data(),
                    [&](int position) -> const Quad<T>* {
                        const std::uint32_t i = index[position - line.lead];
                        return i == none ? nullptr : items + std::size_t(i) * channels;
                    },
                    [&](int place, const Quad<T>* total, const Quad<T>& moment) {
                        Quad<T>* const to = out + place * (channels + 1);
                        for (int c = 0; c < channels; ++c) to[c] = total[c];
                        to[channels] = moment;
                    });
            }
        });
}

// The transpose: windows of channels + 1 quads are spread over items of `channels`.
template <int channels, class T>
void spread_lines(const LatticeLines& along, int w, Quad<T>* windows, Quad<T>* items)
{
    for (const std::uint32_t d : along.dead) {
        for (int c = 0; c <= channels; ++c)
            windows[std::size_t(d) * (channels + 1) + std::size_t(c)].setZero();
    }
    geometry::parallel_for(
        along.lines.size(), entries_a_task / 8, [&](std::size_t begin, std::size_t end) {
            std::vector<Quad<T>> suffix(std::size_t((2 * w + 1) * (channels + 2)));
            for (std::size_t l = begin; l < end; ++l) {
                const auto& line = along.lines[l];
                const std::uint32_t* const index = along.items.data() + line.item;
                const Quad<T>* const in = windows + std::size_t(line.window) * (channels + 1);
                // Seen from the items, place 0 is the first item.
                sum_windows<channels + 1, channels, T>(
                    w, int(line.items), -line.lead, int(line.windows), suffix.data(),
                    [&](int position) { return in + (position + line.lead) * (channels + 1); },
                    [&](int place, const Quad<T>* total, const Quad<T>& moment) {
                        const std::uint32_t i = index[place];
                        if (i == none) return;
                        Quad<T>* const to = items + std::size_t(i) * channels;
                        to[0] = total[0] - moment;
                        for (int c = 1; c < channels; ++c) to[c] = total[c];
                    });
            }
        });
}

template <class T> Quad<T> shifted(const Vec3i& by, const Quad<T>* quads)
{
    return T(by[0]) * quads[0] + T(by[1]) * quads[1] + T(by[2]) * quads[2];
}

}  // namespace

template <class T> RegionSums<T>::RegionSums(const LatticeRegions& regions)
{
    const std::size_t slots = regions.slots(), bars = regions.x.windows, plates = regions.y.windows;
    // Touched first by all threads: at a million particles finding room takes as long as a step.
    const auto make_room = [](std::vector<Quad<T>>& in, std::size_t n) {
        in.resize(n);  // leaves quads as they are
        geometry::parallel_for(n, 16 * entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) in[i].setZero();
        });
    };
    make_room(a, std::max(regions.flat ? 0 : 4 * slots, 2 * bars));
    make_room(b, std::max(3 * plates, regions.particles));
    make_room(exceptional, 4 * regions.exceptions.nodes());
}

template <class T> std::span<Quad<T>> RegionSums<T>::particles(const LatticeRegions& regions)
{
    return {b.data(), regions.particles};
}

template <class T> std::span<Quad<T>> RegionSums<T>::slots(const LatticeRegions& regions)
{
    return {regions.flat ? b.data() : a.data(), regions.quads() * regions.slots()};
}

template <class T> void collect(const LatticeRegions& regions, RegionSums<T>& sums)
{
    const LatticeExceptions& e = regions.exceptions;
    const int w = regions.half_width;
    const std::size_t first_plate = e.bars, first_region = e.bars + e.plates;
    const auto nodes = sums.exceptional.data();
    // A node's value about its own place: S and three moments.
    geometry::parallel_for(e.bars, entries_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            Quad<T> total[4] = {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero()};
            for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
                const Quad<T>& f = sums.b[e.child[k]];
                total[0] += f;
                total[1] += T(k - e.child_at[n]) * f;  // a bar is unbroken, and about its first
            }
            for (std::size_t c = 0; c < 4; ++c) nodes[4 * n + c] = total[c];
        }
    });
    for (const auto& [low, high] :
         {std::pair(first_plate, first_region), std::pair(first_region, e.nodes())}) {
        geometry::parallel_for(
            high - low, entries_a_task, [&, low = low](std::size_t begin, std::size_t end) {
                for (std::size_t n = low + begin; n < low + end; ++n) {
                    Quad<T> total[4] = {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(),
                                        Quad<T>::Zero()};
                    for (std::uint32_t k = e.child_at[n]; k < e.child_at[n + 1]; ++k) {
                        const std::size_t child = e.child[k];
                        const Vec3i by = e.at[child] - e.at[n];
                        const Quad<T>* const from = nodes + 4 * child;
                        total[0] += from[0];
                        for (int d = 0; d < 3; ++d)
                            total[1 + d] += from[1 + d] + T(by[d]) * from[0];
                    }
                    for (std::size_t c = 0; c < 4; ++c) nodes[4 * n + c] = total[c];
                }
            });
    }

    collect_lines<1>(regions.x, w, sums.b.data(), sums.a.data());
    collect_lines<2>(regions.y, w, sums.a.data(), sums.b.data());
    if (!regions.flat) collect_lines<3>(regions.z, w, sums.b.data(), sums.a.data());
    const auto slots = sums.slots(regions);
    const std::size_t quads = regions.quads();
    for (const std::uint32_t d : regions.flat ? regions.y.dead : regions.z.dead) {
        for (std::size_t c = 0; c < quads; ++c) slots[quads * d + c].setZero();
    }
    for (std::size_t i = 0; i < e.region.size(); ++i) {
        for (std::size_t c = 0; c < quads; ++c) {
            slots[quads * e.region[i] + c] = nodes[4 * (first_region + i) + c];
        }
    }
}

template <class T> void spread(const LatticeRegions& regions, RegionSums<T>& sums)
{
    const LatticeExceptions& e = regions.exceptions;
    const int w = regions.half_width;
    const std::size_t first_plate = e.bars, first_region = e.bars + e.plates;
    const auto nodes = sums.exceptional.data();
    const auto slots = sums.slots(regions);
    const std::size_t quads = regions.quads();
    for (std::size_t i = 0; i < e.region.size(); ++i) {
        for (std::size_t c = 0; c < quads; ++c) {
            Quad<T>& slot = slots[quads * e.region[i] + c];
            nodes[4 * (first_region + i) + c] = slot;
            slot.setZero();
        }
    }
    if (!regions.flat) spread_lines<3>(regions.z, w, sums.a.data(), sums.b.data());
    spread_lines<2>(regions.y, w, sums.b.data(), sums.a.data());
    spread_lines<1>(regions.x, w, sums.a.data(), sums.b.data());

    // From plates' regions down: an affine map a node, about its own place.
    for (const auto& [low, high] :
         {std::pair(first_plate, first_region), std::pair(std::size_t{0}, first_plate)}) {
        geometry::parallel_for(
            high - low, entries_a_task, [&, low = low](std::size_t begin, std::size_t end) {
                for (std::size_t n = low + begin; n < low + end; ++n) {
                    Quad<T> total[4] = {Quad<T>::Zero(), Quad<T>::Zero(), Quad<T>::Zero(),
                                        Quad<T>::Zero()};
                    for (std::uint32_t k = e.parent_at[n]; k < e.parent_at[n + 1]; ++k) {
                        const std::size_t parent = e.parent[k];
                        const Quad<T>* const from = nodes + 4 * parent;
                        total[0] += from[0] + shifted<T>(e.at[n] - e.at[parent], from + 1);
                        for (std::size_t c = 1; c < 4; ++c) total[c] += from[c];
                    }
                    for (std::size_t c = 0; c < 4; ++c) nodes[4 * n + c] = total[c];
                }
            });
    }
    geometry::parallel_for(
        e.particle.size(), entries_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                Quad<T> total = Quad<T>::Zero();
                for (std::uint32_t k = e.bar_at[i]; k < e.bar_at[i + 1]; ++k) {
                    const std::size_t bar = e.bar[k] >> 8, along = e.bar[k] & 255u;
                    total += nodes[4 * bar] + T(along) * nodes[4 * bar + 1];
                }
                sums.b[e.particle[i]] += total;
            }
        });
}

template struct RegionSums<float>;
template struct RegionSums<double>;
template void collect(const LatticeRegions&, RegionSums<float>&);
template void collect(const LatticeRegions&, RegionSums<double>&);
template void spread(const LatticeRegions&, RegionSums<float>&);
template void spread(const LatticeRegions&, RegionSums<double>&);

}  // namespace physics
