// The mass of bricks: what a body of few cubes resists turning by, and the frequencies that follow.

#include "physics/state/cube_mass.hpp"

#include "geometry/base/random.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/modal/modes.hpp"
#include "physics/state/first_motion.hpp"
#include "physics/state/measure.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace {

using namespace physics;
using fixtures::box;
using geometry::Cubes;
using geometry::Random;

constexpr double pi = std::numbers::pi;

std::vector<Vec3> random_field(std::size_t count)
{
    const Random random(3);
    std::vector<Vec3> out;
    for (std::size_t k = 0; k < count; ++k) {
        out.emplace_back(random.unit(3 * k) - 0.5, random.unit(3 * k + 1) - 0.5,
                         random.unit(3 * k + 2) - 0.5);
    }
    return out;
}

TEST(CubeMass, WeighsEachMonomialByItsDegree)
{
    // v = xi^m at the corners has c_m = 1 and no other: v^T M v = w_m, and M v = w_m / 8 v.
    const CubeMass mass = cube_mass_matrix();
    for (unsigned m = 0; m < 8; ++m) {
        std::size_t degree = 0;
        for (unsigned axis = 0; axis < 3; ++axis) degree += m >> axis & 1;
        const auto sign = [&](unsigned a) {
            double s = 1;
            for (unsigned axis = 0; axis < 3; ++axis) {
                if ((m >> axis & 1) != 0) s *= (a >> axis & 1) != 0 ? 1 : -1;
            }
            return s;
        };
        for (unsigned a = 0; a < 8; ++a) {
            double sum = 0;
            for (unsigned b = 0; b < 8; ++b) sum += mass[a][b] * sign(b);
            EXPECT_NEAR(sum, mass_shares[degree] * sign(a) / 8, 1e-15) << m;
        }
    }
}

TEST(CubeMass, OfBricksThatMoveIsThatOfTheirCubes)
{
    // Over blocks, pieces and copies of shared corners.
    Cubes cubes = box(23, 11, 7, 0.1);
    const Random random(5);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        cubes.mass[c] *= 0.1 + random.unit(2 * c);
        cubes.mass_damping[c] = random.unit(2 * c + 1);
    }
    const BricksBody body = make_bricks(cubes);
    const auto elasticity = elasticity_of(body, {});
    const auto v = random_field(cubes.corner_count());
    Cubes damped = cubes;
    for (std::size_t c = 0; c < cubes.count(); ++c) damped.mass[c] *= cubes.mass_damping[c];
    for (const Lumped of : {Lumped::mass, Lumped::damping}) {
        const auto expected = brick_momenta(of == Lumped::mass ? cubes : damped, v);
        const auto& lumped = of == Lumped::mass ? body.base.mass : body.base.mass_damping;
        Aligned<double> excess(elasticity->room(), 0);
        ASSERT_TRUE(elasticity->excess(of, by_slot(body.base, v).data(), excess.data()));
        for (std::size_t k = 0; k < v.size(); ++k) {
            const std::size_t at = body.base.slot_of(k);
            const Vec3 less(excess[4 * at], excess[4 * at + 1], excess[4 * at + 2]);
            EXPECT_LT((lumped[at] * v[k] - less - expected[k]).norm(), 1e-14) << k;
        }
    }
}

TEST(CubeMass, OfOnePointBricksIsLumped)
{
    const Cubes cubes = box(3, 2, 2, 0.1);
    const BricksBody body = make_bricks(cubes, {.element = BrickElement::one_point});
    const auto elasticity = elasticity_of(body, {});
    Aligned<double> v(elasticity->room(), 1), y(elasticity->room(), 0);
    EXPECT_FALSE(elasticity->excess(Lumped::mass, v.data(), y.data()));
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.v.size(); ++k) state.v[k] = Vec3(0, state.x[k].x(), 0);
    const auto mass = geometry::corner_masses(cubes);
    double expected = 0;
    for (std::size_t k = 0; k < mass.size(); ++k)
        expected += 0.5 * mass[k] * state.v[k].squaredNorm();
    EXPECT_NEAR(kinetic_energy(state, cubes), expected, 1e-14);
    state.brick_mass = true;
    EXPECT_LT(kinetic_energy(state, cubes), 0.99 * expected);
}

TEST(CubeMass, TheLinearSolverKnowsTheSameMass)
{
    // K + M of a body at rest, its rows and its diagonal, with each precision.
    const Cubes cubes = box(5, 3, 2, 0.1, {.young = 10, .mass_damping = 2});
    const BricksBody body = make_bricks(cubes);
    const auto elasticity = elasticity_of(body, {});
    const auto v = random_field(cubes.corner_count());
    const Aligned<double> p = by_slot(body.base, v);
    Aligned<double> x = body.base.rest, plain(elasticity->room()), coupled = plain, force = plain;
    elasticity->forces(x.data(), force.data());
    elasticity->weigh(1, 0);
    elasticity->multiply(p.data(), plain.data());
    elasticity->couple(3, 0.5);
    elasticity->multiply(p.data(), coupled.data());
    Aligned<double> mass(elasticity->room()), diagonal(p.size(), 0), own(p.size(), 0);
    elasticity->excess(Lumped::mass, p.data(), mass.data());
    elasticity->add_diagonal(diagonal.data());
    for (std::size_t i = 0; i < p.size(); ++i) {
        EXPECT_NEAR(coupled[i], plain[i] - (3 + 0.5 * 2) * mass[i], 1e-13) << i;
    }
    for (std::size_t k = 0; k < cubes.corner_count(); ++k) {
        Aligned<double> unit(p.size(), 0), row(elasticity->room());
        unit[4 * k] = 1;
        elasticity->multiply(unit.data(), row.data());
        EXPECT_NEAR(row[4 * k], diagonal[4 * k], 1e-12 * std::abs(diagonal[4 * k])) << k;
    }
    elasticity->couple(0, 0);
    elasticity->multiply(p.data(), coupled.data());
    EXPECT_EQ(coupled, plain);
}

TEST(CubeMass, TurnsABodyTwoCubesThickByItsInertia)
{
    // About the long axis of a bar n cubes thick: 1 + (3 w - 1) / n^2 of m a^2 / 6. Corners that
    // carry an eighth each have 3, 1.5 and 1.125 of it.
    for (const int n : {1, 2, 4}) {
        const Cubes cubes = box(5 * n, n, n, 0.1 / n);
        State state = rest_state(make_bricks(cubes));
        add_first_motion(state, cubes, Vec3::Zero(), Vec3(1, 0, 0));
        const double exact = total_mass(cubes) * 0.1 * 0.1 / 6;
        const double found = 2 * kinetic_energy(state, cubes) / exact;
        EXPECT_NEAR(found, 1 + (3 * mass_shares[1] - 1) / (n * n), 1e-12);
        if (n >= 2) {
            EXPECT_NEAR(found, 1, 0.02) << n;
        }
        // Moved as a whole, it has its mass.
        State moved = rest_state(make_bricks(cubes));
        add_first_motion(moved, cubes, Vec3(1, 2, 2), Vec3::Zero());
        EXPECT_NEAR(kinetic_energy(moved, cubes), 4.5 * total_mass(cubes), 1e-12);
    }
}

// The lowest frequency (Hz) of a free bar ten times as long as thick among modes that `is` accepts.
template <class Is> double bar_frequency(int n, const Is& is)
{
    const Cubes cubes = box(10 * n, n, n, 0.1 / n);
    const Modes modes = lowest_modes(cubes, {}, {.count = 9});
    for (std::size_t i = 0; i < modes.shape.size(); ++i) {
        if (is(cubes, modes.shape[i])) return std::sqrt(modes.omega_sq[i]) / (2 * pi);
    }
    return 0;
}

// Mean motion of an end of the bar, and how far its corners move.
std::pair<Vec3, double> end_motion(const Cubes& cubes, const std::vector<Vec3>& phi)
{
    Vec3 mean = Vec3::Zero();
    double all = 0, count = 0;
    for (std::size_t k = 0; k < phi.size(); ++k) {
        if (cubes.corner[k].x() != 0) continue;
        mean += phi[k], all += phi[k].norm(), count += 1;
    }
    return {mean / count, all / count};
}

TEST(CubeMass, ABarOneCubeThickTwistsWithin5PercentOfItsFrequency)
{
    // f = sqrt(G J / (rho I_p)) / 2 L with J = 0.140577 a^4 of a square, I_p = a^4 / 6. Bricks
    // twist without the bend of their faces, as J = a^4 / 6 one cube thick: 9 % too fast, less half
    // of that for the mass. Lumped mass has 0.63, 0.89, 0.97.
    const double shear = 1e6 / 2.6, density = 1000;
    const double exact = std::sqrt(shear * 0.140577 * 6 / density) / 2;
    const auto twists = [](const Cubes& cubes, const std::vector<Vec3>& phi) {
        const auto [mean, all] = end_motion(cubes, phi);
        return mean.norm() < 0.1 * all;
    };
    EXPECT_NEAR(bar_frequency(1, twists) / exact, 1, 0.05);
    EXPECT_NEAR(bar_frequency(2, twists) / exact, 1, 0.09);
    EXPECT_NEAR(bar_frequency(4, twists) / exact, 1, 0.03);
}

TEST(CubeMass, ABarOneCubeThickStretchesWithin1PercentOfItsFrequency)
{
    // f = sqrt(E / rho) / 2 L; (pi / 10)^2 / 24 = 0.4 % from cubes this long, either way.
    const double exact = std::sqrt(1e6 / 1000) / 2;
    const auto stretches = [](const Cubes& cubes, const std::vector<Vec3>& phi) {
        const auto [mean, all] = end_motion(cubes, phi);
        return std::abs(mean.x()) > 0.9 * all;
    };
    EXPECT_NEAR(bar_frequency(1, stretches) / exact, 1, 0.01);
    EXPECT_NEAR(bar_frequency(2, stretches) / exact, 1, 0.005);
}

TEST(CubeMass, SimulatedAndModalVibrationAgree)
{
    // Let go with the velocity of a mode, a body is back at rest's place after half its period.
    const Cubes cubes = box(6, 1, 1, 0.1, {.young = 1e6});
    const BricksBody body = make_bricks(cubes);
    Loads loads;
    loads.pins.corner = fixtures::first_layer(cubes);
    for (const auto k : loads.pins.corner) loads.pins.target.push_back(cubes.corner_position(k));
    const Modes modes = lowest_modes(cubes, loads.pins.corner, {.count = 5});
    for (const std::size_t mode : {std::size_t{0}, std::size_t{2}, std::size_t{4}}) {
        State state = rest_state(body);
        const double small = 1e-5;
        for (std::size_t k = 0; k < state.v.size(); ++k) state.v[k] = small * modes.shape[mode][k];
        const double omega = std::sqrt(modes.omega_sq[mode]);
        const StepOptions options{.integrator = Integrator::implicit_midpoint, .tolerance = 1e-8};
        constexpr int steps = 100;
        for (int i = 0; i < steps; ++i)
            state = advance(body, state, loads, pi / omega / steps, options);
        double moved = 0, speed = 0;  // along the mode, by its largest
        const auto momenta = brick_momenta(cubes, modes.shape[mode]);
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            moved += momenta[k].dot(state.x[k] - cubes.corner_position(k));
            speed += momenta[k].dot(state.v[k]);
        }
        EXPECT_NEAR(speed, -small, 1e-3 * small) << mode;
        EXPECT_NEAR(moved, 0, 2e-3 * small / omega) << mode;
    }
}

TEST(CubeMass, DampingWithTheMassSlowsASpinAtItsRate)
{
    // C = alpha M: whatever the shape, momenta go as 1 / (1 + alpha dt) a step of implicit Euler.
    const double alpha = 2, dt = 1.0 / 24;
    const Cubes cubes = box(4, 1, 1, 0.1, {.young = 1e8, .mass_damping = alpha});
    const BricksBody body = make_bricks(cubes);
    State state = rest_state(body);
    add_first_motion(state, cubes, Vec3(0.1, 0, 0), Vec3(3, 0, 0));
    const auto before = fixtures::brick_motion(cubes, state);
    for (int i = 0; i < 24; ++i) state = advance(body, state, {}, dt);
    const auto after = fixtures::brick_motion(cubes, state);
    const double left = std::pow(1 / (1 + alpha * dt), 24);
    EXPECT_NEAR(after.linear.x(), left * before.linear.x(), 1e-6 * before.linear.x());
    EXPECT_NEAR(after.angular.x(), left * before.angular.x(), 0.01 * left * before.angular.x());
}

}  // namespace
