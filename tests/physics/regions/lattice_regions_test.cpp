#include "physics/regions/find_regions.hpp"
#include "physics/regions/region_sums.hpp"
#include "physics/regions/torn_sums.hpp"

#include "geometry/base/random.hpp"
#include "tests/physics/regions/direct_regions.hpp"

#include <gtest/gtest.h>

#include <map>

using namespace physics;
using fixtures::regions_by_search;
using geometry::Random;

namespace {

Lattice linked(std::vector<Vec3i> places, const std::function<bool(std::size_t, int)>& keep_link)
{
    std::map<std::array<int, 3>, std::uint32_t> number;
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        number[{places[i][0], places[i][1], places[i][2]}] = i;
    }
    Lattice lattice;
    lattice.at = std::move(places);
    for (std::size_t i = 0; i < lattice.at.size(); ++i) {
        auto& next = lattice.next.emplace_back();
        for (int d = 0; d < 3; ++d) {
            const Vec3i q = lattice.at[i] + Vec3i::Unit(d);
            const auto found = number.find({q[0], q[1], q[2]});
            next[std::size_t(d)] = found != number.end() && keep_link(i, d) ? found->second : none;
        }
    }
    return lattice;
}

Lattice linked(std::vector<Vec3i> places)
{
    return linked(std::move(places), [](std::size_t, int) { return true; });
}

std::vector<Vec3i> block(int nx, int ny, int nz)
{
    std::vector<Vec3i> places;
    for (int z = 0; z < nz; ++z) {
        for (int y = 0; y < ny; ++y) {
            for (int x = 0; x < nx; ++x) places.emplace_back(x, y, z);
        }
    }
    return places;
}

Lattice joined(const Lattice& a, const Lattice& b)
{
    Lattice both = a;
    for (std::size_t i = 0; i < b.count(); ++i) {
        both.at.push_back(b.at[i]);
        auto next = b.next[i];
        for (auto& j : next) j = j == none ? none : j + std::uint32_t(a.count());
        both.next.push_back(next);
    }
    return both;
}

template <class T> Quad<T> any_quad(const Random& random, std::uint64_t i)
{
    return Quad<double>(random.unit(4 * i) - 0.5, random.unit(4 * i + 1) - 0.5,
                        random.unit(4 * i + 2) - 0.5, random.unit(4 * i + 3))
        .cast<T>();
}

// What sum c of a region weighs a particle by that lies `away` from its middle: 1, a place along
// each axis, and of a plane the product of both.
double weight_of(const LatticeRegions& regions, std::size_t c, const Vec3i& away)
{
    if (c == 0) return 1;
    if (c <= regions.sides()) return away[regions.axes[c - 1]];
    return double(away[regions.axes[0]]) * away[regions.axes[1]];
}

// Both sums against the definition, `direct`, as rounding allows: numbers below 1 are added up in
// the order of the lines, where an error of half an epsilon of the sum is made by each addition.
// Double precision is so held to 1e-14 of the sum of sizes.
template <class T>
void expect_direct_sums(const Lattice& lattice, int w, const LatticeRegions& regions,
                        const std::vector<std::vector<std::uint32_t>>& direct)
{
    SCOPED_TRACE(sizeof(T) == sizeof(float) ? "single precision" : "double precision");
    const double rounding = 45 * double(std::numeric_limits<T>::epsilon());
    const Random random(5);
    RegionSums<T> sums(regions);
    constexpr std::size_t quads = 4;
    std::vector<Quad<T>> kept(quads * regions.slots());
    const auto keep = [&](std::size_t first, std::span<Quad<T>> slots) {
        std::copy(slots.begin(), slots.end(), kept.begin() + std::ptrdiff_t(quads * first));
    };
    const auto fill = [&](std::size_t first, std::span<Quad<T>> slots) {
        std::copy_n(kept.begin() + std::ptrdiff_t(quads * first), slots.size(), slots.begin());
    };
    for (std::size_t round = 0; round < 2; ++round) {  // the second finds used buffers
        for (std::size_t i = 0; i < lattice.count(); ++i) {
            sums.particles[i] = any_quad<T>(random, i);
        }
        collect<T>(regions, sums, keep);
        std::vector<std::size_t> slot(lattice.count(), none);
        for (std::size_t s = 0; s < regions.slots(); ++s) {
            if (regions.particle[s] != none) slot[regions.particle[s]] = s;
        }
        for (std::size_t r = 0; r < lattice.count(); ++r) {
            ASSERT_NE(slot[r], none);
            Quad<double> expected[4] = {Quad<double>::Zero(), Quad<double>::Zero(),
                                        Quad<double>::Zero(), Quad<double>::Zero()};
            for (const auto i : direct[r]) {
                const Quad<double> f = any_quad<T>(random, i).template cast<double>();
                for (std::size_t c = 0; c < quads; ++c) {
                    expected[c] += weight_of(regions, c, lattice.at[i] - lattice.at[r]) * f;
                }
            }
            for (std::size_t c = 0; c < quads; ++c) {
                const Quad<double> got = kept[quads * slot[r] + c].template cast<double>();
                ASSERT_LT((got - expected[c]).abs().maxCoeff(),
                          rounding * double(direct[r].size()) *
                              (c == 0                 ? 1
                               : c <= regions.sides() ? w
                                                      : w * w))
                    << "region " << r << ", sum " << c;
            }
        }

        std::vector<Quad<double>> expected(lattice.count(), Quad<double>::Zero());
        std::vector<std::uint32_t> held_by(lattice.count(), 0);
        for (std::size_t r = 0; r < lattice.count(); ++r) {
            for (std::size_t c = 0; c < quads; ++c) {
                kept[quads * slot[r] + c] = any_quad<T>(random, 7919 * r + c);
            }
            for (const auto i : direct[r]) {
                for (std::size_t c = 0; c < quads; ++c) {
                    expected[i] += weight_of(regions, c, lattice.at[i] - lattice.at[r]) *
                                   any_quad<T>(random, 7919 * r + c).template cast<double>();
                }
                ++held_by[i];
            }
        }
        for (std::size_t s = 0; s < regions.slots(); ++s) {
            if (regions.particle[s] != none) continue;
            for (std::size_t c = 0; c < quads; ++c) {
                ASSERT_TRUE((kept[quads * s + c] == 0).all()) << "slot " << s << " of no particle";
                kept[quads * s + c] = any_quad<T>(random, s);  // what is left there is not spread
            }
        }
        spread<T>(regions, sums, fill);
        for (std::size_t i = 0; i < lattice.count(); ++i) {
            const Quad<double> got = sums.particles[i].template cast<double>();
            ASSERT_LT((got - expected[i]).abs().maxCoeff(),
                      rounding * held_by[i] * (1 + 3 * w + w * w))
                << "particle " << i;
        }
        EXPECT_EQ(count_holders(regions), held_by);
    }

    // There and back at once is both of them, one after the other, to the bit.
    const auto change = [](std::size_t first, std::span<Quad<T>> slots) {
        for (std::size_t k = 0; k < slots.size(); ++k) slots[k] *= T(1 + (quads * first + k) % 7);
    };
    const auto fill_particles = [&] {
        for (std::size_t i = 0; i < lattice.count(); ++i) {
            sums.particles[i] = any_quad<T>(random, i);
        }
    };
    fill_particles();
    collect<T>(regions, sums, keep);
    change(0, kept);
    spread<T>(regions, sums, fill);
    const auto one_by_one = sums.particles;
    fill_particles();
    collect_and_spread<T>(regions, sums, change);
    for (std::size_t i = 0; i < lattice.count(); ++i) {
        ASSERT_TRUE((sums.particles[i] == one_by_one[i]).all()) << "particle " << i;
    }
}

void expect_equal_to_direct_sums(const Lattice& lattice, int w, const std::string& what,
                                 const LatticeRegions& regions)
{
    SCOPED_TRACE(what + ", w = " + std::to_string(w));
    const auto direct = regions_by_search(lattice, w);
    expect_direct_sums<double>(lattice, w, regions, direct);
    expect_direct_sums<float>(lattice, w, regions, direct);
}

void expect_equal_to_direct_sums(const Lattice& lattice, int w, const std::string& what)
{
    expect_equal_to_direct_sums(lattice, w, what, find_regions(lattice, w));
}

void expect_flat_sums(const Lattice& lattice, int w, int axis, const std::string& what)
{
    expect_equal_to_direct_sums(lattice, w, what, find_regions(lattice, w, axis));
}

}  // namespace

TEST(LatticeRegions, SumsEqualDirectOnesOnFullBlocks)
{
    for (const int w : {1, 2, 3, 7}) {
        expect_equal_to_direct_sums(linked(block(9, 6, 5)), w, "block");
        expect_equal_to_direct_sums(linked(block(1, 1, 1)), w, "one particle");
        expect_equal_to_direct_sums(linked(block(12, 1, 1)), w, "line along x");
        expect_equal_to_direct_sums(linked(block(1, 12, 1)), w, "line along y");
        expect_equal_to_direct_sums(linked(block(1, 1, 12)), w, "line along z");
        expect_equal_to_direct_sums(linked(block(7, 1, 8)), w, "plane");
    }
}

TEST(LatticeRegions, AFullBlockHasNoPartialRegions)
{
    // Nothing but the particles' own bars and plates, no partial regions and no dead windows: the
    // cost a particle is the same for any w.
    for (const int w : {1, 3, 16}) {
        const LatticeRegions regions = find_regions(linked(block(12, 11, 10)), w);
        EXPECT_EQ(regions.partial.nodes(), 0u);
        for (const LatticeLines* lines : {&regions.x, &regions.y, &regions.z}) {
            EXPECT_EQ(lines->windows, 12u * 11u * 10u);
            EXPECT_EQ(lines->items.size(), 12u * 11u * 10u);
            EXPECT_TRUE(lines->dead.empty());
        }
    }
}

TEST(LatticeRegions, SumsEqualDirectOnesOnHoledAndBranchingLattices)
{
    std::vector<Vec3i> holed, comb, frame;
    for (const auto& p : block(8, 8, 8)) {
        if ((p - Vec3i(3, 4, 4)).squaredNorm() > 5) holed.push_back(p);
    }
    for (const auto& p : block(11, 9, 3)) {
        if (p[1] < 2 || p[0] % 2 == 0) comb.push_back(p);  // prongs one step apart, not linked
    }
    for (const auto& p : block(9, 9, 9)) {
        int edges = 0;
        for (int d = 0; d < 3; ++d) edges += p[d] == 0 || p[d] == 8;
        if (edges >= 2) frame.push_back(p);
    }
    for (const int w : {1, 2, 3, 5}) {
        expect_equal_to_direct_sums(linked(holed), w, "hollow block");
        expect_equal_to_direct_sums(linked(comb), w, "comb");
        expect_equal_to_direct_sums(linked(frame), w, "wire frame one particle wide");
    }
}

TEST(LatticeRegions, SumsEqualDirectOnesOnRandomLattices)
{
    // Sparse to dense, with a random share of the links cut, and two copies over each other.
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        const Random random(seed);
        const double density = 0.25 + 0.03 * double(seed), cut = seed % 3 == 0 ? 0 : 0.1;
        const auto some = [&](std::uint64_t salt) {
            std::vector<Vec3i> places;
            std::uint64_t i = salt;
            for (const auto& p : block(7, 6, 8)) {
                if (random.unit(i++) < density) places.push_back(p);
            }
            return linked(places, [&](std::size_t k, int d) {
                return random.unit(salt + 9000 + 3 * k + std::uint64_t(d)) >= cut;
            });
        };
        const Lattice one = some(0);
        const Lattice lattice = seed % 4 == 1 ? joined(one, some(50'000)) : one;
        expect_equal_to_direct_sums(lattice, 1 + int(seed % 4), "seed " + std::to_string(seed));
    }
}

TEST(LatticeRegions, SumsEqualDirectOnesOverSeveralSlabs)
{
    // Long enough for several slabs and many visits, with holes and cuts in all of them.
    const Random random(11);
    std::vector<Vec3i> places;
    for (const auto& p : block(40, 30, 5)) {
        if ((p - Vec3i(20, 15, p[2])).squaredNorm() > 9) places.push_back(p);
    }
    const auto cut = [&](std::size_t k, int d) {
        return random.unit(3 * k + std::uint64_t(d)) >= 0.01;
    };
    EXPECT_EQ(find_regions(linked(places), 2).slabs.size(), 5u);
    expect_equal_to_direct_sums(linked(places), 2, "a plate with a hole");
    expect_equal_to_direct_sums(linked(places, cut), 2, "a plate with a hole and cuts");
}

TEST(LatticeRegions, CopiesThatMeetShareRegions)
{
    // Two strands over the same places, joined at one end only: y = 0 is shared, above it each has
    // copies of its own.
    Lattice lattice = linked(block(3, 6, 1));
    const Lattice second = linked(block(3, 6, 1));
    const auto n = std::uint32_t(lattice.count());
    lattice = joined(lattice, second);
    for (std::uint32_t i = 0; i < 3; ++i) {
        // The shared row: the second strand's own is dropped by linking nothing to it.
        lattice.next[n + i] = {none, none, none};
        lattice.next[i][2] = none;
    }
    // The second strand hangs on a row of its own one step below, reached from the first's.
    lattice.at.emplace_back(-1, 0, 0);
    lattice.next.push_back({0, none, none});
    lattice.at.emplace_back(-1, 1, 0);
    lattice.next.push_back({n + 3, none, none});
    lattice.next[2 * n][1] = 2 * n + 1;
    for (const int w : {1, 2, 4}) expect_equal_to_direct_sums(lattice, w, "copies");
}

TEST(LatticeRegions, ALoopOverItselfIsNotTakenForAFullBox)
{
    // A loop that lies over itself at x = 1 and 2: the first particle's box holds as many of the
    // first copies as it reaches, two, but what it reaches is the second.
    Lattice loop;
    loop.at = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {2, 0, 0},
               {2, 0, 0}, {3, 0, 0}, {2, 1, 0}, {3, 1, 0}};
    loop.next.assign(8, {none, none, none});
    loop.next[0][0] = 2, loop.next[2][0] = 4, loop.next[4][1] = 6, loop.next[6][0] = 7;
    loop.next[5][1] = 7, loop.next[3][0] = 5, loop.next[1][0] = 3;
    expect_equal_to_direct_sums(loop, 1, "a loop");
}

TEST(LatticeRegions, UnlinkedProngsDoNotCouple)
{
    // Two parallel lines one step apart: each region holds one line only.
    const auto cut = [](std::size_t, int d) { return d != 1; };
    const Lattice lattice = linked(block(9, 2, 1), cut);
    const LatticeRegions regions = find_regions(lattice, 2);
    for (const auto held : count_holders(regions)) EXPECT_LE(held, 5u);
    expect_equal_to_direct_sums(lattice, 2, "prongs");
}

TEST(LatticeRegions, AnEmptyLatticeHasNone)
{
    const LatticeRegions regions = find_regions({}, 2);
    EXPECT_EQ(regions.slots(), 0u);
    RegionSums<float> sums(regions);
    const auto visit = [](std::size_t, std::span<Quad<float>>) { ADD_FAILURE(); };
    collect_and_spread<float>(regions, sums, visit);
}

TEST(LatticeRegions, RejectBadInput)
{
    EXPECT_THROW(find_regions({}, 0), std::invalid_argument);
    EXPECT_THROW(find_regions({}, 65), std::invalid_argument);
    Lattice lattice = linked(block(3, 1, 1));
    lattice.next[0][0] = 2;
    EXPECT_THROW(find_regions(lattice, 1), std::invalid_argument);
    lattice.next[0][0] = 77;
    EXPECT_THROW(find_regions(lattice, 1), std::invalid_argument);
}

TEST(LatticeRegions, SumsOfPlanesEqualDirectOnes)
{
    for (const int w : {1, 2, 3, 7}) {
        expect_flat_sums(linked(block(9, 7, 1)), w, 2, "across z");
        expect_flat_sums(linked(block(9, 1, 7)), w, 1, "across y");
        expect_flat_sums(linked(block(1, 9, 7)), w, 0, "across x");
        expect_flat_sums(linked(block(12, 1, 1)), w, 1, "a line");
        expect_flat_sums(linked(block(1, 1, 1)), w, 0, "a point");
    }
    EXPECT_THROW(find_regions(linked(block(3, 3, 2)), 1, 2), std::invalid_argument);
}

TEST(LatticeRegions, SumsOfRandomPlanesEqualDirectOnes)
{
    // Several sheets over each other, holed and cut at random.
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        const Random random(seed);
        const double density = 0.3 + 0.03 * double(seed), cut = seed % 3 == 0 ? 0 : 0.1;
        const int axis = int(seed % 3);
        const Vec3i shape = axis == 0   ? Vec3i(2, 12, 9)
                            : axis == 1 ? Vec3i(12, 2, 9)
                                        : Vec3i(12, 9, 2);
        std::vector<Vec3i> places;
        std::uint64_t i = 0;
        for (const auto& p : block(shape[0], shape[1], shape[2])) {
            if (random.unit(i++) < density) places.push_back(p);
        }
        const Lattice lattice = linked(places, [&](std::size_t k, int d) {
            return d != axis && random.unit(9000 + 3 * k + std::uint64_t(d)) >= cut;
        });
        expect_flat_sums(lattice, 1 + int(seed % 4), axis, "seed " + std::to_string(seed));
    }
}

// Loosely linked, so that a break changes reach layers away, and some regions do not hold their
// whole box to begin with; some planes, some with a second sheet over the first.
struct Tearing {
    explicit Tearing(std::uint64_t seed)
        : random(seed), w(1 + int(seed % 3)), axis(int(seed / 3 % 4) - 1)
    {
        const double cut = axis >= 0 ? 0.1 : 0.45;
        const Vec3i shape = axis < 0    ? Vec3i(6, 5, 5)
                            : axis == 0 ? Vec3i(2, 9, 7)
                            : axis == 1 ? Vec3i(9, 2, 7)
                                        : Vec3i(11, 9, 1);
        lattice = linked(block(shape[0], shape[1], shape[2]), [&](std::size_t k, int d) {
            return d != axis && random.unit(9000 + 3 * k + std::uint64_t(d)) >= cut;
        });
        std::vector<std::uint32_t> all;
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            for (std::uint32_t d = 0; d < 3; ++d) {
                if (lattice.next[i][d] != none) all.push_back(3 * i + d);
            }
        }
        for (std::uint64_t k = 0; k < 4 + 5 * seed; ++k) {
            const auto at = std::ptrdiff_t(random.bits(k) % all.size());
            links.push_back(all[std::size_t(at)]);
            all.erase(all.begin() + at);
        }
        whole = find_regions(lattice, w, axis);
    }
    Lattice torn() const
    {
        Lattice out = lattice;
        for (const auto link : links) out.next[link / 3][link % 3] = none;
        return out;
    }

    Random random;
    int w, axis;
    Lattice lattice;
    std::vector<std::uint32_t> links;  // that break, in this order
    LatticeRegions whole;
};

TEST(TornSums, EqualThoseFoundFromScratch)
{
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        const Tearing t(seed);
        TornSums torn(t.lattice, t.whole);
        for (std::size_t k = 0; k < t.links.size();) {  // a few at a time
            const auto some =
                std::min(t.links.size() - k, std::size_t(1 + t.random.bits(700 + k) % 4));
            torn.break_links({t.links.data() + k, some});
            k += some;
        }
        LatticeRegions regions = t.whole;
        regions.partial = torn.partial();
        const std::string name = "torn, seed " + std::to_string(seed);
        expect_equal_to_direct_sums(t.torn(), t.w, name, regions);
        const auto before = count_holders(t.whole), lost = torn.lost();
        const auto after = count_holders(find_regions(t.torn(), t.w, t.axis));
        for (std::size_t i = 0; i < before.size(); ++i) {
            EXPECT_EQ(before[i] - lost[i], after[i]) << name << ", particle " << i;
        }
    }
}

TEST(TornSums, DoNotDependOnTheOrderOfBreaks)
{
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        const Tearing t(seed);
        TornSums at_once(t.lattice, t.whole), one_by_one(t.lattice, t.whole);
        at_once.break_links(t.links);
        for (auto link = t.links.rbegin(); link != t.links.rend(); ++link) {
            one_by_one.break_links({&*link, 1});
        }
        const PartialRegions a = at_once.partial(), b = one_by_one.partial();
        EXPECT_EQ(a.region, b.region);
        EXPECT_EQ(a.at, b.at);
        EXPECT_EQ(a.child_at, b.child_at);
        EXPECT_EQ(a.child, b.child);
        EXPECT_EQ(a.parent_at, b.parent_at);
        EXPECT_EQ(a.parent, b.parent);
        EXPECT_EQ(a.particle, b.particle);
        EXPECT_EQ(a.bar_at, b.bar_at);
        EXPECT_EQ(a.bar, b.bar);
        EXPECT_EQ(at_once.lost(), one_by_one.lost());
    }
}

TEST(TornSums, OnlyBoxesAroundABreakAreUpdated)
{
    const Lattice lattice = linked(block(12, 9, 8));
    const LatticeRegions whole = find_regions(lattice, 2);
    TornSums torn(lattice, whole);
    const std::uint32_t from = 5 + 12 * (4 + 9 * 3);
    torn.break_links(std::vector{3 * from});
    ASSERT_FALSE(torn.changed().empty());
    std::size_t near = 0;
    for (const Vec3i& p : lattice.at) {
        near += (p - Vec3i(5, 4, 3)).cwiseAbs().maxCoeff() <= 2 ||
                (p - Vec3i(6, 4, 3)).cwiseAbs().maxCoeff() <= 2;
    }
    EXPECT_EQ(torn.changed().size(), near);
    EXPECT_EQ(torn.partial().region.size(), near);
}
