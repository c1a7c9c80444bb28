// What `aspic info` says of a mesh file, by numbers that are known beforehand.

#include "nodes/mesh_info.hpp"

#include "geometry/cubes/voxelize.hpp"
#include "geometry/io/write_mesh.hpp"
#include "nodes/registry.hpp"
#include "physics/bricks/bending_error.hpp"
#include "runtime/commands/command_line.hpp"
#include "tests/geometry/files.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <sstream>

namespace {

// A box of 2 x 0.5 x 0.1 units with one corner at the origin, its top of another material.
const char* const slab = R"(mtllib slab.mtl
o slab
v 0 0 0
v 2 0 0
v 2 0.5 0
v 0 0.5 0
v 0 0 0.1
v 2 0 0.1
v 2 0.5 0.1
v 0 0.5 0.1
vt 0 0
usemtl wood
f 4/1 3/1 2/1 1/1
f 5/1 6/1 7/1 8/1
f 1/1 2/1 6/1 5/1
f 2/1 3/1 7/1 6/1
f 4/1 1/1 5/1 8/1
usemtl paint
f 3/1 4/1 8/1 7/1
)";
const char* const slab_materials = R"(newmtl wood
Kd 0.5 0.3 0.1
map_Kd grain.png
newmtl paint
Kd 1 0 0
map_Kd gone.png
)";

struct Said {
    int exit = 0;
    std::string out, err;
};

Said run(const std::vector<std::string>& args)
{
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    console.mesh_info = nodes::describe_mesh;
    const int exit = runtime::run_command_line(args, nodes::registry(), console);
    return {exit, out.str(), err.str()};
}

std::string slab_in(const files::Folder& folder)
{
    folder.write("slab.mtl", slab_materials);
    folder.write("grain.png", "x");
    return folder.write("slab.obj", slab).string();
}

TEST(MeshInfo, SaysWhatAClosedSlabIs)
{
    const files::Folder folder;
    const Said said = run({"info", "--json", slab_in(folder)});
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    const auto all = nlohmann::json::parse(said.out);
    EXPECT_NEAR(all["size"][0].get<double>(), 2, 1e-6);
    EXPECT_NEAR(all["size"][2].get<double>(), 0.1, 1e-6);
    EXPECT_FALSE(all["unit"]["stated"].get<bool>());
    EXPECT_EQ(all["unit"]["name"], "m");
    EXPECT_EQ(all["vertices"], 8);
    EXPECT_EQ(all["polygons"], (nlohmann::json{{"triangles", 0}, {"quads", 6}, {"larger", 0}}));
    EXPECT_EQ(all["triangles"], 12);
    EXPECT_TRUE(all["closed"].get<bool>());
    EXPECT_EQ(all["holes"], 0);
    EXPECT_EQ(all["pieces"], 1);
    EXPECT_NEAR(all["body"]["volume"].get<double>(), 0.1, 1e-6);
    EXPECT_NEAR(all["body"]["centre"][0].get<double>(), 1, 1e-6);
    // (b^2 + c^2) / 12 per mass.
    EXPECT_NEAR(all["body"]["inertia"][0][0].get<double>(), 0.1 * (0.25 + 0.01) / 12, 1e-7);
    EXPECT_NEAR(all["area"].get<double>(), 2 * (1 + 0.2 + 0.05), 1e-6);
    EXPECT_EQ(all["materials"], (nlohmann::json{"wood", "paint"}));
    ASSERT_EQ(all["textures"].size(), 2u);
    EXPECT_EQ(all["textures"][0], (nlohmann::json{{"name", "grain.png"}, {"found", true}}));
    EXPECT_EQ(all["textures"][1], (nlohmann::json{{"name", "gone.png"}, {"found", false}}));
    EXPECT_NEAR(all["thinnest_wall"]["thickness"].get<double>(), 0.1, 1e-6);
    EXPECT_NEAR(all["cubes"]["size"].get<double>(), 0.025, 1e-9);  // four in the wall
    EXPECT_EQ(all["cubes"], all["cubes_for_thinnest_wall"]);
}

TEST(MeshInfo, TheTextNamesMaterialsAndMissingTextures)
{
    const files::Folder folder;
    const Said said = run({"info", slab_in(folder)});
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    for (const char* part :
         {"slab.obj\n", "2 x 0.5 x 0.1 m", "not stated by the file; read here as m\n",
          "triangles     12\n", "polygons      6 quads\n", "surface       closed\n",
          "volume        0.1 m^3", "2: wood, paint", "2: grain.png, gone.png (not found)",
          "thinnest wall 0.1 m"}) {
        EXPECT_NE(said.out.find(part), std::string::npos) << part << "\n" << said.out;
    }
}

// Where ReadMesh finds a picture, info finds it.
TEST(MeshInfo, LooksForTexturesWhereTheyAreReadFrom)
{
    const files::Folder folder;
    folder.write("textures/gone.png", "x");
    const Said said = run({"info", slab_in(folder)});
    EXPECT_NE(said.out.find("2: grain.png, gone.png\n"), std::string::npos) << said.out;
}

TEST(MeshInfo, AnOpenMeshHasHolesAndNoVolume)
{
    const files::Folder folder;
    std::string open = slab;
    open.resize(open.find("usemtl paint"));
    const Said said = run({"info", "--json", folder.write("open.obj", open).string()});
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    const auto all = nlohmann::json::parse(said.out);
    EXPECT_FALSE(all["closed"].get<bool>());
    EXPECT_EQ(all["holes"], 1);
    EXPECT_NEAR(all["longest_rim"].get<double>(), 2 * (2 + 0.1), 1e-6);
    EXPECT_TRUE(all["body"].is_null());
}

TEST(MeshInfo, ACapThatIsWoundTheOtherWayIsNoHole)
{
    const files::Folder folder;
    std::string turned = slab;
    turned.replace(turned.find("f 3/1 4/1 8/1 7/1"), 17, "f 7/1 8/1 4/1 3/1");
    const std::string file = folder.write("turned.obj", turned).string();
    const auto all = nlohmann::json::parse(run({"info", "--json", file}).out);
    EXPECT_TRUE(all["closed"].get<bool>());
    EXPECT_EQ(all["holes"], 0);
    EXPECT_EQ(all["disagreeing_edges"], 4);
    EXPECT_EQ(all["triangles_wound_otherwise"], 2);
    EXPECT_NEAR(all["body"]["volume"].get<double>(), 2 * 0.5 * 0.1, 1e-6);
    const std::string text = run({"info", file}).out;
    EXPECT_NE(text.find("closed; 2 of its triangles are wound the other way"), std::string::npos)
        << text;
    EXPECT_EQ(all["doubled_triangles"], 0);
    const std::string twice = std::string(slab) + "f 3/1 4/1 8/1 7/1\n";
    const std::string doubled = run({"info", folder.write("twice.obj", twice).string()}).out;
    EXPECT_NE(doubled.find("2 triangles lie on another one"), std::string::npos) << doubled;
    // All of them is a mesh inside out.
    std::string inward = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n";
    const Said said = run({"info", folder.write("inward.obj", inward).string()});
    EXPECT_NE(said.out.find("closed, but its faces look inward\n"), std::string::npos) << said.out;
}

const char* const inches =
    R"(<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.0254" name="inch"/><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="a" count="9">0 0 0 40 0 0 0 40 0</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n" name="t">
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";

TEST(MeshInfo, AUnitIsGuessedWhereTheFileStatesNone)
{
    const files::Folder folder;
    geometry::TriMesh box = test_meshes::box({0, 0, 0}, {90, 60, 40});  // a desk, in cm
    const std::string text =
        geometry::obj_text(box, "");  // but for its comment, that it is in metres
    const std::string file = folder.write("desk.obj", text.substr(text.find('\n') + 1)).string();
    auto all = nlohmann::json::parse(run({"info", "--json", file}).out);
    EXPECT_EQ(all["unit"]["name"], "cm");
    EXPECT_NEAR(all["size"][0].get<double>(), 90, 1e-5);  // as ReadMesh reads it
    all = nlohmann::json::parse(run({"info", "--json", file, "--unit", "cm"}).out);
    EXPECT_NEAR(all["size"][0].get<double>(), 0.9, 1e-6);
    EXPECT_NE(run({"info", file}).out.find("in cm it is 0.9 m"), std::string::npos);
    const std::string states = (folder.path / "desk.glb").string();
    geometry::write_mesh(states, geometry::MeshFormat::glb, box);
    all = nlohmann::json::parse(run({"info", "--json", states}).out);
    EXPECT_TRUE(all["unit"]["stated"].get<bool>());
    EXPECT_EQ(all["unit"]["name"], "m");
    EXPECT_NE(run({"info", folder.write("desk.dae", inches).string()})
                  .out.find("m, from the unit that the file states"),
              std::string::npos);
    EXPECT_EQ(nodes::guess_unit(1800).name, "cm");
    EXPECT_EQ(nodes::guess_unit(8000).name, "mm");
}

// Of Voxelize's own making and by its own warning.
TEST(MeshInfo, TheSuggestedCubesAreAboutAsManyAndDrawNoWarning)
{
    const files::Folder folder;
    const std::array meshes{test_meshes::box({0, 0, 0}, {1, 0.4, 0.06}), test_meshes::icosphere(3)};
    for (const geometry::TriMesh& mesh : meshes) {
        const std::string file = (folder.path / "a.obj").string();
        geometry::write_mesh(file, geometry::MeshFormat::obj, mesh);
        const nodes::MeshInfo info = nodes::mesh_info(file, {});
        const geometry::VoxelGrid grid = geometry::fit_grid(info.box, info.cubes.size);
        const geometry::Cubes cubes = geometry::voxelize_solid(
            mesh, geometry::assign_matter(mesh, {}, {}), geometry::Inside::winding, 0, grid, {});
        EXPECT_NEAR(static_cast<double>(cubes.count()), info.cubes.count, 0.4 * info.cubes.count);
        for (const auto& part : physics::thin_parts(mesh, cubes, {})) EXPECT_LT(part.factor, 1.2);
    }
}

TEST(MeshInfo, WhereTooManyCubesWouldBeNeededFewerAreSuggested)
{
    const files::Folder folder;
    const std::string file = (folder.path / "sheet.obj").string();
    geometry::write_mesh(file, geometry::MeshFormat::obj,
                         test_meshes::box({0, 0, 0}, {1, 1, 0.002}));
    const nodes::MeshInfo info = nodes::mesh_info(file, {});
    EXPECT_LE(info.cubes.count, 50'000);
    EXPECT_GT(info.cubes.count, 40'000);
    EXPECT_NEAR(info.fine.size, 0.0005, 1e-9);
    EXPECT_GT(info.fine.count, 1e6);
}

TEST(MeshInfo, AFileThatCannotBeReadIsToldAndTheOthersAreDescribed)
{
    const files::Folder folder;
    const std::string good = slab_in(folder);
    const std::string torn = folder
                                 .write("torn.ply", "ply\nformat ascii 1.0\nelement vertex "
                                                    "4000000000\nproperty float x\n")
                                 .string();
    const std::string lost = folder.write("lost.obj", "v nan 0 0\nv 0 1 0\nf 1 2 9\n").string();
    for (const std::string& bad :
         {torn, lost, (folder.path / "none.obj").string(), folder.path.string()}) {
        const Said said = run({"info", bad, good});
        EXPECT_EQ(said.exit, runtime::exit_failed);
        EXPECT_NE(said.err.find(bad), std::string::npos) << said.err;
        EXPECT_NE(said.out.find("slab.obj"), std::string::npos);
        EXPECT_EQ(said.out.find("nan"), std::string::npos) << said.out;
    }
    EXPECT_EQ(run({"info"}).exit, runtime::exit_usage);
    EXPECT_EQ(run({"info", good, "--unit", "ell"}).exit, runtime::exit_usage);
}

TEST(MeshInfo, PointsHaveNoSurface)
{
    const files::Folder folder;
    const Said said = run({"info", folder
                                       .write("points.ply", "ply\nformat ascii 1.0\nelement "
                                                            "vertex 2\nproperty float x\n"
                                                            "property float y\nproperty float z\n"
                                                            "end_header\n0 0 0\n1 2 3\n")
                                       .string()});
    ASSERT_EQ(said.exit, runtime::exit_ok) << said.err;
    EXPECT_NE(said.out.find("none: points only"), std::string::npos) << said.out;
}

TEST(MeshInfo, SaysThatABoxWithoutALidWouldBeFilled)
{
    const files::Folder folder;
    std::string open = slab;
    open.replace(open.find("f 5/1 6/1 7/1 8/1\n"), 18, "");
    const std::string file = folder.write("tray.obj", open).string();
    const Said said = run({"info", file});
    EXPECT_NE(said.out.find("open: 1 hole, the longest rim 5 m. Voxelize fills it up to the rim"),
              std::string::npos)
        << said.out;
    EXPECT_NE(run({"info", "--json", file}).out.find("\"shell\":true"), std::string::npos);
    EXPECT_NE(run({"info", "--json", slab_in(folder)}).out.find("\"shell\":false"),
              std::string::npos);
}

// The six faces of a cube of 2 m, each half as long as the cube.
TEST(MeshInfo, SaysThatLoosePiecesWouldBeFilledBetween)
{
    const files::Folder folder;
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {-1, 1}) {
            for (int corner = 0; corner < 4; ++corner) {
                std::array<double, 3> p{};
                const auto u = static_cast<std::size_t>(axis);
                p[u] = side;
                p[(u + 1) % 3] = corner == 0 || corner == 3 ? -0.5 : 0.5;
                p[(u + 2) % 3] = corner < 2 ? -0.5 : 0.5;
                text += fmt::format("v {} {} {}\n", p[0], p[1], p[2]);
            }
            text += side > 0 ? "f -4 -3 -2 -1\n" : "f -1 -2 -3 -4\n";
        }
    }
    const std::string file = folder.write("leaves.obj", text).string();
    const std::string said = run({"info", file}).out;
    EXPECT_NE(said.find("takes what lies between 6 of its open pieces for a solid"),
              std::string::npos)
        << said;
    EXPECT_NE(run({"info", "--json", file}).out.find("\"pieces_filled_between\":6"),
              std::string::npos);
}

// A cube with one face listed twice is closed. One whose faces all are there both ways round is,
// and without its lid it encloses nothing.
TEST(MeshInfo, MeasuresTheFacesThatCubesAreMadeOf)
{
    const files::Folder folder;
    const std::string corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n";
    const std::string open = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 4 1 5 8\n";
    const std::string lid = "f 3 4 8 7\n";
    const std::string back = "f 4 1 2 3\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 4 8 5 1\n";
    const auto info_of = [&](const std::string& faces) {
        return nodes::mesh_info(folder.write("cube.obj", corners + faces), {});
    };
    const nodes::MeshInfo twice = info_of(open + lid + lid);
    EXPECT_TRUE(twice.closed);
    EXPECT_EQ(twice.doubled, 2u);
    EXPECT_NEAR(twice.body.mass, 1, 1e-6);
    EXPECT_NEAR(twice.area, 6, 1e-6);
    const nodes::MeshInfo both = info_of(open + lid + back + "f 3 7 8 4\n");
    EXPECT_TRUE(both.closed);
    EXPECT_EQ(both.doubled, 12u);
    EXPECT_NEAR(both.body.mass, 1, 1e-6);
    const nodes::MeshInfo cup = info_of(open + back);
    EXPECT_FALSE(cup.closed);
    EXPECT_EQ(cup.doubled, 10u);
    EXPECT_NEAR(cup.area, 5, 1e-6);
    EXPECT_NE(nodes::info_text("cube.obj", cup).find("it encloses nothing"), std::string::npos);
    EXPECT_EQ(nodes::info_json("cube.obj", cup).find("nan"), std::string::npos);
}

}  // namespace
