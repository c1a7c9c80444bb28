// The stretch of planes, corner by corner, against singular values and finite differences.

#include "physics/lattice/membrane.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"

#include <gtest/gtest.h>

using namespace physics;
using geometry::Random;
using geometry::Vec3;
using Links = Eigen::Matrix<double, 3, 2>;

namespace {

// A sheet of 3 x 2 cells of 0.2 m with one missing, of shares that differ.
struct Sheet {
    geometry::Cubes cubes;
    Membrane membrane;
    std::vector<double> share;
    std::vector<Vec3> x;

    explicit Sheet(int axis = 1)
    {
        auto cells = geometry::rectangle_cells(3, 2);
        std::erase(cells, std::array{1, 1});
        cubes =
            geometry::plane_cubes(cells, {axis, 0.2, {0, 0, 0}}, 0.01, {"s", 500, 1e6, 0, 0, 0});
        membrane = make_membrane(cubes, axis);
        for (std::size_t c = 0; c < cubes.count(); ++c) share.push_back(1 + 0.3 * double(c));
        x = geometry::corner_positions(cubes);
    }

    void shake(double by, std::uint64_t seed)
    {
        const Random random(seed);
        for (std::size_t i = 0; i < x.size(); ++i) {
            for (std::size_t d = 0; d < 3; ++d) {
                x[i][Eigen::Index(d)] += by * (2 * random.unit(3 * i + d) - 1);
            }
        }
    }

    // U, kg m^2, by the singular values of each corner's links: |F - R|^2 is the sum of
    // (sigma - 1)^2.
    double energy(const MembraneState& state = {}) const
    {
        double sum = 0;
        membrane.for_each_cell([&](std::size_t c, const Membrane::Cell& p) {
            for (unsigned corner = 0; corner < 4; ++corner) {
                if (!state.torn.empty() && (state.torn[c] >> corner & 1u)) continue;
                const std::size_t u = corner & 2u, v = corner & 1u;
                Links f;
                f << x[p[u + 1]] - x[p[u]], x[p[v + 2]] - x[p[v]];
                f /= membrane.h;
                if (!state.rest.empty()) {
                    const float* const s = state.rest.data() + 3 * c;
                    Eigen::Matrix2d inverse;
                    inverse << double(s[0]), double(s[1]), double(s[1]), double(s[2]);
                    f = (f * inverse).eval();
                }
                const Eigen::JacobiSVD<Links> svd(f);
                sum += (svd.singularValues() - Eigen::Vector2d::Ones()).squaredNorm() / 4 *
                       share[c] * membrane.h * membrane.h / 2;
            }
        });
        return sum;
    }

    template <class T> std::vector<Vec3> pulls(const MembraneState& state = {}) const
    {
        MembranePull<T> pull;
        const std::vector<T> cast(share.begin(), share.end());
        pull.pull(membrane, state, cast, x);
        std::vector<T> quads(4 * x.size());
        pull.gather(membrane, 0, x.size(), quads.data());
        std::vector<Vec3> out;
        for (std::size_t i = 0; i < x.size(); ++i) {
            EXPECT_EQ(quads[4 * i + 3], T(0));
            out.emplace_back(quads[4 * i], quads[4 * i + 1], quads[4 * i + 2]);
        }
        return out;
    }

    // The largest difference of `pulls` and central differences of U.
    double misfit(const MembraneState& state = {})
    {
        const auto pull = pulls<double>(state);
        constexpr double e = 1e-6;
        double worst = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            for (Eigen::Index d = 0; d < 3; ++d) {
                const double at = x[i][d];
                x[i][d] = at + e;
                const double above = energy(state);
                x[i][d] = at - e;
                const double below = energy(state);
                x[i][d] = at;
                worst = std::max(worst, std::abs(pull[i][d] + (above - below) / (2 * e)));
            }
        }
        return worst;
    }
};

}  // namespace

TEST(Membrane, HasTheCellsOfItsPlane)
{
    for (const int axis : {0, 1, 2}) {
        auto cells = geometry::rectangle_cells(70, 5);
        std::erase(cells, std::array{30, 2});
        const auto cubes = geometry::plane_cubes(cells, {axis, 0.2, {0, 0, 0}}, 0.01);
        const Membrane membrane = make_membrane(cubes, axis);
        const std::size_t u = std::size_t{1} << membrane.axes[0];
        const std::size_t v = std::size_t{1} << membrane.axes[1];
        std::size_t next = 0;
        membrane.for_each_cell([&](std::size_t c, const Membrane::Cell& cell) {
            EXPECT_EQ(c, next++);
            const auto& k = cubes.corners[c];
            EXPECT_EQ(cell, (Membrane::Cell{k[0], k[u], k[v], k[u | v]})) << axis << ' ' << c;
        });
        EXPECT_EQ(next, cubes.count());
        EXPECT_EQ(membrane.cells(), cubes.count());
        // All are in order but what is so near to the last particle that vectors would read on
        // beyond it.
        for (const MembraneStrip& strip : membrane.strip) {
            const std::size_t last = membrane.across(strip, strip.count)[1];
            EXPECT_EQ(strip.in_order, last + 4 < cubes.corner_count()) << axis;
        }
    }
}

TEST(Membrane, PullsDownItsPotential)
{
    // Central differences are good to e^2 U''' / 6 and rounding / e: 1e-9 of forces of some 0.1.
    for (const int axis : {0, 1, 2}) {
        Sheet sheet(axis);
        for (int k = 0; k < 5; ++k) {
            sheet.shake(0.05, std::uint64_t(k));
            EXPECT_LT(sheet.misfit(), 1e-8) << axis << k;
        }
    }
}

TEST(Membrane, PullsDownItsPotentialWhenTornOrPlastic)
{
    Sheet sheet;
    sheet.shake(0.05, 9);
    const std::vector<std::uint8_t> torn{0b0011, 0, 0b1010, 0b1111, 0b0100};
    EXPECT_LT(sheet.misfit({torn, {}}), 1e-8);
    const Random random(4);
    std::vector<float> rest;
    for (std::size_t c = 0; c < sheet.share.size(); ++c) {
        for (const double mean : {1.0, 0.0, 1.0}) {
            rest.push_back(float(mean + 0.3 * (random.unit(rest.size()) - 0.5)));
        }
    }
    EXPECT_LT(sheet.misfit({{}, rest}), 1e-8);
    EXPECT_LT(sheet.misfit({torn, rest}), 1e-8);
}

TEST(Membrane, RestsUnderAnyRigidMotionAndPullsWithoutForceOrTorque)
{
    Sheet sheet;
    const geometry::Mat3 turn = Eigen::AngleAxisd(2, Vec3(1, -2, 3).normalized()).matrix();
    for (Vec3& p : sheet.x) p = turn * p + Vec3(4, 5, 6);
    for (const Vec3& p : sheet.pulls<double>()) EXPECT_LT(p.norm(), 1e-15 * 8);
    sheet.shake(0.3, 2);
    Vec3 force = Vec3::Zero(), torque = force;
    const auto pulls = sheet.pulls<double>();
    for (std::size_t i = 0; i < pulls.size(); ++i) {
        force += pulls[i];
        torque += sheet.x[i].cross(pulls[i]);
    }
    EXPECT_LT(force.norm(), 1e-14);
    // Of torque no more than the flaw: 1e-8 of share h / 4 at links of 0.3 m and 20 corners.
    EXPECT_LT(torque.norm(), 1e-8 * 20 * 2.5 * 0.05 * 0.3);
}

TEST(Membrane, IsFiniteAndBoundedWhereCornersHaveCollapsed)
{
    // At a point, on a line, with links along each other. |R| <= sqrt 2, so corners pull by at
    // most share h / 4 (|F| + sqrt 2).
    for (int kind = 0; kind < 3; ++kind) {
        Sheet sheet;
        for (Vec3& p : sheet.x) {
            if (kind == 0) p = Vec3(1, 2, 3);
            if (kind == 1) p = Vec3(p[0], 0, 0);
            if (kind == 2) p = Vec3(p[0] + p[2], 0, 0);
        }
        for (const Vec3& p : sheet.pulls<float>()) {
            EXPECT_TRUE(p.allFinite());
            EXPECT_LT(p.norm(), 16 * 2.5 * 0.2 / 4 * (2 * std::sqrt(2) + std::sqrt(2))) << kind;
        }
    }
}

TEST(Membrane, SingleIsDoubleToRounding)
{
    Sheet sheet;
    sheet.shake(0.1, 5);
    const auto one = sheet.pulls<float>(), two = sheet.pulls<double>();
    for (std::size_t i = 0; i < one.size(); ++i) EXPECT_LT((one[i] - two[i]).norm(), 1e-6);
}

TEST(Membrane, SumsAtCornersAreThoseOfTheirCells)
{
    auto cells = geometry::rectangle_cells(150, 40);
    std::erase_if(cells, [](const auto& c) { return (c[0] * 7 + c[1] * 13) % 11 == 0; });
    const geometry::Cubes cubes =
        geometry::plane_cubes(cells, {1, 0.1, {0, 0, 0}}, 0.01, {"s", 500, 1e6, 0, 0, 0});
    const Membrane membrane = make_membrane(cubes, 1);
    const Random random(5);
    std::vector<double> of_cell, expected(cubes.corner_count(), 0);
    for (std::size_t c = 0; c < membrane.cells(); ++c) of_cell.push_back(random.unit(c));
    membrane.for_each_cell([&](std::size_t c, const Membrane::Cell& cell) {
        for (const auto k : cell) expected[k] += of_cell[c];
    });
    const auto sums = sum_at_corners(membrane, of_cell, expected.size());
    ASSERT_EQ(sums.size(), expected.size());
    for (std::size_t i = 0; i < sums.size(); ++i) ASSERT_NEAR(sums[i], expected[i], 1e-14) << i;
}

TEST(Membrane, ABrokenLinkDisablesItsCorners)
{
    // Cells (0, 0) and (0, 1) share the link of particle (0, 1) along u: corners 2, 3 of the one
    // and 0, 1 of the other. Cells (0, 0) and (1, 0) share that of (1, 0) along v: 1, 3 and 0, 2.
    for (const int axis : {0, 1, 2}) {
        const Sheet sheet(axis);
        const auto& [u, v] = sheet.membrane.axes;
        const auto torn_at = [&](const geometry::Vec3i& at, int along) {
            std::uint32_t from = 0;
            while (sheet.cubes.corner[from] != at) ++from;
            return torn_corners(sheet.membrane,
                                std::vector<std::uint32_t>{3 * from + std::uint32_t(along)});
        };
        const auto along_u = torn_at(geometry::Vec3i::Unit(v), u);
        const auto along_v = torn_at(geometry::Vec3i::Unit(u), v);
        for (std::size_t c = 0; c < along_u.size(); ++c) {
            const auto& at = sheet.cubes.cell[c];
            const unsigned of_u = at[u] != 0 || at[v] > 1 ? 0u : at[v] == 0 ? 0b1100u : 0b0011u;
            const unsigned of_v = at[v] != 0 || at[u] > 1 ? 0u : at[u] == 0 ? 0b1010u : 0b0101u;
            EXPECT_EQ(along_u[c], of_u) << axis << ' ' << at.transpose();
            EXPECT_EQ(along_v[c], of_v) << axis << ' ' << at.transpose();
        }
    }
}
