// Meshes on and off a sheet, against motions that are known everywhere.

#include "geometry/embed/sheet_motion.hpp"

#include "geometry/cubes/sheet.hpp"
#include "geometry/embed/carried_numbers.hpp"
#include "geometry/embed/cut_torn.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/embed/plane_detail.hpp"
#include "geometry/embed/smooth_normals.hpp"
#include "geometry/embed/torn_faces.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace {

using namespace geometry;
using test_meshes::mesh_of;

// A coarse curved sheet, and a fine ball around it, bumpy: its vertices lie up to 0.2 m from the
// sheet on either side.
struct OnSheetScene {
    Cubes sheet;
    TriMesh mesh;
    explicit OnSheetScene(int sheet_levels = 2, int mesh_levels = 4)
        : sheet(make_sheet(test_meshes::icosphere(sheet_levels), 0.01).cubes),
          mesh(test_meshes::bumpy_sphere(mesh_levels))
    {
        for (const Vec3f& p : mesh.positions) mesh.normals.push_back(p.normalized());
    }
};

std::vector<Vec3> sheet_moved(const Cubes& sheet, const std::function<Vec3(const Vec3&)>& motion)
{
    std::vector<Vec3> x;
    for (const Vec3& p : sheet.place) x.push_back(motion(p));
    return x;
}

TriMesh carried_by_sheet(const TriMesh& mesh, const Cubes& sheet, const std::vector<Vec3>& x)
{
    return embed(bind(mesh, sheet), mesh, sheet, x);
}

// A square of 2 m in the plane z = 0, in two triangles.
Cubes flat_square()
{
    return make_sheet(mesh_of({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, {{0, 1, 2}, {0, 2, 3}}),
                      0.01)
        .cubes;
}

TriMesh points_with_normals(const std::vector<Vec3f>& p, const Vec3f& normal)
{
    TriMesh mesh = mesh_of(p, {});
    mesh.normals.assign(p.size(), normal);
    return mesh;
}

TEST(SheetMotion, VerticesGoWithTheNearestTriangle)
{
    const OnSheetScene s;
    const Binding binding = bind(s.mesh, s.sheet);
    EXPECT_TRUE(binding.strays.empty());
    EXPECT_TRUE(binding.stray_normals.empty());
    EXPECT_TRUE(binding.one_normal_each);
    double farthest = 0;
    for (std::uint32_t v = 0; v < s.mesh.positions.size(); v += 7) {
        const auto place_on = [&](std::size_t cell, const Vec3& share) {
            const auto t = sheet_triangle(s.sheet, cell);
            return Vec3(share[0] * s.sheet.place[t[0]] + share[1] * s.sheet.place[t[1]] +
                        share[2] * s.sheet.place[t[2]]);
        };
        const Vec3 p = s.mesh.positions[v].cast<double>();
        const std::array<double, 8> w = weights(binding, v);
        const Vec3 base = place_on(binding.used[binding.cube[v]], {w[0], w[1], w[2] + w[3]});
        EXPECT_EQ(binding.local[v].z(), 0);
        farthest = std::max(farthest, (p - base).norm());
        // No place of any triangle, by a lattice of them, is nearer.
        double least = 1e9;
        for (std::size_t cell = 0; cell < s.sheet.count(); ++cell) {
            for (int i = 0; i <= 8; ++i) {
                for (int j = 0; j <= 8 - i; ++j) {
                    const Vec3 share(i / 8.0, j / 8.0, (8 - i - j) / 8.0);
                    least = std::min(least, (p - place_on(cell, share)).norm());
                }
            }
        }
        EXPECT_LT((p - base).norm(), least + 1e-6);  // bound in single precision
    }
    EXPECT_GT(binding.farthest, farthest - 1e-6);
    EXPECT_LT(binding.farthest, 0.25);
}

TEST(SheetMotion, AtRestNothingMoves)
{
    const OnSheetScene s;
    const TriMesh out = carried_by_sheet(s.mesh, s.sheet, s.sheet.place);
    EXPECT_EQ(out.positions, s.mesh.positions);
    EXPECT_EQ(out.topology, s.mesh.topology);
    for (std::size_t n = 0; n < out.normals.size(); ++n) {
        EXPECT_NEAR((out.normals[n] - s.mesh.normals[n]).norm(), 0, 1e-6);
    }
}

// The bases are rounded to single precision, but the same at rest and now: what is left is the
// rounding of the result.
TEST(SheetMotion, ARigidMotionIsThatOfAllVerticesOnTheSheetAndOffIt)
{
    OnSheetScene s;
    s.mesh.positions[5] *= 7.0f;  // far off
    const Mat3 R = Eigen::AngleAxisd(2.5, Vec3(1, -2, 0.5).normalized()).toRotationMatrix();
    const Vec3 t(3, -2, 1);
    const TriMesh out = carried_by_sheet(
        s.mesh, s.sheet, sheet_moved(s.sheet, [&](const Vec3& X) { return Vec3(R * X + t); }));
    for (std::size_t v = 0; v < s.mesh.positions.size(); ++v) {
        const Vec3 p = R * s.mesh.positions[v].cast<double>() + t;
        // Half an ulp for each coordinate, which are below 16, and a little from double.
        EXPECT_NEAR((out.positions[v].cast<double>() - p).norm(), 0,
                    p.cwiseAbs().maxCoeff() * 1.1e-7)
            << v;
        EXPECT_NEAR((out.normals[v].cast<double>() - R * s.mesh.normals[v].cast<double>()).norm(),
                    0, 3e-7);
    }
}

// A sheet in a plane under any affine map of that: heights stay, and the rest goes along. Also
// beyond its rim, where the nearest place is on that.
TEST(SheetMotion, AnAffineMotionInThePlaneKeepsHeights)
{
    const Cubes sheet = flat_square();
    const Mat3 m = (Mat3() << 1.5, 0.3, 0, -0.2, 0.8, 0, 0, 0, 1).finished();
    const Vec3 t(1, 2, 3);
    const TriMesh mesh = points_with_normals(
        {{0.5f, 0.25f, 0}, {1.5f, 0.5f, 0.75f}, {0.5f, 1.5f, -0.5f}, {3, 3, 0}, {-1, 0.5f, 0.25f}},
        Vec3f(1, 2, 2) / 3);
    const TriMesh out = carried_by_sheet(
        mesh, sheet, sheet_moved(sheet, [&](const Vec3& X) { return Vec3(m * X + t); }));
    const Vec3 normal = (m.inverse().transpose() * Vec3(1, 2, 2)).normalized();
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 p = m * mesh.positions[v].cast<double>() + t;
        EXPECT_NEAR((out.positions[v].cast<double>() - p).norm(), 0, 1e-6) << v;  // floats below 8
        EXPECT_NEAR((out.normals[v].cast<double>() - normal).norm(), 0, 2e-7) << v;
    }
}

// One triangle, stretched to thrice its length along x: a vertex 0.5 m above stays that far above.
TEST(SheetMotion, AStretchedTriangleKeepsWhatLiesAboveItAtItsHeight)
{
    const Cubes one =
        make_sheet(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), 0.01).cubes;
    const TriMesh mesh = points_with_normals({{0.25f, 0.5f, 0.5f}}, {0, 0, 1});
    const std::vector<Vec3> x{{0, 0, 0}, {3, 0, 0}, {0, 1, 0}};
    const TriMesh out = carried_by_sheet(mesh, one, x);
    EXPECT_EQ(out.positions[0], Vec3f(0.75f, 0.5f, 0.5f));
    EXPECT_EQ(out.normals[0], Vec3f(0, 0, 1));
    // And turned by a right angle about y besides, which takes x to -z and z to x.
    const TriMesh turned = carried_by_sheet(mesh, one, {{0, 0, 0}, {0, 0, -3}, {0, 1, 0}});
    EXPECT_NEAR((turned.positions[0] - Vec3f(0.5f, 0.5f, -0.75f)).norm(), 0, 1e-7);
    EXPECT_NEAR((turned.normals[0] - Vec3f(1, 0, 0)).norm(), 0, 1e-7);
}

// Between two triangles, at a fold: F at the fold is the mean of theirs by their areas at rest.
TEST(SheetMotion, AtACornerIsTheMeanOfItsTrianglesByTheirAreas)
{
    // Triangle 0 (area 1.5) stays; triangle 1 (area 0.5) is turned up by a right angle about x.
    const Cubes sheet =
        make_sheet(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, -3, 0}, {0, 1, 0}}, {{0, 2, 1}, {0, 1, 3}}),
                   0.01)
            .cubes;
    std::vector<Vec3> x = sheet.place;
    x[3] = Vec3(0, 0, 1);
    const TriMesh mesh = points_with_normals({{0.5f, 0, 1}, {0, 1, 1}, {0, -3, 1}}, {0, 0, 1});
    const TriMesh out = carried_by_sheet(mesh, sheet, x);
    // Identity takes z to z, the turn to -y: 3/4 and 1/4 of them at the fold.
    EXPECT_NEAR((out.positions[0] - Vec3f(0.5f, -0.25f, 0.75f)).norm(), 0, 1e-6);
    // Corners of one triangle alone have its own.
    EXPECT_NEAR((out.positions[1] - Vec3f(0, -1, 1)).norm(), 0, 1e-6);
    EXPECT_NEAR((out.positions[2] - Vec3f(0, -3, 1)).norm(), 0, 1e-6);
    // F x = x and F y = (3 y + z) / 4, so cof(F) z = F x cross F y = (3 z - y) / 4.
    const Vec3f normal = Vec3f(0, -1, 3).normalized();
    EXPECT_NEAR((out.normals[0] - normal).norm(), 0, 1e-6);
}

TEST(SheetMotion, VerticesOnTheSheetStayOnIt)
{
    const Cubes sheet = make_sheet(test_meshes::icosphere(1), 0.01).cubes;
    const Random random(8);
    std::vector<Vec3> x = sheet.place;
    for (std::uint64_t k = 0; k < x.size(); ++k) {
        x[k] += Vec3(random.unit(3 * k), random.unit(3 * k + 1), random.unit(3 * k + 2));
    }
    // Its own corners, and places in each triangle.
    TriMesh mesh = sheet_mesh(sheet);
    std::vector<Vec3> wanted = x;
    for (std::size_t c = 0; c < sheet.count(); ++c) {
        const auto t = sheet_triangle(sheet, c);
        const Vec3 share(0.5, 0.125, 0.375);
        const auto mean = [&](const std::vector<Vec3>& at) {
            return Vec3(share[0] * at[t[0]] + share[1] * at[t[1]] + share[2] * at[t[2]]);
        };
        mesh.positions.push_back(mean(sheet.place).cast<float>());
        wanted.push_back(mean(x));
    }
    mesh.normals.clear();
    const TriMesh out = carried_by_sheet(mesh, sheet, x);
    for (std::size_t v = 0; v < wanted.size(); ++v) {
        // Floats of size 2, and places in cells as floats, times gradients of some 5.
        EXPECT_NEAR((out.positions[v].cast<double>() - wanted[v]).norm(), 0, 1e-6) << v;
    }
    // Corners land on their own places but for the rounding of the result.
    for (std::size_t k = 0; k < x.size(); ++k) {
        EXPECT_NEAR((out.positions[k] - x[k].cast<float>()).norm(), 0, 3e-7);
    }
}

// A strip of 4 m along x, rolled to a half circle of radius R about an axis along z: what is at
// height y goes to the radius R - y. In one step along it a triangle turns by an angle `turn`:
//   chords leave the circle by step^2 / 8 R
//   at inner corners the triangles on both sides are as many, and their turns cancel; at the rims
//   along x there are two on one side and one on the other, which leaves a sixth of a turn; at the
//   ends there is one side only, which leaves half of one
//   between corners, the mean of two turns is shorter by turn^2 / 8
TEST(SheetMotion, ADetailedMeshOnACoarseSheetFollowsItsCurve)
{
    constexpr double R = 4 / std::numbers::pi, height = 0.1;
    const auto rolled = [](const Vec3& X) {
        const double angle = X.x() / R;
        return Vec3((R - X.y()) * std::sin(angle), R - (R - X.y()) * std::cos(angle), X.z());
    };
    TriMesh mesh = geometry::grid(4, 1, 200, 50);
    for (Vec3f& p : mesh.positions) {
        p.y() = float(height) * std::sin(20 * p.x()) * std::cos(15 * p.z());
    }
    mesh.topology = std::make_shared<const MeshTopology>();
    mesh.normals.assign(mesh.positions.size(), Vec3f(0, 1, 0));
    for (const int steps : {16, 32, 64}) {
        const Cubes sheet = make_sheet(geometry::grid(4, 1, steps, steps / 4), 0.01).cubes;
        const double step = 4.0 / steps, turn = step / R, second = turn * turn / 8;
        const TriMesh out = carried_by_sheet(mesh, sheet, sheet_moved(sheet, rolled));
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const Vec3 X = mesh.positions[v].cast<double>();
            const double off = std::abs(X.x()) > 2 - step ? turn / 2 : turn / 6;
            EXPECT_LT((out.positions[v].cast<double>() - rolled(X)).norm(),
                      R * second + height * (off + 2 * second) + 1e-6);
            const double angle = X.x() / R;
            const Vec3 normal(-std::sin(angle), std::cos(angle), 0);
            EXPECT_LT((out.normals[v].cast<double>() - normal).norm(), off + 2 * second + 1e-6);
        }
    }
}

TEST(SheetMotion, CollapsedTrianglesGiveFiniteNumbers)
{
    const OnSheetScene s;
    const auto finite = [&](const std::vector<Vec3>& x) {
        const TriMesh out = carried_by_sheet(s.mesh, s.sheet, x);
        for (const Vec3f& p : out.positions) ASSERT_TRUE(p.allFinite());
        for (const Vec3f& n : out.normals) ASSERT_NEAR(n.norm(), 1, 1e-5);
    };
    finite(sheet_moved(s.sheet, [](const Vec3&) { return Vec3(1, 2, 3); }));
    finite(sheet_moved(s.sheet, [](const Vec3& X) { return Vec3(X.x(), 0, 0); }));
    finite(sheet_moved(s.sheet, [](const Vec3& X) { return Vec3(X.x(), X.y(), 0); }));
    finite(sheet_moved(s.sheet, [](const Vec3& X) { return X.x() > 0 ? Vec3(0, 1, 0) : X; }));
}

// Where all triangles at a corner have collapsed it goes as those beside it; where all have that
// are anywhere, as at rest.
TEST(SheetMotion, ACornerOfCollapsedTrianglesGoesWithItsNeighbours)
{
    // Triangle 0 stays whole and turns, triangle 1 collapses: corner 3 is of no other.
    const Cubes strip =
        make_sheet(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}}),
                   0.01)
            .cubes;
    ASSERT_EQ(strip.corner_count(), 4u);
    // Turned by a right angle about y: x to -z, z to x. Corner 3 falls upon corner 2.
    const std::vector<Vec3> x{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, {0, 1, 0}};
    const TriMesh mesh = points_with_normals({{1, 1, 0.5f}}, {0, 0, 1});
    const TriMesh out = carried_by_sheet(mesh, strip, x);
    EXPECT_NEAR((out.positions[0] - Vec3f(0.5f, 1, 0)).norm(), 0, 1e-6);
    EXPECT_NEAR((out.normals[0] - Vec3f(1, 0, 0)).norm(), 0, 1e-6);
    const std::vector<Vec3> point(4, Vec3(7, 7, 7));
    EXPECT_NEAR((carried_by_sheet(mesh, strip, point).positions[0] - Vec3f(7, 7, 7.5f)).norm(), 0,
                1e-6);
    EXPECT_EQ(carried_by_sheet(mesh, strip, point).normals[0], Vec3f(0, 0, 1));
}

// Two triangles of one area folded flat upon each other: at the fold the mean of identity and a
// half turn about x is diag(1, 0, 0), which takes no normal across it anywhere.
TEST(SheetMotion, ANormalThatWouldBeNothingStays)
{
    const Cubes sheet =
        make_sheet(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}}, {{0, 2, 1}, {0, 1, 3}}),
                   0.01)
            .cubes;
    std::vector<Vec3> x = sheet.place;
    x[3] = x[2];
    const TriMesh out = carried_by_sheet(points_with_normals({{0.5f, 0, 0}}, {0, 0, 1}), sheet, x);
    EXPECT_EQ(out.normals[0], Vec3f(0, 0, 1));
    EXPECT_EQ(out.positions[0], Vec3f(0.5f, 0, 0));
}

TEST(SheetMotion, VerticesThatAreNotFiniteHarmNoOthers)
{
    const Cubes sheet = flat_square();
    const TriMesh mesh = points_with_normals({{1, 1, 0}, {NAN, 1, 0}, {0, INFINITY, 0}}, {0, 0, 1});
    const Binding binding = bind(mesh, sheet);
    EXPECT_EQ(binding.farthest, 0);
    EXPECT_EQ(binding.local[1], Vec3f(0, 0, 0));
    const TriMesh out = embed(binding, mesh, sheet, sheet.place);
    EXPECT_EQ(out.positions[0], Vec3f(1, 1, 0));
    EXPECT_TRUE(std::isnan(out.positions[1].x()));
    EXPECT_EQ(out.positions[2].y(), INFINITY);
    EXPECT_EQ(out.normals[2], Vec3f(0, 0, 1));
}

// Normals that faces list for themselves, and some of no vertex.
TEST(SheetMotion, NormalsGoWithTheVertexWhoseTheyAre)
{
    const Cubes sheet = flat_square();
    TriMesh mesh = mesh_of({{0, 0, 0}, {2, 0, 0}, {2, 2, 0}}, {{0, 1, 2}});
    MeshTopology topology = *mesh.topology;
    topology.normal_triangles = {{2, 1, 3}};
    mesh.topology = std::make_shared<const MeshTopology>(topology);
    mesh.normals = {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, -1}};
    const TriMesh out = carried_by_sheet(
        mesh, sheet, sheet_moved(sheet, [](const Vec3& X) { return Vec3(0, X.y(), -X.x()); }));
    EXPECT_EQ(out.normals[0], Vec3f(0, 1, 0));  // of no vertex
    EXPECT_NEAR((out.normals[1] - Vec3f(1, 0, 0)).norm(), 0, 1e-7);
    EXPECT_NEAR((out.normals[2] - Vec3f(0, 0, -1)).norm(), 0, 1e-7);
    EXPECT_NEAR((out.normals[3] - Vec3f(-1, 0, 0)).norm(), 0, 1e-7);
}

TEST(SheetMotion, ForcesHandedBackKeepTheirSumAndOnTheSheetTheirTorque)
{
    const OnSheetScene s;
    const auto sums = [&](const TriMesh& mesh) {
        const Binding binding = bind(mesh, s.sheet);
        const Random random(2);
        std::vector<Vec3> forces;
        Vec3 sum = Vec3::Zero(), torque = Vec3::Zero();
        for (std::uint64_t v = 0; v < mesh.positions.size(); ++v) {
            forces.emplace_back(random.unit(3 * v), -random.unit(3 * v + 1),
                                random.unit(3 * v + 2));
            sum += forces.back();
            torque += mesh.positions[v].cast<double>().cross(forces.back());
            const std::array<double, 8> w = weights(binding, static_cast<std::uint32_t>(v));
            double all = 0;
            for (std::size_t a = 0; a < 8; ++a) {
                EXPECT_TRUE(a < 4 ? w[a] >= 0 && w[a] <= 1 : w[a] == 0);
                all += w[a];
            }
            EXPECT_NEAR(all, 1, 1e-15);
        }
        const std::vector<Vec3> at = transpose(binding, s.sheet, forces);
        for (std::size_t k = 0; k < at.size(); ++k) {
            sum -= at[k];
            torque -= s.sheet.place[k].cross(at[k]);
        }
        return std::pair(sum.norm(), torque.norm());
    };
    EXPECT_NEAR(sums(s.mesh).first, 0, 1e-10);
    // The triangles' middles are on the sheet, each within 1e-7 m of its place.
    TriMesh on;
    on.topology = std::make_shared<const MeshTopology>();
    for (std::size_t c = 0; c < s.sheet.count(); ++c) {
        on.positions.push_back(cell_middle(s.sheet, c).cast<float>());
    }
    EXPECT_NEAR(sums(on).first, 0, 1e-10);
    EXPECT_NEAR(sums(on).second, 0, 1e-7 * double(on.positions.size()));
}

TEST(SheetMotion, NumbersAtCornersAreInterpolatedInTheTriangle)
{
    const OnSheetScene s;
    TriMesh on;
    on.topology = std::make_shared<const MeshTopology>();
    for (std::size_t c = 0; c < s.sheet.count(); ++c) {
        on.positions.push_back(cell_middle(s.sheet, c).cast<float>());
    }
    const Vec3 slope(1, -2, 0.5);
    std::vector<double> values;
    for (const Vec3& p : s.sheet.place) values.push_back(3 + slope.dot(p));
    const std::vector<float> at = interpolate(bind(on, s.sheet), s.sheet, values);
    for (std::size_t v = 0; v < at.size(); ++v) {
        EXPECT_NEAR(at[v], 3 + slope.dot(on.positions[v].cast<double>()), 1e-6);
    }
    // Values of triangles by what fills them: of 1.5 m^2 and 0.5 m^2, at their common corners.
    const Cubes two =
        make_sheet(mesh_of({{0, 0, 0}, {1, 0, 0}, {0, -3, 0}, {0, 1, 0}}, {{0, 2, 1}, {0, 1, 3}}),
                   0.01)
            .cubes;
    const std::vector<double> mean = at_corners(two, std::vector<float>{8, 4});
    const std::vector<double> expected{7, 7, 8, 4};
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(mean[k], expected[k], 1e-14);
}

TEST(SheetMotion, SmoothNormalsAreThoseThatEmbedGives)
{
    const OnSheetScene s;
    const Binding binding = bind(s.mesh, s.sheet);
    const std::vector<Vec3> x = sheet_moved(
        s.sheet, [](const Vec3& X) { return Vec3(X.x() + 0.3 * X.y() * X.z(), X.y(), 2 * X.z()); });
    const TriMesh out = embed(binding, s.mesh, s.sheet, x);
    TriMesh again = out;
    smooth_normals(again, binding, s.mesh, s.sheet, x);
    EXPECT_EQ(again.normals, out.normals);
    EXPECT_NE(out.normals, s.mesh.normals);
}

TEST(SheetMotion, IsTheSameForAnyNumberOfThreads)
{
    const OnSheetScene s(4, 5);
    const std::vector<Vec3> x = sheet_moved(
        s.sheet, [](const Vec3& X) { return Vec3(X.x() + 0.3 * X.y() * X.z(), X.y(), 2 * X.z()); });
    const TriMesh many = carried_by_sheet(s.mesh, s.sheet, x);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const TriMesh alone = carried_by_sheet(s.mesh, s.sheet, x);
    EXPECT_EQ(many.positions, alone.positions);
    EXPECT_EQ(many.normals, alone.normals);
}

TEST(SheetMotion, ASheetDoesNotTearAndIsNoPatch)
{
    const OnSheetScene s;
    const Binding binding = bind(s.mesh, s.sheet);
    EXPECT_TRUE(find_parted(s.sheet, {}).empty());
    const TriMesh out = embed(binding, s.mesh, s.sheet, s.sheet.place);
    EXPECT_EQ(cut_torn(binding, s.mesh, out, s.sheet, s.sheet.place, {}, {}).positions,
              out.positions);
    for (const auto gone : torn_faces(binding, s.mesh, s.sheet, {})) EXPECT_EQ(gone, 0);
    try {
        bind_plane_detail(s.mesh, s.sheet, 1);
        ADD_FAILURE() << "nothing was refused";
    } catch (const std::invalid_argument& error) {
        EXPECT_STREQ(error.what(),
                     "the patch has to be a plane, found the sheet of a mesh: make it "
                     "with Plane");
    }
}

TEST(SheetMotion, NothingIsCarriedAsNothing)
{
    const TriMesh none = mesh_of({}, {});
    EXPECT_TRUE(carried_by_sheet(none, flat_square(), flat_square().place).positions.empty());
    EXPECT_THROW(embed(bind(none, flat_square()), none, flat_square(), {}), std::invalid_argument);
}

}  // namespace
