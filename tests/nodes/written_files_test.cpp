// The files that WriteMesh and WriteVideo leave: their names, their order and what is in them.

#include "geometry/io/read_mesh.hpp"
#include "graph/document/frame_path.hpp"
#include "render/contact_sheet.hpp"
#include "render/exr.hpp"
#include "render/png.hpp"
#include "tests/geometry/files.hpp"
#include "tests/nodes/one_node.hpp"
#include "tests/render/decode_exr.hpp"

#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace {

using fixtures::NodeRun;
using geometry::TriMesh;
using geometry::Vec3f;
using graph::Value;

// A triangle that has gone `frame` metres up.
Value triangle(int frame)
{
    TriMesh mesh;
    const float y = float(frame);
    mesh.positions = {Vec3f(0, y, 0), Vec3f(1, y, 0), Vec3f(0, y, 1)};
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = {{0, 1, 2}};
    mesh.topology = topology;
    return Value::of(std::move(mesh));
}

std::string bytes_of(const std::filesystem::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(WriteMesh, WritesANumberedFilePerFrame)
{
    const files::Folder folder;
    for (const char* ending : {"obj", "ply", "stl", "glb"}) {
        NodeRun write("WriteMesh");
        write.output_folder = folder.path;
        write.param("path").is = std::filesystem::path(std::string("shape/a.###.") + ending);
        for (const int frame : {7, 1234}) {
            write.inputs["mesh"] = {triangle(frame)};
            const auto path = folder.path / "shape" / fmt::format("a.{:03}.{}", frame, ending);
            EXPECT_EQ(write.run(frame).as<graph::WrittenFile>()->path, path.string());
            const TriMesh back = geometry::read_mesh(path).mesh;
            ASSERT_EQ(back.positions.size(), 3u) << path;
            for (const Vec3f& p : back.positions) EXPECT_EQ(p.y(), float(frame));
        }
    }
}

TEST(WriteMesh, WritesTheMaterialsOfEachFrameToAFileOfTheirOwn)
{
    // A mesh that tears has one more from then on, and frames are written in any order.
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.param("path").is = std::filesystem::path("a.##.obj");
    const auto written = [&](int frame, std::vector<geometry::Material> materials) {
        TriMesh mesh = *triangle(1).as<TriMesh>();
        geometry::MeshTopology topology = *mesh.topology;
        topology.material.assign(1, std::uint16_t(materials.size() - 1));
        topology.materials = std::move(materials);
        mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
        write.inputs["mesh"] = {Value::of(mesh)};
        return *write.run(frame).as<graph::WrittenFile>();
    };
    const auto torn = written(12, {{"skin", {1, 0, 0}}, {"inside", {0, 1, 0}}});
    const auto whole = written(3, {{"skin", {1, 0, 0}}});
    EXPECT_EQ(torn.beside, std::vector{(folder.path / "a.12.mtl").string()});
    const TriMesh back = geometry::read_mesh(torn.path).mesh;
    EXPECT_EQ(back.topology->materials.at(back.topology->material.at(0)).name, "inside");
    EXPECT_NEAR(back.topology->materials.at(back.topology->material.at(0)).colour[1], 1, 1e-3);
    EXPECT_EQ(geometry::read_mesh(whole.path).mesh.topology->materials.at(0).name, "skin");
    write.param("path").is = std::filesystem::path("b.ply");
    EXPECT_TRUE(written(1, {{"skin", {1, 0, 0}}}).beside.empty());
}

TEST(WriteMesh, WritesTheGivenFormatWhateverTheEnding)
{
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.inputs["mesh"] = {triangle(1)};
    write.param("path").is = std::filesystem::path("a.dat");
    EXPECT_THROW(write.run(), std::invalid_argument);
    write.param("format").is = std::string("ply");
    write.run();
    EXPECT_EQ(bytes_of(folder.path / "a.dat").substr(0, 4), "ply\n");
}

TEST(WriteMesh, WritesByAssimpWhereNeededOrRequested)
{
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.inputs["mesh"] = {triangle(5)};
    write.param("path").is = std::filesystem::path("a.####.dae");
    const auto path = write.run(3).as<graph::WrittenFile>()->path;
    EXPECT_EQ(path, (folder.path / "a.0003.dae").string());
    EXPECT_EQ(geometry::read_mesh(path).mesh.positions.at(0).y(), 5.f);
    const auto made_by = [&](bool assimp) {
        write.param("path").is = std::filesystem::path("a.glb");
        write.param("assimp").is = assimp;
        write.run();
        const std::string bytes = bytes_of(folder.path / "a.glb");
        return bytes.find("Open Asset Import Library") != std::string::npos;
    };
    EXPECT_FALSE(made_by(false));
    EXPECT_TRUE(made_by(true));
}

// PC2: 32 bytes of header, then 12 bytes a vertex and sample, whatever order frames are cooked in.
TEST(WriteMesh, WritesEveryFrameToItsPlaceInThePointCache)
{
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.range = {11, 14, 24};
    write.param("path").is = std::filesystem::path("a.pc2");
    for (const int frame : {13, 11, 14, 12}) {
        write.inputs["mesh"] = {triangle(frame)};
        write.run(frame);
    }
    const std::string bytes = bytes_of(folder.path / "a.pc2");
    ASSERT_EQ(bytes.size(), 32u + 4 * 3 * 12);
    for (std::size_t sample = 0; sample < 4; ++sample) {
        float y = 0;
        std::memcpy(&y, bytes.data() + 32 + sample * 36 + 4, sizeof y);
        EXPECT_EQ(y, 11 + float(sample));
    }
    write.param("path").is = std::filesystem::path("a.##.pc2");
    EXPECT_THROW(write.run(11), std::invalid_argument);
}

// The height of the triangle in each sample of the file.
std::vector<float> heights(const std::filesystem::path& path, std::size_t samples)
{
    const std::string bytes = bytes_of(path);
    std::vector<float> out(samples, -1);
    for (std::size_t s = 0; s < samples && 32 + 36 * (s + 1) <= bytes.size(); ++s) {
        std::memcpy(&out[s], bytes.data() + 32 + s * 36 + 4, sizeof(float));
    }
    return out;
}

TEST(WriteMesh, RefusesAMeshThatIsNotFiniteInEveryFormat)
{
    const files::Folder folder;
    TriMesh mesh = *triangle(1).as<TriMesh>();
    mesh.attributes.push_back({"displacement", "m", {0, 0, INFINITY}});
    TriMesh far = mesh;
    far.positions[1].x() = INFINITY;
    const auto refused = [&](const std::string& ending, const TriMesh& what) -> std::string {
        NodeRun write("WriteMesh");
        write.output_folder = folder.path;
        write.param("path").is = std::filesystem::path("a." + ending);
        write.inputs["mesh"] = {Value::of(TriMesh(what))};
        try {
            write.run();
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "";
    };
    for (const char* ending : {"obj", "ply", "stl", "glb", "gltf", "pc2"}) {
        const std::string text = refused(ending, far);
        EXPECT_NE(text.find("vertex 2 is at (inf, 1, 0)"), std::string::npos) << ending << text;
        EXPECT_NE(refused(ending, mesh).find("'displacement' of vertex 3 is inf"),
                  std::string::npos);
        EXPECT_FALSE(std::filesystem::exists(folder.path / (std::string("a.") + ending)));
    }
}

TEST(WriteMesh, FillsMissingFramesOfAPointCacheAndWarns)
{
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.range = {1, 8, 24};
    write.param("path").is = std::filesystem::path("a.pc2");
    const auto cook = [&](const std::vector<int>& frames) {
        write.warnings.clear();
        write.cook = std::make_shared<graph::Cook>(frames);
        for (const int frame : frames) {
            write.inputs["mesh"] = {triangle(frame)};
            write.run(frame);
        }
    };
    cook({2, 5, 8});
    EXPECT_EQ(heights(folder.path / "a.pc2", 8), (std::vector<float>{2, 2, 2, 2, 5, 5, 5, 8}));
    ASSERT_FALSE(write.warnings.empty());
    for (const std::string& text : write.warnings) {  // one to read: they are the same
        EXPECT_NE(text.find("lacks frames 1, 3-4, 6-7 of 1-8"), std::string::npos) << text;
    }
    cook({3, 4});
    EXPECT_EQ(heights(folder.path / "a.pc2", 8), (std::vector<float>{2, 2, 3, 4, 5, 5, 5, 8}));
    cook({1, 6, 7});
    EXPECT_TRUE(write.warnings.empty());
    EXPECT_EQ(heights(folder.path / "a.pc2", 8), (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8}));
    EXPECT_EQ(std::filesystem::file_size(folder.path / "a.pc2"), 32u + 8 * 36);
}

TEST(WriteMesh, RefusesAPointCacheWhoseNumberOfVerticesChanges)
{
    const files::Folder folder;
    NodeRun write("WriteMesh");
    write.output_folder = folder.path;
    write.range = {1, 4, 24};
    write.param("path").is = std::filesystem::path("a.pc2");
    const auto with_more = [] {
        TriMesh mesh = *triangle(9).as<TriMesh>();
        mesh.positions.push_back(mesh.positions[0]);
        return Value::of(std::move(mesh));
    };
    write.cook = std::make_shared<graph::Cook>(std::vector{1, 2, 3, 4});
    for (const int frame : {1, 2}) {
        write.inputs["mesh"] = {triangle(frame)};
        write.run(frame);
    }
    write.inputs["mesh"] = {with_more()};
    try {
        write.run(3);
        FAIL() << "was written";
    } catch (const std::invalid_argument& error) {
        for (const char* part : {"expected 3", "found 4", "torn = hide", "a.####.obj"}) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    }
    EXPECT_EQ(heights(folder.path / "a.pc2", 2), (std::vector<float>{1, 2}));
    // A cook of another mesh begins the file anew.
    write.cook = std::make_shared<graph::Cook>(std::vector{3});
    EXPECT_NO_THROW(write.run(3));
}

TEST(WrittenFiles, NeedAFrameNumberInThePathOfSeveralFrames)
{
    const files::Folder folder;
    NodeRun mesh("WriteMesh"), image("WriteImage");
    mesh.inputs["mesh"] = {triangle(1)};
    image.inputs["image"] = {
        Value::of(render::Image{1, 1, std::vector<std::uint8_t>(4, std::uint8_t(255))})};
    mesh.param("path").is = std::filesystem::path("deep/m.obj");
    image.param("path").is = std::filesystem::path("deep/m.png");
    for (NodeRun* write : {&mesh, &image}) {
        write->output_folder = folder.path;
        write->cook = std::make_shared<graph::Cook>(std::vector{1, 4});
        try {
            write->run(1);
            FAIL() << "was written";
        } catch (const std::invalid_argument& error) {
            const std::string text = error.what();
            EXPECT_NE(text.find("'path'"), std::string::npos) << text;
            EXPECT_NE(text.find("deep/m.####."), std::string::npos) << text;
        }
        write->cook = std::make_shared<graph::Cook>(std::vector{4});
        EXPECT_NO_THROW(write->run(4));
    }
}

TEST(WrittenFiles, AnExrHasLightAndOtherPicturesAreToldWhere)
{
    const files::Folder folder;
    NodeRun write("WriteImage");
    write.output_folder = folder.path;
    write.cook = std::make_shared<graph::Cook>(std::vector{4});
    write.param("path").is = std::filesystem::path("m.EXR");
    render::Image image{1, 1, {1, 2, 3, 255}};
    write.inputs["image"] = {Value::of(render::Image(image))};
    try {
        write.run(4);
        FAIL() << "was written";
    } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find("'linear' of the Render"), std::string::npos);
    }
    image.light = {0x3c00, 0x3800, 0, 0x3c00};
    write.inputs["image"] = {Value::of(render::Image(image))};
    write.run(4);
    EXPECT_EQ(tests::decode_exr(files::bytes_of(folder.path / "m.EXR")).light, image.light);
}

render::Image grey(std::uint8_t level)
{
    render::Image image{32, 32, {}};
    for (int i = 0; i < 32 * 32; ++i) {
        for (const int v : {int(level), int(level), int(level), 255}) {
            image.rgba.push_back(static_cast<std::uint8_t>(v));
        }
    }
    return image;
}

TEST(ContactSheet, LabelsTheFramesThatWereCooked)
{
    // Of a cook of frames 7, 9 and 12: those stand for frames between them, which are left out.
    const files::Folder folder;
    NodeRun sheet("ContactSheet");
    sheet.output_folder = folder.path;
    sheet.range = {1, 20, 24};
    sheet.gathered = {7, 7, 9, 9, 9, 12};
    std::map<int, render::Image> picture;
    for (const int frame : sheet.gathered) {
        picture[frame] = {32, 24, std::vector<std::uint8_t>(32 * 24 * 4, std::uint8_t(20 * frame))};
        sheet.inputs["image"].push_back(Value::of(render::Image(picture[frame])));
    }
    const auto expected = render::contact_sheet({{&picture[7], "frame 7   0.25 s"},
                                                 {&picture[9], "frame 9   0.33 s"},
                                                 {&picture[12], "frame 12   0.46 s"}},
                                                4, 1600);
    EXPECT_EQ(sheet.run().as<render::Image>()->rgba, expected.rgba);
}

TEST(WriteVideo, GathersEveryFrameOfTheRangeInOrder)
{
    const NodeRun video("WriteVideo");
    EXPECT_EQ(video.type.gather_frames(video.params, {5, 8, 24}), (std::vector<int>{5, 6, 7, 8}));
}

TEST(WriteVideo, PlaysThePicturesInOrderAtTheFrameRateOfTheDocument)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const files::Folder folder;
    NodeRun video("WriteVideo");
    video.output_folder = folder.path;
    video.range = {5, 8, 12};
    video.param("path").is = std::filesystem::path("cut/v.mp4");
    for (int frame = 5; frame <= 8; ++frame) {
        const auto path = folder.path / fmt::format("{}.png", frame);
        render::write_png(path, grey(static_cast<std::uint8_t>(40 * (frame - 4))));
        video.inputs["frames"].push_back(Value::of(graph::WrittenFile{path.string()}));
    }
    const std::string path = video.run().as<graph::WrittenFile>()->path;
    EXPECT_EQ(path, (folder.path / "cut/v.mp4").string());
    EXPECT_TRUE(video.warnings.empty());
    const auto raw = folder.path / "raw";
    ASSERT_EQ(std::system(("ffmpeg -v error -i '" + path + "' -f rawvideo -pix_fmt gray '" +
                           raw.string() + "'")
                              .c_str()),
              0);
    const std::string frames = bytes_of(raw);
    ASSERT_EQ(frames.size(), 4u * 32 * 32);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(double(static_cast<unsigned char>(frames[i * 1024 + 500])),
                    40.0 * double(i + 1), 4)
            << i;
    }
    EXPECT_EQ(std::system(("test $(ffprobe -v error -select_streams v -show_entries "
                           "stream=r_frame_rate -of csv=p=0 '" +
                           path + "') = 12/1")
                              .c_str()),
              0);
}

TEST(WriteVideo, ACookOfSomeFramesLeavesTheVideoOfAllAlone)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const files::Folder folder;
    const auto picture = folder.path / "p.png";
    render::write_png(picture, grey(40));
    // Of frames 3 and 5, the first stands for frame 4 too.
    for (const auto& [name, frames] : {std::pair{"v.mp4", std::vector<int>{1, 2, 3, 4, 5, 6}},
                                       {"v.3.mp4", {3}},
                                       {"v.3-5.mp4", {3, 3, 5}},
                                       {"v.1-6.mp4", {1, 1, 1, 1, 1, 6}}}) {
        NodeRun video("WriteVideo");
        video.output_folder = folder.path;
        video.range = {1, 6, 24};
        video.param("path").is = std::filesystem::path("v.mp4");
        video.gathered = frames;
        video.inputs["frames"] = {frames.size(), Value::of(graph::WrittenFile{picture.string()})};
        EXPECT_EQ(video.run().as<graph::WrittenFile>()->path, (folder.path / name).string());
        EXPECT_TRUE(files::fs::exists(folder.path / name)) << name;
    }
}

TEST(WriteVideo, WarnsIfFfmpegIsMissing)
{
    const files::Folder folder;
    NodeRun video("WriteVideo");
    video.output_folder = folder.path;
    video.inputs["frames"] = {Value::of(graph::WrittenFile{"x.png"})};
    const std::string path = std::getenv("PATH");
    setenv("PATH", folder.path.c_str(), 1);
    const Value file = video.run();
    setenv("PATH", path.c_str(), 1);
    EXPECT_EQ(file.as<graph::WrittenFile>()->path, "");
    ASSERT_EQ(video.warnings.size(), 1u);
    EXPECT_NE(video.warnings[0].find("install"), std::string::npos);
}

}  // namespace
