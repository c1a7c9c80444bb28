#include "geometry/cubes/plane.hpp"

#include "geometry/embed/embed.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

#include <numbers>

using namespace geometry;

namespace {

// A sheet of 3 by 2 cells with the middle one of the lower row missing.
Cubes holed(int axis)
{
    Cells2 cells = rectangle_cells(3, 2);
    std::erase(cells, std::array{1, 0});
    return plane_cubes(cells, {axis, 0.5, {1, 2, 3}}, 0.01, {"cloth", 400, 1e6, 0, 0, 0});
}

}  // namespace

TEST(Plane, HasOneCornerWhereFourCellsMeetAndTheMassOfItsThickness)
{
    for (const int axis : {0, 1, 2}) {
        const Cubes plane = holed(axis);
        EXPECT_EQ(flat_axis(plane), axis);
        EXPECT_EQ(plane.count(), 5u);
        EXPECT_EQ(plane.corner_count(), 12u);  // 4 by 3, each still used by some cell
        // 5 cells of 0.25 m^2, 0.01 m thick, of 400 kg/m^3.
        EXPECT_NEAR(total_mass(plane), 5, 1e-12);
        for (const Vec3& p : corner_positions(plane)) EXPECT_EQ(p[axis], Vec3(1, 2, 3)[axis]);
        double sum = 0;
        for (const double m : corner_masses(plane)) sum += m;
        EXPECT_NEAR(sum, 5, 1e-12);
    }
    EXPECT_EQ(flat_axis(solid_cubes({{0, 0, 0}}, 1)), -1);
    EXPECT_EQ(flat_axis({}), -1);
    EXPECT_THROW(need_thickness(holed(1), "x"), std::invalid_argument);
    EXPECT_THROW(plane_cubes({}, {1, 0.5}, 0.01), std::invalid_argument);
    EXPECT_THROW(plane_cubes({{0, 0}}, {1, 0}, 0.01), std::invalid_argument);
    EXPECT_THROW(plane_cubes({{0, 0}}, {1, 1}, 0), std::invalid_argument);
    EXPECT_THROW(rectangle_cells(100'000, 100'000), std::invalid_argument);
}

TEST(Plane, MeshFacesAlongTheFlatAxis)
{
    for (const int axis : {0, 1, 2}) {
        const TriMesh mesh = plane_mesh(holed(axis));
        EXPECT_EQ(mesh.triangles().size(), 10u);
        for (const auto& t : mesh.triangles()) {
            const Vec3f n = (mesh.positions[t[1]] - mesh.positions[t[0]])
                                .cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
            EXPECT_FLOAT_EQ(n[axis], 0.25f);  // twice half a cell
        }
    }
}

TEST(Plane, OfAnEllipseHasItsArea)
{
    // 200 by 100 cells: pi / 4 of the rectangle, to a cell's width along its edge (about 1 %).
    EXPECT_NEAR(double(ellipse_cells(200, 100).size()), 20'000 * 0.785398, 200);
}

TEST(Plane, OfAPictureFollowsItsInk)
{
    // 4 by 2 pixels: ink in the left half above, in the right half below.
    const PlanePicture picture{4, 2, {1, 1, 0, 0, 0, 0, 1, 1}};
    const auto high = picture_cells(picture, 2, 4, 0.5);  // the first row is the upper one
    EXPECT_EQ(high, (Cells2{{2, 0}, {3, 0}, {0, 1}, {1, 1}}));
    const auto flat = picture_cells(picture, 1, 4, 0.5);  // lying: the first row is far away, low z
    EXPECT_EQ(flat, (Cells2{{0, 0}, {1, 0}, {2, 1}, {3, 1}}));
    // Of 2 by 2 pixels each: both are half ink.
    EXPECT_EQ(picture_cells(picture, 2, 2, 0.5), (Cells2{{0, 0}, {1, 0}}));
    EXPECT_TRUE(picture_cells(picture, 2, 2, 0.51).empty());
    EXPECT_EQ(picture_cells(picture, 2, 8, 0.5).size(), 16u);  // finer than pixels
    EXPECT_THROW(picture_cells({}, 2, 4, 0.5), std::invalid_argument);
}

TEST(Plane, OfAMeshFootprintHasItsHoles)
{
    // A ring seen from above: cells within 0.2 of the circle of radius 1.
    const TriMesh ring = torus(1, 0.2, 64, 16);
    const PlaneGrid grid{1, 0.05, {-1.2, 0, -1.2}};
    std::size_t in = 0;
    for (const auto& cell : footprint_cells(ring, grid)) {
        const double x = -1.2 + 0.05 * (cell[0] + 0.5), z = -1.2 + 0.05 * (cell[1] + 0.5);
        EXPECT_NEAR(std::hypot(x, z), 1, 0.2);
        ++in;
    }
    // pi (1.2^2 - 0.8^2) / 0.05^2, less what 64 straight pieces cut off.
    EXPECT_NEAR(double(in), 1005, 15);
    EXPECT_TRUE(footprint_cells({}, grid).empty());
}

TEST(Plane, CarriesAMeshAtItsHeight)
{
    // Turned by a quarter about x: what stood 0.1 above the plane stands off by 0.1 along its new
    // normal, and so does what hung below.
    const Cubes plane = plane_cubes(rectangle_cells(4, 4), {1, 0.25, {0, 0, 0}}, 0.01);
    TriMesh mesh;
    mesh.positions = {{0.4f, 0.1f, 0.6f}, {0.3f, -0.1f, 0.2f}, {0.9f, 0, 0.9f}};
    mesh.normals = {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}};
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = {{0, 1, 2}};
    mesh.topology = topology;
    const Mat3 turn = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()).toRotationMatrix();
    std::vector<Vec3> x = corner_positions(plane);
    for (Vec3& p : x) p = turn * p + Vec3(1, 2, 3);
    const TriMesh moved = embed(bind(mesh, plane), mesh, plane, x);
    for (std::size_t v = 0; v < 3; ++v) {
        const Vec3f expected =
            (turn * mesh.positions[v].cast<double>() + Vec3(1, 2, 3)).cast<float>();
        EXPECT_LT((moved.positions[v] - expected).norm(), 1e-5f);
        EXPECT_LT((moved.normals[v] - Vec3f(0, 0, 1)).norm(), 1e-5f);
    }
}

// Points in a row along x beside and on a plane of 1 m by 1 m, all at one height.
TriMesh row_at(float height)
{
    TriMesh mesh;
    auto topology = std::make_shared<MeshTopology>();
    for (const float x : {-0.3f, 0.0f, 0.1f, 0.5f, 0.85f, 1.0f, 1.2f}) {
        mesh.positions.emplace_back(x, height, 0.4f);
        mesh.normals.emplace_back(0, 1, 0);
    }
    for (std::uint32_t v = 1; v < 7; ++v) topology->triangles.push_back({v - 1, v, v});
    mesh.topology = topology;
    return mesh;
}

TEST(Plane, CarriesWhatIsOverItAndWhatIsUnderItAlike)
{
    // On a plane bent about its middle, whose mirror image is itself upside down, what is as far
    // under it moves as the mirror image of what is over it: however far, in no more cubes or
    // fewer.
    const Cubes plane = plane_cubes(rectangle_cells(4, 4), {1, 0.25, {0, 0, 0}}, 0.01);
    const auto bent = [&](double up) {
        std::vector<Vec3> x = corner_positions(plane);
        for (Vec3& p : x) p.y() += up * (p.x() - 0.5) * (p.x() - 0.5);
        return x;
    };
    for (const float height : {0.02f, 0.2f, 0.7f}) {
        const TriMesh over = row_at(height), under = row_at(-height);
        const Binding above = bind(over, plane), below = bind(under, plane);
        // Only what lies beside it.
        for (const Binding* b : {&above, &below}) {
            ASSERT_EQ(b->strays.size(), 2u) << height;
            EXPECT_EQ(b->strays[0].vertex, 0u);
            EXPECT_EQ(b->strays[1].vertex, 6u);
            EXPECT_NEAR(b->farthest, 0.3, 1e-6);
        }
        const TriMesh up = embed(above, over, plane, bent(0.8));
        const TriMesh down = embed(below, under, plane, bent(-0.8));
        for (std::size_t v = 0; v < 7; ++v) {
            const Vec3f& p = down.positions[v];
            EXPECT_LT((up.positions[v] - Vec3f(p.x(), -p.y(), p.z())).norm(), 1e-6f) << v;
        }
    }
}

TEST(Plane, ReadsAPictureAsInk)
{
    // A grey TGA of two pixels, black and white.
    std::string tga(18, '\0');
    tga[2] = 3;
    tga[12] = 2;
    tga[14] = 1;
    tga[16] = 8;
    const files::Folder folder;
    const auto path = folder.write("two.tga", tga + std::string("\x00\xff", 2));
    const PlanePicture dark = read_plane_picture(path, PictureInk::dark),
                       bright = read_plane_picture(path, PictureInk::bright);
    EXPECT_EQ(dark.width, 2);
    EXPECT_NEAR(dark.value[0], 1, 1e-6);
    EXPECT_NEAR(dark.value[1], 0, 1e-6);
    EXPECT_NEAR(bright.value[1], 1, 1e-6);
    EXPECT_NEAR(read_plane_picture(path, PictureInk::opaque).value[0], 1, 1e-6);
}

TEST(Plane, SaysWhichFileIsNoPicture)
{
    const files::Folder folder;
    const auto path = folder.write("not.png", "no picture at all");
    EXPECT_THROW(read_plane_picture(path, PictureInk::dark), std::runtime_error);
    EXPECT_THROW(read_plane_picture(folder.path / "missing.png", PictureInk::dark),
                 std::runtime_error);
}
