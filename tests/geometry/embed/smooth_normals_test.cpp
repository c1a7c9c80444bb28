// Normals of an embedded mesh against those of a motion that is known everywhere.

#include "geometry/embed/smooth_normals.hpp"
#include "geometry/mesh/mesh.hpp"

#include "geometry/embed/embed.hpp"
#include "geometry/mesh/primitive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace {

using namespace geometry;

// A bar along x of 4 m, 2 m thick, bent to a quarter of a circle: what lies at height y above the
// middle runs on a circle of radius R - y.
constexpr double R = 8 / 3.141592653589793;

Vec3 bent(const Vec3& X)
{
    const double angle = X.x() / R;
    return {(R - X.y()) * std::sin(angle), R - (R - X.y()) * std::cos(angle), X.z()};
}

// Its gradient turns by the angle and shortens along x: cof(F) N of a unit N.
Vec3 bent_normal(const Vec3& X, const Vec3& N)
{
    const double angle = X.x() / R, s = (R - X.y()) / R;
    const Vec3 along(std::cos(angle), std::sin(angle), 0), up(-std::sin(angle), std::cos(angle), 0);
    return (N.x() * along + s * N.y() * up + s * N.z() * Vec3::UnitZ()).normalized();
}

struct Errors {
    double worst = 0, mean_sq = 0;  // rad, rad^2
};

Errors errors(const TriMesh& rest, const TriMesh& carried, const Binding& binding)
{
    Errors e;
    for (std::size_t n = 0; n < rest.normals.size(); ++n) {
        const Vec3 wanted = bent_normal(rest.positions[binding.normal_vertex[n]].cast<double>(),
                                        rest.normals[n].cast<double>());
        const Vec3 got = carried.normals[n].cast<double>();
        const double angle = std::atan2(wanted.cross(got).norm(), wanted.dot(got));
        e.worst = std::max(e.worst, angle);
        e.mean_sq += angle * angle / double(rest.normals.size());
    }
    return e;
}

struct Carried {
    Cubes cubes;
    TriMesh rest;
    Binding binding;
    std::vector<Vec3> x;
};

// A ball in the middle of the bar, which is of cubes of `size`, whose corners go where `motion`
// says.
Carried carried_by(double size, const std::function<Vec3(const Vec3&)>& motion)
{
    Carried c;
    const auto n = static_cast<std::int32_t>(std::lround(1 / size));
    std::vector<Vec3i> cells;
    for (std::int32_t i = -2 * n; i < 2 * n; ++i) {
        for (std::int32_t j = -n; j < n; ++j) {
            for (std::int32_t k = -n; k < n; ++k) cells.emplace_back(i, j, k);
        }
    }
    c.cubes = solid_cubes(cells, size);
    c.rest = icosphere(0.98, 4);  // also into the outermost cubes
    c.binding = bind(c.rest, c.cubes);
    for (const Vec3& X : corner_positions(c.cubes)) c.x.push_back(motion(X));
    return c;
}

TEST(SmoothNormals, AreOfSecondOrderWhereThoseOfOneCubeAreOfFirst)
{
    std::array<Errors, 2> one{}, smooth{};
    for (std::size_t i = 0; i < 2; ++i) {
        const Carried c = carried_by(i == 0 ? 0.25 : 0.125, bent);
        TriMesh mesh = embed(c.binding, c.rest, c.cubes, c.x);
        one[i] = errors(c.rest, mesh, c.binding);
        smooth_normals(mesh, c.binding, c.rest, c.cubes, c.x);
        smooth[i] = errors(c.rest, mesh, c.binding);
        RecordProperty("one cube, rms " + std::to_string(i),
                       std::to_string(std::sqrt(one[i].mean_sq)));
        RecordProperty("smooth, rms " + std::to_string(i),
                       std::to_string(std::sqrt(smooth[i].mean_sq)));
        // Within a cube the turn is taken for that of its middle: off by half a cube over R.
        EXPECT_GT(one[i].worst, 0.3 * c.cubes.size / R);
        EXPECT_LT(smooth[i].mean_sq, one[i].mean_sq / 25) << "five times less";
    }
    EXPECT_NEAR(std::sqrt(one[0].mean_sq / one[1].mean_sq), 2, 0.3);
    EXPECT_NEAR(std::sqrt(smooth[0].mean_sq / smooth[1].mean_sq), 4, 0.6);
    EXPECT_LT(smooth[1].worst, one[1].worst / 5);
}

TEST(SmoothNormals, AreExactForAffineMotion)
{
    Mat3 A;
    A << 1.2, 0.3, 0, -0.2, 0.8, 0.1, 0.05, 0, 1.1;
    const Carried c = carried_by(0.25, [&](const Vec3& X) { return Vec3(A * X + Vec3(1, 2, 3)); });
    TriMesh mesh = embed(c.binding, c.rest, c.cubes, c.x);
    const TriMesh before = mesh;
    smooth_normals(mesh, c.binding, c.rest, c.cubes, c.x);
    for (std::size_t n = 0; n < mesh.normals.size(); ++n) {
        ASSERT_LT((mesh.normals[n] - before.normals[n]).norm(), 1e-5f);
    }
    EXPECT_TRUE(mesh.positions == before.positions);
}

// Of two cubes in a row the first stays and the far face of the second moves up by s: their
// gradients are I and I + s e_y e_x^T. The corners of the first have I on one side and, on the
// other, the mean of both: in its middle F = I + s / 4 e_y e_x^T, cof(F) (1, 1, 0) = (1 - s / 4, 1,
// 0).
TEST(SmoothNormals, WeighCornersAlikeHoweverManyCubesAreAround)
{
    const double s = 0.4;
    const Cubes cubes = solid_cubes({{0, 0, 0}, {1, 0, 0}}, 1);
    TriMesh rest;
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = topology->normal_triangles = {{0, 1, 2}};
    rest.topology = topology;
    rest.positions = {{0.5f, 0.5f, 0.5f}, {0.6f, 0.5f, 0.5f}, {0.5f, 0.6f, 0.5f}};
    rest.normals.assign(3, Vec3f(1, 1, 0).normalized());
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p.y() += p.x() > 1.5 ? s : 0;
    const Binding binding = bind(rest, cubes);
    TriMesh mesh = embed(binding, rest, cubes, x);
    smooth_normals(mesh, binding, rest, cubes, x);
    const Vec3f wanted = Vec3f(float(1 - s / 4), 1, 0).normalized();
    EXPECT_LT((mesh.normals[0] - wanted).norm(), 1e-6f);
}

TEST(SmoothNormals, WhatIsTornKeepsItsOwn)
{
    const Carried c = carried_by(0.25, bent);
    const TriMesh before = embed(c.binding, c.rest, c.cubes, c.x);
    TriMesh mesh = before;
    const std::vector<std::uint8_t> all(c.cubes.count(), 1);
    smooth_normals(mesh, c.binding, c.rest, c.cubes, c.x, all);
    EXPECT_TRUE(mesh.normals == before.normals);
}

}  // namespace
