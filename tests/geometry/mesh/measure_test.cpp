#include "geometry/mesh/measure.hpp"

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"

#include <gtest/gtest.h>

using namespace geometry;

// The tetrahedron of the unit corner: volume 1/6, three right triangles of area 1/2 and one of
// side sqrt 2.
static TriMesh unit_corner()
{
    MeshTopology topology;
    topology.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    TriMesh mesh;
    mesh.topology = std::make_shared<const MeshTopology>(std::move(topology));
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return mesh;
}

TEST(Measure, ATetrahedronHasItsAreaAndVolume)
{
    EXPECT_NEAR(surface_area(unit_corner()), 1.5 + std::sqrt(3.0) / 2, 1e-12);
    EXPECT_NEAR(enclosed_volume(unit_corner()), 1.0 / 6, 1e-12);
}

TEST(Measure, VolumeDoesNotDependOnWhereTheMeshStands)
{
    TriMesh far = unit_corner();
    for (Vec3f& p : far.positions) p += Vec3f(64, -128, 32);
    EXPECT_NEAR(enclosed_volume(far), 1.0 / 6, 1e-9);  // float positions: exact for these shifts
}

TEST(Measure, AMovedVertexIsFoundAndItsStretchMeasured)
{
    const TriMesh rest = unit_corner();
    TriMesh moved = rest;
    moved.positions[3] = {0, 0, 3};
    const Displacement d = displacement(moved, rest);
    EXPECT_EQ(d.largest, 2);
    EXPECT_EQ(d.mean, 0.5);
    EXPECT_EQ(d.rms, 1);  // sqrt(2^2 / 4)
    EXPECT_EQ(d.where, 3u);
    EXPECT_EQ(displacement_at(moved, rest, {0, 0.1, 0.9}), Vec3(0, 0, 2));
    EXPECT_EQ(largest_stretch(moved, rest), 3);  // edge 0-3: 1 -> 3
}

TEST(Measure, AVertexThatIsNotANumberIsTheLargestDisplacementAndNotFinite)
{
    const TriMesh rest = unit_corner();
    TriMesh moved = rest;
    moved.positions[2].x() = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(all_finite(moved));
    EXPECT_TRUE(std::isnan(displacement(moved, rest).mean));
    EXPECT_TRUE(std::isnan(largest_stretch(moved, rest)));
}

TEST(Measure, MeshesOfDifferentSizeAreRefusedAndEmptyOnesMeasureNothing)
{
    EXPECT_THROW(displacement(unit_corner(), TriMesh{}), std::invalid_argument);
    EXPECT_EQ(surface_area(TriMesh{}), 0);
    EXPECT_EQ(enclosed_volume(TriMesh{}), 0);
    EXPECT_EQ(displacement(TriMesh{}, TriMesh{}).largest, 0);
}

TEST(Measure, TellsOfCoordinatesThatAreRounded)
{
    TriMesh mesh = icosphere(0.5, 2);
    EXPECT_EQ(far_from_origin(mesh), "");
    EXPECT_EQ(far_from_origin(TriMesh{}), "");
    for (auto& p : mesh.positions) p.x() += 5000;
    EXPECT_EQ(far_from_origin(mesh), "");
    for (auto& p : mesh.positions) p.x() -= 1.005e6f;
    EXPECT_EQ(
        far_from_origin(mesh),
        "coordinates near 1e+06 m are rounded to steps of 0.1 m, which is visible on a mesh 1 m "
        "long: move the mesh to the origin before this step");
}
