#include "geometry/mesh/mesh.hpp"
#include "physics/modal/modes.hpp"

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "physics/state/cube_mass.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <numbers>

using namespace physics;
using fixtures::box;
using fixtures::cubes_on;
using fixtures::first_layer;
using geometry::Cubes;
using geometry::Vec3;

namespace {

using std::numbers::pi;

ModeSettings lowest(int count, bool keep_rigid = false)
{
    return {.count = count, .keep_rigid = keep_rigid};
}

double hertz(double omega_sq)
{
    return std::sqrt(omega_sq) / (2 * pi);
}

// The largest |phi_i^T M phi_j - delta_ij|.
double worst_orthonormality(const Cubes& cubes, const Modes& modes)
{
    double worst = 0;
    for (std::size_t i = 0; i < modes.shape.size(); ++i) {
        const auto momenta = brick_momenta(cubes, modes.shape[i]);
        for (std::size_t j = 0; j <= i; ++j) {
            double sum = 0;
            for (std::size_t k = 0; k < momenta.size(); ++k) {
                sum += momenta[k].dot(modes.shape[j][k]);
            }
            worst = std::max(worst, std::abs(sum - (i == j ? 1 : 0)));
        }
    }
    return worst;
}

}  // namespace

TEST(Modes, OfAnAxialChainAreTheClosedForm)
{
    // nu = 0 and corners that slide along x only in the lowest axial mode of a free-free bar of n
    // cubes, each with the mass 1, w of its mean velocity and of half the difference of its ends':
    // omega_j = (2 c / h) tan(j pi / 2 n) / sqrt(1 + w tan^2(j pi / 2 n)), c = sqrt(E / rho). They
    // are among all 84 - 6 modes.
    const int n = 6;
    const double h = 0.1;
    const Cubes cubes = box(n, 1, 1, h, {.density = 800, .young = 3e6, .poisson = 0});
    const Modes modes = lowest_modes(cubes, {}, lowest(78));
    const double c = std::sqrt(3e6 / 800);
    for (int j = 1; j <= n; ++j) {
        const double s = std::sin(j * pi / (2 * n)), t = std::cos(j * pi / (2 * n));
        const double omega = 2 * c / h * s / std::sqrt(t * t + mass_shares[1] * s * s);
        double nearest = 1e300;
        for (const double found : modes.omega_sq) {
            nearest = std::min(nearest, std::abs(std::sqrt(found) - omega));
        }
        EXPECT_LT(nearest, 1e-9 * omega) << j;
    }
}

TEST(Modes, OfASlenderCantileverAreTimoshenkos)
{
    // f = (beta L)^2 / (2 pi L^2) sqrt(EI / (rho A)), betas L 1.875104 and 4.694091 for bending,
    // each twice. L/h = 20: shear and rotary inertia lower the first by about 0.4 %, the second by
    // 2 %; a root clamped in all directions raises them by up to h / 3 L, 1.7 %. Axial: sqrt(E /
    // rho) / (4 L).
    const double h = 0.05, length = 1, young = 1e7, density = 1000;
    const Cubes cubes = box(20, 1, 1, h, {density, young, 0.3});
    const Modes modes = lowest_modes(cubes, first_layer(cubes), lowest(8));
    const double bending = std::sqrt(young * h * h / 12 / density) / (2 * pi * length * length);
    const double first = 1.875104 * 1.875104 * bending, second = 4.694091 * 4.694091 * bending;
    EXPECT_NEAR(hertz(modes.omega_sq[0]) / first, 1 - 0.004 + 0.01, 0.01);
    EXPECT_NEAR(hertz(modes.omega_sq[1]) / first, 1 - 0.004 + 0.01, 0.01);
    EXPECT_NEAR(hertz(modes.omega_sq[2]) / second, 1 - 0.02 + 0.01, 0.01);
    EXPECT_NEAR(hertz(modes.omega_sq[3]) / second, 1 - 0.02 + 0.01, 0.01);
    EXPECT_EQ(modes.rigid_left_out, 0);
    EXPECT_LT(worst_orthonormality(cubes, modes), 1e-10);
    EXPECT_LT(modes.report.residual, 1e-6);
}

TEST(Modes, OfASquareBeamComeInPairsAllFound)
{
    // Both bending directions have one frequency; a search from one start vector sees each once.
    const Cubes cubes = box(24, 2, 2, 0.05);
    const Modes modes = lowest_modes(cubes, first_layer(cubes), lowest(6));
    EXPECT_NEAR(modes.omega_sq[0], modes.omega_sq[1], 1e-8 * modes.omega_sq[0]);
    EXPECT_NEAR(modes.omega_sq[2], modes.omega_sq[3], 1e-8 * modes.omega_sq[2]);
    EXPECT_GT(modes.omega_sq[2], 10 * modes.omega_sq[1]);
    EXPECT_TRUE(std::is_sorted(modes.omega_sq.begin(), modes.omega_sq.end()));
}

TEST(Modes, OfManyEqualPiecesAreFoundForEveryPiece)
{
    // Eight equal free columns: 48 rigid motions, and each elastic frequency sixteen-fold (two
    // bending directions).
    std::vector<geometry::Vec3i> cells;
    for (int piece = 0; piece < 8; ++piece) {
        for (int y = 0; y < 6; ++y) cells.emplace_back(3 * piece, y, 0);
    }
    const Cubes cubes = cubes_on(cells, 0.1);
    const Modes modes = lowest_modes(cubes, {}, lowest(18));
    EXPECT_EQ(modes.rigid_left_out, 48);
    EXPECT_EQ(modes.rigid, 0);
    for (int i = 1; i < 16; ++i) {
        EXPECT_NEAR(modes.omega_sq[std::size_t(i)], modes.omega_sq[0], 1e-7 * modes.omega_sq[0]);
    }
    EXPECT_GT(modes.omega_sq[16], 1.1 * modes.omega_sq[0]);
    EXPECT_LT(worst_orthonormality(cubes, modes), 1e-9);
}

TEST(Modes, OfAFreeBodyLeaveOutOrKeepTheSixRigidMotions)
{
    const Cubes cubes = box(5, 4, 3, 0.1);
    const Modes elastic = lowest_modes(cubes, {}, lowest(5));
    const Modes all = lowest_modes(cubes, {}, lowest(11, true));
    EXPECT_EQ(elastic.rigid_left_out, 6);
    EXPECT_EQ(all.rigid, 6);
    EXPECT_EQ(all.rigid_left_out, 0);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(all.omega_sq[i], 0);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_GT(elastic.omega_sq[i], 0);
        EXPECT_NEAR(all.omega_sq[6 + i], elastic.omega_sq[i], 1e-9 * elastic.omega_sq[i]);
    }
    EXPECT_LT(worst_orthonormality(cubes, all), 1e-9);
}

TEST(Modes, KnowWhichRigidMotionsPinsLeave)
{
    // One pinned corner leaves three rotations, two leave the hinge between them, three none.
    const Cubes cubes = box(3, 2, 2, 0.1);
    EXPECT_EQ(lowest_modes(cubes, {0}, lowest(1)).rigid_left_out, 3);
    EXPECT_EQ(lowest_modes(cubes, {0, 1}, lowest(1)).rigid_left_out, 1);
    EXPECT_EQ(lowest_modes(cubes, {0, 1, 2}, lowest(1)).rigid_left_out, 1);  // on one line
    EXPECT_EQ(lowest_modes(cubes, {0, 1, 5}, lowest(1)).rigid_left_out, 0);
}

TEST(Modes, LanczosAgreesWithTheDenseSolver)
{
    // 90 corners, 270 unknowns: the sparse way for few modes, the dense one for many.
    const Cubes cubes = box(5, 4, 2, 0.1);
    const Modes few = lowest_modes(cubes, {}, lowest(12)),
                many = lowest_modes(cubes, {}, lowest(200));
    ASSERT_GT(few.report.iterations, 0);
    ASSERT_EQ(many.report.iterations, 0);
    for (std::size_t i = 0; i < 12; ++i) {
        EXPECT_NEAR(few.omega_sq[i], many.omega_sq[i], 1e-9 * many.omega_sq[i]);
    }
}

TEST(Modes, AreFoundAfterTheBasisIsCutToTheBest)
{
    // Columns whose frequencies lie close together: to tell the lowest takes more than the 160
    // vectors that are kept for one mode.
    constexpr int pieces = 30;
    const auto lowest_of = [](int first, int last) {
        std::vector<geometry::Vec3i> cells;
        for (int piece = first; piece < last; ++piece) {
            for (int x = 0; x < 4; ++x) cells.emplace_back(x, 3 * piece, 0);
        }
        Cubes cubes = cubes_on(cells, 0.1);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            cubes.young[c] *= 1 + 1e-4 * std::abs(cubes.cell[c].y() / 3 - 11);
        }
        return lowest_modes(cubes, first_layer(cubes), lowest(1));
    };
    const Modes all = lowest_of(0, pieces), one = lowest_of(11, 12);
    EXPECT_GT(all.report.iterations, 160);
    EXPECT_TRUE(all.report.converged);
    EXPECT_NEAR(all.omega_sq[0] / one.omega_sq[0], 1, 1e-9);
    EXPECT_LT(all.report.residual, 1e-6);
}

TEST(Modes, LeaveOutHingesAndSayIt)
{
    // Two cubes that share one edge turn about it at no cost.
    const Cubes cubes = cubes_on({{0, 0, 0}, {1, 1, 0}}, 0.1);
    const Modes modes = lowest_modes(cubes, {}, lowest(4));
    EXPECT_EQ(modes.rigid_left_out, 6);
    ASSERT_EQ(modes.report.warnings.size(), 1u);
    EXPECT_EQ(modes.omega_sq.size(), 3u);
    for (const double omega_sq : modes.omega_sq) EXPECT_GT(omega_sq, 1);
}

// n cubes in a row, the last two of them of another stiffness.
Cubes beam_with_tip(int n, double young)
{
    Cubes beam = box(n, 1, 1, 0.02, {.young = 1e4, .poisson = 0.3});
    for (std::size_t c = beam.count() - 2; c < beam.count(); ++c) beam.young[c] = young;
    return beam;
}

TEST(Modes, OfASoftBeamWithATipOfSteelAreThoseOfOneWithARigidTip)
{
    for (const int n : {20, 30, 40}) {
        const Cubes rigid = beam_with_tip(n, 1e7), steel = beam_with_tip(n, 2e11);
        const Modes expected = lowest_modes(rigid, first_layer(rigid), lowest(4));
        const Modes found = lowest_modes(steel, first_layer(steel), lowest(4));
        EXPECT_TRUE(found.report.warnings.empty()) << found.report.warnings[0];
        ASSERT_EQ(found.omega_sq.size(), 4u);
        // Rounding of steel leaves 1e-3 of the lowest: eps * 2e11 Pa * h / m beside omega^2 m.
        for (std::size_t i = 0; i < 4; ++i) {
            EXPECT_NEAR(hertz(found.omega_sq[i]) / hertz(expected.omega_sq[i]), 1, 2e-3) << n;
        }
    }
}

TEST(Modes, TooLowToBeKnownBesideAStiffTipAreToldAsSuch)
{
    const Cubes cubes = beam_with_tip(60, 1e13);
    const Modes modes = lowest_modes(cubes, first_layer(cubes), lowest(4));
    EXPECT_EQ(modes.omega_sq.size(), 2u);
    ASSERT_EQ(modes.report.warnings.size(), 1u);
    EXPECT_EQ(modes.report.warnings[0].rfind("2 of the lowest modes were left out: their", 0), 0u)
        << modes.report.warnings[0];
}

TEST(Modes, OfALongThinBeamAreThoseOfTheBook)
{
    // Euler-Bernoulli: omega = 3.516 sqrt(E I / (rho A L^4)), with h^2 / 12 for I / A. The lowest
    // of 2,000 cubes is 6e-14 of the largest.
    const int n = 2000;
    const Cubes beam = box(n, 1, 1, 0.1, {.young = 1e9, .poisson = 0.3});
    const Modes modes = lowest_modes(beam, first_layer(beam), lowest(2));
    const double exact = 3.516 * std::sqrt(1e9 / 1000 / 12 * 0.01 / std::pow(0.1 * n, 4));
    EXPECT_TRUE(modes.report.warnings.empty());
    ASSERT_EQ(modes.omega_sq.size(), 2u);
    for (const double omega_sq : modes.omega_sq) {
        EXPECT_NEAR(std::sqrt(omega_sq) / exact, 1, 5e-3);
    }
}

TEST(Modes, AreFoundBesideManyHinges)
{
    // Blocks that hang together by edges alone turn about them at no cost: 11 motions, beside which
    // the others are 1e-8 as large in the search.
    std::vector<geometry::Vec3i> cells;
    for (int piece = 0; piece < 12; ++piece) {
        for (int x = 0; x < 2; ++x) {
            for (int y = 0; y < 2; ++y) cells.emplace_back(2 * piece + x, 2 * piece + y, 0);
        }
    }
    const Cubes cubes = cubes_on(cells, 0.1);
    const Modes few = lowest_modes(cubes, {}, lowest(20)),
                many = lowest_modes(cubes, {}, lowest(190));
    ASSERT_GT(few.report.iterations, 0);
    ASSERT_EQ(many.report.iterations, 0);
    EXPECT_TRUE(few.report.converged);
    ASSERT_EQ(few.omega_sq.size(), 9u);
    for (std::size_t i = 0; i < few.omega_sq.size(); ++i) {
        EXPECT_NEAR(few.omega_sq[i], many.omega_sq[i], 1e-6 * many.omega_sq[i]) << i;
    }
}

TEST(Modes, CarryTheMaterialsRayleighDamping)
{
    // C = alpha M + beta K with one alpha and beta everywhere: phi^T C phi = alpha + beta omega^2.
    Cubes cubes = box(6, 2, 1, 0.2);  // of 8 kg each
    cubes.mass_damping.assign(cubes.count(), 0.5);
    cubes.stiffness_damping.assign(cubes.count(), 1e-3);
    const Modes modes = lowest_modes(cubes, first_layer(cubes), lowest(5));
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(modes.damping[i], 0.5 + 1e-3 * modes.omega_sq[i], 1e-8 * modes.damping[i]);
    }
}

TEST(Modes, OfHalfFilledCubesAreThoseOfFullOnesWithHalfMass)
{
    // Stiffness and mass scale alike: the frequencies stay. Counted as full stiffness: sqrt(2) up.
    Cubes cubes = box(6, 2, 1, 0.1);
    const auto pins = first_layer(cubes);
    const Modes full = lowest_modes(cubes, pins, lowest(3));
    for (auto& m : cubes.mass) m /= 2;
    for (auto& f : cubes.fill) f /= 2;
    const Modes half = lowest_modes(cubes, pins, lowest(3));
    const Modes stiff = lowest_modes(cubes, pins, {.count = 3, .weighting = Weighting::full});
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(half.omega_sq[i], full.omega_sq[i], 1e-9 * full.omega_sq[i]);
        EXPECT_NEAR(stiff.omega_sq[i], 2 * full.omega_sq[i], 1e-8 * full.omega_sq[i]);
    }
}

TEST(Modes, RefusesBadInputAndSaysWhatWasExpected)
{
    const auto message = [](const Cubes& cubes, const std::vector<std::uint32_t>& pins, int count) {
        try {
            lowest_modes(cubes, pins, lowest(count));
        } catch (const std::invalid_argument& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    const Cubes cube = box(1, 1, 1, 0.1);
    EXPECT_NE(message({}, {}, 1).find("no"), std::string::npos);
    EXPECT_NE(message(cube, {}, 0).find("at least one mode"), std::string::npos);
    // 24 unknowns, 6 rigid: 18 elastic modes.
    EXPECT_EQ(message(cube, {}, 18), "nothing");
    EXPECT_NE(message(cube, {}, 19).find("at most 18"), std::string::npos);
    EXPECT_NE(message(cube, {0, 1, 2, 3, 4, 5, 6, 7}, 1).find("every corner pinned"),
              std::string::npos);
    EXPECT_NE(message(cube, {99}, 1).find("below 8"), std::string::npos);
    Cubes weightless = cube;
    weightless.mass[0] = 0;
    EXPECT_NE(message(weightless, {}, 1).find("mass"), std::string::npos);
}

// Teeth that stand on a bar below y = 0, in the given places along x: 8 cubes high and 1.5 wide.
static geometry::TriMesh comb(const std::vector<int>& teeth)
{
    const auto block = [](const Vec3& lo, const Vec3& hi) {
        geometry::TriMesh mesh = geometry::box(hi - lo, {1, 1, 1});
        move(mesh, geometry::placement((lo + hi) / 2, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}));
        return mesh;
    };
    std::vector<geometry::TriMesh> parts{block({0, -1, 0}, {9.5, 0, 1})};
    for (const int i : teeth) parts.push_back(block({2.0 * i, 0, 0}, {2.0 * i + 1.5, 8, 1}));
    std::vector<const geometry::TriMesh*> all;
    for (const geometry::TriMesh& part : parts) all.push_back(&part);
    return geometry::merge(all);
}

static double lowest_of_comb(const std::vector<int>& teeth, geometry::NearPieces pieces, int mode)
{
    const Cubes cubes =
        voxelize_solid(comb(teeth), {{}, {{}}, {}}, geometry::Inside::winding, 0,
                       {1, Vec3::Zero(), geometry::Vec3i::Zero()}, {.pieces = pieces});
    std::vector<std::uint32_t> held;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (cubes.corner[k].y() <= 0) held.push_back(k);
    }
    const Modes modes = lowest_modes(cubes, held, lowest(mode + 1));
    return std::sqrt(modes.omega_sq[static_cast<std::size_t>(mode)]);
}

TEST(Modes, OfACombAreThoseOfOneToothWhereGapsAreHalfACube)
{
    // The lowest mode of one tooth is bending along z; five teeth have it five times over.
    const auto apart = geometry::NearPieces::apart, merge = geometry::NearPieces::merge;
    const double one = lowest_of_comb({2}, apart, 0);
    EXPECT_NEAR(one, lowest_of_comb({2}, merge, 0), 1e-9 * one);
    const std::vector<int> five{0, 1, 2, 3, 4};
    EXPECT_NEAR(lowest_of_comb(five, apart, 0), one, 1e-3 * one);
    EXPECT_NEAR(lowest_of_comb(five, apart, 4), one, 1e-3 * one);
    // Bending along x comes next. Merged, the teeth brace each other.
    const double along = lowest_of_comb({2}, apart, 1);
    EXPECT_NEAR(lowest_of_comb(five, apart, 5), along, 1e-3 * along);
    EXPECT_NEAR(lowest_of_comb(five, apart, 9), along, 1e-3 * along);
    EXPECT_GT(lowest_of_comb(five, merge, 4), 1.5 * one);
}
