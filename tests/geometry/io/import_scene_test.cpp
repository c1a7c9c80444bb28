#include "geometry/io/import_scene.hpp"

#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

#include <random>

namespace {

using namespace geometry;

const char* const triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string import_error(const files::fs::path& path, const ImportOptions& options = {})
{
    try {
        return import_scene(path, options).error;
    } catch (const std::runtime_error& error) {
        return error.what();
    }
}

ImportedScene some_scene()
{
    ImportedScene scene;
    scene.meshes.resize(2);
    scene.meshes[0] = {"a",
                       1,
                       {{1, 2, 3}, {4, 5, 6}},
                       {},
                       {{1, 0, 0}, {0, 1, 0}},
                       {{0.5f, 1}},
                       {{0, 1, 7}},
                       {3},
                       5,
                       {{0, 3}}};
    scene.materials = {{"steel", {0.1f, 0.2f, 0.3f}, 0.5f, 0.25f, 1.f}};
    scene.nodes = {{"root", 1, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}}};
    scene.unit = 0.01;
    scene.files = {{"/x/y.mtl", false}};
    scene.error = "none really";
    return scene;
}

TEST(ImportScene, WhatIsPackedComesOutAgain)
{
    const std::string bytes = pack(some_scene());
    const ImportedScene scene = unpack<ImportedScene>(bytes.data(), bytes.size());
    EXPECT_EQ(pack(scene), bytes);
    EXPECT_EQ(scene.meshes[0].positions[1], Vec3f(4, 5, 6));
    EXPECT_EQ(scene.meshes[0].lines, 5u);
    EXPECT_EQ(scene.meshes[0].segments.at(0)[1], 3u);
    EXPECT_EQ(scene.materials[0].name, "steel");
    EXPECT_EQ(scene.nodes[0].to_world[11], 12);
    EXPECT_EQ(scene.files[0].path, "/x/y.mtl");
}

TEST(ImportScene, NoCutOrSpoiltPackageIsTakenOrCrashes)
{
    const std::string bytes = pack(some_scene());
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        EXPECT_THROW(unpack<ImportedScene>(bytes.data(), n), std::runtime_error) << n;
    }
    EXPECT_THROW(unpack<ImportedScene>((bytes + "x").data(), bytes.size() + 1), std::runtime_error);
    std::minstd_rand random(7);
    for (int i = 0; i < 2000; ++i) {
        std::string spoilt = bytes;
        for (int k = 0; k < 4; ++k) spoilt[random() % spoilt.size()] = char(random());
        try {
            unpack<ImportedScene>(spoilt.data(), spoilt.size());
        } catch (const std::runtime_error&) {
        }
    }
}

TEST(ImportScene, ReadsAFileInAnotherProcess)
{
    const files::Folder folder;
    const ImportedScene scene = import_scene(folder.write("t.obj", triangle));
    EXPECT_EQ(scene.error, "");
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
    ASSERT_EQ(scene.nodes.size(), 1u);
    ASSERT_FALSE(scene.files.empty());
    EXPECT_EQ(scene.files[0].path, (folder.path / "t.obj").string());
}

TEST(ImportScene, SaysWhatIsWrongWithThePath)
{
    const files::Folder folder;
    EXPECT_NE(import_error(folder.path / "none.obj").find("there is no file"), std::string::npos);
    EXPECT_NE(import_error(folder.path).find("is a folder"), std::string::npos);
    EXPECT_NE(import_error("/dev/zero").find("not a regular file"), std::string::npos);
    EXPECT_NE(import_error(folder.write("empty.obj", "")).find("is empty"), std::string::npos);
    EXPECT_NE(import_error(folder.write("notes.txt", "hello")), "");
}

TEST(ImportScene, AMissingImporterSaysHowToFindIt)
{
    const files::Folder folder;
    const auto path = folder.write("t.obj", triangle);
    const char* before = std::getenv("ASPIC_ASSIMP");
    const std::string kept = before ? before : "";
    setenv("ASPIC_ASSIMP", "/nowhere/aspic-assimp", 1);
    const std::string error = import_error(path);
    if (before) {
        setenv("ASPIC_ASSIMP", kept.c_str(), 1);
    } else {
        unsetenv("ASPIC_ASSIMP");
    }
    EXPECT_NE(error.find("/nowhere/aspic-assimp"), std::string::npos) << error;
}

// An importer that misbehaves, and what reading a file with it says.
class FakeImporter {
public:
    explicit FakeImporter(const std::string& script) : fake_(script) {}
    std::string error(const ImportOptions& options = {})
    {
        return import_error(folder_.write("t.obj", triangle), options);
    }

private:
    files::Folder folder_;
    files::FakeAssimp fake_;
};

TEST(ImportScene, ACrashIsAnError)
{
    const std::string error =
        FakeImporter("echo 'assertion failed: x > 0' >&2; kill -SEGV $$").error();
    EXPECT_NE(error.find("crashed"), std::string::npos) << error;
    EXPECT_NE(error.find("x > 0"), std::string::npos) << error;
    EXPECT_NE(FakeImporter("kill -ABRT $$").error().find("crashed"), std::string::npos);
}

TEST(ImportScene, AnEndlessImportIsAnError)
{
    ImportOptions options;
    options.limits.seconds = 0.2;
    const std::string error = FakeImporter("exec sleep 60").error(options);
    EXPECT_NE(error.find("more than 0.2 s"), std::string::npos) << error;
}

TEST(ImportScene, RunningOutOfMemoryIsAnError)
{
    EXPECT_NE(FakeImporter("exit 3").error().find("8 GiB"), std::string::npos);
}

TEST(ImportScene, NonsenseFromTheImporterIsAnError)
{
    EXPECT_NE(FakeImporter("echo hello >&3").error().find("not understood"), std::string::npos);
    EXPECT_NE(FakeImporter("exit 0").error().find("not understood"), std::string::npos);
    EXPECT_NE(FakeImporter("echo why >&2; exit 1").error().find("why"), std::string::npos);
    // Much talk does not fill a pipe and hang.
    EXPECT_NE(FakeImporter("head -c 1000000 /dev/zero >&2; exit 1").error(), "");
}

TEST(ImportScene, CancellingStopsAnImport)
{
    FakeImporter fake("exec sleep 60");
    ImportOptions options;
    int asked = 0;
    options.check = [&] {
        if (++asked == 2) throw std::runtime_error("cancelled by the test");
    };
    EXPECT_EQ(fake.error(options), "cancelled by the test");
}

TEST(ImportScene, AMemoryBombStopsAtTheLimit)
{
    // A PLY header that announces vertices of which none follow.
#ifdef ASPIC_SANITIZED
    const std::string vertices = "4000000000";  // a sanitizer's own memory passes any limit
#else
    const std::string vertices = "60000000";  // would fit into this machine, not into the limit
#endif
    const files::Folder folder;
    ImportOptions options;
    options.limits.gigabytes = 0.4;
    const auto path = folder.write("bomb.ply", "ply\nformat ascii 1.0\nelement vertex " + vertices +
                                                   "\nproperty float x\nproperty float y\n"
                                                   "property float z\nend_header\n");
    const std::string error = import_error(path, options);
    EXPECT_NE(error, "");
#ifndef ASPIC_SANITIZED
    EXPECT_NE(error.find("memory"), std::string::npos) << error;
#endif
}

TEST(ImportScene, SideFilesOutsideTheRootAreNotOpened)
{
    const files::Folder folder;
    folder.write("secret.mtl", "newmtl m\nKd 1 0 0\n");
    const auto path =
        folder.write("inside/t.obj", std::string("mtllib ../secret.mtl\nusemtl m\n") + triangle);
    ImportOptions options;
    const auto red = [&] {
        for (const auto& m : import_scene(path, options).materials) {
            if (m.name == "m") return m.colour == Vec3f(1, 0, 0);
        }
        return false;
    };
    EXPECT_TRUE(red());
    options.root = folder.path / "inside";
    EXPECT_FALSE(red());
    options.root = folder.path;
    EXPECT_TRUE(red());
}

}  // namespace
