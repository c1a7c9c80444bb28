// What other tools and the field call nodes, parameters and materials is answered with what they
// are here.

#include "graph/document/document.hpp"
#include "graph/document/other_names.hpp"
#include "nodes/registry.hpp"
#include "runtime/commands/command_line.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>
#include <sstream>

namespace {

// What is suggested for the only mistake of a document with one node of that type.
std::string suggested(const std::string& type, const std::string& params = "")
{
    const graph::Loaded loaded = graph::load_text(
        fmt::format(
            R"({{ "aspic": 1, "nodes": {{ "n": {{ "type": "{}", "params": {{ {} }} }} }} }})", type,
            params),
        "scene.json", nodes::registry());
    std::string text;
    for (const graph::Problem& p : loaded.problems) {
        if (p.part == graph::Part::input || p.severity != graph::Severity::error) continue;
        text += (text.empty() ? "" : "\n") + p.suggestion;
    }
    return text;
}

TEST(OtherNames, OfNodesAreAnsweredWithNodesThatExist)
{
    for (const std::string name :
         {"RigidBody",   "Rigid",        "RBD",      "RBDObject", "Softbody", "SoftBody",
          "Cloth",       "Wind",         "Gravity",  "Mesh",      "File",     "Import",
          "Alembic",     "USD",          "FBX",      "Camera",    "Light",    "Material",
          "Output",      "Cache",        "Instance", "Scatter",   "Fracture", "RigidBodySolver",
          "VellumCloth", "VellumSolver", "Hinge",    "BallJoint", "Attach",   "Glue",
          "Rope",        "Chain",        "nCloth",   "nRigid",    "nucleus",  "polySphere",
          "IcoSphere",   "FEMSolver",    "Remesh",   "playblast", "Karma",    "AttribWrangle",
          "SkinCluster", "StaticObject", "PopForce", "VellumPin", "Turntable"}) {
        const std::string text = suggested(name + "@1");
        EXPECT_EQ(text.find("available"), text.npos) << name << ": " << text;
        EXPECT_EQ(text.find("did you mean"), text.npos) << name << ": " << text;
        int types = 0;
        for (std::size_t at = 0; (at = text.find('\'', at)) != text.npos;) {
            const std::size_t end = text.find('\'', at + 1);
            const std::string quoted = text.substr(at + 1, end - at - 1);
            at = end + 1;
            if (!std::isupper(static_cast<unsigned char>(quoted.at(0)))) continue;
            ++types;
            EXPECT_TRUE(nodes::registry().find(quoted)) << name << ": " << text;
        }
        EXPECT_GT(types, 0) << name << ": " << text;
    }
}

TEST(OtherNames, OfNothingThatIsHereAreAnsweredWithTheWayToAll)
{
    EXPECT_EQ(suggested("Spaceship@1"), "`aspic nodes` lists all");
    EXPECT_EQ(suggested("Render@2", R"("spaceship": 1)"), "`aspic nodes Render` lists all");
    EXPECT_EQ(suggested("ReadUsdFile@1").find("available: 'Read"), 0u);
}

TEST(OtherNames, OfRigidBodiesNameTheOptionOfSimulate)
{
    for (const char* name : {"RigidBody@1", "rigid_body@1", "Rigid@1", "RBD@1", "RBDObject@2"}) {
        EXPECT_EQ(suggested(name), "use 'Simulate' with \"bodies\": [{ \"rigid\": true }], or "
                                   "'Collider' for what does not move");
    }
}

TEST(OtherNames, OfMaterialsAreAnsweredWithPresetsOfTheirKind)
{
    for (const auto& [name, presets] : std::initializer_list<std::pair<const char*, const char*>>{
             {"wood", "'oak' or 'pine'"},
             {"Metal", "'steel' or 'aluminium'"},
             {"aluminum", "'aluminium'"},
             {"plastic", "'nylon'"},
             {"stone", "'concrete'"},
             {"cloth", "'leather'"},
             {"skin", "'flesh'"},
         }) {
        EXPECT_EQ(suggested("Plane@1", fmt::format(R"("matter": {{ "preset": "{}" }})", name)),
                  fmt::format("did you mean {}?", presets));
    }
}

TEST(OtherNames, OfShapesAreAnsweredWithOurs)
{
    EXPECT_EQ(suggested("Primitive@1", R"("shape": "cube")"), "did you mean 'box'?");
    EXPECT_EQ(suggested("Primitive@1", R"("shape": "Donut")"), "did you mean 'torus'?");
    EXPECT_EQ(suggested("Primitive@1", R"("shape": "plane")"), "did you mean 'grid'?");
    EXPECT_EQ(suggested("Primitive@1", R"("shape": "ico_sphere")"), "did you mean 'sphere'?");
    EXPECT_EQ(suggested("Collider@1", R"("kind": "ball")"), "did you mean 'sphere'?");
    EXPECT_EQ(suggested("Simulate@3", R"("method": "FEM")"), "did you mean 'bricks'?");
    EXPECT_EQ(suggested("Simulate@3", R"("method": "cloth")"), "did you mean 'shell'?");
}

// `aspic nodes WORD` gives the same answers.
TEST(OtherNames, ASearchForThemBeginsWithWhatToUse)
{
    for (const auto& [word, use] : std::initializer_list<std::pair<const char*, const char*>>{
             {"attach", "attach: use 'Merge'"},
             {"hinge", "hinge: use 'Joint'"},
             {"rope", "rope: use a thin 'Primitive'"},
             {"fracture", "fracture: use 'Voxelize'"},
         }) {
        std::ostringstream out, err;
        runtime::Console console{out, err, false, {}, {}, "test"};
        EXPECT_EQ(runtime::run_command_line({"nodes", word}, nodes::registry(), console),
                  runtime::exit_ok);
        EXPECT_EQ(out.str().rfind(use, 0), 0u) << out.str();
    }
}

TEST(OtherNames, OfParametersAreAnsweredWithOurs)
{
    struct Case {
        const char *type, *params, *says;
    };
    const char* const of_contact = "it is no material's: set it where things touch, on Ground, "
                                   "Collider or 'contact' of Simulate";
    const char* const of_mass = "use 'density', or 'total_mass' of the node that makes the cubes";
    for (const Case& c : {
             Case{"Render@2", R"("camera": { "position": [1, 1, 1] })", "did you mean 'eye'?"},
             {"Render@2", R"("camera": { "lookAt": [1, 1, 1] })", "did you mean 'target'?"},
             {"Render@2", R"("camera": { "fov": 3 })", "did you mean 'field_of_view'?"},
             {"Render@2", R"("position": [1, 1, 1])", "did you mean 'camera.eye'?"},
             {"Render@2", R"("resolution": [1920, 1080])", "use 'width' and 'height'"},
             {"Voxelize@1", R"("voxel_size": 1)", "did you mean 'size'?"},
             {"Ground@1", R"("position": [0, 0, 0])", "did you mean 'height'?"},
             {"Ground@1", R"("restitution": 1)", "did you mean 'bounce'?"},
             {"Transform@1", R"("location": [0, 0, 0])", "did you mean 'translate'?"},
             {"Transform@1", R"("rotation": [0, 0, 0])", "did you mean 'rotate_degrees'?"},
             {"Transform@1", R"("size": 2)", "did you mean 'scale'?"},
             {"Primitive@1", R"("shape": "torus", "radius": 2)", "did you mean 'torus.radius'?"},
             {"Primitive@1", R"("shape": "sphere", "size": 2)", "did you mean 'sphere.radius'?"},
             {"Primitive@1", R"("size": 2)", "did you mean 'box.size'?"},
             {"Primitive@1", R"("position": 2)", "did you mean 'centre'?"},
             {"Primitive@1", R"("scale": 2)", "link a Transform behind this node"},
             {"Plane@1", R"("matter": { "mass": 2 })", of_mass},
             {"Plane@1", R"("matter": { "bounciness": 2 })", of_contact},
             {"Plane@1", R"("matter": { "stiffness": 2 })", "did you mean 'young'?"},
             {"Simulate@3", R"("step": { "dt": 0.1 })", "'dt' belongs outside 'step'"},
             {"Simulate@3", R"("friction": 0.1)", "did you mean 'contact.friction'?"},
             {"Simulate@3", R"("method": "shell", "bend": 2)", "did you mean 'shell.bend'?"},
         }) {
        EXPECT_EQ(suggested(c.type, c.params), c.says) << c.type << ": " << c.params;
    }
}

}  // namespace
