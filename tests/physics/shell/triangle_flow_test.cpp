// Sheets whose rest shape gives way for good.

#include "physics/shell/triangle_flow.hpp"

#include "geometry/base/random.hpp"
#include "physics/shell/triangle_elasticity.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace physics;
using namespace fixtures;
using Eigen::Index;

// A sheet whose rest shape has flowed as chance has it, and corners moved likewise.
struct FlowedSheet {
    Cubes cubes = sheet_of(squares({.ni = 4, .nj = 3}), 0.02);
    ShellBody body = make_shell(cubes);
    TriangleElasticity elasticity{body, {}};
    Aligned<double> x = body.base.rest;

    FlowedSheet()
    {
        const geometry::Random random(3);
        std::vector<float> plastic(triangle_plastic_rows * cubes.count());
        for (std::size_t i = 0; i < plastic.size(); ++i) {
            const double most = i % 6 < 3 ? 0.2 : 10;
            plastic[i] = static_cast<float>(most * (random.unit(i) - 0.5));
        }
        elasticity.load_plastic(plastic);
        for (std::size_t i = 0; i < 4 * body.base.corners; ++i) {
            if (i % 4 != 3) x[i] += 0.04 * (random.unit(9000 + i) - 0.5);
        }
    }
};

TEST(TriangleFlow, ForcesAreTheSlopeOfTheEnergyAndHaveNoNetTorque)
{
    FlowedSheet sheet;
    Aligned<double> f(sheet.elasticity.room(), 0);
    sheet.elasticity.forces(sheet.x.data(), f.data());
    double most = 0, wrong = 0;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t k = 0; k < sheet.body.base.corners; ++k) {
        const Eigen::Map<const Vec3> at(&sheet.x[4 * k]), own(&f[4 * k]);
        force += own, torque += Vec3(at).cross(own);
        for (std::size_t i = 4 * k; i < 4 * k + 3; ++i) {
            constexpr double step = 1e-6;
            const double before = sheet.x[i];
            sheet.x[i] = before + step;
            const double up = sheet.elasticity.energy(sheet.x.data());
            sheet.x[i] = before - step;
            const double down = sheet.elasticity.energy(sheet.x.data());
            sheet.x[i] = before;
            most = std::max(most, std::abs(f[i]));
            wrong = std::max(wrong, std::abs(f[i] + (up - down) / (2 * step)));
        }
    }
    EXPECT_LT(wrong, 1e-6 * most);
    EXPECT_LT(force.norm(), 1e-9 * most);
    EXPECT_LT(torque.norm(), 1e-9 * most);
}

TEST(TriangleFlow, TheMatrixIsTheSlopeOfTheForces)
{
    // Near where it rests with small curvatures: of Gauss and Newton, as far as it is curved.
    FlowedSheet sheet;
    std::vector<float> plastic = sheet.elasticity.plastic();
    for (std::size_t i = 0; i < plastic.size(); ++i) plastic[i] *= i % 6 < 3 ? 0.02f : 0.05f;
    sheet.elasticity.load_plastic(plastic);
    sheet.x = sheet.body.base.rest;
    sheet.elasticity.use_hessian(true);
    const std::size_t n = sheet.body.base.corners;
    Aligned<double> f(sheet.elasticity.room(), 0), p(f.size(), 0), y(f.size(), 0), up(f), down(f);
    const geometry::Random random(6);
    for (std::size_t i = 0; i < 4 * n; ++i) p[i] = i % 4 == 3 ? 0 : random.unit(i) - 0.5;
    constexpr double step = 1e-6;
    const auto forces_at = [&](double share, Aligned<double>& to) {
        Aligned<double> x = sheet.x;
        for (std::size_t i = 0; i < 4 * n; ++i) x[i] += share * p[i];
        sheet.elasticity.forces(x.data(), to.data());
    };
    forces_at(step, up), forces_at(-step, down), forces_at(0, f);
    sheet.elasticity.weigh(1, 0);
    sheet.elasticity.multiply(p.data(), y.data());
    double wrong = 0, most = 0, curved_wrong = 0;
    for (std::size_t i = 0; i < 4 * n; ++i) {
        const double slope = -(up[i] - down[i]) / (2 * step);
        wrong = std::max(wrong, std::abs(y[i] - slope));
        most = std::max(most, std::abs(slope));
    }
    EXPECT_LT(wrong, 2e-3 * most);
    // With the sides' slopes eliminated, the triangles' own matrices make the same product.
    std::vector<BrickMatrix> own;
    ASSERT_TRUE(sheet.elasticity.cube_matrices(own));
    const auto& triangles = sheet.body.triangles->triangle;
    const std::size_t sides = sheet.body.triangles->side.size();
    Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(Index(3 * (n + sides)), Index(3 * (n + sides)));
    for (std::size_t t = 0; t < own.size(); ++t) {
        std::array<std::size_t, 6> at;
        for (std::size_t i = 0; i < 3; ++i) {
            at[i] = triangles[t].corner[i], at[3 + i] = n + triangles[t].side[i];
        }
        for (std::size_t i = 0; i < 6; ++i) {
            for (std::size_t j = 0; j < 6; ++j) {
                whole.block<3, 3>(Index(3 * at[i]), Index(3 * at[j])) +=
                    own[t].block<3, 3>(Index(3 * i), Index(3 * j));
            }
        }
    }
    Eigen::VectorXd moved(Index(3 * n));
    for (std::size_t k = 0; k < n; ++k) {
        moved.segment<3>(Index(3 * k)) = Eigen::Map<const Vec3>(&p[4 * k]);
    }
    const Index c = Index(3 * n), s = Index(3 * sides);
    const Eigen::VectorXd pulled = whole.bottomLeftCorner(s, c) * moved;
    const Eigen::VectorXd product =
        whole.topLeftCorner(c, c) * moved -
        whole.topRightCorner(c, s) * whole.bottomRightCorner(s, s).llt().solve(pulled);
    for (std::size_t k = 0; k < n; ++k) {
        const Vec3 found = Eigen::Map<const Vec3>(&y[4 * k]);
        curved_wrong = std::max(curved_wrong, (found - product.segment<3>(Index(3 * k))).norm());
    }
    EXPECT_LT(curved_wrong, 1e-9 * most);
}

TEST(TriangleFlow, TheRestShapeStopsAtTheYieldStrain)
{
    FlowedSheet sheet;
    const ShellTriangle& own = sheet.body.triangles->triangle[2];
    const PlasticOptions options{.yield = 0.03, .flow = 1e6, .limit = 0.9};
    Eigen::Matrix3d places;
    for (std::size_t i = 0; i < 3; ++i) {
        const Eigen::Map<const Vec3> at(&sheet.body.base.rest[4 * std::size_t{own.corner[i]}]);
        places.col(Index(i)) = Vec3(1.2 * at.x() + 0.1 * at.z(), at.y(), 0.9 * at.z());
    }
    const Eigen::Vector3d curvature(5, -2, 1);
    TriangleStrain rest;
    for (int i = 0; i < 100; ++i) {
        rest = flowed(own, rest, places, curvature - rest.curvature, options, 0.01);
    }
    // What is left of it: as a further step has it with a yield strain of all but nothing.
    const TriangleStrain all =
        flowed(own, rest, places, curvature - rest.curvature, {1e-9, 1e9, 0.9}, 1);
    EXPECT_NEAR(size_of({all.stretch - rest.stretch, all.curvature - rest.curvature}, 0.02), 0.03,
                0.03 * 0.15);
    EXPECT_NEAR((curvature - rest.curvature).normalized().dot(curvature.normalized()), 1, 1e-9);
    const TriangleStrain same =
        flowed(own, rest, places, curvature - rest.curvature, {0.0301, 1e6, 0.9}, 0.01);
    EXPECT_EQ(same.stretch, rest.stretch);
    EXPECT_EQ(same.curvature, rest.curvature);
}

// A strip along x of 40 by 4 squares of 25 mm, 10 mm thick. Its ends, two squares long, go to where
// `to` has them in a second, stay for half of one, and are let go but for the first, for three.
struct Strip {
    State held, after;
};
Strip let_go(const PlasticOptions& plastic, const std::function<Vec3(const Vec3&, double)>& to)
{
    geometry::TriMesh mesh = squares({.ni = 40, .nj = 4, .a = 0.025, .moved = 0.2});
    Cubes cubes = geometry::make_sheet(mesh, 0.01, {"sheet", 1000, 1e8, 0.3, 3, 0.002}).cubes;
    const ShellBody body = make_shell(cubes, {.plastic = plastic});
    Strip out;
    State state = rest_state(body);
    for (int frame = 1; frame <= 108; ++frame) {
        Loads loads;
        loads.pins = held_at(cubes, [&](const Vec3& at) {
            return at.x() < 0.051 || (frame <= 36 && at.x() > 0.949);
        });
        const double share = std::min(1.0, frame / 24.0);
        for (std::size_t p = 0; p < loads.pins.corner.size(); ++p) {
            loads.pins.target[p] = to(loads.pins.target[p], share);
        }
        state = advance(body, std::move(state), loads, 1.0 / 24,
                        {.substeps = 2, .newton_iterations = 5, .tolerance = 1e-6});
        if (frame == 36) out.held = state;
    }
    out.after = std::move(state);
    return out;
}

// The middle of the corners that are near x at rest.
Vec3 row_at(const State& state, double x)
{
    geometry::TriMesh mesh = squares({.ni = 40, .nj = 4, .a = 0.025, .moved = 0.2});
    const Cubes cubes = geometry::make_sheet(mesh, 0.01, {"sheet", 1000, 1e8, 0.3, 3, 0.002}).cubes;
    Vec3 sum = Vec3::Zero();
    double count = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (std::abs(cubes.corner_position(k).x() - x) > 0.013) continue;
        sum += state.x[k], ++count;
    }
    return sum / count;
}

TEST(TriangleFlow, AStripThatWasBentKeepsTheCurvatureBeyondTheYieldStrain)
{
    // Along a circle between the ends, so that it is bent evenly.
    constexpr double angle = 1.2, length = 0.9;
    const auto to = [&](const Vec3& rest, double share) {
        const double turn = share * angle, r = length / turn;
        const double end = std::clamp((rest.x() - 0.05) / length, 0.0, 1.0) * turn;
        const double past = rest.x() > 0.949 ? rest.x() - 0.95 : std::min(rest.x() - 0.05, 0.0);
        return Vec3(0.05 + r * std::sin(end) + past * std::cos(end),
                    r * (1 - std::cos(end)) + past * std::sin(end), rest.z());
    };
    const auto angle_of = [&](const State& state) {
        const Vec3 low = row_at(state, 0.15) - row_at(state, 0.1);
        const Vec3 high = row_at(state, 0.9) - row_at(state, 0.85);
        return std::atan2(low.cross(high).z(), low.dot(high));
    };
    const double yield = 0.0015, nu = 0.3;
    const Strip kept = let_go({.yield = yield, .flow = 1e6}, to);
    // The elastic part springs back: k along the strip and -nu k across.
    const double bends = angle_of(kept.held) / 0.75;
    const double elastic = yield * std::sqrt(12.0) / 0.01 / std::sqrt(1 + nu * nu);
    EXPECT_NEAR(bends, angle / length, 0.03 * angle / length);
    EXPECT_NEAR(angle_of(kept.after), 0.75 * (bends - elastic), 0.03 * 0.75 * bends);
    EXPECT_NEAR(angle_of(let_go({}, to).after), 0, 0.01);
}

TEST(TriangleFlow, AStripThatWasDrawnOutStaysLonger)
{
    const auto to = [](const Vec3& rest, double share) {
        return Vec3(rest.x() * (1 + 0.05 * share), rest.y(), rest.z());
    };
    const auto length_of = [&](const State& state) {
        return (row_at(state, 0.75) - row_at(state, 0.25)).norm();
    };
    const double yield = 0.01, nu = 0.3;
    const Strip kept = let_go({.yield = yield, .flow = 1e6}, to);
    const double elastic = yield / std::sqrt(1 + nu * nu);
    const double rest = 0.5, expected = length_of(kept.held) / (1 + elastic);
    EXPECT_NEAR(length_of(kept.after) - rest, expected - rest, 0.03 * (expected - rest));
}

// A plane that hung from one end for a second.
State hung(const Cubes& plane, const ShellBody& body, State state, int frames)
{
    Loads loads;
    loads.pins = held_where(plane, [](const Vec3i& at) { return at.x() <= 1; });
    loads.forces.push_back({});
    for (int i = 0; i < frames; ++i) state = advance(body, std::move(state), loads, 1.0 / 24);
    return state;
}

TEST(TriangleFlow, AStateIsACheckpoint)
{
    const Cubes plane = sheet(6, 2, 0.1, 0.02);
    const ShellOptions options{.plastic = {.yield = 0.001, .flow = 50}};
    const ShellBody body = make_shell(plane, options), other = make_shell(plane, options);
    const State state = hung(plane, body, rest_state(body), 12);
    EXPECT_EQ(state.plastic.size(), 2 * triangle_plastic_rows * plane.count());
    EXPECT_EQ(state.plastic_of, PlasticOf::triangles);
    const State a = hung(plane, body, state, 1), b = hung(plane, other, state, 1);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.plastic, b.plastic);
    EXPECT_NE(a.plastic, state.plastic);
    // With a yield strain that nothing reaches, it stays as it is.
    const ShellBody firm = make_shell(plane, {.plastic = {.yield = 10}});
    EXPECT_EQ(hung(plane, firm, state, 3).plastic, state.plastic);
}

TEST(TriangleFlow, APinnedRimOfAPlaneIsAHingeAtAllItsCorners)
{
    // Its cells are cut along one diagonal. It sags as evenly as it is made.
    const Cubes plane = sheet(8, 8, 0.1, 0.02);
    const ShellBody body = make_shell(plane, {.plastic = {.yield = 10}});
    Loads loads;
    loads.pins = held_where(plane, [](const Vec3i& at) { return near_border(at, 8, 8, 1); });
    loads.forces.push_back(weight(Vec3(0, -0.01, 0)));
    const State state = settled(body, loads);
    const auto sag = [&](int i, int j) {
        for (std::uint32_t k = 0; k < plane.corner_count(); ++k) {
            if (plane.corner[k].x() == i && plane.corner[k].z() == j) return state.x[k].y();
        }
        return 0.0;
    };
    EXPECT_LT(sag(4, 4), 0);
    EXPECT_NEAR(sag(1, 1), sag(7, 1), 0.03 * std::abs(sag(1, 1)));
}

TEST(TriangleFlow, TellsTheStrainOfEachCell)
{
    const double h = 0.02;
    const ShellBody sheet = make_shell(sheet_of(squares({.ni = 1, .nj = 1}), h));
    std::vector<float> plastic(2 * triangle_plastic_rows, 0.0f);
    plastic[0] = 0.1f, plastic[2] = 0.05f;    // 11, 12
    plastic[triangle_plastic_rows + 3] = 30;  // 11 of the curvature, 1/m
    TriangleElasticity elasticity(sheet, {});
    EXPECT_TRUE(elasticity.plastic_strain().empty());
    elasticity.load_plastic(plastic);
    const float stretched = std::sqrt(0.01f + 2 * 0.0025f);
    const auto bent = static_cast<float>(30 * h / std::sqrt(12.0));
    const auto told = elasticity.plastic_strain();
    ASSERT_EQ(told.size(), 2u);
    EXPECT_NEAR(told[0], stretched, 1e-6);
    EXPECT_NEAR(told[1], bent, 1e-6);
    // Two triangles make one cell of a plane.
    const ShellBody plane =
        make_shell(geometry::plane_cubes(geometry::rectangle_cells(2, 1), {1, 0.1, {0, 0, 0}}, h),
                   {.plastic = {.yield = 0.01}});
    plastic.resize(4 * triangle_plastic_rows, 0.0f);
    TriangleElasticity halves(plane, {});
    halves.load_plastic(plastic);
    EXPECT_EQ(rest_state(plane).plastic_strain, std::vector<float>(2, 0.0f));
    const auto of_cells = halves.plastic_strain();
    ASSERT_EQ(of_cells.size(), 2u);
    EXPECT_NEAR(of_cells[0], std::max(stretched, bent), 1e-6);
    EXPECT_EQ(of_cells[1], 0);
}

}  // namespace
