// Wrote the files beside it, which the tests of ReadVolume read:
//   g++ -std=c++20 -O1 write_by_openvdb.cpp -o /tmp/write -lopenvdb -ltbb -lImath-3_1
//   -lboost_iostreams /tmp/write tests/geometry/volumes
// No part of any build.

#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetSphere.h>

#include <limits>

using namespace openvdb;

// A sphere of radius 0.25 about (0.5, 0.5, 0.5), in voxels of 0.02.
static FloatGrid::Ptr sphere()
{
    auto grid = tools::createLevelSetSphere<FloatGrid>(0.25f, Vec3f(0.5f), 0.02f, 2.0f);
    grid->setName("surface");
    grid->setSaveFloatAsHalf(true);
    return grid;
}

// The same voxels, which are written once, in another place.
static FloatGrid::Ptr same(const FloatGrid::Ptr& grid, const char* name)
{
    auto other = grid->copy();
    other->setTransform(grid->transform().copy());
    other->setName(name);
    return other;
}

// 8 x 4 x 4 voxels of 0.1, the first at (0, 0, 0): 1, 2 ... 8 along x, 0 elsewhere.
static FloatGrid::Ptr ramp(const char* name)
{
    auto grid = FloatGrid::create(0);
    grid->setName(name);
    grid->setGridClass(GRID_FOG_VOLUME);
    grid->setTransform(math::Transform::createLinearTransform(0.1));
    for (auto at = CoordBBox({0, 0, 0}, {7, 3, 3}).begin(); at; ++at) {
        grid->tree().setValue(*at, float((*at).x() + 1));
    }
    return grid;
}

int main(int, char** argv)
{
    initialize();
    const std::string folder = argv[1];
    const auto ball = sphere(), fog = ramp("density");
    GridPtrVec all{ball, fog};

    // Twice as large, about (2, 3, 4).
    auto moved = same(ball, "moved");
    moved->transform().postScale(2);
    moved->transform().postTranslate({1, 2, 3});
    all.push_back(moved);

    auto mirrored = same(ball, "mirrored");
    mirrored->transform().postScale(Vec3d(-1, 1, 1));
    all.push_back(mirrored);

    // A block of 8^3 voxels that share one value, which the tree holds as a tile.
    auto tile = FloatGrid::create(0);
    tile->setName("tile");
    tile->setGridClass(GRID_FOG_VOLUME);
    tile->setTransform(math::Transform::createLinearTransform(0.1));
    tile->tree().addTile(1, Coord(0, 0, 0), 3, true);
    all.push_back(tile);

    // One tile of 4096^3 voxels.
    auto huge = FloatGrid::create(0);
    huge->setName("huge");
    huge->tree().root().addTile(Coord(0, 0, 0), 1, true);
    all.push_back(huge);

    auto empty = FloatGrid::create(0);
    empty->setName("empty");
    all.push_back(empty);

    auto broken = ramp("not_a_number");
    broken->tree().setValue(Coord(2, 1, 3), std::numeric_limits<float>::quiet_NaN());
    all.push_back(broken);

    auto frustum = same(fog, "frustum");
    frustum->setTransform(math::Transform::createFrustumTransform(
        BBoxd(Vec3d(0, 0, 0), Vec3d(8, 4, 4)), 0.5, 2.0, 0.1));
    all.push_back(frustum);

    auto velocity = Vec3SGrid::create();
    velocity->setName("velocity");
    velocity->tree().setValue(Coord(0, 0, 0), Vec3s(1, 0, 0));
    all.push_back(velocity);

    io::File grids(folder + "/grids.vdb");
    grids.setCompression(io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
    grids.write(all);
    io::File vectors(folder + "/no_floats.vdb");
    vectors.setCompression(io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
    vectors.write(GridPtrVec{velocity});
    ball->setName("");
    io::File unnamed(folder + "/unnamed.vdb");
    unnamed.setCompression(io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
    unnamed.write(GridPtrVec{ball});
    return 0;
}
