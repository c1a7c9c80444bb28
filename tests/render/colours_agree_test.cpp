// One colour, however it leaves: in a picture, a video, the material of an OBJ and of a GLB, and at
// vertices. All are decoded and compared as levels of a display.

#include "geometry/io/write_mesh.hpp"
#include "geometry/mesh/mesh.hpp"
#include "pictures.hpp"
#include "render/png.hpp"
#include "render/video.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace {

using namespace tests;
using geometry::TriMesh;
using geometry::Vec3f;

using Levels = std::array<double, 3>;

const std::array<Vec3f, 6> colours{{{0.6f, 0.02f, 0.01f},
                                    {0.02f, 0.35f, 0.05f},
                                    {0.03f, 0.05f, 0.5f},
                                    {0.75f, 0.6f, 0.08f},
                                    {0.2f, 0.2f, 0.2f},
                                    {0.01f, 0.3f, 0.35f}}};

Levels levels_of(const Vec3f& linear)
{
    const Vec3f shown = render::srgb_from_linear(linear);
    return {255 * double(shown[0]), 255 * double(shown[1]), 255 * double(shown[2])};
}

// What a picture shows of an unlit surface: the tone map takes the 4 % that surfaces mirror away.
Levels levels_in_pictures(const Vec3f& linear)
{
    const float least = linear.minCoeff();
    const float off = least < 0.08f ? least - 6.25f * least * least : 0.04f;
    return levels_of(Vec3f(linear.array() - off));
}

// A card before the camera, of one material and with vertices of the same colour.
TriMesh card(const Vec3f& colour)
{
    TriMesh mesh = geometry::grid(8, 8, 1, 1);
    for (Vec3f& p : mesh.positions) p = Vec3f(p.x(), -p.z(), 0);
    for (Vec3f& n : mesh.normals) n = Vec3f::UnitZ();
    geometry::MeshTopology topology = *mesh.topology;
    topology.materials = {{"paint", colour}};
    topology.material.assign(topology.triangles.size(), 0);
    mesh.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    mesh.colours.assign(mesh.positions.size(), colour);
    return mesh;
}

render::Image picture(const TriMesh& mesh)
{
    render::Scene scene;
    scene.surfaces = {surface(mesh)};
    scene.surfaces[0].receives = false;  // the colour itself, unlit
    return render::draw(scene, {{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 0.4}, plain_look(64));
}

// The pixel in the middle of each frame of a picture or video, by ffmpeg: rounded, where it would
// cut off by itself.
std::vector<Levels> decoded(const files::fs::path& file, int size)
{
    const std::string raw = file.string() + ".raw";
    const std::string command =
        "ffmpeg -loglevel error -i '" + file.string() +
        "' -vf scale=in_color_matrix=bt709:in_range=auto:flags=accurate_rnd+full_chroma_int "
        "-f rawvideo -pix_fmt rgb24 '" +
        raw + "'";
    EXPECT_EQ(std::system(command.c_str()), 0);
    const std::string bytes = files::bytes_of(raw);
    const std::size_t frame = std::size_t(3 * size * size);
    std::vector<Levels> out;
    for (std::size_t i = 0; i < bytes.size() / frame; ++i) {
        const std::size_t at = i * frame + std::size_t(3 * (size / 2 * size + size / 2));
        const auto level = [&](std::size_t k) {
            return double(static_cast<unsigned char>(bytes[at + k]));
        };
        out.push_back({level(0), level(1), level(2)});
    }
    return out;
}

// The three numbers after a word, from `skip` words on: of 0 .. 1.
Levels numbers_after(const std::string& text, const std::string& word, int skip = 0)
{
    std::istringstream in(text.substr(text.find(word) + word.size()));
    double number = 0;
    for (int i = 0; i < skip; ++i) in >> number;
    Levels out{};
    for (double& level : out) {
        in >> level;
        level *= 255;
    }
    return out;
}

nlohmann::json json_of(const std::string& glb)
{
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, sizeof length);
    return nlohmann::json::parse(glb.substr(20, length));
}

Levels material_of_glb(const std::string& glb)
{
    const auto factor = json_of(glb)["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"];
    return levels_of(Vec3f(factor[0].get<float>(), factor[1].get<float>(), factor[2].get<float>()));
}

Levels vertex_of_glb(const std::string& glb)
{
    const auto json = json_of(glb);
    const std::size_t accessor = json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"];
    const std::size_t view = json["accessors"][accessor]["bufferView"];
    const std::size_t offset = json["bufferViews"][view]["byteOffset"];
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, sizeof length);
    Vec3f linear;
    std::memcpy(linear.data(), glb.data() + 20 + length + 8 + offset, 12);
    return levels_of(linear);
}

// Of the first vertex of a PLY with positions, one normal each and colours.
Levels vertex_of_ply(const std::string& ply)
{
    const std::size_t floats = ply.find("property float nx") == std::string::npos ? 3 : 6;
    const std::size_t coordinates = ply.find("property float s\n") == std::string::npos ? 0 : 2;
    const std::size_t at = ply.find("end_header\n") + 11 + sizeof(float) * (floats + coordinates);
    const auto level = [&](std::size_t k) {
        return double(static_cast<unsigned char>(ply[at + k]));
    };
    return {level(0), level(1), level(2)};
}

void expect_near(const Levels& found, const Levels& expected, const char* where, std::size_t i)
{
    for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(found[k], expected[k], 2) << where << ", colour " << i << ", part " << k;
    }
}

// Two levels: what eight bits, and the halved colour of a video, leave.
TEST(ColoursAgree, InPicturesVideosAndMeshFiles)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const files::Folder folder;
    std::vector<files::fs::path> pictures;
    std::vector<Levels> shown;
    for (std::size_t i = 0; i < colours.size(); ++i) {
        const TriMesh mesh = card(colours[i]);
        const Levels expected = levels_of(colours[i]);
        pictures.push_back(folder.path / (std::to_string(i) + ".png"));
        render::write_png(pictures.back(), picture(mesh));
        shown.push_back(decoded(pictures.back(), 64).at(0));
        expect_near(shown[i], levels_in_pictures(colours[i]), "png", i);
        expect_near(numbers_after(geometry::mtl_text(mesh), "\nKd"), expected, "obj", i);
        expect_near(numbers_after(geometry::obj_text(mesh, ""), "\nv", 3), expected,
                    "vertices of obj", i);
        const std::string glb = geometry::glb_bytes(mesh);
        expect_near(material_of_glb(glb), expected, "glb", i);
        expect_near(vertex_of_glb(glb), expected, "vertices of glb", i);
        expect_near(vertex_of_ply(geometry::ply_bytes(mesh)), expected, "vertices of ply", i);
    }
    const files::fs::path video = folder.path / "v.mp4";
    ASSERT_TRUE(render::write_video(video, pictures, 24, 4));
    const std::vector<Levels> frames = decoded(video, 64);
    ASSERT_EQ(frames.size(), colours.size());
    for (std::size_t i = 0; i < frames.size(); ++i) {
        expect_near(frames[i], shown[i], "video", i);
    }
}

}  // namespace
