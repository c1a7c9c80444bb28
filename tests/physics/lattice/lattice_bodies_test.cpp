// Several bodies in one lattice, and rigid balls.

#include "geometry/base/random.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/lattice/near_pairs.hpp"
#include "tests/physics/lattice/lattice_fixtures.hpp"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <set>

using namespace physics;
using fixtures::box;
using fixtures::whole_sheet;
using geometry::Cubes;
using geometry::Vec3i;

namespace {

// The same cubes once more, `by` cells away and not linked to the first.
Cubes with_copy(const Cubes& one, const Vec3i& by)
{
    Cubes both = one;
    for (std::size_t c = 0; c < one.count(); ++c) {
        both.cell.push_back(one.cell[c] + by);
        auto corners = one.corners[c];
        for (auto& k : corners) k += std::uint32_t(one.corner_count());
        both.corners.push_back(corners);
        both.mass.push_back(one.mass[c]);
        both.fill.push_back(one.fill[c]);
        both.young.push_back(one.young[c]);
        both.poisson.push_back(one.poisson[c]);
        both.mass_damping.push_back(one.mass_damping[c]);
        both.stiffness_damping.push_back(one.stiffness_damping[c]);
        both.matter.push_back(one.matter[c]);
    }
    for (const Vec3i& at : one.corner) both.corner.push_back(at + by);
    return both;
}

// Two arms of n cubes along x, three apart, joined at x = 0; two wide.
std::vector<Vec3i> horseshoe(int n)
{
    std::vector<Vec3i> cells;
    for (int z = 0; z < 2; ++z) {
        for (int x = 0; x < n; ++x) {
            cells.emplace_back(x, 0, z);
            cells.emplace_back(x, 4, z);
        }
        for (int y = 1; y < 4; ++y) cells.emplace_back(0, y, z);
    }
    return cells;
}

// Links from one particle to each other.
std::vector<int> links_from(const Lattice& lattice, std::uint32_t start)
{
    std::vector<int> links(lattice.count(), 1 << 20);
    links[start] = 0;
    for (std::uint32_t round = 0; round < lattice.count(); ++round) {
        for (std::uint32_t i = 0; i < lattice.count(); ++i) {
            for (const auto j : lattice.next[i]) {
                if (j == none) continue;
                links[i] = std::min(links[i], links[j] + 1);
                links[j] = std::min(links[j], links[i] + 1);
            }
        }
    }
    return links;
}

}  // namespace

TEST(LatticeBodies, KnowWhichOfTheirParticlesAreNearAlongThem)
{
    const Lattice lattice = corner_lattice(fixtures::cubes_on(horseshoe(5), 0.1));
    std::vector<std::uint32_t> side;
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        if (i % 11 != 0) side.push_back(i);
    }
    std::vector<std::vector<int>> links;
    for (std::uint32_t i = 0; i < lattice.count(); ++i) links.push_back(links_from(lattice, i));
    for (const double distance : {0.0, 3.1}) {  // the arms are three apart
        const auto rest_near = [&](std::uint32_t a, std::uint32_t b) {
            return (lattice.at[a] - lattice.at[b]).cast<double>().norm() < distance;
        };
        const NearAlong near(lattice, side, 5, distance);
        int count = 0;
        for (const auto a : side) {
            for (const auto b : side) {
                if (a == b) continue;
                bool expected = links[a][b] <= 5 || rest_near(a, b);
                for (const auto k : side) {  // a neighbour of one that rests near the other
                    expected |= links[a][k] == 1 && k != b && rest_near(k, b);
                    expected |= k != a && rest_near(a, k) && links[k][b] == 1;
                }
                EXPECT_EQ(near.has(a, b), expected) << a << ' ' << b;
                count += near.has(a, b);
            }
        }
        EXPECT_GT(count, 100);
    }
}

TEST(LatticeBodies, FindThePairsOfTheirOwnThatASearchOfAllFinds)
{
    const Lattice lattice = corner_lattice(fixtures::cubes_on(horseshoe(8), 0.1));
    const geometry::Random random(3);
    std::vector<std::uint32_t> side;
    std::vector<BodyPoint> points;  // crushed
    for (std::uint32_t i = 0; i < lattice.count(); ++i) {
        side.push_back(i);
        const Vec3 moved(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2));
        points.push_back(
            {0.03 * lattice.at[i].cast<double>() + 0.05 * moved, i, i % 2, i % 7 == 0});
    }
    const NearAlong along(lattice, side, 5, 0);
    std::set<std::pair<std::uint32_t, std::uint32_t>> expected, found;
    int own = 0;
    for (const BodyPoint& a : points) {
        for (const BodyPoint& b : points) {
            if (a.particle >= b.particle || (a.pinned && b.pinned)) continue;
            if (!((a.at - b.at).norm() < 0.08)) continue;
            if (a.body == b.body && along.has(a.particle, b.particle)) continue;
            expected.insert({a.particle, b.particle});
            own += a.body == b.body;
        }
    }
    const NearPairs pairs = find_near_pairs(
        points, 0.08, [&](std::uint32_t a, std::uint32_t b) { return along.has(a, b); });
    for (const auto& [a, b] : pairs.pair) EXPECT_TRUE(found.insert(std::minmax(a, b)).second);
    EXPECT_EQ(found, expected);
    EXPECT_GT(own, 15);
}

// The upper arm sags by many times the gap, were it not for the lower one.
TEST(LatticeBodies, LieOnThemselvesWhereTheyFold)
{
    const double h = 0.1;
    const Cubes cubes = fixtures::cubes_on(
        horseshoe(12), h,
        {.young = 3e5, .poisson = 0, .mass_damping = 2, .stiffness_damping = 0.01});
    Loads loads;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k][1] > 1) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    loads.forces.push_back({});
    const auto lowest_of_the_upper = [&](bool self, double& fastest) {
        LatticeOptions options{.half_width = 1, .substeps = 12};
        options.contact.on = true;
        options.contact.self = self;
        const LatticeBody body = make_lattice(cubes, options);
        State state = rest_state(body);
        for (int f = 0; f < 96; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
        }
        double lowest = 1, speed = 0;
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k][1] >= 4) lowest = std::min(lowest, state.x[k].y());
            speed = std::max(speed, state.v[k].norm());
        }
        fastest = speed;
        return lowest;
    };
    double fastest = 0;
    EXPECT_LT(lowest_of_the_upper(false, fastest), -h);
    // Its lower corners are a cube from the upper ones of the lower arm, which are at h; where they
    // come to lie between those, a little less above.
    const double lowest = lowest_of_the_upper(true, fastest);
    EXPECT_GT(lowest, 1.8 * h);
    EXPECT_LT(lowest, 2.2 * h);
    EXPECT_LT(fastest, 0.02);
}

TEST(LatticeBodies, KeepTheirMomentaWhereTheyHitThemselves)
{
    const Cubes cubes = fixtures::cubes_on(horseshoe(8), 0.1, {.young = 1e6, .poisson = 0});
    LatticeOptions options{.half_width = 1, .substeps = 8, .precision = Precision::full};
    options.contact = {.on = true, .self = true, .friction = 0};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        state.v[k] = Vec3(0.3, cubes.corner[k][1] >= 4 ? -4 : 2, 0.1 * cubes.corner[k][0]);
    }
    const auto momenta = [&] {
        std::pair<Vec3, Vec3> sum(Vec3::Zero(), Vec3::Zero());
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            sum.first += body.base.mass[k] * state.v[k];
            sum.second += body.base.mass[k] * state.x[k].cross(state.v[k]);
        }
        return sum;
    };
    const auto before = momenta();
    double nearest = 1;
    for (int f = 0; f < 12; ++f) {
        state = advance(body, std::move(state), {}, 1.0 / 24, options);
        for (std::uint32_t a = 0; a < cubes.corner_count(); ++a) {
            for (std::uint32_t b = 0; b < cubes.corner_count(); ++b) {
                if (cubes.corner[a][1] == 1 && cubes.corner[b][1] == 4) {
                    nearest = std::min(nearest, (state.x[a] - state.x[b]).norm());
                }
            }
        }
    }
    EXPECT_LT(nearest, 0.105) << "they meet";
    EXPECT_GT(nearest, 0.09);
    EXPECT_LT((momenta().first - before.first).norm(), 1e-9 * before.first.norm());
    // Pushes act along the line between where two come to be, not where they are: 7e-4.
    EXPECT_LT((momenta().second - before.second).norm(), 2e-3 * before.second.norm());
}

TEST(LatticeBodies, SeveralAreEachAsStiffAsAlone)
{
    // A slender beam bends too stiffly by far more than a block does: side by side, not linked,
    // each is softened by its own excess.
    const LatticeOptions options{.half_width = 2};
    std::vector<Vec3i> beam, block, both;
    for (int x = 0; x < 12; ++x) beam.emplace_back(x, 0, 0);
    for (int k = 0; k < 27; ++k) block.emplace_back(k % 3, 5 + k / 3 % 3, k / 9);
    both = beam;
    both.insert(both.end(), block.begin(), block.end());
    const auto rates = [&](const std::vector<Vec3i>& cells) {
        const Cubes cubes = fixtures::cubes_on(cells, 0.1);
        const LatticeBody body = make_lattice(cubes, options);
        std::map<std::array<int, 3>, float> out;
        for (std::size_t s = 0; s < body.whole.rate_sq.size(); ++s) {
            const auto r = body.whole.regions.particle[s];
            if (r == none) continue;
            const Vec3i& at = cubes.corner[r];
            out[{at[0], at[1], at[2]}] = body.whole.rate_sq[s];
        }
        return out;
    };
    auto alone = rates(beam);
    alone.merge(rates(block));
    const auto together = rates(both);
    ASSERT_EQ(together.size(), alone.size());
    // The bend that tells is so slight that some 1e-5 of it is rounding.
    for (const auto& [at, rate] : together) EXPECT_NEAR(rate / alone[at], 1, 1e-3);
}

TEST(LatticeBodies, CollideAndDoNotPassThroughEachOther)
{
    // One block falls on another that lies on the ground, half over its edge of contact distance.
    const Cubes one = fixtures::box(3, 3, 3, 0.1, {1000, 1e5, 0.3});
    const auto n = std::uint32_t(one.corner_count());
    const Cubes cubes = with_copy(one, Vec3i(0, 8, 0));
    LatticeOptions options{.half_width = 2, .damping = 0.01, .substeps = 8};
    options.contact.on = true;
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State state = rest_state(body);
    for (int f = 0; f < 72; ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
        double nearest = 1e9;
        for (std::uint32_t a = 0; a < n; ++a) {
            for (std::uint32_t b = n; b < 2 * n; ++b) {
                nearest = std::min(nearest, (state.x[a] - state.x[b]).norm());
            }
        }
        ASSERT_GT(nearest, 0.07) << f;  // 0.1 apart, less what a fifth a step has yet to resolve
    }
    double upper = 0;
    for (std::uint32_t k = n; k < 2 * n; ++k) upper += state.x[k].y() / n;
    EXPECT_NEAR(upper, 0.3 + 0.1 + 0.15, 0.06);  // on top of the other, a contact distance above
    // Momentum between free bodies is kept.
    State free = rest_state(body);
    for (std::uint32_t k = n; k < 2 * n; ++k) free.v[k] = Vec3(0.3, -6, 0);
    Vec3 before = Vec3::Zero(), after = before;
    for (std::uint32_t k = 0; k < 2 * n; ++k) before += body.base.mass[k] * free.v[k];
    for (int f = 0; f < 24; ++f) free = advance(body, std::move(free), {}, 1.0 / 48, options);
    for (std::uint32_t k = 0; k < 2 * n; ++k) after += body.base.mass[k] * free.v[k];
    EXPECT_LT((after - before).norm(), 1e-10 * before.norm());
    double moved = 0;
    for (std::uint32_t k = 0; k < n; ++k) moved = std::max(moved, free.v[k].norm());
    EXPECT_GT(moved, 0.5);  // the other was hit
}

TEST(LatticeBodies, PiecesThatNothingPullsStayWhereTheyAre)
{
    // A sheet in two pieces, one cell apart, without gravity. Sums in single precision leave each
    // piece a momentum of its own; taken off both together, they crept apart by millimetres. Taken
    // off each piece, centres keep still to the rounding of double precision.
    auto cells = geometry::rectangle_cells(13, 9);
    std::erase_if(cells, [](const auto& cell) { return cell[0] == 6; });
    const Cubes apart =
        geometry::plane_cubes(cells, {1, 0.1, {0, 0, 0}}, 0.002, {"sheet", 1000, 1e7, 0, 0, 0});
    const Cubes whole = geometry::plane_cubes(geometry::rectangle_cells(13, 9), {1, 0.1, {0, 0, 0}},
                                              0.002, {"sheet", 1000, 1e7, 0, 0, 0});
    enum class Case { free, one_is_held, torn };
    for (const Case which : {Case::free, Case::one_is_held, Case::torn}) {
        const Cubes& cubes = which == Case::torn ? whole : apart;
        const LatticeOptions options{
            .half_width = 1, .tear = which == Case::torn ? 10.0 : 0.0, .substeps = 4};
        const LatticeBody body = make_lattice(cubes, options);
        State state = rest_state(body);
        Loads loads;
        const auto is_left = [&](std::uint32_t k) { return cubes.corner[k][0] <= 6; };
        if (which == Case::torn) {
            const Lattice lattice = corner_lattice(cubes);
            for (std::uint32_t i = 0; i < lattice.count(); ++i) {
                if (cubes.corner[i][0] == 6) state.broken.push_back(3 * i);
            }
        }
        if (which == Case::one_is_held) {
            loads.pins.corner.push_back(0);
            loads.pins.target.push_back(state.x[0]);
        }
        ASSERT_TRUE(is_left(0));
        const State start = state;
        for (int f = 0; f < 120; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
        }
        for (const bool left : {true, false}) {
            if (left && which == Case::one_is_held) continue;
            Vec3 moved = Vec3::Zero();
            double mass = 0;
            for (std::uint32_t k = 0; k < state.x.size(); ++k) {
                if (is_left(k) != left) continue;
                moved += body.base.mass[k] * (state.x[k] - start.x[k]);
                mass += body.base.mass[k];
            }
            EXPECT_LT((moved / mass).norm(), 1e-12) << int(which) << " left " << left;
        }
    }
}

TEST(LatticeBodies, KeepTheirContactDistance)
{
    // Two cubes of 0.1 m meet face to face, of which one may be held. A push leaves no gap and
    // closes none beyond, so while the corners in front touch they are the contact distance apart:
    // 0.16 m where that is given, the edge of a cube where it is 0. What is held gives nothing of
    // way: if its mass took part, each push would leave half the speed, 1 mm a step. Pushes are
    // kept in single precision: of 1 m/s for 1 ms. (With a Poisson's ratio the faces that meet
    // spread while they are pushed, and corners slide past each other.)
    const Cubes cubes = with_copy(box(1, 1, 1, 0.1, {.poisson = 0}), Vec3i(3, 0, 0));
    for (const double distance : {0.0, 0.16}) {
        for (const bool held : {false, true}) {
            LatticeOptions options{.half_width = 1, .substeps = 1};
            options.contact.on = true;
            options.contact.distance = distance;
            const LatticeBody body = make_lattice(cubes, options);
            State state = rest_state(body);
            Loads loads;
            for (std::uint32_t k = 0; k < 16; ++k) {
                if (k < 8) state.v[k] = Vec3(2, 0, 0);
                if (k < 8 || !held) continue;
                loads.pins.corner.push_back(k);
                loads.pins.target.push_back(state.x[k]);
            }
            double nearest = 1;
            for (int f = 0; f < 200; ++f) {
                state = advance(body, std::move(state), loads, 1e-3, options);
                for (std::size_t a = 0; a < 8; ++a) {
                    for (std::size_t b = 8; b < 16; ++b) {
                        nearest = std::min(nearest, (state.x[a] - state.x[b]).norm());
                    }
                }
            }
            EXPECT_NEAR(nearest, distance > 0 ? distance : 0.1, 1e-6) << held;
        }
    }
}

TEST(LatticeBodies, TouchWithOutsideParticlesOnly)
{
    // Of 4 x 4 x 4 particles all but the 2 x 2 x 2 within; of a plane, which has nothing but two
    // faces, all.
    LatticeOptions options{.half_width = 1};
    options.contact.on = true;
    EXPECT_EQ(make_lattice(box(3, 3, 3, 0.1), options).side.size(), 64u - 8u);
    EXPECT_EQ(make_lattice(whole_sheet(4, 5), options).side.size(), 5u * 6u);
}

TEST(LatticeBalls, RestOnASheetAndLoadItsPins)
{
    // A ball settles on a sheet held at its rim; momentum balance: its speed goes to 0 while
    // gravity pulls, so the pins carry it. It lies where it touches, above the sheet's dent.
    const Cubes cubes = whole_sheet(12, 12);
    LatticeOptions options{.half_width = 1, .damping = 0.02, .substeps = 16};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    Ball ball;
    ball.radius = 0.25;
    ball.mass = 4;
    ball.position = Vec3(0.6, 0.4, 0.6);
    loads.balls.push_back(ball);
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const auto& at = cubes.corner[k];
        if (at[0] % 12 != 0 && at[2] % 12 != 0) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    State state = rest_state(body);
    for (int f = 0; f < 240; ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
        for (Vec3& v : state.v) v *= 0.98;
    }
    ASSERT_EQ(state.balls.size(), 1u);
    EXPECT_LT(state.balls[0].v.norm(), 0.05);
    double lowest = 0;
    for (const Vec3& x : state.x) lowest = std::min(lowest, x[1]);
    EXPECT_LT(lowest, -0.01);
    EXPECT_NEAR(state.balls[0].x[1], lowest + 0.25, 0.02);
    EXPECT_NEAR(state.balls[0].x[0], 0.6, 0.02);
}

TEST(LatticeBalls, RollDownASlopeAsSolidBallsDo)
{
    // Without slip a = 5/7 g sin(30 deg): after 0.5 s it has gone 5/7 9.81 0.5 0.5^2 / 2 = 0.438 m.
    const Cubes cubes = fixtures::box(1, 1, 1, 0.1);
    LatticeOptions options{.half_width = 1, .substeps = 20};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    Collider slope;
    slope.pose.linear() = Eigen::AngleAxisd(std::numbers::pi / 6, Vec3::UnitZ()).toRotationMatrix();
    slope.before = slope.pose;
    loads.colliders.push_back(slope);
    Ball ball;
    ball.radius = 0.2;
    const Vec3 normal = slope.pose.linear() * Vec3::UnitY();
    ball.position = Vec3(5, 5 * std::tan(std::numbers::pi / 6), 0) + 0.2 * normal;
    loads.balls.push_back(ball);
    State state = rest_state(body);
    for (int f = 0; f < 12; ++f) state = advance(body, std::move(state), loads, 1.0 / 24, options);
    EXPECT_NEAR((state.balls[0].x - ball.position).norm(), 0.438, 0.01);
    EXPECT_NEAR(state.balls[0].spin.norm() * 0.2, state.balls[0].v.norm(), 0.01);
}

TEST(LatticeBalls, TurnAboutTheirSpinFromAnyOrientation)
{
    const LatticeOptions options{.half_width = 1, .substeps = 7};
    const LatticeBody body = make_lattice(box(1, 1, 1, 0.1), options);
    Loads loads;
    loads.balls.push_back({.position = Vec3(5, 5, 5)});
    State state = advance(body, rest_state(body), loads, 0.1, options);
    const Eigen::Quaterniond lies(Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized()));
    state.balls[0].turn = {lies.w(), lies.x(), lies.y(), lies.z()};
    state.balls[0].spin = Vec3(0, 3, 0);
    const State after = advance(body, state, loads, 0.1, options);
    const Eigen::Vector4d q = after.balls[0].turn;
    const Eigen::Quaterniond turned(q[0], q[1], q[2], q[3]);
    const Eigen::Quaterniond expected = Eigen::AngleAxisd(0.3, Vec3::UnitY()) * lies;
    EXPECT_LT(turned.angularDistance(expected), 1e-7);  // the arc cosine of 1 less rounding
    state.balls[0].spin[1] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(advance(body, state, loads, 0.1, options), std::invalid_argument);
}

TEST(LatticeBalls, HitEachOtherAsSolidBallsWithFrictionDo)
{
    // One comes down on another at 2 m/s while it goes past at 5 m/s: they meet at t = 0.3 s, one
    // above the other, without bounce. Each takes on half of 2 m/s, J = m / 2 * 2; friction is of
    // the two coefficients' geometric mean, 0.3 J = 0.45 N s, far from what would stop their slip,
    // and turns both the same way at r 0.3 J / (2/5 m r^2) = 3.75 rad/s.
    const double m = 1.5, r = 0.2;
    const LatticeOptions options{.half_width = 1, .substeps = 400};
    const LatticeBody body = make_lattice(box(1, 1, 1, 0.1), options);
    Loads loads;
    Ball one{.radius = r, .mass = m, .friction = 1}, other = one;
    one.position = Vec3(-1.5, 1, 5);
    one.velocity = Vec3(5, -2, 0);
    other.position = Vec3(0, 0, 5);
    other.friction = 0.09;
    loads.balls = {one, other};
    State state = rest_state(body);
    for (int f = 0; f < 8; ++f) state = advance(body, std::move(state), loads, 1.0 / 24, options);
    // In a step of 0.1 ms they slide by 0.5 mm, so the normal is off by some thousandths.
    const auto& a = state.balls[0];
    const auto& b = state.balls[1];
    EXPECT_LT((a.v - Vec3(4.7, -1, 0)).norm(), 0.03);
    EXPECT_LT((b.v - Vec3(0.3, -1, 0)).norm(), 0.03);
    EXPECT_LT((a.spin - Vec3(0, 0, -3.75)).norm(), 0.05);
    EXPECT_LT((b.spin - Vec3(0, 0, -3.75)).norm(), 0.05);
}
