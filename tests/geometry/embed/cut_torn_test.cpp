#include "geometry/embed/cut_torn.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/embed/cut_faces.hpp"
#include "geometry/embed/torn_faces.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/normals.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/embed/torn_blocks.hpp"
#include "tests/geometry/meshes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

using namespace geometry;
using namespace torn_blocks;

// A solid torn straight through, one half at rest and one turned away: the mesh is parted in the
// middle of the torn cubes and nothing of it is lost, drawn out or bent.
TEST(CutTorn, HalvesMoveAsTheRigidBodiesTheyAre)
{
    const Cubes cubes = block({7, 4, 4}, 0.25, Vec3(-1, -0.5, -0.5));
    const TriMesh rest = meshes::moved(uv_sphere(0.45, 32, 16), Vec3(-0.1, 0.02, 0.01));
    const auto broken = links_across(cubes, 0, 3);
    const double middle = -1 + 0.25 * 3.5;
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (cubes.corner[k].x() > 3) x[k] = turned * x[k];
    }
    const TriMesh out = torn(rest, cubes, x, broken);
    ASSERT_GT(out.triangles().size(), rest.triangles().size());
    EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-5);

    double left = 0, right = 0;
    for (std::size_t f = 0; f < out.triangles().size(); ++f) {
        Vec3 mean = Vec3::Zero();
        for (const auto v : out.triangles()[f]) mean += out.positions[v].cast<double>() / 3;
        const bool is_left = mean.x() < middle && (mean - Vec3(-0.1, 0.02, 0.01)).norm() < 0.46;
        (is_left ? left : right) += area(out, f);
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3 p = out.positions[out.triangles()[f][k]].cast<double>();
            const Vec3 at = is_left ? p : Vec3(turned.inverse() * p);
            const Vec3 from = at - Vec3(-0.1, 0.02, 0.01);
            ASSERT_NEAR(from.norm(), 0.447, 0.0035) << f;  // on the sphere's flat faces
            ASSERT_TRUE(is_left ? at.x() < middle + 1e-6 : at.x() > middle - 1e-6) << at.x();
            const Vec3f& n = out.normals[out.topology->normal_triangles.empty()
                                             ? out.triangles()[f][k]
                                             : out.topology->normal_triangles[f][k]];
            const Vec3 lit = n.cast<double>();
            const Vec3 normal = is_left ? lit : Vec3(turned.linear().transpose() * lit);
            ASSERT_NEAR(normal.norm(), 1, 1e-5);
            ASSERT_GT(normal.dot(from.normalized()), 0.99);
        }
    }
    const double sphere = surface_area(rest);
    EXPECT_NEAR(left, sphere * (middle + 0.55) / 0.9, 0.01 * sphere);  // Archimedes
    EXPECT_NEAR(right, sphere * (0.35 - middle) / 0.9, 0.01 * sphere);
}

// No face goes from one half, which stays, to the other, 5 m on, and each half is where it was.
void expect_two_halves(const TriMesh& out, const TriMesh& rest, double middle, double tolerance)
{
    EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-5 * surface_area(rest));
    const Box box = bounds(rest);
    for (std::size_t f = 0; f < out.triangles().size(); ++f) {
        if (area(out, f) == 0) continue;
        int far = 0;
        for (const auto v : out.triangles()[f]) far += out.positions[v].x() > 3;
        ASSERT_TRUE(far == 0 || far == 3) << f;
        for (const auto v : out.triangles()[f]) {
            const Vec3 p = out.positions[v].cast<double>() - Vec3(far ? 5 : 0, 0, 0);
            ASSERT_LT((p - p.cwiseMax(box.lo).cwiseMin(box.hi)).norm(), tolerance) << f;
            ASSERT_LT(far ? middle - p.x() : p.x() - middle, tolerance) << f;
        }
    }
}

TEST(CutTorn, FacesOnTheOutermostPlanesAndBeyondAreCut)
{
    // A box exactly as large as its cubes, and higher, and lower.
    const Cubes cubes = block({7, 4, 4}, 0.25, Vec3(-1, -0.5, -0.5));
    const auto broken = links_across(cubes, 0, 3);
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (cubes.corner[k].x() > 3) x[k].x() += 5;
    }
    for (const double more : {0.0, 0.05, 0.2, -0.05}) {
        const Vec3 size(1.75, 1, 1 + more);
        const TriMesh rest = meshes::moved(box(size, {2, 1, 3}), Vec3(-0.125, 0, 0));
        expect_two_halves(torn(rest, cubes, x, broken), rest, -0.125, 1e-5);
        if (more > 0) continue;  // what closes it reaches as far as cubes do
        const TriMesh solid = closed(rest, cubes, x, broken);
        EXPECT_NEAR(enclosed_volume(solid), enclosed_volume(rest), 1e-4);
    }
}

// The mesh ends in the plane between the parts of cubes, of which one goes far away without it.
TEST(CutTorn, FacesBetweenPartsGoWithWhatTheyBound)
{
    const Cubes cubes = block({4, 3, 3}, 0.25, Vec3(-0.5, -0.375, -0.375));
    const TriMesh rest = box({0.75, 0.5, 0.5}, {3, 2, 2});
    for (const bool above : {false, true}) {
        const int below = above ? 3 : 0;
        const auto broken = links_across(cubes, 0, below);
        std::vector<Vec3> x = corner_positions(cubes);
        for (std::size_t k = 0; k < x.size(); ++k) {
            if ((cubes.corner[k].x() > below) == above) x[k].y() += 5;
        }
        for (const TriMesh& out : {torn(rest, cubes, x, broken), closed(rest, cubes, x, broken)}) {
            EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-6);
            for (const auto& triangle : out.triangles()) {
                for (const auto v : triangle) ASSERT_LT(out.positions[v].y(), 0.251f) << above;
            }
        }
    }
}

TEST(CutTorn, WallsThatStandOnAPlaneAreCutAndHidden)
{
    const Cubes sheet = plane_cubes(rectangle_cells(10, 6), {1, 0.1, {0, 0, 0}}, 0.02);
    const auto broken = links_across(sheet, 0, 4);
    std::vector<Vec3> x = corner_positions(sheet);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (sheet.corner[k].x() > 4) x[k].x() += 5;
    }
    const double middle = corner_positions(sheet)[0].x() + 0.45;
    const Box of_sheet = [&] {
        Box box;
        for (const Vec3& p : corner_positions(sheet)) box.add(p);
        return box;
    }();
    const Vec3 centre = (of_sheet.lo + of_sheet.hi) / 2;
    for (const Vec3& size : {Vec3(0.96, 0.3, 0.5), Vec3(1, 0.04, 0.6), Vec3(0.96, 3, 0.64)}) {
        const TriMesh rest = meshes::moved(box(size, {1, 1, 2}), centre);
        expect_two_halves(torn(rest, sheet, x, broken), rest, middle, 1e-5);
        const auto gone = torn_faces(bind(rest, sheet), rest, sheet, broken);
        for (std::size_t f = 0; f < gone.size(); ++f) {
            double low = 1e9, high = -1e9;
            for (const auto v : rest.triangles()[f]) {
                low = std::min(low, double(rest.positions[v].x()));
                high = std::max(high, double(rest.positions[v].x()));
            }
            EXPECT_EQ(gone[f] != 0, low < middle && high > middle) << f;
        }
    }
}

// Along and across, and with a corner in the tear's way: borders of both sides are one polyline
// each, so that vertices are shared by all that meet there.
TEST(CutTorn, WhatMeetsOnOneSideOfATearStaysJoined)
{
    const Cubes cubes = plane_cubes(rectangle_cells(6, 6), {1, 0.5, Vec3(0, 1, 0)}, 0.01);
    const TriMesh rest = plane_mesh(cubes);
    const auto broken = links_between(cubes, [](const Vec3i& a, const Vec3i& b) {
        const auto inside = [](const Vec3i& c) { return c.x() >= 2 && c.z() >= 3; };
        return inside(a) != inside(b);
    });
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (cubes.corner[k].x() >= 2 && cubes.corner[k].z() >= 3) x[k] = turned * x[k];
    }
    const TriMesh out = torn(rest, cubes, x, broken);
    EXPECT_NEAR(surface_area(out), 9, 1e-5);
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& t : out.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) sides[std::minmax(t[k], t[(k + 1) % 3])] += 1;
    }
    double border = 0;
    for (const auto& [ends, count] : sides) {
        ASSERT_LE(count, 2);
        if (count == 1)
            border += double((out.positions[ends.first] - out.positions[ends.second]).norm());
    }
    // The outline, and both sides of a tear that turns once.
    const double tear = (6 - 1.5) * 0.5 + (6 - 2.5) * 0.5;
    EXPECT_NEAR(border, 4 * 3 + 2 * tear, 1e-4);
    // Every normal is that of its side.
    const Vec3f up = turned.linear().col(1).cast<float>();
    ASSERT_EQ(out.topology->normal_triangles.size(), out.triangles().size());
    for (std::size_t f = 0; f < out.triangles().size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const bool moved = out.positions[out.triangles()[f][k]].y() != 1.0f;
            const Vec3f& n = out.normals[out.topology->normal_triangles[f][k]];
            ASSERT_LT((n - (moved ? up : Vec3f(Vec3f::UnitY()))).norm(), 1e-4f) << f;
        }
    }
    // What it carries above itself keeps its height, whatever is drawn out beside it.
    const TriMesh raised = meshes::moved(rest, Vec3(0, 0.2, 0));
    EXPECT_NEAR(surface_area(torn(raised, cubes, x, broken)), 9, 1e-5);
}

// Threads: corners that are linked along one axis alone, turned across it.
TEST(CutTorn, WhatHangsOnOneLinkTurnsAsThatDoes)
{
    const Cubes cubes = plane_cubes(rectangle_cells(5, 3), {1, 0.5, Vec3::Zero()}, 0.01);
    const TriMesh rest = plane_mesh(cubes);
    const auto across = [](const Vec3i& a, const Vec3i& b) { return a.z() != b.z(); };
    const Mat3 turn = Eigen::AngleAxisd(0.8, Vec3::UnitZ()).toRotationMatrix();
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p = turn * p;
    for (const double height : {0.0, 0.2}) {
        const TriMesh raised = meshes::moved(rest, Vec3(0, height, 0));
        const TriMesh out = torn(raised, cubes, x, links_between(cubes, across));
        EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-5);
        for (const auto& triangle : out.triangles()) {
            for (const auto v : triangle) {
                const Vec3 back = turn.transpose() * out.positions[v].cast<double>();
                ASSERT_NEAR(back.y(), height, 1e-6);
                ASSERT_TRUE(back.x() > -1e-6 && back.x() < 2.5 + 1e-6) << back.transpose();
            }
        }
        const Vec3f up = turn.col(1).cast<float>();
        for (const auto& triangle : out.topology->normal_triangles) {
            for (const auto n : triangle) ASSERT_LT((out.normals[n] - up).norm(), 1e-5f);
        }
    }
}

// Sheets of corners, linked along two axes, anyhow turned: the third is across both.
TEST(CutTorn, WhatHangsOnTwoLinksTurnsAsTheyDo)
{
    const Cubes cubes = block({3, 1, 3}, 0.5, Vec3::Zero());
    const TriMesh rest = meshes::moved(box({1.4, 0.4, 1.4}, {4, 4, 4}), Vec3(0.75, 0.25, 0.75));
    const auto above = [](const Vec3i& a, const Vec3i& b) { return a.y() != b.y(); };
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p = turned * p;
    const TriMesh out = torn(rest, cubes, x, links_between(cubes, above));
    EXPECT_GT(out.triangles().size(), rest.triangles().size());
    EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-5);
    for (const auto& triangle : out.triangles()) {
        for (const auto v : triangle) {
            const Vec3 back = turned.inverse() * out.positions[v].cast<double>();
            const Vec3 from = (back - Vec3(0.75, 0.25, 0.75)).cwiseAbs();
            ASSERT_NEAR(std::max({from.x() - 0.7, from.y() - 0.2, from.z() - 0.7}), 0, 1e-5);
        }
    }
}

TEST(CutTorn, WhatHangsOnNoLinkGoesAlongUnturned)
{
    // All links of a plane's cell are gone: each quarter goes with its corner.
    const Cubes cubes = plane_cubes(rectangle_cells(1, 1), {1, 1, Vec3::Zero()}, 0.01);
    const TriMesh rest = plane_mesh(cubes);
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p *= 3;
    const TriMesh out =
        torn(rest, cubes, x, links_between(cubes, [](const Vec3i&, const Vec3i&) { return true; }));
    EXPECT_NEAR(surface_area(out), 1, 1e-6);
    for (std::size_t f = 0; f < out.triangles().size(); ++f) {
        for (const auto v : out.triangles()[f]) {
            const Vec3f& p = out.positions[v];
            for (const int d : {0, 2}) {
                EXPECT_TRUE((p[d] > -1e-5f && p[d] < 0.50001f) ||
                            (p[d] > 2.49999f && p[d] < 3.00001f))
                    << p.transpose();
            }
            EXPECT_NEAR(p.y(), 0, 1e-6);
        }
    }
}

TEST(CutTorn, KeepsWhatBelongsToFacesAndVertices)
{
    const Cubes cubes = block({4, 1, 1}, 1, Vec3::Zero());
    TriMesh rest = meshes::soup({{0.2f, 0.5f, 0.2f},
                                 {3.8f, 0.5f, 0.2f},
                                 {3.8f, 0.5f, 0.8f},
                                 {0.1f, 0.2f, 0.2f},
                                 {0.8f, 0.2f, 0.2f},
                                 {0.8f, 0.2f, 0.8f}},
                                {{0, 1, 2}, {3, 4, 5}});
    auto topology = std::make_shared<MeshTopology>(*rest.topology);
    topology->uvs = {{0.2f, 0.2f}, {3.8f, 0.2f}, {3.8f, 0.8f}};
    topology->uv_triangles = {{0, 1, 2}, {0, 1, 2}};
    topology->materials.resize(2);
    topology->material = {1, 0};
    topology->groups = {"a", "b"};
    topology->group = {1, 0};
    rest.topology = topology;
    rest.colours = {{0.2f, 0, 0}, {3.8f, 0, 0}, {3.8f, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    rest.attributes = {{"along", "m", {0.2f, 3.8f, 3.8f, 0, 0, 0}}};
    const std::vector<Vec3> x = corner_positions(cubes);  // parted, but not moved
    const TriMesh out = torn(rest, cubes, x, links_across(cubes, 0, 1));
    EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-6);
    ASSERT_EQ(out.triangles()[0], rest.triangles()[1]);  // untouched, and first now
    EXPECT_EQ(out.topology->material[0], 0);
    ASSERT_GE(out.triangles().size(), 4u);
    ASSERT_EQ(out.colours.size(), out.positions.size());
    ASSERT_EQ(out.attributes[0].values.size(), out.positions.size());
    bool left = false, right = false;
    for (std::size_t f = 1; f < out.triangles().size(); ++f) {
        EXPECT_EQ(out.topology->material[f], 1);
        EXPECT_EQ(out.topology->group[f], 1);
        bool is_left = true, is_right = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = out.triangles()[f][k];
            const Vec3f& p = out.positions[v];
            EXPECT_NEAR(out.colours[v].x(), p.x(), 1e-5);
            EXPECT_NEAR(out.attributes[0].values[v], p.x(), 1e-5);
            const Vec2f uv = out.topology->uvs[out.topology->uv_triangles[f][k]];
            EXPECT_LT((uv - Vec2f(p.x(), p.z())).norm(), 1e-5f);
            is_left &= p.x() < 1.50001f;
            is_right &= p.x() > 1.49999f;
        }
        EXPECT_TRUE(is_left || is_right);
        left |= is_left;
        right |= is_right;
    }
    EXPECT_TRUE(left && right);
    for (std::size_t v = 0; v < rest.positions.size(); ++v) {
        EXPECT_LT((out.positions[v] - rest.positions[v]).norm(), 1e-6f);
    }
}

// One quad lies in a whole cube, one across the tear.
TEST(CutTorn, QuadsThatAreNotCutStayQuads)
{
    const Cubes cubes = block({4, 1, 1}, 1, Vec3::Zero());
    TriMesh rest = meshes::soup({{0.1f, 0.2f, 0.2f},
                                 {0.8f, 0.2f, 0.2f},
                                 {0.8f, 0.2f, 0.8f},
                                 {0.1f, 0.2f, 0.8f},
                                 {3.8f, 0.2f, 0.2f},
                                 {3.8f, 0.2f, 0.8f}},
                                {{1, 4, 5}, {1, 5, 2}, {0, 1, 2}, {0, 2, 3}});
    auto topology = std::make_shared<MeshTopology>(*rest.topology);
    topology->polygon = {0, 0, 1, 1};
    rest.topology = topology;
    const TriMesh out = torn(rest, cubes, corner_positions(cubes), links_across(cubes, 0, 1));
    meshes::expect_consistent(out);
    EXPECT_NEAR(surface_area(out), surface_area(rest), 1e-6);
    const Outlines faces = outlines(*out.topology);
    EXPECT_EQ(faces.count(), out.triangles().size() - 1);
    ASSERT_EQ(faces[0].size(), 4u);  // what is not cut comes first
    EXPECT_EQ(faces.most_corners(), 4u);
    for (const std::uint32_t c : faces[0]) EXPECT_LT(out.triangles()[c / 3][c % 3], 4u);
}

// Outside of all cubes, a piece goes with one part; what sticks out goes on as its cube does,
// however far and however that is bent.
TEST(CutTorn, WhatIsInNoCubeStaysTogetherAndNear)
{
    const Cubes cubes = block({3, 1, 1}, 1, Vec3::Zero());
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p += 0.2 * Vec3(p.y() * p.z() * p.x(), p.x() * p.y(), 0);
    for (std::size_t k = 0; k < x.size(); ++k) x[k].x() += cubes.corner[k].x() > 1 ? 10 : 0;
    for (const float y : {2.0f, 1.2f}) {  // one that is apart, but near, as well
        const TriMesh rest = meshes::soup({{1.2f, 0.5f, 0.5f},
                                           {1.3f, 60, 0.4f},
                                           {1.3f, 60, 40},  // sticks out
                                           {1.2f, y, 0.2f},
                                           {1.8f, y, 0.2f},
                                           {1.8f, y, 0.8f}},
                                          {{0, 1, 2}, {3, 4, 5}});
        const auto broken = links_across(cubes, 0, 1);
        const TriMesh out = torn(rest, cubes, x, broken);
        for (const Vec3f& p : out.positions) {
            EXPECT_LT(p.cwiseAbs().maxCoeff(), 90) << p.transpose();
        }
        const auto& p = out.positions;
        EXPECT_LT((p[3] - p[4]).norm(), 1.5f);
        EXPECT_LT((p[4] - p[5]).norm(), 1.5f);
        EXPECT_EQ(torn_faces(bind(rest, cubes), rest, cubes, broken)[1], 0);
        EXPECT_EQ(std::ranges::count(out.triangles(), Triangle{3, 4, 5}), 1);  // not cut
    }
}

TEST(CutTorn, PointsGoWithTheirPartToo)
{
    const Cubes cubes = block({3, 1, 1}, 1, Vec3::Zero());
    TriMesh rest;
    rest.positions = {{1.1f, 0.5f, 0.5f}, {1.49f, 0.2f, 0.1f}, {1.51f, 0.2f, 0.1f}, {2.5f, 0, 0}};
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) x[k].x() += cubes.corner[k].x() > 1 ? 10 : 0;
    const TriMesh out = torn(rest, cubes, x, links_across(cubes, 0, 1));
    ASSERT_EQ(out.positions.size(), 4u);
    for (std::size_t v = 0; v < 4; ++v) {
        const Vec3f way = out.positions[v] - rest.positions[v];
        EXPECT_LT((way - Vec3f(v < 2 ? 0 : 10, 0, 0)).norm(), 1e-5f) << v;
    }
}

TEST(CutTorn, WhatIsWholeStaysAsItIs)
{
    const Cubes cubes = block({4, 1, 1}, 1, Vec3::Zero());
    const TriMesh rest = meshes::moved(box({0.5, 0.5, 0.5}, {1, 1, 1}), Vec3(0.5, 0.5, 0.5));
    const std::vector<Vec3> x = corner_positions(cubes);
    for (const auto& broken : {std::vector<std::uint32_t>{}, std::vector<std::uint32_t>{0},
                               links_across(cubes, 0, 2)}) {  // none, not parted, elsewhere
        const TriMesh out = torn(rest, cubes, x, broken);
        EXPECT_EQ(out.topology, rest.topology);
        EXPECT_EQ(out.positions.size(), rest.positions.size());
    }
}

TEST(CutTorn, AFaceThatIsHugeOrNotFiniteIsNoTrouble)
{
    const Cubes cubes = block({3, 1, 1}, 1e-3, Vec3::Zero());
    const float far = 1e5f, nan = std::numeric_limits<float>::quiet_NaN();
    const TriMesh rest =
        meshes::soup({{-far, 5e-4f, -far}, {far, 5e-4f, -far}, {0, 5e-4f, far}, {0, nan, 1}},
                     {{0, 1, 2}, {0, 1, 3}});
    std::vector<Vec3> x = corner_positions(cubes);
    const TriMesh out = torn(rest, cubes, x, links_across(cubes, 0, 1));
    EXPECT_GT(out.triangles().size(), 2u);
    // Of 3 cubes and the 6 large pieces around them; each side of a piece that others end on is in
    // more parts then, by no more than there are such ends.
    const auto broken = links_across(cubes, 0, 1);
    const auto parted = find_parted(cubes, broken);
    const CutFaces cut = cut_faces(bind(rest, cubes), rest, cubes, parted, nullptr);
    EXPECT_LT(cut.faces.size(), 40u);
    EXPECT_LE(out.triangles().size(), cut.faces.size() + cut.corners.size());
    EXPECT_EQ(closed(rest, cubes, x, links_across(cubes, 0, 1)).triangles().size(),
              out.triangles().size());
    for (Vec3& p : x) p = Vec3::Zero();  // all in one place
    EXPECT_GT(torn(rest, cubes, x, links_across(cubes, 0, 1)).triangles().size(), 2u);
}
