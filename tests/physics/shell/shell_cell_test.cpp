// What one cell of a shell costs, and its derivatives.

#include "geometry/base/random.hpp"
#include "physics/shell/shell_cell.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include <cmath>

using namespace physics;

namespace {

constexpr ShellCell matter{.shear = 1.5, .bulk = 0.7, .plane_bend = 0.3, .twist = 0.05};

ShellVector sides(const Vec3& f1, const Vec3& f2, const Vec3& g)
{
    ShellVector out;
    out << f1, f2, g;
    return out;
}

// Near rest times `size`, bent, sheared and turned by chance.
ShellVector by_chance(std::uint64_t seed, double size, double change)
{
    const geometry::Random random(seed);
    ShellVector out = sides({1, 0, 0}, {0, 1, 0}, {0, 0, 0}) * size;
    for (std::uint64_t i = 0; i < 9; ++i) {
        out[Eigen::Index(i)] += change * (2 * random.unit(i) - 1);
    }
    return out;
}

}  // namespace

TEST(ShellCell, CostsWhatItsStretchesSay)
{
    // Stretches 1.2 and 0.9, turned anyhow: 1/2 1.5 (0.2^2 + 0.1^2) + 1/2 0.7 (0.2 - 0.1)^2.
    const Eigen::AngleAxisd turn(1.1, Vec3(1, 2, -1).normalized());
    const Eigen::AngleAxisd within(0.4, Vec3::UnitZ());
    const geometry::Mat3 along = within.toRotationMatrix();
    const geometry::Mat3 f = turn * along * Vec3(1.2, 0.9, 1).asDiagonal() * along.transpose();
    const auto cost = cell_energy(matter, sides(f.col(0), f.col(1), Vec3::Zero()), Curvature::none);
    EXPECT_NEAR(cost.energy, 0.75 * 0.05 + 0.35 * 0.01, 1e-15);
    // A twist g along the normal: both squared sides are longer by g^2 / 12, and 1/2 twist g^2.
    const double g = 0.3, s = std::sqrt(1 + g * g / 12);
    const auto twisted =
        cell_energy(matter, sides({1, 0, 0}, {0, 1, 0}, {0, 0, g}), Curvature::none);
    EXPECT_NEAR(twisted.energy, 0.025 * g * g + 1.5 * std::pow(s - 1, 2) + 1.4 * std::pow(s - 1, 2),
                1e-15);
    // A bend within the plane: 1/2 plane_bend |g|^2, and the same stretch.
    const auto bent = cell_energy(matter, sides({1, 0, 0}, {0, 1, 0}, {g, 0, 0}), Curvature::none);
    EXPECT_NEAR(bent.energy - twisted.energy, 0.15 * g * g, 1e-15);
}

TEST(ShellCell, ItsDerivativesAreThoseOfItsEnergy)
{
    // Central differences err by e^2 = 1e-10 of third derivatives of about 10.
    constexpr double e = 1e-5;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const ShellVector at = by_chance(seed, seed % 2 ? 1.1 : 0.6, 0.4);
        const CellEnergy here = cell_energy(matter, at, Curvature::whole);
        for (Eigen::Index i = 0; i < 9; ++i) {
            const ShellVector step = e * ShellVector::Unit(i);
            const CellEnergy more = cell_energy(matter, at + step, Curvature::none);
            const CellEnergy less = cell_energy(matter, at - step, Curvature::none);
            EXPECT_NEAR((more.energy - less.energy) / (2 * e), here.slope[i], 1e-8) << seed << i;
            const ShellVector bend = (more.slope - less.slope) / (2 * e);
            EXPECT_LT((bend - here.curvature.col(i)).norm(), 1e-6) << seed << ' ' << i;
        }
    }
}

TEST(ShellCell, TheCurvatureThatIsKeptIsNeverNegative)
{
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
        const ShellVector at = by_chance(seed, 0.1 * double(seed % 20), 0.5);
        const auto kept = cell_energy(matter, at, Curvature::positive).curvature;
        EXPECT_LT((kept - kept.transpose()).norm(), 1e-14);
        const Eigen::SelfAdjointEigenSolver<ShellMatrix> eigen(kept);
        EXPECT_GT(eigen.eigenvalues()[0], -1e-13) << seed;
    }
    // Where a flat cell is stretched all ways, all of it is kept.
    const ShellVector wide = sides({1.2, 0.1, 0}, {0, 0, 1.3}, {0, 0, 0});
    const auto kept = cell_energy(matter, wide, Curvature::positive).curvature;
    EXPECT_LT((kept - cell_energy(matter, wide, Curvature::whole).curvature).norm(), 1e-14);
}

TEST(ShellCell, ThatHasCollapsedIsPulledOpen)
{
    // To a line: the side that is left has no force across it, and the other is pulled with
    // 2 mu + lambda (T - 2 = -1) by what little there is of it.
    const auto line =
        cell_energy(matter, sides({1, 0, 0}, {0, 1e-6, 0}, {0, 0, 0}), Curvature::whole);
    EXPECT_NEAR(line.slope[4], -1.5 - 0.7, 1e-5);
    const auto point = cell_energy(matter, ShellVector::Zero(), Curvature::positive);
    EXPECT_TRUE(point.slope.allFinite() && point.curvature.allFinite());
}
