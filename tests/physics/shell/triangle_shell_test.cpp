// What a shell of triangles says of itself to the time step.

#include "physics/shell/triangle_elasticity.hpp"

#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/direct_factor.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double thick_sheet = 0.02;

// A sheet that is flat at rest, one that is a part of a tube, and one with sharp edges.
std::vector<Cubes> sheets_of_all_shapes()
{
    const Squares s{4, 3, 0.1};
    const auto tube = [](double x, double z) {
        return Vec3(0.2 * std::cos(x / 0.2), 0.2 * std::sin(x / 0.2), z + 0.1 * x);
    };
    return {sheet_of(squares(s), thick_sheet), sheet_of(squares(s, tube), thick_sheet),
            sheet_of(geometry::box({0.2, 0.1, 0.15}, {2, 1, 2}), thick_sheet)};
}

// Places that are moved by chance, by up to `far` (m).
Aligned<double> moved_by_chance(const ShellBody& body, double far, std::uint32_t seed = 1)
{
    Aligned<double> x = body.base.rest;
    std::uint32_t drawn = 0;
    for (std::size_t k = 0; k < body.base.corners; ++k) {
        for (std::size_t i = 0; i < 3; ++i) x[4 * k + i] += far * (2 * chance(seed, drawn++) - 1);
    }
    return x;
}

Aligned<double> elastic_forces_at(TriangleElasticity& elasticity, const ShellBody& body,
                                  const Aligned<double>& x)
{
    Aligned<double> f(body.base.numbers, 0);
    elasticity.forces(x.data(), f.data());
    return f;
}

Eigen::MatrixXd matrix_by_products(const Elasticity& elasticity, const ShellBody& body)
{
    const std::size_t n = 3 * body.base.corners;
    Eigen::MatrixXd out(n, n);
    Aligned<double> p(body.base.numbers, 0), y(body.base.numbers, 0);
    for (std::size_t i = 0; i < n; ++i) {
        p[4 * (i / 3) + i % 3] = 1;
        elasticity.multiply(p.data(), y.data());
        p[4 * (i / 3) + i % 3] = 0;
        for (std::size_t j = 0; j < n; ++j) {
            out(Eigen::Index(j), Eigen::Index(i)) = y[4 * (j / 3) + j % 3];
        }
    }
    return out;
}

}  // namespace

TEST(TriangleShell, ForcesAreTheSlopeOfTheEnergy)
{
    for (const Cubes& cubes : sheets_of_all_shapes()) {
        const ShellBody body = make_shell(cubes);
        TriangleElasticity elasticity(body, {});
        Aligned<double> x = moved_by_chance(body, 0.03);
        const Aligned<double> f = elastic_forces_at(elasticity, body, x);
        double most = 0, wrong = 0;
        for (std::size_t i = 0; i < 4 * body.base.corners; ++i) {
            if (i % 4 == 3) continue;
            constexpr double step = 1e-6;
            const double at = x[i];
            x[i] = at + step;
            const double up = elasticity.energy(x.data());
            x[i] = at - step;
            const double down = elasticity.energy(x.data());
            x[i] = at;
            most = std::max(most, std::abs(f[i]));
            wrong = std::max(wrong, std::abs(f[i] + (up - down) / (2 * step)));
        }
        EXPECT_LT(wrong, 1e-7 * most);
    }
}

TEST(TriangleShell, TheMatrixIsTheSlopeOfTheForces)
{
    // All of it where the sheet is flat at rest; where it is curved, near its rest.
    for (const Cubes& cubes : sheets_of_all_shapes()) {
        const ShellBody body = make_shell(cubes);
        const bool flat = body.triangles->triangle[0].curved.isZero(0) &&
                          body.triangles->triangle[5].curved.isZero(0);
        TriangleElasticity elasticity(body, {});
        elasticity.use_hessian(true);
        Aligned<double> x = moved_by_chance(body, flat ? 0.02 : 0);
        elastic_forces_at(elasticity, body, x);
        const Eigen::MatrixXd k = matrix_by_products(elasticity, body);
        EXPECT_LT((k - k.transpose()).norm(), 1e-9 * k.norm());
        double wrong = 0;
        for (std::size_t i = 0; i < 3 * body.base.corners; ++i) {
            constexpr double step = 1e-6;
            const std::size_t at = 4 * (i / 3) + i % 3;
            const double before = x[at];
            x[at] = before + step;
            const Aligned<double> up = elastic_forces_at(elasticity, body, x);
            x[at] = before - step;
            const Aligned<double> down = elastic_forces_at(elasticity, body, x);
            x[at] = before;
            for (std::size_t j = 0; j < 3 * body.base.corners; ++j) {
                const std::size_t to = 4 * (j / 3) + j % 3;
                const double slope = -(up[to] - down[to]) / (2 * step);
                wrong = std::max(wrong, std::abs(slope - k(Eigen::Index(j), Eigen::Index(i))));
            }
        }
        EXPECT_LT(wrong, 1e-5 * k.cwiseAbs().maxCoeff()) << flat;
    }
}

TEST(TriangleShell, TheMatrixIsNeverNegativeWithoutTheHessian)
{
    for (const Cubes& cubes : sheets_of_all_shapes()) {
        const ShellBody body = make_shell(cubes);
        TriangleElasticity elasticity(body, {});
        elastic_forces_at(elasticity, body, moved_by_chance(body, 0.05));
        const Eigen::MatrixXd k = matrix_by_products(elasticity, body);
        const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver((k + k.transpose()) / 2);
        EXPECT_GT(solver.eigenvalues()[0], -1e-10 * solver.eigenvalues().maxCoeff());
    }
}

TEST(TriangleShell, RestsAsItIsMadeAndWhereverItIsTurnedTo)
{
    for (const Cubes& cubes : sheets_of_all_shapes()) {
        const ShellBody body = make_shell(cubes);
        TriangleElasticity elasticity(body, {});
        const Eigen::Matrix3d turn =
            Eigen::AngleAxisd(2.1, Vec3(1, 2, -0.5).normalized()).toRotationMatrix();
        Aligned<double> x = body.base.rest, bent = moved_by_chance(body, 0.01);
        const double much = elasticity.energy(bent.data());
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            Eigen::Map<Vec3> at(x.data() + 4 * k), other(bent.data() + 4 * k);
            at = turn * at + Vec3(3, -1, 2);
            other = turn * other + Vec3(3, -1, 2);
        }
        EXPECT_LT(elasticity.energy(x.data()), 1e-18 * much);
        EXPECT_NEAR(elasticity.energy(bent.data()) / much, 1, 1e-9);
        double most = 0;
        for (const double f : elastic_forces_at(elasticity, body, x))
            most = std::max(most, std::abs(f));
        EXPECT_LT(most, 1e-7 * much / 0.01);
    }
}

TEST(TriangleShell, AFactorOfItsElementsInvertsTheMatrix)
{
    // With damping that differs, and some corners held.
    for (Cubes cubes : sheets_of_all_shapes()) {
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            cubes.stiffness_damping[c] = c % 3 == 0 ? 0.0 : 0.01 * double(c % 5);
        }
        const ShellBody body = make_shell(cubes);
        const Pins pins{{0, 1, 2}, {}};
        TriangleElasticity elasticity(body, pins);
        elastic_forces_at(elasticity, body, moved_by_chance(body, 0.02));
        elasticity.weigh(0.3, 0.7);
        const auto tree = elasticity.dissection(pins.corner);
        ASSERT_TRUE(tree);
        std::vector<BrickMatrix> elements;
        ASSERT_TRUE(elasticity.cube_matrices(elements));
        std::vector<std::uint32_t> slot(body.base.corners);
        std::iota(slot.begin(), slot.end(), 0u);
        Aligned<double> diagonal(body.base.numbers, 0.01), b(body.base.numbers, 0);
        auto factor = DirectFactor::make(tree, elements, diagonal, slot);
        ASSERT_TRUE(factor);
        for (std::size_t k = 3; k < body.base.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                b[4 * k + i] = chance(3, std::uint32_t(3 * k + i)) - 0.5;
            }
        }
        Aligned<double> x(body.base.numbers, 0), y(body.base.numbers, 0);
        factor->solve(b.data(), x.data());
        elasticity.multiply(x.data(), y.data());
        double wrong = 0;
        for (std::size_t i = 12; i < 4 * body.base.corners; ++i) {
            if (i % 4 < 3) wrong = std::max(wrong, std::abs(y[i] + 0.01 * x[i] - b[i]));
        }
        EXPECT_LT(wrong, 1e-8);
    }
}

TEST(TriangleShell, StretchesAsTheSheetOfSquaresDoes)
{
    // Pulled evenly both are exact.
    const Cubes triangles = sheet_of(squares({6, 4, 0.1}), thick_sheet);
    const Cubes cells = sheet(6, 4, 0.1, thick_sheet, 0.3);
    const ShellBody a = make_shell(triangles), b = make_shell(cells);
    TriangleElasticity of_triangles(a, {});
    ShellElasticity of_cells(b, {});
    Aligned<double> x = a.base.rest, y = b.base.rest;
    for (auto* of : {&x, &y}) {
        for (std::size_t k = 0; 4 * k < of->size(); ++k) {
            Eigen::Map<Vec3> at(of->data() + 4 * k);
            at = Vec3(1.2 * at.x() + 0.1 * at.z(), 0.3 * at.x(), 0.9 * at.z());
        }
    }
    EXPECT_NEAR(of_triangles.energy(x.data()) / of_cells.energy(y.data()), 1, 1e-6);
}

TEST(TriangleShell, OfThreeFacesAtASideTheTwoThatRunOnBendAsOne)
{
    // Two faces in a plane, about, and a third across, wherever it stands in the list: the third
    // turns freely about the side.
    geometry::TriMesh mesh;
    mesh.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0.5f}, {-1, 0.1f, 0.5f}, {0, 1, 0.5f}};
    std::vector<geometry::Triangle> faces{{0, 1, 2}, {0, 1, 4}, {1, 0, 3}};
    do {
        auto topology = std::make_shared<geometry::MeshTopology>();
        topology->triangles = faces;
        mesh.topology = topology;
        const auto made = geometry::make_sheet(mesh, thick_sheet);
        EXPECT_EQ(made.joints, 1u);
        const ShellBody body = make_shell(made.cubes);
        TriangleElasticity elasticity(body, {});
        const auto energy_with = [&](std::size_t corner, const Vec3& way) {
            Aligned<double> x = body.base.rest;
            Eigen::Map<Vec3>(x.data() + 4 * corner) += way;
            return elasticity.energy(x.data());
        };
        const double bent = energy_with(2, {0, 1e-4, 0});
        EXPECT_GT(bent, 0);
        EXPECT_LT(energy_with(4, {1e-4, 0, 0}), 1e-3 * bent);
    } while (std::next_permutation(faces.begin(), faces.end()));
}

TEST(TriangleShell, DampingAloneMayBeAskedForWhereSomeFacesHaveNone)
{
    Cubes cubes = sheet_of(squares({4, 3, 0.1}), thick_sheet);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        cubes.stiffness_damping[c] = c % 2 == 0 ? 0.0 : 0.01;
    }
    const ShellBody body = make_shell(cubes);
    TriangleElasticity elasticity(body, {});
    elastic_forces_at(elasticity, body, moved_by_chance(body, 0.02));
    elasticity.weigh(0, 1);
    const Eigen::MatrixXd k = matrix_by_products(elasticity, body);
    ASSERT_TRUE(k.allFinite());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver((k + k.transpose()) / 2);
    EXPECT_GT(solver.eigenvalues()[0], -1e-10 * solver.eigenvalues().maxCoeff());
}

TEST(TriangleShell, PlanesBesideASheetAreTrianglesToo)
{
    const Cubes other = sheet_of(squares({2, 2, 0.1}), 0.03);
    for (int axis = 0; axis < 3; ++axis) {
        const Cubes plane =
            geometry::plane_cubes(geometry::rectangle_cells(3, 2), {axis, 0.1, {0, 0, 0}},
                                  thick_sheet, {"sheet", 1000, 1e6, 0.3, 0, 0});
        const BodyModel models[] = {{&plane, nullptr}, {&other, nullptr}};
        const ShellBody body = make_shell(BodyModels(models, ModelKind::plane));
        EXPECT_EQ(body.triangles->triangle.size(), 2 * plane.count() + other.count());
        EXPECT_EQ(body.base.parts, 2u) << axis;
        TriangleElasticity elasticity(body, {});
        EXPECT_LT(elasticity.energy(body.base.rest.data()), 1e-20);
        const std::vector<double> of_plane = geometry::corner_masses(plane);
        for (std::size_t k = 0; k < of_plane.size(); ++k) {
            EXPECT_NEAR(body.base.mass[k], of_plane[k], 1e-9) << axis;
        }
    }
}

TEST(TriangleShell, WithoutStiffnessToBendItStillStretches)
{
    ShellOptions limp;
    limp.bend = 0;
    const ShellBody body = make_shell(sheet_of(squares({4, 3, 0.1}), thick_sheet), limp);
    const ShellBody stiff = make_shell(sheet_of(squares({4, 3, 0.1}), thick_sheet));
    Aligned<double> pulled = body.base.rest, bent = body.base.rest;
    for (std::size_t k = 0; k < body.base.corners; ++k) {
        pulled[4 * k] *= 1.1;
        bent[4 * k + 1] = 1e-3 * std::sin(20 * bent[4 * k]);
    }
    TriangleElasticity of_limp(body, {}), of_stiff(stiff, {});
    EXPECT_NEAR(of_limp.energy(pulled.data()) / of_stiff.energy(pulled.data()), 1, 1e-6);
    EXPECT_LT(of_limp.energy(bent.data()), 0.1 * of_stiff.energy(bent.data()));
}
