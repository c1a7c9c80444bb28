// Layers through a graph against closed forms: how far bulges reach, rigid bodies that stand on
// each other, the volume that is drawn.

#include "geometry/base/union_find.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered.hpp"
#include "tests/nodes/scene.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace {

using fixtures::Scene;
using geometry::TriMesh;
using physics::LayeredScene;

// A ball of radius 0.5 m that a floor cuts by 0.05 m, with a bulge 0.1 m wide: what lies outside of
// the ball is the bulge. The mesh rounds the border of the contact by up to a twentieth of a cell.
TEST(LayerForms, ABulgeReachesAsFarAsItsWidthSays)
{
    Scene scene(R"("one": { "type": "Skeletons@1", "params": { "skeletons": [
            { "position": [0, 0.45, 0], "contribution":
                { "thickness": 0.5, "stiffness": 2, "radius": 1 } } ] } },
        "ball": { "type": "ImplicitLayer@3", "inputs": { "layer": "one.layer" }, "params": {
            "base": "still", "seed_spacing": 0.02,
            "matter": { "bulge_width": 0.1, "bulge_height": 0.5 } } },
        "floor": { "type": "Ground@1" },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["ball.part"],
            "colliders": ["floor.collider"] } },
        "mesh": { "type": "Polygonize@2", "inputs": { "scene": "bodies.scene" },
            "params": { "cell": 0.02 } })");
    const auto mesh = scene.at<TriMesh>("mesh");
    double highest = 0, thickest = 0;
    for (const auto& p : mesh->positions) {
        const geometry::Vec3 at = p.cast<double>();
        const double beyond = (at - geometry::Vec3(0, 0.45, 0)).norm() - 0.5;
        thickest = std::max(thickest, beyond);
        if (beyond > 1e-6) highest = std::max(highest, at.y());
        EXPECT_GT(at.y(), -1e-3) << "it fits the floor";
    }
    EXPECT_NEAR(highest, 0.1, 0.002);
    EXPECT_GT(thickest, 0.005);
}

// Boxes 0.3 m high, layers included, and a soft ball of 0.1 m on top.
TEST(LayerForms, RigidBodiesStandOnEachOtherAndCarryASoftOne)
{
    Scene scene(R"("slab": { "type": "Skeletons@1", "params": { "skeletons": [
            { "kind": "box", "size": [0.4, 0.2, 0.4], "contribution":
                { "thickness": 0.05, "stiffness": 20, "radius": 0.12 } } ] } },
        "one": { "type": "Skeletons@1", "params": { "skeletons": [
            { "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } ] } },
        "low": { "type": "ImplicitLayer@3", "inputs": { "layer": "slab.layer" }, "params": {
            "seed_spacing": 0.05, "translate": [0, 0.15, 0], "matter": { "rigid": true } } },
        "high": { "type": "ImplicitLayer@3", "inputs": { "layer": "slab.layer" }, "params": {
            "seed_spacing": 0.05, "translate": [0.03, 0.45, 0], "matter": { "rigid": true } } },
        "ball": { "type": "ImplicitLayer@3", "inputs": { "layer": "one.layer" }, "params": {
            "seed_spacing": 0.03, "translate": [0, 0.69, 0], "density": 500,
            "matter": { "restitution": 0 } } },
        "floor": { "type": "Ground@1" },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["low.part", "high.part",
            "ball.part"], "colliders": ["floor.collider"] } })");
    const auto at = scene.at<LayeredScene>("bodies", 36);
    const auto height = [&](std::size_t b) { return at->states[b].position[0].y(); };
    // Each stands within 0.1 % of its thickness.
    EXPECT_NEAR(height(0), 0.15, 1e-4);
    EXPECT_NEAR(height(1), 0.45, 2e-4);
    EXPECT_GT(height(2), 0.65);
    EXPECT_LT(height(2), 0.6999) << "its weight presses it";
    EXPECT_LT(at->states[2].velocity[0].norm(), 0.02);
}

// How many pieces a mesh has.
std::size_t pieces_of(const TriMesh& mesh)
{
    geometry::UnionFind joined(mesh.positions.size());
    for (const geometry::Triangle& t : mesh.triangles()) {
        joined.join(t[0], t[1]);
        joined.join(t[1], t[2]);
    }
    std::set<std::size_t> roots;
    for (const geometry::Triangle& t : mesh.triangles()) roots.insert(joined.root(t[0]));
    return roots.size();
}

// A net of nine masses, pinned at its corners, catches a ball: springs along its edges stretch, and
// so do the segments that coat them: the skin stays one.
TEST(LayerForms, ANetWearsOneSkinAndCatchesABall)
{
    Scene scene(R"("sheet": { "type": "Primitive@1", "params": { "shape": "grid", "grid": {
            "size_x": 0.8, "size_z": 0.8, "divisions_x": 2, "divisions_z": 2 } } },
        "cords": { "type": "Skeletons@1", "inputs": { "mesh": "sheet.mesh" }, "params": {
            "faces": "edges", "blend": "gradient", "each":
                { "thickness": 0.03, "stiffness": 33, "radius": 0.08 } } },
        "net": { "type": "ImplicitLayer@3", "inputs": { "layer": "cords.layer" }, "params": {
            "base": "net", "seed_spacing": 0.03, "density": 500, "matter": { "stiffness": 1e5 },
            "pins": [ { "position": [-0.4, 0, -0.4] }, { "position": [0.4, 0, -0.4] },
                { "position": [-0.4, 0, 0.4] }, { "position": [0.4, 0, 0.4] } ] } },
        "sprung": { "type": "Springs@1", "inputs": { "part": "net.part" }, "params": {
            "along": "skeletons", "stiffness": 1500, "damping": 20 } },
        "one": { "type": "Skeletons@1", "params": { "skeletons": [ { "contribution":
            { "thickness": 0.15, "stiffness": 6.7, "radius": 0.4 } } ] } },
        "ball": { "type": "ImplicitLayer@3", "inputs": { "layer": "one.layer" }, "params": {
            "seed_spacing": 0.03, "translate": [0.02, 0.4, 0.05], "density": 400,
            "matter": { "stiffness": 1e5 } } },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["sprung.part", "ball.part"] } },
        "skin": { "type": "Polygonize@2", "inputs": { "scene": "bodies.scene" }, "params": {
            "cell": 0.015, "body": 0 } })");
    double lowest = 0;
    for (const int frame : {1, 8, 16, 24}) {
        const auto at = scene.at<LayeredScene>("bodies", frame);
        EXPECT_EQ(pieces_of(*scene.at<TriMesh>("skin", frame)), 1u) << "frame " << frame;
        EXPECT_EQ(physics::mass_count(at->parts[0].body->base), 9u);
        EXPECT_EQ(at->states[0].position[0], at->parts[0].body->base.frames[0].translation());
        EXPECT_GT(at->states[1].position[0].y(), -0.4) << "it fell through in frame " << frame;
        for (const auto& p : at->states[0].position) lowest = std::min(lowest, p.y());
    }
    EXPECT_LT(lowest, -0.05) << "the ball stretches it";
}

// Two parts of one body that press each other, on a floor: with the bulges of both contacts, what
// is drawn keeps the volume that it had in the air. A mesh of cells of 0.01 m is 3e-4 too small, at
// all frames.
TEST(LayerForms, TheVolumeThatIsDrawnStays)
{
    Scene scene(R"("two": { "type": "Skeletons@1", "params": { "blend": "smooth_groups",
            "skeletons": [
            { "position": [-0.17, 0.24, 0], "contribution":
                { "thickness": 0.2, "stiffness": 5, "radius": 0.5 } },
            { "position": [0.17, 0.24, 0], "contribution":
                { "thickness": 0.2, "stiffness": 5, "radius": 0.5 } } ] } },
        "body": { "type": "ImplicitLayer@3", "inputs": { "layer": "two.layer" }, "params": {
            "seed_spacing": 0.02, "volume": { "proportional": 60 },
            "matter": { "stiffness": 20000, "self_contact": true, "bulge_width": 0.06,
                        "bulge_height": 0.5 } } },
        "floor": { "type": "Ground@1" },
        "bodies": { "type": "Layered@1", "inputs": { "parts": ["body.part"],
            "colliders": ["floor.collider"] } },
        "mesh": { "type": "Polygonize@2", "inputs": { "scene": "bodies.scene" },
            "params": { "cell": 0.01 } },
        "volume": { "type": "Measure@1", "inputs": { "mesh": "mesh.mesh" },
            "params": { "what": "volume" } })");
    const double first = *scene.at<double>("volume");
    for (const int frame : {4, 6, 8, 12, 20}) {
        EXPECT_NEAR(*scene.at<double>("volume", frame) / first, 1, 0.005) << frame;
    }
    EXPECT_LT(scene.at<LayeredScene>("bodies", 20)->states[0].position[0].y(), 0.2)
        << "it has come down";
}

}  // namespace
