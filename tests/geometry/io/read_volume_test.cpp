// VDB files, written by tests/geometry/volumes/write_by_openvdb.cpp.

#include "geometry/io/read_volume.hpp"

#include "geometry/io/imported_volume.hpp"
#include "geometry/mesh/mass_properties.hpp"
#include "tests/geometry/files.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <numbers>

namespace geometry {
namespace {

const std::string volumes = ASPIC_SOURCE_DIR "/tests/geometry/volumes/";

#define SKIP_WITHOUT_OPENVDB()                                                                     \
    if (const std::string why = why_no_volumes(); !why.empty()) GTEST_SKIP() << why

ReadVolume read(const std::string& grid, VolumeOptions options = {})
{
    options.grid = grid;
    return read_volume(volumes + "grids.vdb", options);
}

std::string error_of(const files::fs::path& path, const VolumeOptions& options = {})
{
    try {
        read_volume(path, options);
    } catch (const std::exception& error) {
        return error.what();
    }
    return "read without an error";
}

std::string error_of_grid(const std::string& grid, VolumeOptions options = {})
{
    options.grid = grid;
    return error_of(volumes + "grids.vdb", options);
}

void expect_tells(const std::string& told, const char* text)
{
    EXPECT_NE(told.find(text), std::string::npos) << told;
}

double volume_of(const TriMesh& mesh)
{
    return mass_properties(mesh).mass;
}

// Each edge is in one face one way, and in another the other way.
bool is_closed(const TriMesh& mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle& t : mesh.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    return std::all_of(edges.begin(), edges.end(), [&](const auto& e) {
        const auto back = edges.find({e.first.second, e.first.first});
        return e.second == 1 && back != edges.end() && back->second == 1;
    });
}

constexpr double ball = 4.0 / 3 * std::numbers::pi * 0.25 * 0.25 * 0.25;  // m^3
constexpr double voxel = 0.02 * 0.02 * 0.02;

TEST(ReadVolume, TheSurfaceOfALevelSetIsTheSphereThatItHolds)
{
    SKIP_WITHOUT_OPENVDB();
    const ReadVolume made = read("surface");
    EXPECT_TRUE(is_closed(made.mesh));
    EXPECT_NEAR(volume_of(made.mesh), ball, 0.01 * ball);  // negative where faces look inwards
    for (const Vec3f& p : made.mesh.positions) {
        EXPECT_NEAR((p - Vec3f::Constant(0.5f)).norm(), 0.25, 0.1 * 0.02);
    }
    ASSERT_FALSE(made.mesh.normals.empty());
    EXPECT_GT(made.mesh.normals[made.mesh.topology->normal_triangles[0][0]].dot(
                  made.mesh.positions[made.mesh.triangles()[0][0]] - Vec3f::Constant(0.5f)),
              0);
}

// Those whose middles are in the sphere. The file holds distances as half floats: within 1e-4 m.
TEST(ReadVolume, PointsAreTheVoxelsInside)
{
    SKIP_WITHOUT_OPENVDB();
    const ReadVolume made = read("surface");
    std::size_t inside = 0;
    for (int i = 0; i < 51 * 51 * 51; ++i) {
        const int y = i / 51 % 51, z = i / (51 * 51);
        const Vec3 at(i % 51 * 0.02, y * 0.02, z * 0.02);
        inside += (at - Vec3::Constant(0.5)).norm() < 0.25 - 1e-4;
    }
    const auto count = double(made.points.positions.size());
    EXPECT_NEAR(count, double(inside), 40.0);  // as many may lie on it to rounding
    EXPECT_NEAR(count * voxel, ball, 0.02 * ball);
    EXPECT_TRUE(made.points.triangles().empty());
    ASSERT_EQ(made.points.attributes.size(), 1u);
    const Attribute& value = made.points.attributes[0];
    EXPECT_EQ(value.name, "surface");
    EXPECT_EQ(value.unit, "m");
    ASSERT_EQ(value.values.size(), made.points.positions.size());
    // Distances in the band of two voxels, and its width within.
    for (std::size_t i = 0; i < value.values.size(); ++i) {
        const double r = (made.points.positions[i] - Vec3f::Constant(0.5f)).norm();
        EXPECT_NEAR(value.values[i], std::max(r - 0.25, -0.04), 1e-4);
    }
}

TEST(ReadVolume, AnIsovalueGrowsALevelSet)
{
    SKIP_WITHOUT_OPENVDB();
    VolumeOptions grown;
    grown.iso = 0.03;
    const double volume = volume_of(read("surface", grown).mesh), r = 0.28 / 0.25;
    EXPECT_NEAR(volume, ball * r * r * r, 0.01 * volume);
}

// Twice as large about (2, 3, 4); in centimetres with z up, that is (0.02, 0.04, -0.03).
TEST(ReadVolume, TheTransformTheUnitAndTheAxisAreThoseOfTheFile)
{
    SKIP_WITHOUT_OPENVDB();
    const ReadVolume moved = read("moved");
    EXPECT_NEAR(volume_of(moved.mesh), 8 * ball, 0.01 * 8 * ball);
    EXPECT_LT((bounds(moved.mesh).centre() - Vec3(2, 3, 4)).norm(), 1e-3);
    EXPECT_LT((bounds(moved.points).centre() - Vec3(2, 3, 4)).norm(), 1e-3);
    VolumeOptions options;
    options.unit = LengthUnit::centimetre;
    options.up = UpAxis::z;
    options.iso = 0.0003;
    const ReadVolume turned = read("moved", options);
    EXPECT_LT((bounds(turned.mesh).centre() - Vec3(0.02f, 0.04f, -0.03f)).norm(), 1e-5);
    EXPECT_LT((bounds(turned.points).centre() - Vec3(0.02f, 0.04f, -0.03f)).norm(), 1e-5);
    const auto [low, high] = std::minmax_element(turned.points.attributes[0].values.begin(),
                                                 turned.points.attributes[0].values.end());
    EXPECT_NEAR(*low, -0.0004, 1e-6);
    EXPECT_LT(*high, 0.0003);
    EXPECT_GT(*high, 0.0002);
}

TEST(ReadVolume, AMirroredGridStillFacesOutwards)
{
    SKIP_WITHOUT_OPENVDB();
    const ReadVolume made = read("mirrored");
    EXPECT_NEAR(volume_of(made.mesh), ball, 0.01 * ball);
    EXPECT_NEAR(bounds(made.mesh).centre().x(), -0.5, 1e-3);
}

// 8 x 4 x 4 voxels of 0.1 m, of values 1 to 8 along x. From 2.5 on there are 6 x 4 x 4. Surfaces
// lie where linear values between the middles of voxels cross 2.5: at x = 0.15 m, and 2.5 / v of a
// voxel short of the zeros around.
TEST(ReadVolume, InsideAFogIsWhatIsAsMuchOrMore)
{
    SKIP_WITHOUT_OPENVDB();
    VolumeOptions options;
    options.fog_iso = 2.5;
    const ReadVolume made = read("density", options);
    ASSERT_EQ(made.points.positions.size(), 96u);
    EXPECT_EQ(made.points.attributes[0].name, "density");
    EXPECT_EQ(made.points.attributes[0].unit, "");
    for (std::size_t i = 0; i < 96; ++i) {
        const double x = made.points.positions[i].x();
        EXPECT_NEAR(made.points.attributes[0].values[i], 1 + x / 0.1, 1e-5);
    }
    EXPECT_TRUE(is_closed(made.mesh));
    EXPECT_GT(volume_of(made.mesh), 0);
    EXPECT_NEAR(bounds(made.mesh).lo.x(), 0.15, 1e-3);
    EXPECT_LT(bounds(made.mesh).hi.x(), 0.8);
    EXPECT_GT(bounds(made.mesh).hi.x(), 0.7);
    options.fog_iso = 3;  // exactly that of a voxel
    EXPECT_EQ(read("density", options).points.positions.size(), 96u);
}

// Its voxels are the cubes of 0.1 m from (-0.05, -0.05, -0.05) on.
TEST(ReadVolume, ABlockOfOneValueIsAllItsVoxels)
{
    SKIP_WITHOUT_OPENVDB();
    const ReadVolume made = read("tile");
    EXPECT_EQ(made.points.positions.size(), 512u);
    EXPECT_LT((bounds(made.points).lo - Vec3::Zero()).norm(), 1e-6);
    EXPECT_LT((bounds(made.points).hi - Vec3::Constant(0.7f)).norm(), 1e-6);
    EXPECT_TRUE(is_closed(made.mesh));
}

TEST(ReadVolume, MakesWhatIsAskedFor)
{
    SKIP_WITHOUT_OPENVDB();
    VolumeOptions options;
    options.make = VolumeParts::mesh;
    const ReadVolume mesh = read("surface", options);
    EXPECT_FALSE(mesh.mesh.positions.empty());
    EXPECT_TRUE(mesh.points.positions.empty());
    options.make = VolumeParts::points;
    const ReadVolume points = read("surface", options);
    EXPECT_TRUE(points.mesh.positions.empty());
    EXPECT_FALSE(points.points.positions.empty());
}

TEST(ReadVolume, TheGridThatIsReadWithoutANameIsTheSurface)
{
    SKIP_WITHOUT_OPENVDB();
    EXPECT_EQ(read("").points.attributes[0].name, "surface");
    // A file whose one grid has no name.
    EXPECT_EQ(read_volume(volumes + "unnamed.vdb").points.attributes[0].name, "value");
}

TEST(ReadVolume, AGridThatCannotBeUsedIsToldWithTheReason)
{
    SKIP_WITHOUT_OPENVDB();
    expect_tells(error_of_grid("dens"), "there is no grid \"dens\", but \"density\" (float), ");
    expect_tells(error_of_grid("velocity"),
                 "grid \"velocity\" holds values of type vec3s, expected float");
    expect_tells(error_of(volumes + "no_floats.vdb"),
                 "expected a grid of floats, found \"velocity\" (vec3s)");
    expect_tells(error_of_grid("empty"), "grid \"empty\" is empty: it has no active voxel");
    expect_tells(error_of_grid("frustum"), "has a frustum transform, expected an affine one");
    expect_tells(error_of_grid("not_a_number"), "has the value nan at voxel [2, 1, 3]");
    expect_tells(error_of_grid("huge"),
                 "has 68719476736 active voxels, more than max_voxels = 50000000");
    VolumeOptions few;
    few.max_voxels = 9000;  // a ball of 0.27 m has 10,306
    few.iso = 0.02;
    few.make = VolumeParts::points;
    expect_tells(error_of_grid("surface", few), " inner voxels, more than max_voxels = 9000");
    few.make = VolumeParts::mesh;
    EXPECT_GT(read("surface", few).mesh.positions.size(), 0u);
}

TEST(ReadVolume, AnIsovalueBeyondAllValuesIsTold)
{
    SKIP_WITHOUT_OPENVDB();
    VolumeOptions options;
    options.iso = 0.06;
    expect_tells(error_of_grid("surface", options),
                 "would be inside, where its value is 0.0400085: expected less than that");
    options.iso = -0.3;
    expect_tells(error_of_grid("surface", options), "no voxel of grid \"surface\" is inside");
    options.fog_iso = 9;
    expect_tells(error_of_grid("density", options), "its values reach from 0 to 8");
    options.fog_iso = 0;
    expect_tells(error_of_grid("density", options),
                 "would be inside, where its value is 0: expected more than that");
}

TEST(ReadVolume, AFileThatIsNoneIsTold)
{
    SKIP_WITHOUT_OPENVDB();
    const files::Folder folder;
    expect_tells(error_of(folder.path / "none.vdb"), "there is no file");
    expect_tells(error_of(folder.path), "is a folder");
    expect_tells(error_of(folder.write("empty.vdb", "")), "is empty");
    expect_tells(error_of(folder.write("text.vdb", "hello, world")), "expected a VDB file");
    const std::string whole = files::bytes_of(volumes + "no_floats.vdb");
    for (const std::size_t size : {9u, 40u, 400u, 5000u}) {
        expect_tells(error_of(folder.write("cut.vdb", whole.substr(0, size))), "cut.vdb: ");
    }
}

// Whatever a byte says, there is a volume or an error, within the limits.
TEST(ReadVolume, DamagedFilesEndInAnErrorOrAVolume)
{
    SKIP_WITHOUT_OPENVDB();
    const files::Folder folder;
    const std::string whole = files::bytes_of(volumes + "unnamed.vdb");
    VolumeOptions options;
    options.limits.gigabytes = 0.5;
    options.limits.seconds = 5;
    for (std::size_t k = 0; k < 24; ++k) {
        std::string bytes = whole;
        bytes[(k * 53 + 20) % 1200] ^= static_cast<char>(1 << k % 8);
        const std::string told = error_of(folder.write("damaged.vdb", bytes), options);
        EXPECT_TRUE(told == "read without an error" || told.find("damaged.vdb: ") == 0 ||
                    told.find("/damaged.vdb: ") != std::string::npos)
            << told;
    }
}

// Another program in place of aspic-openvdb, as long as this lives.
class ProgramAt {
public:
    explicit ProgramAt(const files::fs::path& program)
    {
        if (const char* before = std::getenv("ASPIC_OPENVDB")) kept_ = before;
        setenv("ASPIC_OPENVDB", program.c_str(), 1);
    }
    ProgramAt(const ProgramAt&) = delete;
    ~ProgramAt()
    {
        if (kept_.empty()) {
            unsetenv("ASPIC_OPENVDB");
        } else {
            setenv("ASPIC_OPENVDB", kept_.c_str(), 1);
        }
    }

private:
    std::string kept_;
};

// A reader that a damaged file damaged hands over what is no mesh.
TEST(ReadVolume, WhatIsHandedOverIsCheckedBeforeItIsUsed)
{
    const ImportedVolume good{.grid = "density",
                              .positions = {Vec3f(0, 0, 0), Vec3f(1, 0, 0), Vec3f(0, 1, 0)},
                              .triangles = {{0, 1, 2}},
                              .points = {Vec3f(0, 0, 0)},
                              .values = {1},
                              .error = {}};
    ImportedVolume no_vertex = good, no_value = good, no_place = good;
    no_vertex.triangles[0][2] = 3;
    no_value.values.clear();
    no_place.points[0].x() = std::numeric_limits<float>::infinity();
    const files::Folder folder;
    const auto error_with = [&](const ImportedVolume& volume) {
        const auto handed = folder.write("handed", pack(volume));
        const auto script = folder.write("fake", "#!/bin/sh\ncat '" + handed.string() + "' >&3\n");
        files::fs::permissions(script, files::fs::perms::owner_all);
        const ProgramAt program(script);
        return error_of_grid("density");
    };
    EXPECT_EQ(error_with(good), "read without an error");
    for (const ImportedVolume& volume : {no_vertex, no_value, no_place}) {
        expect_tells(error_with(volume), "its voxels have places that are not finite, or are not "
                                         "whole: the file is damaged. Write it again");
    }
}

TEST(ReadVolume, ABuildWithoutOpenVdbSaysHowToGetIt)
{
    const ProgramAt program("/nowhere/aspic-openvdb");
    const std::string error = error_of_grid("surface");
    expect_tells(error, "aspic-openvdb, the program that reads VDB files, is not at /nowhere");
    expect_tells(error, "Install libopenvdb-dev and libboost-iostreams-dev");
    EXPECT_EQ(error, why_no_volumes());
}

TEST(ReadVolume, AProcessThatIsLostIsToldWithTheReason)
{
    const files::Folder folder;
    const auto error_by = [&](const std::string& script) {
        const auto file = folder.write("fake", "#!/bin/sh\n" + script);
        files::fs::permissions(file, files::fs::perms::owner_all);
        const ProgramAt program(file);
        VolumeOptions options;
        options.limits.seconds = 0.3;
        return error_of_grid("surface", options);
    };
    expect_tells(error_by("kill -SEGV $$"), "grids.vdb: OpenVDB crashed (Segmentation fault");
    expect_tells(error_by("exit 3"), "grids.vdb: reading it takes more than 8 GiB of memory");
    expect_tells(error_by("sleep 20"), "grids.vdb: reading it takes more than 0.3 s");
    expect_tells(error_by("echo nonsense >&3"), "grids.vdb: the result of ");
}

}  // namespace
}  // namespace geometry
