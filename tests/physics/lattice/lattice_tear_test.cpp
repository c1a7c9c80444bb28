// Links that break, and the regions around them.

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/lattice/torn_regions.hpp"
#include "physics/regions/find_regions.hpp"
#include "tests/physics/lattice/lattice_fixtures.hpp"

#include <gtest/gtest.h>

using namespace physics;
using fixtures::box;
using fixtures::drive;
using fixtures::whole_sheet;
using geometry::Cubes;
using geometry::Random;
using geometry::Vec3i;

TEST(LatticeTear, ASheetPulledApartTearsAndItsPartsMoveIndependently)
{
    // The middle row of links is pulled to three times its length and gives way; then each half
    // moves as if the other were not there.
    const Cubes cubes = whole_sheet(9, 4);
    LatticeOptions options{.half_width = 2, .damping = 0.01, .tear = 0.6, .substeps = 12};
    const LatticeBody body = make_lattice(cubes, options);
    State state =
        drive(body, cubes, rest_state(body), 72, options,
              [](const Vec3& x, double share) { return Vec3(x[0] * (1 + 2 * share), x[1], x[2]); });
    ASSERT_FALSE(state.broken.empty());
    EXPECT_TRUE(std::is_sorted(state.broken.begin(), state.broken.end()));
    EXPECT_EQ(std::adjacent_find(state.broken.begin(), state.broken.end()), state.broken.end())
        << "a link breaks once";
    // The halves come back to their shape: every link that is left is as long as it was.
    options.damping = 0.05;
    for (int f = 0; f < 120; ++f) state = advance(body, std::move(state), {}, 1.0 / 24, options);
    const Lattice lattice = corner_lattice(cubes);
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        for (std::uint32_t d = 0; d < 3; ++d) {
            const auto j = lattice.next[i][d];
            if (j == none) continue;
            if (std::binary_search(state.broken.begin(), state.broken.end(), 3 * i + d)) continue;
            EXPECT_NEAR((state.x[i] - state.x[j]).norm(), 0.1, 2e-3);
        }
    }
    double low = 1e9, high = -1e9;
    for (const Vec3& x : state.x) low = std::min(low, x[0]), high = std::max(high, x[0]);
    EXPECT_GT(high - low, 1.5);  // 2.7 m apart less what snapped back
}

TEST(LatticeTear, LinksTearAlongAnyAxis)
{
    const Cubes cubes = box(2, 3, 2, 0.1);
    const LatticeOptions options{.half_width = 1, .tear = 0.5, .substeps = 1};
    const LatticeBody body = make_lattice(cubes, options);
    const Lattice lattice = corner_lattice(cubes);
    for (std::uint32_t d = 0; d < 3; ++d) {
        State state = rest_state(body);
        for (Vec3& x : state.x) x[Eigen::Index(d)] *= 2;
        std::vector<std::uint32_t> along;
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            if (lattice.next[i][d] != none) along.push_back(3 * i + d);
        }
        EXPECT_EQ(advance(body, state, {}, 1e-6, options).broken, along);
    }
}

TEST(LatticeTear, AStoredStateContinuesIdentically)
{
    // The torn regions are a function of the broken links alone: a body made anew, as after a
    // restart, continues to the same bytes.
    const Cubes cubes = whole_sheet(9, 4);
    const LatticeOptions options{.half_width = 1, .damping = 0.01, .tear = 0.4, .substeps = 6};
    const auto pulled = [](const Vec3& x, double share) {
        return Vec3(x[0] * (1 + 2 * share), x[1], x[2]);
    };
    const LatticeBody one = make_lattice(cubes, options), other = make_lattice(cubes, options);
    const State half = drive(one, cubes, rest_state(one), 48, options, pulled);
    ASSERT_FALSE(half.broken.empty());
    const State a = advance(one, half, {}, 1.0 / 24, options);
    const State b = advance(other, half, {}, 1.0 / 24, options);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.broken, b.broken);
}

TEST(LatticeTear, RegionsChangeInTheStepThatBreaksALink)
{
    // Two steps of one frame are two frames of one step, though a link breaks in the first: a kick
    // takes a corner away from its neighbours.
    const Cubes cubes = box(4, 3, 3, 0.1);
    LatticeOptions options{
        .half_width = 1, .tear = 0.2, .substeps = 2, .precision = Precision::full};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    state.v[0] = Vec3(-80, 0, 0);
    const State both = advance(body, state, {}, 0.002, options);
    options.substeps = 1;
    const State first = advance(body, state, {}, 0.001, options);
    ASSERT_FALSE(first.broken.empty());
    const State second = advance(body, first, {}, 0.001, options);
    EXPECT_EQ(both.broken, second.broken);
    for (std::size_t i = 0; i < both.x.size(); ++i) {
        EXPECT_LT((both.x[i] - second.x[i]).norm(), 1e-12);  // measured from other middles
    }
}

TEST(LatticeTear, OneBodyStepsStatesTornInDifferentPlaces)
{
    // As many broken links, but others: a body that has just stepped the one steps the other as a
    // body made for it does.
    const Cubes cubes = box(4, 3, 3, 0.1);
    const LatticeOptions options{.half_width = 1, .tear = 5, .substeps = 1};
    const LatticeBody shared = make_lattice(cubes, options), own = make_lattice(cubes, options);
    State state = rest_state(shared);
    for (std::size_t i = 0; i < state.x.size(); ++i) state.x[i][0] *= 1 + 0.1 * double(i % 3);
    State one = state, other = state;
    one.broken = {0, 1, 2};
    const std::uint32_t far = 3 * 21;
    other.broken = {far, far + 1, far + 2};
    const State a = advance(shared, one, {}, 0.01, options);
    const State b = advance(shared, other, {}, 0.01, options);
    EXPECT_EQ(b.x, advance(own, other, {}, 0.01, options).x);
    EXPECT_NE(a.x, b.x);
}

TEST(LatticeTear, PiecesStayAboveTheGroundAndGainNoEnergy)
{
    // Thrown down so that it shatters, with its own outside as its skin and with a ball inside it.
    const Cubes cubes = box(6, 6, 6, 0.1);
    auto ball = geometry::icosphere(0.26, 2);
    for (auto& p : ball.positions) p += geometry::Vec3f(0.3f, 0.3f, 0.3f);
    for (const geometry::TriMesh* surface : {static_cast<geometry::TriMesh*>(nullptr), &ball}) {
        const LatticeOptions options{.half_width = 1, .tear = 0.15, .substeps = 8};
        const LatticeBody body = make_lattice(cubes, options, surface);
        State state = rest_state(body);
        for (Vec3& x : state.x) x[1] += 0.05;
        state.v.assign(state.x.size(), Vec3(0.5, -6, 0));
        Loads loads;
        loads.forces.push_back({});
        loads.colliders.push_back({});
        const auto energy = [&] {
            double sum = 0;
            for (std::size_t k = 0; k < state.x.size(); ++k) {
                sum += body.base.mass[k] * (state.v[k].squaredNorm() / 2 + 9.81 * state.x[k][1]);
            }
            return sum;
        };
        const double before = energy();
        for (int f = 0; f < 36; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
            EXPECT_LT(energy(), before) << f << (surface ? " ball" : "");
            // The corners of the block are 0.26 m from the ball.
            const double low = surface ? -0.3 : -0.15;
            for (const Vec3& x : state.x) ASSERT_GT(x[1], low) << f;
        }
        EXPECT_GT(state.broken.size(), 100u);
    }
}

TEST(LatticeTear, ABodyTornAtRandomRestsUnderAnyRigidMotion)
{
    // Regions that are left with a line of particles, or with one, see no twist, no stretch across
    // and nothing to flow.
    const Mat3 about_y = Eigen::AngleAxisd(2, Vec3(0, 1, 0)).toRotationMatrix();
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    for (int kind = 0; kind < 6; ++kind) {
        const bool solid = kind % 3 == 0, in_plane = kind % 3 == 2, plastic = kind >= 3;
        for (const Precision precision : {Precision::full, Precision::single}) {
            for (const int w : {1, 2, 3}) {
                LatticeOptions options{.half_width = w,
                                       .stiffness = Stiffness::rate,
                                       .rate = 1e4,
                                       .bend = 0.3,
                                       .tear = 5,
                                       .substeps = 1,
                                       .precision = precision};
                if (in_plane) options.plane = PlaneMotion::in_plane;
                if (plastic) options.plastic = {.yield = 0.01, .flow = 100};
                const LatticeBody body =
                    make_lattice(solid ? box(4, 3, 5, 0.1) : whole_sheet(7, 5), options);
                const Random random(std::uint64_t(10 * kind + w));
                State state = rest_state(body);
                for (Vec3& x : state.x) x = (in_plane ? about_y : turn) * x + Vec3(0.2, 0, 0.3);
                for (std::uint32_t link = 0; link < 3 * state.x.size(); ++link) {
                    if (random.unit(link) < 0.5) state.broken.push_back(link);
                }
                const State after = advance(body, state, {}, 0.01, options);
                const double tolerance = precision == Precision::full ? 1e-7 : 1e-6;
                double worst = 0, flowed = 0;
                for (std::size_t i = 0; i < state.x.size(); ++i) {
                    worst = std::max(worst, (after.x[i] - state.x[i]).norm());
                }
                for (const float p : after.plastic) flowed = std::max(flowed, std::abs(double(p)));
                EXPECT_LT(worst, tolerance) << kind << " " << w;
                EXPECT_EQ(flowed, 0) << kind << " " << w;
            }
        }
    }
}

TEST(LatticeTear, RegionsAwayFromABreakDoNotChange)
{
    for (const bool flat : {false, true}) {
        const LatticeOptions options{.half_width = 1, .tear = 0.5};
        const Cubes cubes = flat ? whole_sheet(8, 3) : box(8, 2, 2, 0.1);
        const LatticeBody body = make_lattice(cubes, options);
        const std::uint32_t link = 0;  // of the first particle, along x
        const auto torn = body.torn->find(body.whole, {link});
        std::size_t alike = 0;
        for (std::size_t s = 0; s < body.whole.rate_sq.size(); ++s) {
            const auto r = body.whole.regions.particle[s];
            if (r == none || cubes.corner[r][0] < 3) continue;
            ASSERT_EQ(torn->regions.particle[s], r);
            EXPECT_EQ(torn->rate_sq[s], body.whole.rate_sq[s]);
            if (flat) {
                EXPECT_EQ(torn->bend_sq[s], body.whole.bend_sq[s]);
            }
            ++alike;
        }
        EXPECT_GT(alike, 10u);
        // The last few are kept.
        EXPECT_NE(body.torn->find(body.whole, {3}), torn);
        EXPECT_EQ(body.torn->find(body.whole, {link}), torn);
        const auto third = body.torn->find(body.whole, {6});
        EXPECT_EQ(body.torn->find(body.whole, {6}), third);
        EXPECT_EQ(body.torn->find(body.whole, {link}), torn);
    }
}

TEST(LatticeTear, RegionsDependOnTheBrokenLinksAlone)
{
    // Whether links break a few at a time or all at once, and as a search of the torn lattice
    // finds.
    const double h = 0.1;
    struct Case {
        geometry::Cubes cubes;
        bool flat, slit;
    };
    // Small, and torn at random until all regions have changed; and large, with a slit that grows.
    const Case cases[] = {{box(7, 4, 3, h), false, false},
                          {whole_sheet(9, 6), true, false},
                          {box(19, 8, 7, h), false, true},
                          {whole_sheet(40, 30), true, true}};
    for (const auto& [cubes, flat, slit] : cases) {
        const Lattice lattice = corner_lattice(cubes);
        const auto n = std::uint32_t(lattice.count());
        const Random random(20 + flat);
        std::vector<RegionMatter> matter;
        for (std::uint64_t i = 0; i < n; ++i) {
            const double third = random.unit(3 * i + 2);  // of a plane thickness, of a solid nu
            matter.push_back({1 + random.unit(3 * i), 1 + random.unit(3 * i + 1),
                              flat ? 1e-3 * (1 + third) : 0.4 * third, flat ? 0.0 : third});
        }
        const auto matched = [&, depth = flat ? 1 : -1](const Lattice& of) {
            MatchedRegions out = match_regions(find_regions(of, 2, depth), of, matter, h, true);
            if (depth < 0) add_volume(out, of, matter, h);
            return out;
        };
        const MatchedRegions whole = matched(lattice);
        TornRegions bit_by_bit(lattice, matter, h, true), at_once(lattice, matter, h, true);
        std::vector<std::uint32_t> across;
        for (std::uint32_t i = 0; i < n; ++i) {
            if (lattice.at[i][0] == lattice.at[0][0] + 9) across.push_back(3 * i);
        }
        std::vector<std::uint32_t> broken;
        TornRegions::Found found;
        for (std::uint64_t some = 0; some < 5; ++some) {
            for (std::uint64_t k = 12 * some; k < 12 * some + 12; ++k) {
                if (!slit) broken.push_back(std::uint32_t(random.bits(1000 + k) % (3 * n)));
                if (slit && k / 2 < across.size()) broken.push_back(across[k / 2]);
            }
            std::sort(broken.begin(), broken.end());
            broken.erase(std::unique(broken.begin(), broken.end()), broken.end());
            found = bit_by_bit.find(whole, broken);
        }
        const auto same = at_once.find(whole, broken);
        EXPECT_EQ(found->mass, same->mass);
        EXPECT_EQ(found->held_by, same->held_by);
        EXPECT_EQ(found->rate_sq, same->rate_sq);
        EXPECT_EQ(found->bend_sq, same->bend_sq);
        EXPECT_EQ(found->inverse_spread, same->inverse_spread);
        EXPECT_EQ(found->poisson, same->poisson);
        EXPECT_EQ(found->volume_gain, same->volume_gain);
        ASSERT_EQ(found->volume.size(), flat ? 0 : found->regions.slots());
        EXPECT_EQ(found->regions.partial.child, same->regions.partial.child);
        ASSERT_EQ(found->twist.size(), same->twist.size());
        for (std::size_t k = 0; k < found->twist.size(); ++k) {
            EXPECT_EQ(found->twist[k].b, same->twist[k].b);
            EXPECT_EQ(found->twist[k].loose, same->twist[k].loose);
        }

        Lattice torn = lattice;
        for (const auto link : broken) torn.next[link / 3][link % 3] = none;
        const MatchedRegions anew = matched(torn);
        EXPECT_EQ(found->mass, anew.mass);
        EXPECT_EQ(found->held_by, anew.held_by);
        std::vector<std::size_t> slot(n);
        for (std::size_t s = 0; s < anew.regions.slots(); ++s) {
            if (anew.regions.particle[s] != none) slot[anew.regions.particle[s]] = s;
        }
        for (std::size_t s = 0; s < found->regions.slots(); ++s) {
            if (found->regions.particle[s] == none) continue;
            const std::size_t other = slot[found->regions.particle[s]];
            EXPECT_NEAR(found->rate_sq[s] / anew.rate_sq[other], 1, 1e-6);
            if (!flat) {
                EXPECT_NEAR(found->poisson[s], anew.poisson[other], 1e-6);
                EXPECT_NEAR(found->volume_gain[s], anew.volume_gain[other], 1e-6);
                const auto &own = found->volume[s], &fresh = anew.volume[other];
                EXPECT_NEAR(own.scale, fresh.scale, 1e-5 * double(fresh.scale));
                for (std::size_t c = 0; c < 6; ++c) {
                    EXPECT_EQ(own.root[c], same->volume[s].root[c]);
                    EXPECT_NEAR(own.root[c], fresh.root[c], 1e-5);
                }
            }
            if (flat) {
                EXPECT_NEAR(found->bend_sq[s] / anew.bend_sq[other], 1, 1e-6);
                EXPECT_NEAR(found->twist[s].loose, anew.twist[other].loose,
                            1e-4 * std::abs(anew.twist[other].loose));
            }
            for (std::size_t k = 0; k < 6; ++k) {
                EXPECT_NEAR(found->inverse_spread[6 * s + k], anew.inverse_spread[6 * other + k],
                            1e-5);
            }
        }
    }
}
