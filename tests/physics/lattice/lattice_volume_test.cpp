#include "physics/lattice/region_volume.hpp"

#include "geometry/base/random.hpp"
#include "physics/lattice/bend_ratio.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/lattice/match_slots.hpp"
#include "tests/physics/lattice/lattice_fixtures.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

using namespace physics;
using fixtures::box;
using geometry::Cubes;
using geometry::Mat3;
using geometry::Random;

namespace {

// Particles of a region, M and X - C in lattice steps, about their middle.
struct Region {
    std::vector<double> mass;
    std::vector<Vec3> at;
    Mat3 spread = Mat3::Zero();  // B
    RegionVolume<double> volume;
};

Region random_region(std::uint64_t seed)
{
    const Random random(seed);
    std::uint64_t draw = 0;
    Region out;
    Vec3 centre = Vec3::Zero();
    double total = 0;
    for (int i = 0; i < 9; ++i) {
        out.mass.push_back(0.5 + random.unit(draw++));
        out.at.emplace_back(random.unit(draw), 2 * random.unit(draw + 1), random.unit(draw + 2));
        draw += 3;
        centre += out.mass.back() * out.at.back();
        total += out.mass.back();
    }
    for (std::size_t i = 0; i < out.at.size(); ++i) {
        out.at[i] -= centre / total;
        out.spread += out.mass[i] * out.at[i] * out.at[i].transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(out.spread);
    const double third = std::cbrt(out.spread.determinant());
    const Mat3 q = std::sqrt(third) * eigen.operatorInverseSqrt();
    out.volume = {{q(0, 0), q(0, 1), q(0, 2), q(1, 1), q(1, 2), q(2, 2)}, 1 / third, 1};
    return out;
}

Mat3 random_map(std::uint64_t seed, double size)
{
    const Random random(seed);
    Mat3 out;
    for (Eigen::Index i = 0; i < 9; ++i) out(i) = size * (2 * random.unit(std::uint64_t(i)) - 1);
    return out;
}

// V of region_volume.hpp times det(B)^(1/3), of a region moved by a linear map.
double energy_of(const Region& region, const Mat3& map)
{
    const double third = std::cbrt(region.spread.determinant());
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(region.spread);
    const Mat3 g = map * eigen.operatorSqrt() / std::sqrt(third);
    const Mat3 cofactors = g.determinant() * g.inverse().transpose();
    const double size_sq = g.squaredNorm(), away = g.determinant() - 1;
    return third * away * away / (cofactors.squaredNorm() + size_sq * size_sq / 9 + 2);
}

double volume_of(const Cubes& cubes, const State& state)
{
    double sum = 0;
    for (const auto& corners : cubes.corners) {
        Mat3 sides = Mat3::Zero();
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t d = 0; d < 3; ++d) {
                sides.col(Eigen::Index(d)) += (a >> d & 1 ? 0.25 : -0.25) * state.x[corners[a]];
            }
        }
        sum += sides.determinant();
    }
    return sum;
}

// What the middle of a bar has come to be longer and thinner, of what its material would be longer.
struct Drawn {
    double longer = 0, thinner = 0;
};

// Both ends are drawn apart by a force that makes it 2 % longer, until it is at rest.
Drawn drawn_bar(double nu, int half_width, int substeps)
{
    const int length = 16, side = 4;
    const Cubes cubes = box(length, side, side, 0.1, {1000, 1e5, nu});
    const LatticeOptions options{.half_width = half_width,
                                 .calibrate = Calibration::stretch,
                                 .damping = 0.02,
                                 .substeps = substeps};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    Loads loads;
    for (const int end : {0, length}) {
        Force pull;
        pull.kind = Force::Kind::point;
        pull.position = Vec3(0.1 * end, 0.2, 0.2);
        pull.radius = 0.35;
        pull.force[0] = (end == 0 ? -1 : 1) * 1e5 * 0.16 * 0.02;
        loads.forces.push_back(pull);
    }
    for (int f = 0; f < 60; ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
        for (Vec3& v : state.v) v *= 0.8;
    }
    Drawn out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const Vec3i at = cubes.corner[k];
        const Vec3 moved = (state.x[k] - cubes.corner_position(k)) / 0.02;
        if (at[0] == 5 || at[0] == 11) out.longer += (at[0] == 5 ? -1 : 1) * moved[0] / (0.6 * 25);
        if (at[0] != 8) continue;
        for (const int d : {1, 2}) {
            if (at[d] == 0 || at[d] == side) {
                out.thinner += (at[d] == 0 ? 1 : -1) * moved[d] / (0.4 * 10);
            }
        }
    }
    return out;
}

}  // namespace

TEST(RegionVolume, PullsDownItsEnergyWithoutTorque)
{
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Region region = random_region(seed);
        // From nearly at rest to crushed, stretched and turned inside out.
        const double size = seed % 4 == 0 ? 0.1 : 1.5;
        const Mat3 turn = Eigen::AngleAxisd(double(seed), Vec3(1, 2, 3).normalized()).matrix();
        const Mat3 map = turn * (Mat3::Identity() + random_map(100 + seed, size));
        const Mat3 moments = map * region.spread;
        const Mat3 pull = pull_to_volume(region.volume, Mat3(0.3 * moments), 0.3, 1.0);
        const Mat3 force = pull * region.spread;  // -dU / dF
        const double step = 1e-5;
        Mat3 slope;
        for (Eigen::Index i = 0; i < 9; ++i) {
            Mat3 more = map, less = map;
            more(i) += step, less(i) -= step;
            slope(i) = (energy_of(region, more) - energy_of(region, less)) / (2 * step);
        }
        EXPECT_LT((force + slope).norm(), 1e-6 * (1 + slope.norm())) << seed;
        const Mat3 torque = force * map.transpose();
        EXPECT_LT((torque - torque.transpose()).norm(), 1e-12 * (1 + torque.norm())) << seed;
    }
}

TEST(RegionVolume, IsAtRestUnderMapsThatKeepIt)
{
    const Region region = random_region(7);
    for (const double shear : {0.0, 0.1, 3.0}) {
        Mat3 map = Eigen::AngleAxisd(1.0, Vec3::UnitX()).matrix();
        map.col(2) += shear * map.col(0);
        const Mat3 pull = pull_to_volume(region.volume, Mat3(map * region.spread), 1.0, 1.0);
        EXPECT_LT(pull.norm(), 1e-13);
        // Of a rest shape of half the volume, half of it.
        const Mat3 half = std::cbrt(0.5) * map;
        EXPECT_LT(pull_to_volume(region.volume, Mat3(half * region.spread), 1.0, 0.5).norm(),
                  1e-13);
        EXPECT_GT(pull_to_volume(region.volume, Mat3(half * region.spread), 1.0, 1.0).norm(), 0.05);
    }
}

TEST(RegionVolume, ManyRegionsAtATimeArePulledAsOne)
{
    // 19 regions: some groups of vectors, and a rest. They have a rotation, and some of their pull.
    constexpr std::size_t count = 19;
    const float h = 0.3f;
    std::vector<float> slots(16 * count), weight(count, 1.0f), rotation(4 * count, 0.0f);
    std::vector<float> share(count), stretch(count), plain;
    std::vector<RegionVolume<float>> volume(count);
    std::vector<Region> region;
    std::vector<Mat3> moments;
    for (std::size_t i = 0; i < count; ++i) {
        region.push_back(random_region(i));
        const double size = i % 2 ? 0.2 : 1.2;
        moments.push_back(0.3 * (Mat3::Identity() + random_map(50 + i, size)) * region[i].spread);
        for (std::size_t c = 0; c < 6; ++c) volume[i].root[c] = float(region[i].volume.root[c]);
        volume[i].scale = float(region[i].volume.scale);
        share[i] = 0.25f * float(i % 5);
        stretch[i] = float(i % 4) - 0.5f;
        slots[16 * i + 3] = 1;  // mass, at the origin
        for (std::size_t d = 0; d < 3; ++d) {
            for (std::size_t c = 0; c < 3; ++c) {
                slots[16 * i + 4 * (d + 1) + c] =
                    float(moments[i](Eigen::Index(c), Eigen::Index(d)));
            }
        }
    }
    plain = slots;
    std::vector<float> turned = rotation;
    MatchedSlots of{count, slots.data(), weight.data(), rotation.data()};
    of.axes = {0, 1, 2};
    of.h = h;
    of.volume = volume[0].root.data();
    of.volume_share = share.data();
    of.stretch_share = stretch.data();
    match_slots(of);
    of.slots = plain.data();
    of.rotation = turned.data();
    of.volume = of.volume_share = of.stretch_share = nullptr;
    match_slots(of);
    for (std::size_t i = 0; i < count; ++i) {
        const Mat3 pull = pull_to_volume(region[i].volume, moments[i], 0.3, 1.0);
        const Mat3 map = linear_map(region[i].volume, moments[i], 0.3);
        EXPECT_LT((0.3 * map * region[i].spread - moments[i]).norm(), 1e-12 * moments[i].norm());
        for (std::size_t e = 0; e < 9; ++e) {
            const std::size_t at = 16 * i + 4 * (e / 3 + 1) + e % 3;
            // With S more, by what the rotation is beyond the map.
            const double expected =
                0.3 * double(share[i]) * pull(Eigen::Index(e)) +
                double(stretch[i]) * (double(plain[at]) - 0.3 * map(Eigen::Index(e)));
            EXPECT_NEAR(double(slots[at] - plain[at]), expected, 2e-6) << i << " " << e;
        }
    }
}

// By hand, with w = 1: of a body one cube thick V = 2/3, Q = (2/3 - 4/9) / 4 and V' = 1/4, beta =
// 12 (Q + V V') / V = 4; with w = 2, V = 2 and Q = (34/5 - 4) / 4, 12 (0.7 + 0.5) / 2.
TEST(BendRatio, IsWhatABendWithinRegionsCosts)
{
    EXPECT_NEAR(bend_ratio(1, 40, 1), 4, 1e-12);
    EXPECT_NEAR(bend_ratio(1, 40, 2), 7.2, 1e-12);
    EXPECT_EQ(bend_ratio(2, 2, 2), 1);
    // A thin post on the corner of a block, and the block: each by its own thickness and length.
    std::vector<geometry::Vec3i> cells;
    for (int y = 0; y < 12; ++y) cells.emplace_back(0, y, 0);
    for (int z = 0; z < 4; ++z) {
        for (int y = 12; y < 16; ++y) {
            for (int x = 0; x < 4; ++x) cells.emplace_back(x, y, z);
        }
    }
    const Cubes cubes = fixtures::cubes_on(cells, 0.1);
    const std::vector<double> found = bend_ratios(cubes, 1);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const Vec3i at = cubes.cell[c];
        const int length = at[0] == 0 && at[2] == 0 ? 16 : 4;
        EXPECT_EQ(found[c], bend_ratio(at[1] < 12 ? 1 : 4, length, 1)) << at.transpose();
    }
}

TEST(LatticeVolume, ABarThinsByItsPoissonsRatio)
{
    EXPECT_LT(std::abs(drawn_bar(0, 1, 30).thinner), 1e-4);
    for (const int half_width : {1, 2}) {
        for (const double nu : {0.3, 0.45}) {
            const auto [longer, thinner] = drawn_bar(nu, half_width, 30);
            EXPECT_NEAR(thinner / longer, nu, 0.02) << half_width;
            EXPECT_NEAR(longer, 1, half_width == 1 ? 0.1 : 0.15) << nu;
        }
    }
}

TEST(LatticeVolume, ABarIsAsLongWhereStepsCannotBearItsVolume)
{
    // In 7 substeps E takes 0.53 of what they bear, and nu is (1 - 0.53) / 2.
    const auto [longer, thinner] = drawn_bar(0.45, 1, 7);
    EXPECT_NEAR(thinner / longer, 0.235, 0.02);
    EXPECT_NEAR(longer, 1, 0.08);
}

TEST(LatticeVolume, WhatIsSquashedBulges)
{
    // A cube of 8 cubes between two plates that hold it, pressed together by a quarter.
    const auto kept = [](double nu) {
        const Cubes cubes = box(8, 8, 8, 0.1, {1000, 1e4, nu, 0.0, 0.01});
        const LatticeOptions options{.half_width = 1, .substeps = 10};
        const LatticeBody body = make_lattice(cubes, options);
        State state = rest_state(body);
        const double whole = volume_of(cubes, state);
        for (int f = 1; f <= 72; ++f) {
            Loads loads;
            for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
                const int y = cubes.corner[k][1];
                if (y != 0 && y != 8) continue;
                Vec3 to = cubes.corner_position(k);
                if (y == 8) to[1] -= 0.2 * std::min(1.0, f / 24.0);
                loads.pins.corner.push_back(k);
                loads.pins.target.push_back(to);
            }
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
        }
        return volume_of(cubes, state) / whole;
    };
    EXPECT_NEAR(kept(0), 0.75, 0.01);
    EXPECT_GT(kept(0.45), 0.93);
    EXPECT_LT(kept(0.45), 1.02);
}

TEST(LatticeVolume, ComesBackFromAnyStart)
{
    // Scattered, flat, turned inside out, a line, a point, and drawn out at its own volume.
    const Random random(3);
    for (const double nu : {0.2, 0.49}) {
        for (int start = 0; start < 6; ++start) {
            const Cubes cubes = box(2, 1, 1, 0.1, {1000, 4e4, nu});
            const LatticeOptions options{.half_width = 1, .damping = 0.01, .substeps = 16};
            const LatticeBody body = make_lattice(cubes, options);
            State state = rest_state(body);
            std::uint64_t draw = 0;
            for (Vec3& x : state.x) {
                if (start == 1) x[1] *= 1e-3;
                if (start == 2) x[1] *= -1;
                if (start == 3) x[1] = x[2] = 0;
                if (start == 4) x.setZero();
                if (start == 5) x = Vec3(16 * x[0], x[1] / 4, x[2] / 4);
                for (double& c : x) c += (start == 0 ? 0.3 : 1e-6) * (random.unit(draw++) - 0.5);
            }
            for (int f = 0; f < 240; ++f) {
                state = advance(body, std::move(state), {}, 1.0 / 24, options);
            }
            for (const auto& corners : cubes.corners) {
                for (unsigned a = 0; a < 7; ++a) {
                    const double side = (state.x[corners[7]] - state.x[corners[a]]).norm();
                    const double right =
                        (cubes.corner_position(corners[7]) - cubes.corner_position(corners[a]))
                            .norm();
                    EXPECT_NEAR(side, right, 0.005) << nu << " " << start;
                }
            }
        }
    }
}

TEST(LatticeVolume, SingleCubesTurnedInsideOutGainNoEnergy)
{
    // What hardly resolves the volume is damped a little; without, some of these gain 1e20 times.
    for (const double nu : {0.3, 0.49}) {
        for (std::uint64_t seed = 0; seed < 4; ++seed) {
            const Cubes cubes = box(1, 1, 1, 0.1, {1000, 1e5, nu});
            const LatticeOptions options{.half_width = 2, .substeps = 200};
            const LatticeBody body = make_lattice(cubes, options);
            State state = rest_state(body);
            const Random random(seed);
            for (std::size_t k = 0; k < 8; ++k) {
                for (std::size_t d = 0; d < 3; ++d) {
                    state.x[k][Eigen::Index(d)] += 0.2 * (random.unit(3 * k + d) - 0.5);
                }
            }
            double early = 0, late = 0;
            for (int f = 0; f < 300; ++f) {
                state = advance(body, std::move(state), {}, 10.0 / 24, options);
                double& most = f < 30 ? early : late;
                most = std::max(most, fixtures::energy(body, state));
            }
            EXPECT_LT(late, 1.2 * early) << nu << " " << seed;
        }
    }
}

TEST(LatticeVolume, SingleSumsGiveTheMotionOfFullOnes)
{
    // With pins, which regions weigh by more: a cantilever of several materials.
    const auto sagged = [](Precision precision) {
        Cubes cubes = box(8, 2, 3, 0.1, {1000, 1e5, 0.45});
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            if (cubes.cell[c][0] < 4) cubes.poisson[c] = c % 2 == 0 ? 0 : 0.2;
        }
        const LatticeOptions options{.half_width = 1, .substeps = 12, .precision = precision};
        const LatticeBody body = make_lattice(cubes, options);
        State state = rest_state(body);
        Loads loads;
        loads.forces.push_back({});
        loads.pins.corner = fixtures::first_layer(cubes);
        for (const auto k : loads.pins.corner) loads.pins.target.push_back(state.x[k]);
        for (int f = 0; f < 12; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, options);
        }
        return state.x;
    };
    const auto single = sagged(Precision::single), full = sagged(Precision::full);
    for (std::size_t k = 0; k < full.size(); ++k) EXPECT_LT((single[k] - full[k]).norm(), 1e-5);
}

TEST(LatticeVolume, OtherPinsAreWeighedAnew)
{
    // What regions with pins see is kept from frame to frame, and depends on the pins alone.
    const Cubes cubes = box(6, 2, 2, 0.1, {1000, 1e5, 0.4});
    const LatticeOptions options{.half_width = 1, .substeps = 12};
    const auto held = [&](int layer) {
        Loads loads;
        loads.forces.push_back({});
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k][0] != layer) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        return loads;
    };
    const LatticeBody used = make_lattice(cubes, options), fresh = make_lattice(cubes, options);
    advance(used, rest_state(used), held(0), 1.0 / 24, options);
    for (int again = 0; again < 2; ++again) {
        const State after = advance(used, rest_state(used), held(6), 1.0 / 24, options);
        EXPECT_EQ(after.x, advance(fresh, rest_state(fresh), held(6), 1.0 / 24, options).x);
    }
}

TEST(LatticeVolume, WarnsWhereStepsDoNotResolveIt)
{
    const auto warned = [](double poisson, Stiffness stiffness, int substeps, int half_width = 1) {
        const LatticeOptions options{
            .half_width = half_width, .stiffness = stiffness, .substeps = substeps};
        const Cubes cubes = box(8, 8, 3, 0.1, {.young = 1e5, .poisson = poisson});
        const LatticeBody body = make_lattice(cubes, options);
        const auto& all = advance(body, rest_state(body), {}, 1.0 / 24, options).report.warnings;
        return all.empty() ? std::string{} : all.back();
    };
    const std::string told = warned(0.45, Stiffness::material, 6);
    EXPECT_NE(told.find(", not 0.45. From "), std::string::npos) << told;
    EXPECT_EQ(warned(0, Stiffness::material, 6), "");
    EXPECT_EQ(warned(0.45, Stiffness::rate, 6), "");
    const std::string softer = warned(0.45, Stiffness::material, 1);
    EXPECT_NE(softer.find(" to keep its volume). "), std::string::npos) << softer;
    // What is advised is enough.
    const int advised = std::stoi(told.substr(told.find("From ") + 5));
    EXPECT_GT(advised, 6);
    EXPECT_EQ(warned(0.45, Stiffness::material, advised), "");
}

// 0 takes as many as the warning asks for, of the frame's own duration.
TEST(LatticeVolume, NoSubstepsAreAsManyAsItsMaterialNeeds)
{
    const Cubes cubes = box(8, 8, 3, 0.1, {.young = 1e5, .poisson = 0.45});
    const LatticeBody body = make_lattice(cubes, {.half_width = 1});
    for (const double dt : {1.0 / 24, 1.0 / 240}) {
        const State enough = advance(body, rest_state(body), {}, dt, StepOptions{.substeps = 0});
        EXPECT_TRUE(enough.report.warnings.empty());
        EXPECT_TRUE(enough.report.converged);
        const auto taken = int(enough.report.steps);
        EXPECT_EQ(taken, enough_substeps(body, dt));
        EXPECT_GE(taken, least_substeps(body, dt));
        const State same = advance(body, rest_state(body), {}, dt, StepOptions{.substeps = taken});
        EXPECT_EQ(same.x, enough.x);
        if (dt < 1.0 / 24) continue;
        const State fewer =
            advance(body, rest_state(body), {}, dt, StepOptions{.substeps = taken / 2});
        EXPECT_FALSE(fewer.report.warnings.empty());
    }
    const LatticeBody rated = make_lattice(cubes, {.stiffness = Stiffness::rate});
    EXPECT_EQ(enough_substeps(rated, 1.0 / 24), 1);
}
