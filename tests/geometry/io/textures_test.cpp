// Textures from a file to a mesh and back to files of other formats.

#include "geometry/io/export_mesh.hpp"
#include "geometry/io/read_mesh.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/texture.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/meshes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <set>

namespace {

using namespace geometry;

// `cells` by `cells` squares of `texels` each, `a` in the upper left corner.
Picture checker(int cells, int texels, std::array<std::uint8_t, 4> a, std::array<std::uint8_t, 4> b)
{
    Picture picture{cells * texels, cells * texels, {}};
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            const auto& colour = (x / texels + y / texels) % 2 == 0 ? a : b;
            picture.rgba.insert(picture.rgba.end(), colour.begin(), colour.end());
        }
    }
    return picture;
}

const std::string red_and_blue = encode_png(checker(4, 2, {200, 30, 20, 255}, {20, 40, 180, 255}));

// A square in two triangles, one corner of which has texture coordinates of its own: a seam.
const std::string square_obj = "mtllib a.mtl\nusemtl wood\n"
                               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                               "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.25 0.5\n"
                               "f 1/1 2/2 3/3\nf 1/5 3/3 4/4\n";

// The texture coordinates of every corner, by where the corner is.
std::vector<std::array<float, 5>> corners_of(const TriMesh& mesh)
{
    std::vector<std::array<float, 5>> out;
    const MeshTopology& t = *mesh.topology;
    for (std::size_t f = 0; f < t.uv_triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3f& p = mesh.positions[t.triangles[f][k]];
            const Vec2f& uv = t.uvs[t.uv_triangles[f][k]];
            out.push_back({p.x(), p.y(), p.z(), uv.x(), uv.y()});
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

bool mentions(const ReadMesh& read, const std::string& text)
{
    return std::any_of(read.warnings.begin(), read.warnings.end(),
                       [&](const std::string& w) { return w.find(text) != std::string::npos; });
}

TEST(Textures, AnObjKeepsItsPictureItsCoordinatesAndItsWeldedVertices)
{
    const files::Folder folder;
    folder.write("pictures/red and blue.png", red_and_blue);
    folder.write("a.mtl",
                 "newmtl wood\nKd 0.5 0.5 0.5\nmap_Kd -clamp on pictures\\red and blue.png\n");
    const ReadMesh read = read_mesh(folder.write("a.obj", square_obj));
    EXPECT_EQ(read.warnings, std::vector<std::string>{});
    meshes::expect_consistent(read.mesh);
    EXPECT_EQ(read.mesh.positions.size(), 4u) << "a seam splits no vertex";
    EXPECT_EQ(read.mesh.topology->uvs.size(), 5u);
    const Material& wood = read.mesh.topology->materials.at(0);
    ASSERT_TRUE(wood.texture);
    EXPECT_EQ(wood.texture->source().name, "red and blue.png");
    EXPECT_EQ(wood.texture->source().file, red_and_blue);
    EXPECT_EQ(wood.texture->size().width, 8);
    EXPECT_EQ(wood.texture->picture().rgba, decode_picture(red_and_blue).rgba);
    EXPECT_EQ(wood.use.u, TextureUse::Wrap::clamp);
    EXPECT_EQ(wood.use.alpha, TextureUse::Alpha::ignored);
    EXPECT_NEAR(wood.colour.x(), 0.2140f, 1e-3) << "display value 0.5, which the picture is times";
    // The runtime learns of the picture: when it changes, the mesh is read again.
    const auto& files = read.side_files;
    EXPECT_NE(std::find(files.begin(), files.end(), folder.path / "pictures/red and blue.png"),
              files.end());
}

TEST(Textures, APictureThatIsElsewhereIsFoundByItsName)
{
    for (const char* place : {"deep/red.png", "deep/textures/red.png"}) {
        const files::Folder folder;
        folder.write(place, red_and_blue);
        folder.write("deep/a.mtl", "newmtl wood\nKd 0 0 0\nmap_Kd C:\\old\\machine\\red.png\n");
        const ReadMesh read = read_mesh(folder.write("deep/a.obj", square_obj));
        EXPECT_EQ(read.warnings, std::vector<std::string>{});
        ASSERT_TRUE(read.mesh.topology->materials.at(0).texture);
        EXPECT_EQ(read.mesh.topology->materials[0].colour, Vec3f(1, 1, 1)) << "black hides nothing";
    }
}

TEST(Textures, AMissingPictureIsToldWithItsMaterialAndWhatToDo)
{
    const files::Folder folder;
    folder.write("a.mtl", "newmtl wood\nKd 0.5 0.5 0.5\nmap_Kd maps/oak.png\n");
    const ReadMesh read = read_mesh(folder.write("a.obj", square_obj));
    EXPECT_FALSE(read.mesh.topology->materials.at(0).texture);
    ASSERT_EQ(read.warnings.size(), 1u);
    EXPECT_EQ(read.warnings[0],
              "material \"wood\" is drawn in its plain colour: its picture maps/oak.png cannot "
              "be opened; put the file beside the model, or correct its path in the material.");
    EXPECT_FALSE(read.side_files.empty());
}

TEST(Textures, APictureThatIsDamagedOrOfAnotherFormatIsTold)
{
    const files::Folder folder;
    folder.write("a.mtl", "newmtl wood\nKd 0.5 0.5 0.5\nmap_Kd oak.png\n");
    const auto obj = folder.write("a.obj", square_obj);
    folder.write("oak.png", red_and_blue.substr(0, red_and_blue.size() / 2));
    EXPECT_TRUE(mentions(read_mesh(obj), "its picture oak.png is damaged"));
    folder.write("oak.png", "RIFF....WEBP");
    EXPECT_TRUE(mentions(read_mesh(obj), "convert it to PNG or JPEG"));
    EXPECT_FALSE(read_mesh(obj).mesh.topology->materials.at(0).texture);
}

TEST(Textures, APictureOutsideTheRootIsNotOpened)
{
    const files::Folder folder;
    folder.write("red.png", red_and_blue);
    folder.write("job/a.mtl", "newmtl wood\nKd 0.5 0.5 0.5\nmap_Kd ../red.png\n");
    const auto obj = folder.write("job/a.obj", square_obj);
    ReadOptions options;
    EXPECT_TRUE(read_mesh(obj, options).mesh.topology->materials.at(0).texture);
    options.import.root = folder.path / "job";
    EXPECT_FALSE(read_mesh(obj, options).mesh.topology->materials.at(0).texture);
}

TEST(Textures, WhatIsNotUsedIsTold)
{
    const files::Folder folder;
    folder.write("red.png", red_and_blue);
    folder.write("a.mtl",
                 "newmtl wood\nKd 1 1 1\nmap_Kd red.png\nmap_d mask.png\nmap_Bump n.png\n");
    const ReadMesh read = read_mesh(folder.write("a.obj", square_obj));
    EXPECT_TRUE(mentions(read, "its picture mask.png of opacity is not used"));
    EXPECT_TRUE(mentions(read,
                         "material \"wood\" is drawn without its normal map: its picture n.png "
                         "cannot be opened"));
}

// As Blender 3.4 writes it with its PBR extensions.
TEST(Textures, ALibraryMaySayWhatAssimpDoesNotUnderstand)
{
    const files::Folder folder;
    folder.write("red.png", red_and_blue);
    folder.write("a.mtl", "newmtl wood\nKd 0.5 0.5 0.5\nPr 0.25\nPcr 0.03\naniso 0.000000\n"
                          "anisor 0.000000\nmap_Kd red.png\naniso 1");
    const ReadMesh read = read_mesh(folder.write("a.obj", square_obj));
    EXPECT_EQ(read.warnings, std::vector<std::string>{});
    EXPECT_TRUE(read.mesh.topology->materials.at(0).texture);
    EXPECT_EQ(read.mesh.topology->materials[0].roughness, 0.25f);

    // Lines may be indented, as 3ds Max writes them.
    folder.write("a.mtl", "newmtl wood\n\tKd 0.5 0.5 0.5\n\taniso 0.5\n\tmap_Kd red.png\n");
    EXPECT_TRUE(read_mesh(folder.path / "a.obj").mesh.topology->materials.at(0).texture);
    folder.write("a.mtl", "newmtl wood\n  d 1\n  map_Kd red.png\n");
    EXPECT_EQ(read_mesh(folder.path / "a.obj").mesh.topology->materials.at(0).colour,
              Vec3f(1, 1, 1));

    // One that has a picture and no colour is as bright as the picture.
    folder.write("a.mtl", "newmtl other\nmap_Kd red.png\nKd 0.5 0 0\n"
                          "newmtl wood\nd 1\nmap_Kd red.png\nnewmtl third\nd 1");
    const Material wood = read_mesh(folder.path / "a.obj").mesh.topology->materials.at(0);
    EXPECT_EQ(wood.colour, Vec3f(1, 1, 1));
    EXPECT_TRUE(wood.texture);
}

// Directions that lean by a quarter to all sides.
const std::string waves = encode_png(checker(4, 2, {160, 96, 246, 255}, {96, 160, 246, 255}));

TEST(NormalMaps, AreReadFromObjAndGlbAndBroughtBack)
{
    const files::Folder folder;
    folder.write("waves.png", waves);
    folder.write("red.png", red_and_blue);
    folder.write("a.mtl", "newmtl wood\nKd 1 1 1\nmap_Kd red.png\nnorm -bm 0.5 waves.png\n");
    const ReadMesh obj = read_mesh(folder.write("a.obj", square_obj));
    EXPECT_EQ(obj.warnings, std::vector<std::string>{});
    TriMesh mesh = obj.mesh;
    for (const bool alone : {false, true}) {  // beside a picture of the colour, and without
        if (alone) {
            auto topology = std::make_shared<MeshTopology>(*mesh.topology);
            topology->materials[0].texture = nullptr;
            mesh.topology = topology;
        }
        for (const char* name : {"out/a.obj", "out/a.glb"}) {
            SCOPED_TRACE(name);
            write_mesh(folder.path / name, mesh_format(name), mesh);
            const ReadMesh back = read_mesh(folder.path / name);
            EXPECT_EQ(back.warnings, std::vector<std::string>{});
            const Material& m = back.mesh.topology->materials.at(0);
            ASSERT_TRUE(m.normal_map);
            EXPECT_EQ(m.normal_map->source().file, waves);
            EXPECT_EQ(m.bump, 0.5f);
            EXPECT_EQ(m.texture == nullptr, alone);
            EXPECT_EQ(corners_of(back.mesh).size(), corners_of(mesh).size());
        }
    }
    write_mesh(folder.path / "ply/a.ply", MeshFormat::ply, obj.mesh);
    EXPECT_FALSE(files::fs::exists(folder.path / "ply/waves.png")) << "a PLY does not name it";
}

// OBJ's map_Bump is used for heights and for normals alike.
TEST(NormalMaps, OfABumpMapThePixelsTellWhatItHas)
{
    const files::Folder folder;
    folder.write("a.mtl", "newmtl wood\nKd 1 1 1\nmap_Bump -bm 2 n.png\n");
    const auto obj = folder.write("a.obj", square_obj);
    folder.write("n.png", waves);
    const ReadMesh normals = read_mesh(obj);
    EXPECT_EQ(normals.warnings, std::vector<std::string>{});
    EXPECT_TRUE(normals.mesh.topology->materials.at(0).normal_map);
    EXPECT_EQ(normals.mesh.topology->materials[0].bump, 2);

    const std::string heights =
        encode_png(checker(4, 2, {200, 202, 199, 255}, {190, 191, 194, 255}));
    const std::array<std::pair<std::string, const char*>, 2> others{
        {{heights, "its bump map n.png has heights; bake a normal map of it"},
         {red_and_blue, "whether its bump map n.png has heights or normals cannot be told"}}};
    for (const auto& [file, why] : others) {
        folder.write("n.png", file);
        const ReadMesh read = read_mesh(obj);
        EXPECT_FALSE(read.mesh.topology->materials.at(0).normal_map);
        EXPECT_TRUE(mentions(read, why)) << why;
    }
    // What is named a normal map is taken for one.
    folder.write("a.mtl", "newmtl wood\nKd 1 1 1\nnorm n.png\n");
    EXPECT_TRUE(read_mesh(obj).mesh.topology->materials.at(0).normal_map);
}

TEST(Textures, LeavesAreCutOutAndVeilsAreBlended)
{
    Picture leaf = checker(2, 8, {30, 120, 30, 255}, {0, 0, 0, 0});
    EXPECT_EQ(alpha_of(leaf), TextureUse::Alpha::cutout);
    for (std::size_t i = 3; i < leaf.rgba.size(); i += 4) leaf.rgba[i] = std::uint8_t(i / 4);
    EXPECT_EQ(alpha_of(leaf), TextureUse::Alpha::blended);
    EXPECT_EQ(alpha_of(decode_picture(red_and_blue)), TextureUse::Alpha::ignored);
}

// A mesh of two textured materials and one plain one, of which one picture is a TGA, which glTF
// does not know, and two pictures share a name.
TriMesh textured()
{
    const Picture leaf = checker(2, 8, {30, 120, 30, 255}, {0, 0, 0, 0});
    std::string tga(18, '\0');
    tga[2] = 2, tga[12] = 16, tga[14] = 16, tga[16] = 32, tga[17] = 0x28;
    for (std::size_t i = 0; i < leaf.rgba.size(); i += 4) {
        for (const std::size_t k : {2u, 1u, 0u, 3u}) tga += static_cast<char>(leaf.rgba[i + k]);
    }
    Material wood{"wood", {1, 1, 1}}, green{"leaf", {1, 1, 1}};
    wood.texture = std::make_shared<const Texture>(Texture::Source{"my picture.png", red_and_blue});
    wood.use.u = TextureUse::Wrap::mirror;
    green.texture = std::make_shared<const Texture>(Texture::Source{"my picture.png", tga});
    green.use.alpha = TextureUse::Alpha::cutout;
    const TriMesh a = meshes::with_material(uv_sphere(1, 8, 6), wood, "a");
    const TriMesh b = meshes::with_material(grid(2, 2, 2, 2), green, "b");
    const TriMesh c = meshes::with_material(box({1, 1, 1}, {1, 1, 1}), {"plain", {1, 0, 0}}, "c");
    const std::array<const TriMesh*, 3> all{&a, &b, &c};
    return merge(all);
}

// Of the texture of material `m` as a file: "name.1f6e02a9.png".
std::string written_name(const char* name, const TriMesh& mesh, std::size_t m)
{
    const std::uint64_t digest = mesh.topology->materials.at(m).texture->digest();
    return fmt::format("{}.{:08x}.png", name, digest & 0xffffffffu);
}

TEST(Textures, ObjAndGlbBringThemBack)
{
    const files::Folder folder;
    const TriMesh mesh = textured();
    for (const char* name : {"out/a.0001.obj", "out/a.0001.glb"}) {
        SCOPED_TRACE(name);
        const auto beside = write_mesh(folder.path / name, mesh_format(name), mesh);
        for (const auto& file : beside) EXPECT_TRUE(files::fs::exists(file)) << file;
        const ReadMesh back = read_mesh(folder.path / name);
        EXPECT_EQ(back.warnings, std::vector<std::string>{});
        const auto& materials = back.mesh.topology->materials;
        ASSERT_EQ(materials.size(), 3u);
        for (std::size_t m = 0; m < 2; ++m) {
            ASSERT_TRUE(materials[m].texture);
            EXPECT_EQ(materials[m].texture->picture().rgba,
                      mesh.topology->materials[m].texture->picture().rgba);
        }
        EXPECT_EQ(materials[1].use.alpha, TextureUse::Alpha::cutout);
        EXPECT_FALSE(materials[2].texture);
        if (std::string(name).ends_with("glb")) {
            EXPECT_EQ(materials[0].use.u, TextureUse::Wrap::mirror);
            EXPECT_EQ(materials[0].use.v, TextureUse::Wrap::repeat);
        } else {
            EXPECT_EQ(std::set(beside.begin(), beside.end()),
                      (std::set{folder.path / "out/a.0001.mtl",
                                folder.path / "out" / written_name("my_picture", mesh, 0),
                                folder.path / "out" / written_name("my_picture", mesh, 1)}));
        }
        const auto before = corners_of(mesh), after = corners_of(back.mesh);
        ASSERT_EQ(before.size(), after.size());
        // glTF counts v from the top: 1 - (1 - v) is v to a place or two.
        for (std::size_t i = 0; i < before.size(); ++i) {
            for (std::size_t k = 0; k < 5; ++k) ASSERT_NEAR(before[i][k], after[i][k], 1e-6);
        }
    }
}

// A GLB of `mesh` whose materials place their pictures (KHR_texture_transform).
std::string placed_glb(const TriMesh& mesh, const nlohmann::json& transform)
{
    const std::string glb = glb_bytes(mesh);
    std::uint32_t length = 0;
    std::memcpy(&length, glb.data() + 12, sizeof length);
    auto json = nlohmann::json::parse(glb.substr(20, length));
    for (auto& m : json["materials"]) {
        auto& look = m["pbrMetallicRoughness"];
        if (!look.contains("baseColorTexture")) continue;
        look["baseColorTexture"]["extensions"]["KHR_texture_transform"] = transform;
    }
    json["extensionsUsed"] = {"KHR_texture_transform"};
    std::string text = json.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string file = glb.substr(0, 8);
    for (const std::size_t size : {glb.size() - length + text.size(), text.size()}) {
        const auto word = static_cast<std::uint32_t>(size);
        file.append(reinterpret_cast<const char*>(&word), sizeof word);
    }
    return file + glb.substr(16, 4) + text + glb.substr(20 + length);
}

// uv' = scale * uv + offset, where v runs down.
TEST(Textures, AGltfMayMoveAndScaleItsPicture)
{
    const files::Folder folder;
    const TriMesh mesh = textured();
    const std::string file = placed_glb(mesh, {{"scale", {2, 3}}, {"offset", {0.25, 0.5}}});
    const TriMesh back = read_mesh(folder.write("placed.glb", file)).mesh;
    const MeshTopology &s = *mesh.topology, &t = *back.topology;
    ASSERT_EQ(s.uv_triangles.size(), t.uv_triangles.size());
    for (std::size_t f = 0; f < s.uv_triangles.size(); ++f) {
        if (!s.materials[s.material[f]].texture) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec2f& uv = s.uvs[s.uv_triangles[f][k]];
            const Vec2f wanted(2 * uv.x() + 0.25f, 1 - (3 * (1 - uv.y()) + 0.5f));
            ASSERT_LT((t.uvs[t.uv_triangles[f][k]] - wanted).norm(), 1e-5f) << f;
        }
    }
    const auto turned = folder.write("turned.glb", placed_glb(mesh, {{"rotation", 0.5}}));
    EXPECT_TRUE(mentions(read_mesh(turned),
                         "material \"wood\": the turn of its picture is not used, "
                         "nor are the scale and offset"));
}

TEST(Textures, VertexColoursThatMultiplyAPictureAreTold)
{
    const files::Folder folder;
    TriMesh mesh = textured();
    const auto told = [&](const Vec3f& colour) {
        mesh.colours.assign(mesh.positions.size(), Vec3f::Ones());
        mesh.colours[0] = colour;  // of wood
        return read_mesh(folder.write("tinted.glb", glb_bytes(mesh)));
    };
    const ReadMesh tinted = told({1, 0.5f, 1});
    EXPECT_TRUE(mentions(tinted, "material \"wood\": the vertex colours that multiply"));
    EXPECT_FALSE(mentions(tinted, "material \"plain\": the vertex colours"));
    EXPECT_FALSE(mentions(told({1, 1, 1}), "the vertex colours"));
}

TEST(Textures, APlyHasCoordinatesAlsoAtSeamsAndNamesItsOnePicture)
{
    const files::Folder folder;
    TriMesh mesh = uv_sphere(1, 8, 6);  // the seam runs from pole to pole
    Material wood{"wood", {1, 1, 1}};
    wood.texture = std::make_shared<const Texture>(Texture::Source{"red.png", red_and_blue});
    for (const bool seams : {true, false}) {
        if (!seams) mesh = grid(2, 2, 3, 2);
        mesh = meshes::with_material(std::move(mesh), wood, "ball");
        const auto beside = write_mesh(folder.path / "a.ply", MeshFormat::ply, mesh);
        EXPECT_EQ(beside, std::vector{folder.path / written_name("red", mesh, 0)});
        const ReadMesh back = read_mesh(folder.path / "a.ply");
        EXPECT_EQ(back.warnings, std::vector<std::string>{});
        EXPECT_TRUE(back.mesh.positions == mesh.positions) << "vertices keep their order";
        EXPECT_EQ(corners_of(back.mesh), corners_of(mesh));
        ASSERT_EQ(back.mesh.topology->materials.size(), 1u);
        ASSERT_TRUE(back.mesh.topology->materials[0].texture);
        EXPECT_EQ(back.mesh.topology->materials[0].texture->source().file, red_and_blue);
    }
}

TEST(Textures, APlyWithSeveralNamesNone)
{
    const files::Folder folder;
    EXPECT_TRUE(write_mesh(folder.path / "a.ply", MeshFormat::ply, textured()).empty());
    EXPECT_EQ(files::bytes_of(folder.path / "a.ply").find("TextureFile"), std::string::npos);
}

TEST(Textures, AFrameDoesNotWriteAgainWhatIsThere)
{
    const files::Folder folder;
    const TriMesh mesh = textured();
    write_mesh(folder.path / "a.0001.obj", MeshFormat::obj, mesh);
    const auto picture = folder.path / written_name("my_picture", mesh, 0);
    const auto long_ago = files::fs::last_write_time(picture) - std::chrono::hours(1);
    files::fs::last_write_time(picture, long_ago);
    write_mesh(folder.path / "a.0002.obj", MeshFormat::obj, mesh);
    EXPECT_EQ(files::fs::last_write_time(picture), long_ago);
    folder.write(picture.filename().string(), "another");
    write_mesh(folder.path / "a.0003.obj", MeshFormat::obj, mesh);
    EXPECT_EQ(files::bytes_of(picture), red_and_blue);
}

TEST(Textures, MeshesWithOtherPicturesOfOneNameShareAFolder)
{
    const files::Folder folder;
    const std::string other = encode_png(checker(2, 8, {0, 255, 0, 255}, {0, 0, 0, 255}));
    Material wood{"wood", {1, 1, 1}};
    for (const auto& [name, file] : {std::pair{"a", red_and_blue}, {"b", other}}) {
        wood.texture = std::make_shared<const Texture>(Texture::Source{"wood.png", file});
        const TriMesh mesh = meshes::with_material(grid(2, 2, 3, 2), wood, "floor");
        for (const char* ending : {".obj", ".ply"}) {
            const std::string path = name + std::string(ending);
            write_mesh(folder.path / path, mesh_format(path), mesh);
        }
    }
    for (const auto& [name, file] : {std::pair{"a", red_and_blue}, {"b", other}}) {
        for (const char* ending : {".obj", ".ply"}) {
            const std::string path = name + std::string(ending);
            const TriMesh back = read_mesh(folder.path / path).mesh;
            EXPECT_EQ(back.topology->materials.at(0).texture->source().file, file);
            // What was read back is written by the same name again.
            const auto again = write_mesh(folder.path / "again" / path, mesh_format(path), back);
            EXPECT_EQ(again.back().filename(), back.topology->materials[0].texture->source().name);
        }
    }
}

TEST(Textures, MaterialsAreEqualWhereTheirPicturesAre)
{
    const auto picture = [](const std::string& name) {
        return std::make_shared<const Texture>(Texture::Source{name, red_and_blue});
    };
    Material a{"a"}, b{"a"};
    a.texture = picture("x.png");
    EXPECT_NE(a, b);
    b.texture = picture("x.png");
    EXPECT_EQ(a, b);
    b.texture = picture("y.png");
    EXPECT_NE(a, b);
    b = a;
    b.use.cutoff = 0.3f;
    EXPECT_NE(a, b);
    b = a;
    b.normal_map = picture("x.png");
    EXPECT_NE(a, b);
    b = a;
    b.bump = 2;
    EXPECT_NE(a, b);
}

}  // namespace
