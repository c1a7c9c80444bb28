// Lattice shape matching on planes, in space and strictly in two dimensions.

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/lattice/lattice.hpp"
#include "tests/physics/every_target.hpp"
#include "tests/physics/regions/direct_regions.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <functional>
#include <numbers>

using namespace physics;
using fixtures::misfit;
using geometry::Cubes;
using geometry::Mat3;
using geometry::Random;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

// ni by nj cells of 0.1 m across `axis`, the corner (0, 0) at the origin, with a hole.
Cubes sheet(int ni, int nj, int axis = 1, double thickness = 0.02, double young = 1e6)
{
    auto cells = geometry::rectangle_cells(ni, nj);
    if (ni > 4 && nj > 4) std::erase(cells, std::array{2, 2});
    return geometry::plane_cubes(cells, {axis, 0.1, {0, 0, 0}}, thickness,
                                 {"sheet", 500, young, 0, 0, 0});
}

LatticeOptions stiffest_plane(PlaneMotion motion = PlaneMotion::space)
{
    return {.stiffness = Stiffness::rate,
            .rate = infinite,
            .damping = 1,
            .plane = motion,
            .substeps = 10};
}

// The acceleration in the middle of a long strip that is displaced by A sin(k x) along `d`, over
// -A sin(k x).
double stiffness_of_wave(int w, int d, double k, double thickness, double bend, double nu = 0)
{
    const Cubes cubes =
        geometry::plane_cubes(geometry::rectangle_cells(120, 12), {1, 0.1, {0, 0, 0}}, thickness,
                              {"sheet", 500, 1e6, nu, 0, 0});
    const LatticeOptions options{
        .half_width = w, .bend = bend, .substeps = 1, .precision = Precision::full};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    const double a = 1e-5, dt = 1e-5;
    for (Vec3& x : state.x) x[d] += a * std::sin(k * (x[0] - 6) + std::numbers::pi / 2);
    const State after = advance(body, state, {}, dt, options);
    for (std::size_t i = 0; i < state.x.size(); ++i) {
        if (cubes.corner[i] == Vec3i(60, 0, 6)) return -after.v[i][d] / dt / a;
    }
    return 0;
}

// d of every particle, by the formulas of lattice.hpp a region at a time: where its region's
// particles should be, turned as the two sides of the region are and bent like a saddle as far as
// it may stay so, less where they are; the mean over the regions that hold it.
std::vector<Vec3> away_by_formulas(const Cubes& cubes, const LatticeBody& body, const State& state)
{
    const int w = body.options.half_width;
    double m2 = 0, m4 = 0;
    for (int i = -w; i <= w; ++i) m2 += i * i, m4 += i * i * i * i;
    m2 /= 2 * w + 1, m4 /= 2 * w + 1;
    const double phi = (m4 - m2 * m2) / (2 * m2 * m2);
    const int u = (body.flat_axis + 1) % 3, v = (body.flat_axis + 2) % 3;
    const auto regions = fixtures::regions_by_search(corner_lattice(cubes), w);
    const std::size_t n = state.x.size();
    std::vector<double> held(n, 0);
    for (const auto& region : regions) {
        for (const auto i : region) ++held[i];
    }
    std::vector<Vec3> away(n, Vec3::Zero());
    for (const auto& region : regions) {
        // Of 1, X and Y, the weighed sums of products with themselves, with X Y and with x.
        const auto linear = [&](std::uint32_t i) {
            return Vec3(1, cubes.corner[i][u], cubes.corner[i][v]);
        };
        const auto mass = [&](std::uint32_t i) { return body.base.mass[i] / held[i]; };
        Mat3 square = Mat3::Zero(), placed = Mat3::Zero();
        Vec3 twisted = Vec3::Zero();
        for (const auto i : region) {
            const Vec3 p = linear(i);
            square += mass(i) * p * p.transpose();
            placed += mass(i) * state.x[i] * p.transpose();
            twisted += mass(i) * p[1] * p[2] * p;
        }
        const Vec3 centre = placed.col(0) / square(0, 0), middle = square.col(0) / square(0, 0);
        Eigen::Matrix<double, 3, 2> sides;
        for (int d = 0; d < 2; ++d)
            sides.col(d) = placed.col(d + 1) - middle[d + 1] * placed.col(0);
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> stretch(sides.transpose() * sides);
        const Eigen::Matrix<double, 3, 2> turn = sides * stretch.operatorInverseSqrt();
        const Vec3 straight = square.inverse() * twisted;
        const auto psi = [&](std::uint32_t i) {
            const Vec3 p = linear(i);
            return p[1] * p[2] - straight.dot(p);
        };
        double b = 0;
        Vec3 saddle = Vec3::Zero();
        for (const auto i : region) {
            b += mass(i) * psi(i) * psi(i);
            saddle += mass(i) * psi(i) * state.x[i];
        }
        for (const auto i : region) {
            const Vec3 goal = centre + cubes.size * turn * (linear(i) - middle).tail<2>() +
                              (1 - phi) / b * psi(i) * saddle;
            away[i] += (goal - state.x[i]) / held[i];
        }
    }
    return away;
}

}  // namespace

TEST(PlaneLattice, AtRestUnderAnyRigidMotionStaysThere)
{
    for (const int axis : {0, 1, 2}) {
        for (const int w : {1, 3}) {
            for (const bool in_plane : {false, true}) {
                LatticeOptions options =
                    stiffest_plane(in_plane ? PlaneMotion::in_plane : PlaneMotion::space);
                options.half_width = w;
                options.bend = 0.3;
                options.rate = 1e4;
                options.substeps = 1;
                options.precision = Precision::full;
                const LatticeBody body = make_lattice(sheet(7, 6, axis), options);
                State state = rest_state(body);
                const Vec3 about = in_plane ? Vec3(Vec3::Unit(axis)) : Vec3(1, -2, 3).normalized();
                const Mat3 turn = Eigen::AngleAxisd(2, about).toRotationMatrix();
                for (Vec3& x : state.x)
                    x = turn * x + (in_plane ? Vec3(Vec3::Zero()) : Vec3(5, 6, 7));
                const State before = state;
                state = advance(body, state, {}, 0.01, options);
                double worst = 0;
                for (std::size_t i = 0; i < state.x.size(); ++i) {
                    worst = std::max(worst, (state.x[i] - before.x[i]).norm());
                }
                EXPECT_LT(worst, 1e-13) << axis << w << in_plane;  // rounding of places below 12 m
                if (in_plane) continue;
                // What every region starts the next step from.
                options.precision = Precision::single;
                const State next = advance(body, before, {}, 0.01, options);
                const Eigen::Quaternionf turned(turn.cast<float>());
                for (std::size_t s = 0; s < body.whole.regions.slots(); ++s) {
                    if (body.whole.regions.particle[s] == none) continue;
                    const float* const q = next.rotation.data() + 4 * s;
                    EXPECT_NEAR(std::abs(turned.dot(Eigen::Quaternionf(q[0], q[1], q[2], q[3]))), 1,
                                1e-5);
                }
            }
        }
    }
}

TEST(PlaneLattice, RecoversFromAnyDeformation)
{
    // As a solid does: folded over, rolled up, at a point, on a line, mirrored, at random.
    const Random random(3);
    using Move = std::function<Vec3(const Vec3&, std::uint64_t)>;
    const std::vector<std::pair<std::string, Move>> cases = {
        {"a point", [](const Vec3&, std::uint64_t) { return Vec3(1, 2, 3); }},
        {"a line", [](const Vec3& x, std::uint64_t) { return Vec3(x[0], 0, 0); }},
        {"mirrored", [](const Vec3& x, std::uint64_t) { return Vec3(-x[0], x[1], x[2]); }},
        // Folded over, a hair apart: exactly flat, nothing says to which side it should open.
        {"folded",
         [](const Vec3& x, std::uint64_t) {
             return Vec3(std::abs(x[0] - 0.3), 1e-3 * std::max(0.0, x[0] - 0.3), x[2]);
         }},
        {"rolled",
         [](const Vec3& x, std::uint64_t) {
             return Vec3(0.1 * std::cos(10 * x[0]), 0.1 * std::sin(10 * x[0]), x[2]);
         }},
        {"random",
         [&](const Vec3&, std::uint64_t i) {
             return Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2));
         }},
    };
    for (const int w : {1, 2}) {
        LatticeOptions options = stiffest_plane();
        options.half_width = w;
        const LatticeBody body = make_lattice(sheet(6, 5), options);
        for (const auto& [name, move] : cases) {
            State state = rest_state(body);
            for (std::size_t i = 0; i < state.x.size(); ++i) state.x[i] = move(state.x[i], i);
            for (int frame = 0; frame < 300; ++frame) {
                state = advance(body, state, {}, 0.1, options);
            }
            EXPECT_LT(misfit(rest_state(body), state), 1e-3 * 0.8) << name << ", w = " << w;
        }
    }
}

TEST(PlaneLattice, RecoversInItsPlane)
{
    const Random random(4);
    for (const int w : {1, 2}) {
        LatticeOptions options = stiffest_plane(PlaneMotion::in_plane);
        options.half_width = w;
        const LatticeBody body = make_lattice(sheet(6, 5), options);
        for (int kind = 0; kind < 4; ++kind) {
            State state = rest_state(body);
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                Vec3& x = state.x[i];
                if (kind == 0) x = Vec3(0.3, 0, 0.3);
                if (kind == 1) x[0] = 0.3;
                if (kind == 2) x[0] = -x[0];
                if (kind == 3) x = Vec3(random.unit(2 * i), 0, random.unit(2 * i + 1));
            }
            for (int frame = 0; frame < 300; ++frame) {
                state = advance(body, state, {}, 0.1, options);
            }
            for (const Vec3& x : state.x) ASSERT_EQ(x[1], 0);
            EXPECT_LT(misfit(rest_state(body), state), 1e-3 * 0.8) << kind << ", w = " << w;
        }
    }
}

TEST(PlaneLattice, WithUnequalStiffnessRestsUnderAnyRigidMotion)
{
    // Regions pull with weights of their own, as long as steps are so short that none pulls all the
    // way.
    for (const bool in_plane : {false, true}) {
        for (const Precision precision : {Precision::full, Precision::single}) {
            Cubes cubes = sheet(7, 6);
            for (std::size_t c = 0; c < cubes.count(); ++c) cubes.young[c] *= 1 + double(c % 5);
            const LatticeOptions options{.half_width = 2,
                                         .plane =
                                             in_plane ? PlaneMotion::in_plane : PlaneMotion::space,
                                         .substeps = 1,
                                         .precision = precision};
            const LatticeBody body = make_lattice(cubes, options);
            State state = rest_state(body);
            const Vec3 about = in_plane ? Vec3(Vec3::UnitY()) : Vec3(1, -2, 3).normalized();
            const Mat3 turn = Eigen::AngleAxisd(2, about).toRotationMatrix();
            for (Vec3& x : state.x) x = turn * x + Vec3(0.1, 0, 0.2);
            const State after = advance(body, state, {}, 5e-4, options);
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                // Rounding of places below 1 m.
                ASSERT_LT((after.x[i] - state.x[i]).norm(),
                          precision == Precision::full ? 1e-13 : 1e-6)
                    << in_plane;
            }
        }
    }
}

TEST(PlaneLattice, RecoversFromAPointWithItsLastRotation)
{
    // A quarter turn at rest, then all particles at one point: nothing says which way it was but
    // the rotations of the step before.
    LatticeOptions options = stiffest_plane(PlaneMotion::in_plane);
    options.half_width = 1;
    options.damping = 0;
    options.substeps = 1;
    const LatticeBody body = make_lattice(sheet(4, 4), options);
    const Mat3 turn = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();
    const State rest = rest_state(body);
    State state = rest;
    for (Vec3& x : state.x) x = turn * x;
    state = advance(body, state, {}, 0.01, options);
    const Vec3 point(0.25, 0, 0.25);  // in binary: their mean is there too
    for (Vec3& x : state.x) x = point;
    for (Vec3& v : state.v) v.setZero();
    state = advance(body, state, {}, 0.01, options);
    double along = 0, across = 0;
    for (std::size_t i = 0; i < rest.x.size(); ++i) {
        const Vec3 from = rest.x[i] - Vec3(0.2, 0, 0.2), to = state.x[i] - point;
        along += to.dot(turn * from);
        across += to.dot(from);
    }
    EXPECT_GT(along, 0.01);
    EXPECT_LT(std::abs(across), 1e-6);
}

TEST(PlaneLattice, AStepIsWhatItsFormulasSay)
{
    // A crumpled sheet of no symmetry, whose regions share what their neighbourhoods are like with
    // no other; d in m, of which there are some centimetres.
    const Random random(6);
    auto cells = geometry::rectangle_cells(9, 8);
    std::erase_if(
        cells, [&](const auto& c) { return random.unit(std::uint64_t(16 * c[0] + c[1])) < 0.2; });
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    for (const int axis : {0, 1, 2}) {
        const double density = axis == 1 ? 500 : 1e-3;  // whatever it weighs
        const Cubes cubes = geometry::plane_cubes(cells, {axis, 0.1, {0, 0, 0}}, 0.02,
                                                  {"s", density, 1e6, 0.3, 0, 0});
        for (const int w : {1, 2, 3}) {
            for (const Precision precision : {Precision::full, Precision::single}) {
                const LatticeOptions options{.half_width = w,
                                             .stiffness = Stiffness::rate,
                                             .rate = 50,
                                             .substeps = 1,
                                             .precision = precision};
                const LatticeBody body = make_lattice(cubes, options);
                State state = rest_state(body);
                for (std::size_t i = 0; i < state.x.size(); ++i) {
                    for (std::size_t d = 0; d < 3; ++d) {
                        state.x[i][Eigen::Index(d)] += 0.08 * (random.unit(3 * i + d) - 0.5);
                    }
                    state.x[i] = turn * state.x[i];
                }
                const double dt = 0.01;
                const State after = advance(body, state, {}, dt, options);
                const std::vector<Vec3> away = away_by_formulas(cubes, body, state);
                // Masses are kept in single precision, a region's share of 1e-7 of them.
                const double tolerance = precision == Precision::full ? 2e-8 : 1e-6;
                for (std::size_t i = 0; i < away.size(); ++i) {
                    const Vec3 got = after.v[i] / (50 * 50 * dt);
                    ASSERT_LT((got - away[i]).norm(), tolerance) << axis << w << " " << i;
                }
            }
        }
    }
}

TEST(PlaneLattice, StretchesLikeItsMaterial)
{
    // rho a = -E k^2 u for a wave of 60 cells; shape matching falls short by some (k w h)^2. The
    // membrane leaves to regions what they resist because they resist bending, which grows with nu.
    const double k = 2 * std::numbers::pi / 6;
    for (const int w : {1, 2, 3}) {
        for (const auto& [t, nu] : {std::pair(0.02, 0.0), {0.08, 0.45}}) {
            EXPECT_NEAR(stiffness_of_wave(w, 0, k, t, 1, nu) / (1e6 / 500 * k * k), 1,
                        0.2 * std::pow(0.1 * k * w, 2) + 0.005)
                << w << " " << t;
        }
    }
}

TEST(PlaneLattice, BendsLikeItsThickness)
{
    // rho t a = -D k^4 u with D = E t^3 / 12, whatever w; and `bend` multiplies it.
    const double k = 2 * std::numbers::pi / 6;
    for (const int w : {1, 2, 3}) {
        for (const double t : {0.05, 0.005}) {
            for (const double bend : {1.0, 4.0}) {
                const double expected = bend * 1e6 * t * t / 12 / 500 * std::pow(k, 4);
                EXPECT_NEAR(stiffness_of_wave(w, 1, k, t, bend) / expected, 1,
                            0.4 * std::pow(0.1 * k * w, 2) + 0.005)
                    << w << " " << t;
            }
        }
    }
}

TEST(PlaneLattice, BendsAlikeInAllDirections)
{
    // A wave sin(k x) sin(k y) twists as much as it bends: rho t a = -D (2 k^2)^2 u, with D = E t^3
    // / (12 (1 - nu^2)). With full weight of twist it would be (1 + 1 / phi) / 2 of that: 2.5 times
    // at w = 1, 1.8 at w = 3.
    const double k = 2 * std::numbers::pi / 6, nu = 0.3, t = 0.02;
    const Cubes cubes = geometry::plane_cubes(geometry::rectangle_cells(60, 60),
                                              {1, 0.1, {0, 0, 0}}, t, {"s", 500, 1e6, nu, 0, 0});
    for (const int w : {1, 2, 3}) {
        for (const Precision precision : {Precision::full, Precision::single}) {
            const LatticeOptions options{.half_width = w, .substeps = 1, .precision = precision};
            const LatticeBody body = make_lattice(cubes, options);
            State state = rest_state(body);
            const double a = precision == Precision::full ? 1e-5 : 1e-2, dt = 1e-4;
            for (Vec3& x : state.x) x[1] += a * std::cos(k * (x[0] - 3)) * std::cos(k * (x[2] - 3));
            const State after = advance(body, state, {}, dt, options);
            const double d = 1e6 * t * t / 12 / (1 - nu * nu) / 500;
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                if (cubes.corner[i] != Vec3i(30, 0, 30)) continue;
                // Single precision knows places to 3 m * 6e-8, some hundredths of what bends.
                EXPECT_NEAR(-after.v[i][1] / dt / a / (d * 4 * std::pow(k, 4)), 1,
                            0.8 * std::pow(0.1 * k * w, 2) + 0.02)
                    << w;
            }
        }
    }
}

TEST(PlaneLattice, WithAnyOutlineAndPinsRestsUnderAnyRigidMotion)
{
    // Regions at the border and around pins have twists of their own: none must see one in a rigid
    // motion.
    const Random random(8);
    auto cells = geometry::rectangle_cells(9, 8);
    std::erase_if(
        cells, [&](const auto& c) { return random.unit(std::uint64_t(16 * c[0] + c[1])) < 0.2; });
    const Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).toRotationMatrix();
    for (const int axis : {0, 1, 2}) {
        for (const int w : {1, 2, 3}) {
            const Cubes cubes = geometry::plane_cubes(cells, {axis, 0.1, {0, 0, 0}}, 0.02,
                                                      {"s", 500, 1e6, 0.3, 0, 0});
            for (const Precision precision : {Precision::full, Precision::single}) {
                const LatticeOptions options{.half_width = w,
                                             .stiffness = Stiffness::rate,
                                             .rate = 1e4,
                                             .bend = 0.3,
                                             .substeps = 1,
                                             .precision = precision};
                const LatticeBody body = make_lattice(cubes, options);
                State state = rest_state(body);
                for (Vec3& x : state.x) x = turn * x + Vec3(1, 2, 3);
                Loads loads;
                for (std::uint32_t k = 0; k < state.x.size(); k += 7) {
                    loads.pins.corner.push_back(k);
                    loads.pins.target.push_back(state.x[k]);
                }
                const State after = advance(body, state, loads, 0.01, options);
                // Weights are single in any case; in single precision places are measured from
                // the sheet's middle, 0.6 m away at most, and rounded at 4e-8 m some times over.
                const double tolerance = precision == Precision::full ? 1e-7 : 4e-7;
                for (std::size_t i = 0; i < state.x.size(); ++i) {
                    ASSERT_LT((after.x[i] - state.x[i]).norm(), tolerance) << axis << w << i;
                }
            }
        }
    }
}

TEST(PlaneLattice, AClampedPlateSagsAsItsTheorySays)
{
    // Circular, radius 1 m, held on a ring as wide as regions reach, P over a disc of 0.2 m in its
    // middle: w = P / (64 pi D) (4 a^2 - 4 c^2 ln(a / c) - 3 c^2). Its rim is a stair of 0.1 m,
    // some 0.02 m too far out: 4 per cent; and regions see curvature blurred by their width.
    const double a = 1, h = 0.1, t = 0.05, nu = 0.3, young = 1e6, load = 0.02;
    const double d = young * t * t * t / (12 * (1 - nu * nu));
    const double omega = 10.2158 / (a * a) * std::sqrt(d / (1000 * t));
    const int n = 14;
    const Cubes cubes = geometry::plane_cubes(geometry::ellipse_cells(2 * n, 2 * n),
                                              {1, h, Vec3(-n * h, 0, -n * h)}, t,
                                              {"rubber", 1000, young, nu, 2 * omega, 0});
    LatticeOptions options{.half_width = 1};
    const LatticeBody body = make_lattice(cubes, options);
    options.substeps = least_substeps(body, 1.0 / 24);
    State state = rest_state(body);
    Loads loads;
    std::uint32_t middle = 0, pushed = 0;
    for (std::uint32_t k = 0; k < state.x.size(); ++k) {
        const double r = std::hypot(state.x[k][0], state.x[k][2]);
        if (r > a - 0.25 * h) {
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(state.x[k]);
        }
        if (r < 1e-9) middle = k;
        pushed += r < 0.2 + 1e-9;
    }
    const double c = std::sqrt(pushed * h * h / std::numbers::pi);
    const double expected =
        load / (64 * std::numbers::pi * d) * (4 * a * a - 4 * c * c * std::log(a / c) - 3 * c * c);
    for (double time = 0; time < 12 / omega; time += 1.0 / 24) {
        // Evenly over the disc, which the Gaussian of a point force is not.
        const double dt = 1.0 / 24;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            if (std::hypot(state.x[k][0], state.x[k][2]) > 0.2 + 1e-4) continue;
            state.v[k][1] -= load / pushed / body.base.mass[k] * dt;
        }
        state = advance(body, std::move(state), loads, dt, options);
        ASSERT_TRUE(state.report.converged);
    }
    EXPECT_NEAR(-state.x[middle][1] / expected, 1, 0.08);
}

TEST(PlaneLattice, KeepsMomentumWhileItFolds)
{
    const Random random(2);
    LatticeOptions options{.half_width = 2, .damping = 0.01, .substeps = 4};
    const LatticeBody body = make_lattice(sheet(8, 7), options);
    State state = rest_state(body);
    for (std::size_t i = 0; i < state.x.size(); ++i) {
        for (int d = 0; d < 3; ++d) {
            state.x[i][d] += 0.03 * (random.unit(6 * i + std::uint64_t(d)) - 0.5);
            state.v[i][d] = random.unit(6 * i + 3 + std::uint64_t(d)) - 0.3;
        }
    }
    const auto momenta = [&] {
        std::array<Vec3, 2> sum{Vec3::Zero(), Vec3::Zero()};
        for (std::size_t i = 0; i < state.x.size(); ++i) {
            sum[0] += body.base.mass[i] * state.v[i];
            sum[1] += body.base.mass[i] * state.x[i].cross(state.v[i]);
        }
        return sum;
    };
    const auto before = momenta();
    for (int frame = 0; frame < 25; ++frame) state = advance(body, state, {}, 0.02, options);
    const auto after = momenta();
    double mass = 0;
    for (const double m : body.base.mass) mass += m;
    EXPECT_LT((after[0] - before[0]).norm(), 1e-12 * mass);
    EXPECT_LT((after[1] - before[1]).norm(), 1e-11 * mass);
}

TEST(PlaneLattice, AKickGainsNoEnergy)
{
    // A free sheet without damping, one particle kicked across it: it never moves with more energy
    // than the kick had (steps of omega dt < 1 exchange some per cent of it), no particle stands
    // out by more than two cells and no link is drawn out by a tenth.
    for (const int w : {1, 2, 4}) {
        const Cubes cubes =
            geometry::plane_cubes(geometry::rectangle_cells(12, 10), {1, 0.1, {0, 0, 0}}, 0.002,
                                  {"sheet", 1100, 4e6, 0, 0, 0});
        const LatticeOptions options{.half_width = w, .substeps = 72};
        const LatticeBody body = make_lattice(cubes, options);
        const Lattice lattice = corner_lattice(cubes);
        State state = rest_state(body);
        const auto energy = [&] {
            double sum = 0;
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                sum += 0.5 * body.base.mass[i] * state.v[i].squaredNorm();
            }
            return sum;
        };
        std::size_t middle = 0;
        while (cubes.corner[middle] != Vec3i(6, 0, 5)) ++middle;
        state.v[middle] = Vec3(0, 3, 0);
        const double kick = energy();
        for (int frame = 0; frame < 96; ++frame) {
            state = advance(body, std::move(state), {}, 1.0 / 24, options);
            EXPECT_TRUE(state.report.converged);
            ASSERT_LT(energy(), 1.05 * kick) << "w = " << w << ", frame " << frame;
        }
        double mean = 0;
        for (const Vec3& x : state.x) mean += x[1] / double(state.x.size());
        for (std::size_t i = 0; i < state.x.size(); ++i) {
            EXPECT_LT(std::abs(state.x[i][1] - mean), 0.2) << w;
            for (const auto j : lattice.next[i]) {
                if (j == none) continue;
                EXPECT_LT((state.x[i] - state.x[j]).norm(), 0.11) << w;
            }
        }
    }
}

TEST(PlaneLattice, WarnsWhenItMovesTooFastForItsSteps)
{
    // 0.1 m cells at 60 substeps of a frame: a corner that leaves its neighbours at 3 cells a
    // substep, 431 m/s, needs 72 of them for 2.5.
    const Cubes cubes =
        geometry::plane_cubes(geometry::rectangle_cells(12, 10), {1, 0.1, {0, 0, 0}}, 0.002,
                              {"sheet", 1100, 4e6, 0, 0, 0});
    const LatticeOptions options{.half_width = 1, .substeps = 60};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    for (Vec3& v : state.v) v = Vec3(0, 1000, 0);  // all together is no kick
    State after = advance(body, state, {}, 1.0 / 24, options);
    EXPECT_TRUE(after.report.warnings.empty());
    state.v[60][1] += 2.99 * 0.1 * 24 * 60;
    after = advance(body, state, {}, 1.0 / 24, options);
    ASSERT_EQ(after.report.warnings.size(), 1u);
    EXPECT_NE(after.report.warnings[0].find("use at least 100 substeps"), std::string::npos)
        << after.report.warnings[0];
    // Where no number of substeps is enough, the text is another, and the same each time.
    for (const double speed : {1e7, 1e8}) {
        state.v[60][1] = speed;
        after = advance(body, state, {}, 1.0 / 24, options);
        ASSERT_EQ(after.report.warnings.size(), 1u);
        EXPECT_NE(after.report.warnings[0].find("even with 10000 substeps"), std::string::npos)
            << after.report.warnings[0];
    }
    // A row that goes all together passes the rows beside it, whichever way it lies.
    for (const int along : {0, 2}) {
        State rows = rest_state(body);
        for (std::size_t k = 0; k < rows.v.size(); ++k) {
            if (cubes.corner[k][along] == 4) rows.v[k][1] = 2.99 * 0.1 * 24 * 60;
        }
        EXPECT_EQ(advance(body, rows, {}, 1.0 / 24, options).report.warnings.size(), 1u) << along;
    }
}

TEST(PlaneLattice, WarnsHowManySubstepsItsMaterialNeeds)
{
    // What each particle has of its membrane, 2 dt^2 times the sum of its cells' E V / h^2 over its
    // mass, is 8 E dt^2 / (rho h^2) of any particle, less the (t / h)^2 that regions resist; steps
    // bear 2. So a frame of 1/24 s takes 2 sqrt(0.9975 E / rho) / h / 24 = 37.2 substeps.
    const Cubes cubes = sheet(6, 5, 1, 0.005);
    LatticeOptions options{.half_width = 1, .substeps = 37};
    const LatticeBody body = make_lattice(cubes, options);
    EXPECT_EQ(least_substeps(body, 1.0 / 24), 38);
    State state = advance(body, rest_state(body), {}, 1.0 / 24, options);
    ASSERT_EQ(state.report.warnings.size(), 1u);
    EXPECT_NE(state.report.warnings[0].find("need at least 38 substeps"), std::string::npos)
        << state.report.warnings[0];
    options.substeps = 38;
    state = advance(body, rest_state(body), {}, 1.0 / 24, options);
    EXPECT_TRUE(state.report.converged);
}

TEST(PlaneLattice, IsStableForAnyDampingAndStiffness)
{
    // Regions and membrane as stiff as they get leave little room below the limit of 4: a sheet
    // that is off its rest shape by less than a hundredth of a cell goes back to it.
    const Random random(9);
    for (const double bend : {0.05, 0.3, 1.0}) {
        for (const double damping : {0.01, 1.0, 1e6}) {
            LatticeOptions options = stiffest_plane();
            options.half_width = 1;
            options.bend = bend;
            options.damping = damping;
            const LatticeBody body = make_lattice(sheet(6, 5), options);
            State state = rest_state(body);
            for (std::size_t i = 0; i < state.x.size(); ++i) {
                for (std::size_t d = 0; d < 3; ++d) {
                    state.x[i][Eigen::Index(d)] += 1e-3 * (random.unit(3 * i + d) - 0.5);
                }
            }
            for (int f = 0; f < 40; ++f) state = advance(body, state, {}, 0.1, options);
            EXPECT_LT(misfit(rest_state(body), state), 2e-3) << bend << " " << damping;
        }
    }
}

TEST(PlaneLattice, FallsAndHangsOnItsPins)
{
    // A sheet held along one side ends up hanging straight down, as long as it was.
    LatticeOptions options{.damping = 0.05, .substeps = 20};
    const Cubes cubes = sheet(8, 4, 1, 0.004, 2e5);
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    Loads loads;
    loads.forces.push_back({});
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k][0] > 0) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(state.x[k]);
    }
    for (auto& v : body.base.mass_damping) ASSERT_EQ(v, 0);
    for (int frame = 0; frame < 240; ++frame) {
        state = advance(body, state, loads, 1.0 / 24, options);
        for (Vec3& v : state.v) v *= 0.97;
    }
    double lowest = 0;
    for (const Vec3& x : state.x) lowest = std::min(lowest, x[1]);
    EXPECT_NEAR(lowest, -0.8, 0.03);
}

TEST(PlaneLattice, ThreadsGiveTheSameBytes)
{
    const Cubes cubes = sheet(60, 50);
    LatticeOptions options{.half_width = 3, .substeps = 2};
    const LatticeBody body = make_lattice(cubes, options);
    Loads loads;
    loads.forces.push_back({});
    Force wind;
    wind.kind = Force::Kind::wind;
    wind.velocity = Vec3(1, 2, 3);
    loads.forces.push_back(wind);
    const auto run = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        State state = rest_state(body);
        for (Vec3& x : state.x) x[1] += 0.05 * std::sin(3 * x[0] + x[2]);
        for (int frame = 0; frame < 3; ++frame) {
            state = advance(body, state, loads, 1.0 / 24, options);
        }
        return state;
    };
    const State one = run(1);
    for (const std::size_t threads : {2u, 8u}) {
        const State many = run(threads);
        EXPECT_EQ(one.x, many.x);
        EXPECT_EQ(one.v, many.v);
        EXPECT_EQ(one.rotation, many.rotation);
    }
}

TEST(PlaneLattice, EveryProcessorGivesTheSameBytes)
{
    const Cubes cubes = sheet(23, 19);
    for (const int w : {1, 2, 3, 5}) {
        for (const Precision precision : {Precision::single, Precision::full}) {
            const LatticeOptions options{
                .half_width = w, .damping = 0.5, .substeps = 3, .precision = precision};
            const LatticeBody body = make_lattice(cubes, options);
            const auto run = [&] {
                State state = rest_state(body);
                for (Vec3& x : state.x) x[1] += 0.05 * std::sin(3 * x[0] + x[2]);
                state = advance(body, state, {}, 1.0 / 24, options);
                return advance(body, state, {}, 1.0 / 24, options);
            };
            const State first = run();
            on_every_target([&](const char* target) {
                const State again = run();
                EXPECT_EQ(again.x, first.x) << target << ", w = " << w;
                EXPECT_EQ(again.v, first.v) << target << ", w = " << w;
            });
        }
    }
}

TEST(PlaneLattice, WindDragsItByItsArea)
{
    // A stiff square sheet of 0.36 m^2 facing a wind u feels 1/2 rho C A u^2, on both sides by
    // half.
    const Cubes cubes = geometry::plane_cubes(geometry::rectangle_cells(6, 6), {2, 0.1, {0, 0, 0}},
                                              0.02, {"s", 500, 1e6, 0, 0, 0});
    const LatticeBody body = make_lattice(cubes, stiffest_plane());
    Loads loads;
    Force wind;
    wind.kind = Force::Kind::wind;
    wind.velocity = Vec3(0, 0, 10);
    wind.air_density = 1.2;
    wind.drag = 1;
    loads.forces.push_back(wind);
    LatticeOptions options = stiffest_plane();
    options.substeps = 1;
    const double dt = 1e-4, mass = 500 * 0.36 * 0.02;
    const State state = advance(body, rest_state(body), loads, dt, options);
    double momentum = 0;
    for (std::size_t i = 0; i < state.v.size(); ++i) momentum += body.base.mass[i] * state.v[i][2];
    EXPECT_NEAR(momentum / dt, 0.5 * 1.2 * 0.36 * 100, 1e-3 * 21.6);
    EXPECT_NEAR(mass, 3.6, 1e-12);
    // Drag is taken at the end of the step, so a sheet of 3.6 g goes with the wind and no faster:
    // v = u q / (1 + q) with q = 1/2 rho C A u dt / m.
    const Cubes light_cubes = geometry::plane_cubes(
        geometry::rectangle_cells(6, 6), {2, 0.1, {0, 0, 0}}, 0.02, {"s", 0.5, 1e3, 0, 0, 0});
    const LatticeBody light = make_lattice(light_cubes, stiffest_plane());
    const State follows = advance(light, rest_state(light), loads, 0.1, options);
    const double q = 0.5 * 1.2 * 0.36 * 10 * 0.1 / 0.0036;
    for (const Vec3& v : follows.v) EXPECT_NEAR(v[2], 10 * q / (1 + q), 1e-5);
}

TEST(PlaneLattice, BucklesWherePressedTogetherExactlyInItsPlane)
{
    // Its ends are pushed together by a fifth. Not a number leaves the plane by itself; the sheet
    // has a flaw that grows, and bows out: as one half wave, by 2 / pi sqrt(0.2) of its 1.2 m, as n
    // of them by an nth.
    const Cubes cubes = geometry::plane_cubes(geometry::rectangle_cells(12, 3), {1, 0.1, {0, 0, 0}},
                                              0.005, {"s", 500, 1e6, 0, 0, 0});
    const LatticeOptions options{.half_width = 1, .damping = 0.01, .substeps = 20};
    const LatticeBody body = make_lattice(cubes, options);
    State state = rest_state(body);
    for (int f = 1; f <= 48; ++f) {
        Loads loads;
        for (std::uint32_t k = 0; k < state.x.size(); ++k) {
            const int i = cubes.corner[k][0];
            if (i != 0 && i != 12) continue;
            const double in = 0.12 * std::min(1.0, f / 24.0);
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner_position(k) + Vec3(i == 0 ? in : -in, 0, 0));
        }
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
    }
    double most = 0;
    for (const Vec3& x : state.x) most = std::max(most, std::abs(x[1]));
    EXPECT_GT(most, 0.34 / 6);
    EXPECT_LT(most, 0.36);
}

TEST(PlaneLattice, InPlaneMotionFollowsForcesInThePlane)
{
    // Gravity at a slant, and a ball that comes down on it at a slant: all of it stays in the
    // plane, and goes along it with the momentum that gravity and the ball gave.
    LatticeOptions options{.plane = PlaneMotion::in_plane, .substeps = 8};
    const LatticeBody body = make_lattice(sheet(6, 5), options);
    Loads loads;
    Force gravity;
    gravity.acceleration = Vec3(2, -9, 0);
    loads.forces.push_back(gravity);
    Ball ball;
    ball.radius = 0.1;
    ball.mass = 0.5;
    ball.position = Vec3(0.3, 0.12, 0.25);
    ball.velocity = Vec3(0, -1, 1);
    loads.balls.push_back(ball);
    State state = rest_state(body);
    for (int f = 0; f < 6; ++f) state = advance(body, std::move(state), loads, 1.0 / 24, options);
    Vec3 momentum = state.balls[0].v * ball.mass;
    double mass = ball.mass;
    for (std::size_t i = 0; i < state.x.size(); ++i) {
        ASSERT_EQ(state.x[i][1], 0);
        ASSERT_EQ(state.v[i][1], 0);
        momentum += body.base.mass[i] * state.v[i];
        mass += body.base.mass[i];
    }
    EXPECT_NEAR(momentum[0], mass * 2 * 0.25, 1e-9 * mass);
    EXPECT_NEAR(momentum[2], ball.mass * 1, 1e-9 * mass);
    EXPECT_LT(state.balls[0].v[2], 0.9);  // the sheet took some of it
    loads.balls.clear();
    const State alone = advance(body, rest_state(body), loads, 1.0 / 24, options);
    for (const Vec3& x : alone.x) ASSERT_EQ(x[1], 0);
}

TEST(PlaneLattice, DampsOnlyWhatIsDamped)
{
    // Two sheets of one body in free flight, the second in a medium: nothing else slows them down.
    auto cells = geometry::rectangle_cells(6, 9);
    std::erase_if(cells, [](const auto& cell) { return cell[1] == 4; });
    Cubes cubes =
        geometry::plane_cubes(cells, {1, 0.1, {0, 0, 0}}, 0.02, {"sheets", 500, 1e6, 0, 0, 0});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        cubes.mass_damping[c] = cubes.cell[c][2] > 4 ? 3 : 0;
    }
    const LatticeBody body = make_lattice(cubes, {});
    State state = rest_state(body);
    const Vec3 v(1, 2, 3);
    state.v.assign(state.v.size(), v);
    for (int frame = 0; frame < 10; ++frame) state = advance(body, state, {}, 0.05, body.options);
    for (std::size_t k = 0; k < state.v.size(); ++k) {
        const double left = cubes.corner[k][2] > 4 ? std::exp(-3 * 0.5) : 1;
        // In single precision the way behind them rounds to 1e-7 m, over steps of 1/80 s.
        EXPECT_LT((state.v[k] - left * v).norm(), 1e-4) << k;
    }
}

TEST(PlaneLattice, TakesLessThanTwoHundredBytesPerParticle)
{
    for (const int axis : {0, 1, 2}) {
        const Cubes cubes = geometry::plane_cubes(geometry::rectangle_cells(100, 100),
                                                  {axis, 0.1, {0, 0, 0}}, 0.02);
        const LatticeBody body = make_lattice(cubes, {});
        const State state = advance(body, rest_state(body), {}, 0.04, body.options);
        const std::size_t of_state = state.x.size() * sizeof(Vec3) + state.v.size() * sizeof(Vec3) +
                                     state.rotation.size() * sizeof(float);
        EXPECT_LT(double(body.bytes() + of_state) / double(cubes.corner_count()), 200) << axis;
    }
}

// A sheet 0.02 m thick on a floor and a ball upon it: half of it is below what is drawn, half
// above.
TEST(PlaneLattice, LiesOnAFloorAndBearsABallAtHalfOfItsThickness)
{
    const Cubes cubes = sheet(4, 4);
    const LatticeBody body = make_lattice(cubes, {.half_width = 1, .substeps = 8});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    State state = rest_state(body);
    for (Vec3& x : state.x) x.y() = 0.05;
    Ball ball;
    ball.radius = 0.2;
    ball.mass = 0.05;
    ball.position = Vec3(0.15, 0.35, 0.15);  // over the middle of a cell
    loads.balls = {ball};
    LatticeOptions options = body.options;
    for (int f = 0; f < 48; ++f) {
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
    }
    for (const Vec3& x : state.x) EXPECT_NEAR(x.y(), 0.01, 1e-4);
    // On the middle of the cell, not sunk in among its corners.
    EXPECT_NEAR(state.balls[0].x.y(), 0.01 + 0.01 + 0.2, 3e-4);
}

// With its middle on the floor, half of it inside, it is lifted and not thrown, and beside its pins
// not at all, where a bit of the surface is held by little that could move.
TEST(PlaneLattice, StartsOnAFloorWithoutAHop)
{
    const Cubes cubes = sheet(4, 4);
    geometry::TriMesh surface = geometry::grid(0.4, 0.4, 41, 41);
    for (auto& p : surface.positions) p += geometry::Vec3f(0.2f, 0, 0.2f);
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].x() > 0) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(cubes.corner_position(k));
    }
    for (const geometry::TriMesh* linked : {static_cast<const geometry::TriMesh*>(nullptr),
                                            static_cast<const geometry::TriMesh*>(&surface)}) {
        const LatticeBody body = make_lattice(cubes, {.half_width = 1, .substeps = 40}, linked);
        State state = rest_state(body);
        double highest = 0;
        for (int f = 0; f < 24; ++f) {
            state = advance(body, std::move(state), loads, 1.0 / 24, body.options);
            for (const Vec3& x : state.x) highest = std::max(highest, x.y());
        }
        EXPECT_LT(highest, 0.012) << (linked != nullptr);
        EXPECT_GT(highest, 0.009);
    }
}

TEST(PlaneLattice, InPlaneMotionNeedsAPlane)
{
    EXPECT_THROW(
        make_lattice(geometry::solid_cubes({{0, 0, 0}}, 1), stiffest_plane(PlaneMotion::in_plane)),
        std::invalid_argument);
}
