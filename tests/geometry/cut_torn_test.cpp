#include "geometry/cut_torn.hpp"

#include "geometry/embed.hpp"
#include "geometry/measure.hpp"
#include "geometry/normals.hpp"
#include "geometry/plane.hpp"
#include "geometry/primitive.hpp"
#include "geometry/random.hpp"
#include "geometry/torn_faces.hpp"
#include "meshes.hpp"

#include <gtest/gtest.h>

#include <map>
#include <set>

using namespace geometry;

namespace {

Cubes block(const Vec3i& n, double size, const Vec3& origin)
{
    std::vector<Vec3i> cells;
    for (int z = 0; z < n.z(); ++z) {
        for (int y = 0; y < n.y(); ++y) {
            for (int x = 0; x < n.x(); ++x) cells.emplace_back(x, y, z);
        }
    }
    return solid_cubes(cells, size, {}, origin);
}

// Links between corners that `apart` says are apart.
template <class Apart>
std::vector<std::uint32_t> links_between(const Cubes& cubes, const Apart& apart)
{
    std::set<std::uint32_t> broken;
    for (const auto& corners : cubes.corners) {
        for (std::uint32_t a = 0; a < 8; ++a) {
            for (std::uint32_t d = 0; d < 3; ++d) {
                const std::uint32_t i = corners[a], j = corners[a | 1u << d];
                if (i != j && apart(cubes.corner[i], cubes.corner[j])) broken.insert(3 * i + d);
            }
        }
    }
    return {broken.begin(), broken.end()};
}

std::vector<std::uint32_t> links_across(const Cubes& cubes, int axis, int below)
{
    return links_between(cubes, [&](const Vec3i& a, const Vec3i& b) {
        return (a[axis] <= below) != (b[axis] <= below);
    });
}

TriMesh torn(const TriMesh& rest, const Cubes& cubes, const std::vector<Vec3>& x,
             const std::vector<std::uint32_t>& broken, const Closing& closing = {})
{
    const auto parted = find_parted(cubes, broken);
    const Binding binding = bind(rest, cubes);
    TriMesh carried = embed(binding, rest, cubes, x, marked(cubes, parted));
    return cut_torn(binding, rest, std::move(carried), cubes, x, broken, parted, closing);
}

// Far enough for what is moved to be told from what is not.
const Transform turned = [] {
    Transform t = Transform::Identity();
    t.translate(Vec3(0.4, -0.2, 0.7));
    t.rotate(Eigen::AngleAxisd(1.3, Vec3(1, 2, -1).normalized()));
    return t;
}();

// The same as a solid, cut and closed.
TriMesh closed(const TriMesh& rest, const Cubes& cubes, const std::vector<Vec3>& x,
               const std::vector<std::uint32_t>& broken,
               const std::optional<Material>& material = {})
{
    const TriangleBvh solid(rest);
    return torn(rest, cubes, x, broken, {&solid, material});
}

double area(const TriMesh& mesh, std::size_t f)
{
    const auto& [a, b, c] = mesh.triangles()[f];
    const auto& p = mesh.positions;
    return 0.5 * double((p[b] - p[a]).cross(p[c] - p[a]).norm());
}

}  // namespace

TEST(FindParted, CountsWhatTheLinksOfACubeLeaveJoined)
{
    const Cubes cubes = block({3, 2, 2}, 0.5, Vec3(1, 2, 3));
    EXPECT_TRUE(find_parted(cubes, {}).empty());
    // One link less, or all around one edge: each cube still joins the ends another way.
    const std::uint32_t first = cubes.corners[0][0];
    EXPECT_TRUE(find_parted(cubes, std::vector{3 * first}).empty());
    // A corner of the block that has lost its three links is a part of its own.
    const auto lone = find_parted(cubes, std::vector{3 * first, 3 * first + 1, 3 * first + 2});
    ASSERT_EQ(lone.size(), 1u);
    EXPECT_EQ(lone[0].cube, 0u);
    EXPECT_EQ(lone[0].parts, 2);
    EXPECT_EQ(lone[0].part, (std::array<std::uint8_t, 8>{0, 1, 1, 1, 1, 1, 1, 1}));
    // All cubes of a slice are in halves.
    const auto slice = find_parted(cubes, links_across(cubes, 0, 1));
    ASSERT_EQ(slice.size(), 4u);
    for (const PartedCube& p : slice) {
        EXPECT_EQ(cubes.cell[p.cube].x(), 1);
        EXPECT_EQ(p.part, (std::array<std::uint8_t, 8>{0, 1, 0, 1, 0, 1, 0, 1}));
    }
    // Every link gone: eight parts each.
    const auto dust =
        find_parted(cubes, links_between(cubes, [](const Vec3i&, const Vec3i&) { return true; }));
    ASSERT_EQ(dust.size(), cubes.count());
    for (const PartedCube& p : dust) EXPECT_EQ(p.parts, 8);
    const auto all = marked(cubes, slice);
    EXPECT_EQ(std::count(all.begin(), all.end(), 1), 4);
    EXPECT_EQ(all[slice[2].cube], 1);
}

TEST(FindParted, OfAPlaneKnowsNoThickness)
{
    const Cubes cubes = plane_cubes(rectangle_cells(3, 2), {1, 0.25, Vec3::Zero()}, 0.01);
    const auto parted = find_parted(cubes, links_across(cubes, 2, 1));
    ASSERT_EQ(parted.size(), 3u);
    for (const PartedCube& p : parted) {
        EXPECT_EQ(cubes.cell[p.cube].z(), 1);
        EXPECT_EQ(p.parts, 2);
        EXPECT_EQ(p.part, (std::array<std::uint8_t, 8>{0, 0, 0, 0, 1, 1, 1, 1}));
    }
}

TEST(FindParted, OfCubesThatShareACellIsTheFirst)
{
    Cubes cubes = solid_cubes({{0, 0, 0}}, 1);  // and a copy of it, linked to nothing
    cubes.cell.push_back(cubes.cell[0]);
    cubes.corners.push_back(cubes.corners[0]);
    for (auto& k : cubes.corners[1]) k += 8;
    for (std::size_t k = 0; k < 8; ++k) cubes.corner.push_back(cubes.corner[k]);
    const auto lone = [&](std::uint32_t k) {
        return find_parted(cubes, std::vector{3 * k, 3 * k + 1, 3 * k + 2});
    };
    EXPECT_EQ(lone(0).size(), 1u);
    EXPECT_TRUE(lone(8).empty());
}

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
    // The outline, and both sides of a tear that turns once. In the cell where it does the outer
    // part has a corner on the edge of the cell below, which is not cut: that edge counts twice.
    const double tear = (6 - 1.5) * 0.5 + (6 - 2.5) * 0.5;
    EXPECT_NEAR(border, 4 * 3 + 2 * tear + 2 * 0.5, 1e-4);
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
    EXPECT_LT(out.triangles().size(), 40u);
    EXPECT_EQ(closed(rest, cubes, x, links_across(cubes, 0, 1)).triangles().size(),
              out.triangles().size());
    for (Vec3& p : x) p = Vec3::Zero();  // all in one place
    EXPECT_GT(torn(rest, cubes, x, links_across(cubes, 0, 1)).triangles().size(), 2u);
}

namespace {

// Of the faces that close what is cut.
double inside_area(const TriMesh& mesh)
{
    const MeshTopology& t = *mesh.topology;
    double sum = 0;
    for (std::size_t f = 0; f < t.group.size(); ++f) {
        if (t.groups[t.group[f]] == "inside") sum += area(mesh, f);
    }
    return sum;
}

TriMesh reversed(TriMesh mesh)
{
    MeshTopology topology = *mesh.topology;
    for (auto* faces : {&topology.triangles, &topology.normal_triangles}) {
        for (Triangle& t : *faces) std::swap(t[1], t[2]);
    }
    mesh.topology = std::make_shared<const MeshTopology>(std::move(topology));
    for (Vec3f& n : mesh.normals) n = -n;
    return mesh;
}

TriMesh together(const TriMesh& one, const TriMesh& other)
{
    const std::array both{&one, &other};
    return merge(both);
}

// Blocks of corners that are each of one of three pieces, at random.
std::vector<std::size_t> random_pieces(const Cubes& cubes, std::uint64_t seed)
{
    const Random random(seed);
    std::map<std::array<int, 3>, std::size_t> piece;
    std::vector<std::size_t> of;
    for (const Vec3i& at : cubes.corner) {
        const auto [found, fresh] = piece.try_emplace({at.x() / 3, at.y() / 2, at.z() / 3}, 0);
        if (fresh) found->second = std::size_t(3 * random.unit(piece.size()));
        of.push_back(found->second);
    }
    return of;
}

std::vector<std::uint32_t> links_between_pieces(const Cubes& cubes,
                                                const std::vector<std::size_t>& piece)
{
    std::map<std::array<int, 3>, std::size_t> piece_at;
    const auto key = [](const Vec3i& p) { return std::array{p.x(), p.y(), p.z()}; };
    for (std::size_t k = 0; k < piece.size(); ++k) piece_at[key(cubes.corner[k])] = piece[k];
    return links_between(cubes, [&](const Vec3i& a, const Vec3i& b) {
        return piece_at[key(a)] != piece_at[key(b)];
    });
}

}  // namespace

TEST(CutCaps, HalvesOfASolidAreClosed)
{
    const Cubes cubes = block({7, 4, 4}, 0.25, Vec3(-1, -0.5, -0.5));
    const TriMesh rest = box({1.4, 0.7, 0.6}, {3, 2, 2});  // -0.7 .. 0.7, ...
    const auto broken = links_across(cubes, 0, 3);
    std::vector<Vec3> x = corner_positions(cubes);
    for (std::size_t k = 0; k < x.size(); ++k) {
        if (cubes.corner[k].x() > 3) x[k] = turned * x[k];
    }
    const TriMesh out = closed(rest, cubes, x, broken);
    EXPECT_NEAR(inside_area(out), 2 * 0.7 * 0.6, 1e-6);
    EXPECT_NEAR(surface_area(out), surface_area(rest) + 2 * 0.7 * 0.6, 1e-5);
    EXPECT_NEAR(enclosed_volume(out), enclosed_volume(rest), 1e-5);
    ASSERT_TRUE(all_finite(out));
    // What closes faces away from what it closes, and every vertex is on one side.
    const double middle = -1 + 0.25 * 3.5;
    const MeshTopology& t = *out.topology;
    for (std::size_t f = 0; f < t.triangles.size(); ++f) {
        if (t.groups[t.group[f]] != "inside") continue;
        const Vec3f& normal = out.normals[t.normal_triangles[f][0]];
        const Vec3 p = out.positions[t.triangles[f][0]].cast<double>();
        const bool is_left = std::abs(p.x() - middle) < 1e-6;
        const Vec3 expected = is_left ? Vec3(1, 0, 0) : Vec3(turned.linear() * Vec3(-1, 0, 0));
        EXPECT_NEAR((normal.cast<double>() - expected).norm(), 0, 1e-5) << f;
        EXPECT_NEAR(is_left ? p.x() : (turned.inverse() * p).x(), middle, 1e-6) << f;
    }
    // Without the tree it stays open.
    EXPECT_EQ(inside_area(torn(rest, cubes, x, broken)), 0);
}

// The volume of what is cut is that of the whole, by pieces of any shape: so what closes it fits
// the rims, on solids with curves, holes and pieces within each other.
TEST(CutCaps, KeepTheVolumeOfAnySolid)
{
    const Cubes cubes = block({12, 12, 12}, 0.1, Vec3(-0.6, -0.6, -0.6));
    const TriMesh hollow =
        together(icosphere(0.5, 3), reversed(meshes::moved(icosphere(0.25, 2), Vec3(0.05, 0, 0))));
    const std::vector<std::pair<const char*, TriMesh>> solids{
        {"ball", icosphere(0.53, 3)},
        {"torus", torus(0.38, 0.13, 40, 20)},
        {"hollow", hollow},
        {"box", box({1.03, 0.4, 0.77}, {2, 3, 1})},
        {"inside out", reversed(icosphere(0.45, 2))},
    };
    for (const auto& [name, rest] : solids) {
        const double volume = enclosed_volume(rest);
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            const auto piece = random_pieces(cubes, seed);
            const auto broken = links_between_pieces(cubes, piece);
            auto x = corner_positions(cubes);
            const TriMesh still = closed(rest, cubes, x, broken);
            EXPECT_GT(inside_area(still), 0.1) << name << seed;
            EXPECT_NEAR(enclosed_volume(still), volume, 1e-5) << name << seed;
            // The volume of what is closed does not depend on where it is.
            for (std::size_t k = 0; k < x.size(); ++k) x[k] += double(piece[k]) * Vec3(3, 1, 2);
            const TriMesh apart = closed(rest, cubes, x, broken);
            EXPECT_NEAR(enclosed_volume(apart), volume, 1e-5) << name << seed;
            EXPECT_NEAR(surface_area(apart), surface_area(rest) + inside_area(still), 1e-4)
                << name << seed;
        }
    }
}

// Hundreds of edges in the plane of one cube, on a curve that bends both ways.
TEST(CutCaps, KeepTheVolumeOfAFineMeshInLargeCubes)
{
    const Cubes cubes = block({2, 2, 2}, 0.6, Vec3(-0.6, -0.6, -0.6));
    TriMesh rest = icosphere(0.5, 6);
    for (Vec3f& p : rest.positions) p *= 1 + 0.15f * std::sin(40 * p.x()) * std::sin(40 * p.y());
    for (int axis = 0; axis < 3; ++axis) {
        const auto broken = links_across(cubes, axis, 0);
        auto x = corner_positions(cubes);
        for (std::size_t k = 0; k < x.size(); ++k) {
            if (cubes.corner[k][axis] > 0) x[k] += Vec3(1, 2, 3);
        }
        const TriMesh out = closed(rest, cubes, x, broken);
        // Slivers at the rim, where the mesh is all but in the plane, may be taken for outside.
        EXPECT_NEAR(enclosed_volume(out), enclosed_volume(rest), 5e-5) << axis;
        EXPECT_GT(inside_area(out), 0.5) << axis;
    }
}

TEST(CutCaps, OfPiecesThatOverlapAreThoseOfAll)
{
    // Two boxes that share 0.2 x 0.5 x 0.5 of the plane: what closes them does so once.
    const Cubes cubes = block({8, 8, 8}, 0.15, Vec3(-0.6, -0.6, -0.6));
    const TriMesh rest = together(meshes::moved(box({0.5, 0.5, 0.5}, {1, 1, 1}), Vec3(0, 0, 0.1)),
                                  meshes::moved(box({0.5, 0.5, 0.5}, {1, 1, 1}), Vec3(0, 0, -0.2)));
    const auto broken = links_across(cubes, 0, 3);
    const TriMesh out = closed(rest, cubes, corner_positions(cubes), broken);
    EXPECT_NEAR(inside_area(out), 2 * 0.5 * 0.8, 1e-5);
}

TEST(CutCaps, AreNoneWhereNothingIsEnclosed)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    const auto broken = links_across(cubes, 1, 2);
    TriMesh sheet = grid(1, 1, 5, 5);
    move(sheet, placement({0, 0, 0}, {70, 10, 0}, {1, 1, 1}, {0, 0, 0}));
    const TriMesh out = closed(sheet, cubes, corner_positions(cubes), broken);
    EXPECT_GT(out.triangles().size(), sheet.triangles().size());
    EXPECT_EQ(inside_area(out), 0);
    // Nor where a face of the mesh lies in the plane.
    for (const double y : {0.1, -0.3}) {  // above it, and below
        const TriMesh beside = meshes::moved(box({0.8, 0.4, 0.8}, {1, 1, 1}), Vec3(0, y, 0));
        EXPECT_EQ(inside_area(closed(beside, cubes, corner_positions(cubes), broken)), 0) << y;
    }
}

TEST(CutCaps, OfASoupAreFinite)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    for (std::uint64_t seed = 2; seed < 5; ++seed) {  // 3: with a face that is a line
        const Random random(seed);
        std::vector<Vec3f> points;
        std::vector<Triangle> faces;
        for (std::uint32_t k = 0; k < 900; ++k) {
            // Many on the planes themselves, so that edges lie on each other.
            const auto number = [&](std::uint64_t d) {
                return 0.1f * float(std::round(12 * random.unit(3 * k + d))) - 0.6f;
            };
            points.emplace_back(number(0), number(1), number(2));
            if (k % 3 == 2) faces.push_back({k - 2, k - 1, k});
        }
        const TriMesh rest = meshes::soup(points, faces);
        const auto broken = links_between_pieces(cubes, random_pieces(cubes, seed));
        const TriMesh out = closed(rest, cubes, corner_positions(cubes), broken);
        EXPECT_TRUE(all_finite(out));
        // No more than both sides of all planes.
        EXPECT_LT(inside_area(out), 2 * 3 * 6 * 1.44);
    }
}

TEST(CutCaps, LookLikeWhatIsNear)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    TriMesh rest = meshes::with_material(box({0.5, 0.5, 0.5}, {1, 1, 1}), {"red"}, "a");
    rest.attributes.push_back({"heat", "K", std::vector<float>(rest.positions.size(), 7.0f)});
    rest.colours.assign(rest.positions.size(), Vec3f(0.1f, 0.2f, 0.3f));
    const TriMesh out = closed(rest, cubes, corner_positions(cubes), links_across(cubes, 2, 2));
    const MeshTopology& t = *out.topology;
    EXPECT_EQ(t.groups, (std::vector<std::string>{"a", "inside"}));
    ASSERT_EQ(t.group.size(), t.triangles.size());
    ASSERT_EQ(t.material.size(), t.triangles.size());
    for (const auto m : t.material) EXPECT_EQ(t.materials[m].name, "red");
    ASSERT_EQ(out.attributes[0].values.size(), out.positions.size());
    for (const float v : out.attributes[0].values) EXPECT_NEAR(v, 7, 1e-5);
    for (const Vec3f& c : out.colours) EXPECT_NEAR((c - Vec3f(0.1f, 0.2f, 0.3f)).norm(), 0, 1e-6);
    EXPECT_NEAR(inside_area(out), 2 * 0.25, 1e-6);
}

TEST(CutCaps, HaveAMaterialOfTheirOwnAndLieInItAsTheyDoInTheirPlane)
{
    const Cubes cubes = block({6, 6, 6}, 0.2, Vec3(-0.6, -0.6, -0.6));
    for (const bool has_materials : {false, true}) {
        TriMesh rest = box({0.5, 0.5, 0.5}, {1, 1, 1});
        MeshTopology with_uvs = *rest.topology;
        with_uvs.materials.clear();
        with_uvs.material.clear();
        if (has_materials) {
            with_uvs.materials = {{"blue"}, {"red"}};
            with_uvs.material.assign(with_uvs.triangles.size(), 1);
        }
        with_uvs.uvs = {{0, 0}, {1, 0}, {0, 1}};
        with_uvs.uv_triangles.assign(with_uvs.triangles.size(), {0, 1, 2});
        rest.topology = std::make_shared<const MeshTopology>(with_uvs);
        const Material crumb{"crumb", {0.9f, 0.8f, 0.6f}};
        std::vector<Vec3> x = corner_positions(cubes);
        for (Vec3& p : x) p += Vec3(3, 0, 0);
        const TriMesh out = closed(rest, cubes, x, links_across(cubes, 2, 2), crumb);
        const MeshTopology& t = *out.topology;
        const std::uint16_t before = has_materials ? 1 : 0;
        ASSERT_EQ(t.materials.size(), before + 2u);
        EXPECT_EQ(t.materials[before].name, has_materials ? "red" : "");
        EXPECT_EQ(t.materials[before + 1u], crumb);
        ASSERT_EQ(t.material.size(), t.triangles.size());
        ASSERT_EQ(t.uv_triangles.size(), t.triangles.size());
        double uv_area = 0;
        for (std::size_t f = 0; f < t.triangles.size(); ++f) {
            const bool inside = t.groups[t.group[f]] == "inside";
            EXPECT_EQ(t.material[f], inside ? before + 1 : before);
            if (!inside) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3f& p = out.positions[t.triangles[f][k]];
                const Vec2f& uv = t.uvs[t.uv_triangles[f][k]];
                EXPECT_NEAR((uv - Vec2f(p[0] - 3, p[1])).norm(), 0, 1e-5);
            }
            uv_area += area(out, f);
        }
        EXPECT_NEAR(uv_area, 2 * 0.25, 1e-6);
    }
}
