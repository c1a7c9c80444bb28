#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layered_bodies/layered_mesh.hpp"

#include "physics/layered_bodies/layered_body.hpp"
#include "physics/layered_bodies/layered_moment.hpp"
#include "physics/layered_bodies/layered_step.hpp"
#include "physics/layers/deformed_layer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace physics {
namespace {

// `along`: how many times as thick they are along the way between them, and as far apart.
LayeredScene two_pressed_balls(double along = 1)
{
    std::vector<LayeredPart> parts;
    for (const double x : {-0.09 * along, 0.09 * along}) {
        geometry::ImplicitLayer layer;
        layer.skeletons = {{.kind = geometry::SkeletonKind::point, .points = {Vec3(x, 0, 0)}}};
        layer.skeletons[0].stretch(0, 0) = along;
        layer.contributions = {{.thickness = 0.1, .stiffness = 10, .radius = 0.25}};
        layer.frame = {0};
        LayeredPart part;
        part.body = std::make_shared<const LayeredBody>(
            make_layered_body(layer, BaseKind::still, 1000, 0.01));
        part.colour = {x < 0 ? 1.f : 0.f, 0, 0};
        parts.push_back(part);
    }
    return start(parts);
}

}  // namespace

TEST(LayeredMesh, EachBodyIsAGroupThatEndsAtTheCommonSurface)
{
    const LayeredScene scene = two_pressed_balls();
    for (const auto surface :
         {LayeredMeshOptions::Surface::exact, LayeredMeshOptions::Surface::samples}) {
        const geometry::TriMesh mesh = layered_mesh(scene, {.surface = surface, .cell = 0.01});
        ASSERT_EQ(mesh.topology->materials.size(), 2u);
        ASSERT_EQ(mesh.topology->group.size(), mesh.triangles().size());
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
        ASSERT_EQ(mesh.attributes.at(0).values.size(), mesh.positions.size());
        EXPECT_EQ(mesh.topology->materials[0].colour.x(), 1.f);
        // k times the depth where they press each other most, and nothing on their far sides.
        const auto& pressed = mesh.attributes[0].values;
        EXPECT_NEAR(*std::max_element(pressed.begin(), pressed.end()), 10 * (0.1 - 0.09), 0.01);
        EXPECT_NEAR(*std::min_element(pressed.begin(), pressed.end()), 0, 1e-5);
        for (std::size_t t = 0; t < mesh.triangles().size(); ++t) {
            for (const std::uint32_t v : mesh.triangles()[t]) {
                const float side = mesh.topology->group[t] == 0 ? -1.f : 1.f;
                // The grid of 0.01 m cuts the border's corner by about its curvature.
                EXPECT_GT(side * mesh.positions[v].x(), -1e-4f);
            }
        }
    }
}

// The preview carries the samples from where the last step left them: for a scene at rest the exact
// surface, flat where two press each other, with the bulge around it.
TEST(LayeredMesh, ThePreviewOfASteppedSceneNeedsNoField)
{
    LayeredScene scene = two_pressed_balls();
    scene = advance(scene, scene.parts, {.gravity = Vec3::Zero()}, 1.0 / 24, 1);
    const geometry::TriMesh mesh =
        layered_mesh(scene, {.surface = LayeredMeshOptions::Surface::samples});
    ASSERT_EQ(mesh.attributes.at(0).values.size(), mesh.positions.size());
    // It is closed all the same: each ball less the cap beyond the cut, of height 0.01 m, and the
    // bulge of a twentieth of all.
    const double ball = 4.0 / 3 * std::numbers::pi * 1e-3;
    const double cap = std::numbers::pi * 1e-4 * (0.1 - 0.01 / 3);
    EXPECT_NEAR(geometry::enclosed_volume(mesh), 2 * (ball - cap), 0.1 * ball);
    const LayeredMoment moment(scene);
    const std::array exact{deformed(moment.bodies, 0, moment.contacts),
                           deformed(moment.bodies, 1, moment.contacts)};
    double flat = 0, pressed = 0, bulged = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const bool left = v < scene.parts[0].body->samples.count();
        const geometry::Vec3f p = mesh.positions[v];
        const float r = (p - geometry::Vec3f(left ? -0.09f : 0.09f, 0, 0)).norm();
        EXPECT_LT((left ? 1.f : -1.f) * p.x(), 1e-6f);
        if (std::abs(p.x()) > 1e-6f) {
            // k = 10: a float's rounding of the position is worth this much of the field.
            EXPECT_NEAR(value_at(exact[left ? 0 : 1], p.cast<double>()).f, 1, 1e-5);
            EXPECT_GE(r, 0.1f - 1e-6f);
            bulged = std::max(bulged, static_cast<double>(r) - 0.1);
        } else {
            flat += 1;
        }
        pressed = std::max(pressed, static_cast<double>(mesh.attributes[0].values[v]));
    }
    EXPECT_GT(flat, 20);
    EXPECT_GT(bulged, 3e-3);                        // nearly half the depth: bulge_height is 0.5
    EXPECT_NEAR(pressed, 10 * (0.1 - 0.09), 5e-3);  // k times the depth at the middle
}

TEST(LayeredMesh, ThePreviewOfStretchedLayersKnowsTheirCompression)
{
    LayeredScene scene = two_pressed_balls(3);
    scene = advance(scene, scene.parts, {.gravity = Vec3::Zero()}, 1.0 / 24, 1);
    const geometry::TriMesh mesh =
        layered_mesh(scene, {.surface = LayeredMeshOptions::Surface::samples});
    const auto& pressed = mesh.attributes.at(0).values;
    EXPECT_NEAR(*std::max_element(pressed.begin(), pressed.end()), 10 * (0.1 - 0.09), 5e-3);
}

TEST(LayeredMesh, OneBodyCanBeMeshedUndeformedOrCut)
{
    const LayeredScene scene = two_pressed_balls();
    const auto right = layered_mesh(scene, {.cell = 0.01, .body = 1, .deformed = false});
    for (const auto& p : right.positions) {
        EXPECT_NEAR((p - geometry::Vec3f(0.09f, 0, 0)).norm(), 0.1f, 1e-6f);
    }
    EXPECT_THROW(layered_mesh(scene, {.body = 2}), std::invalid_argument);
}

// Between lines of the grid too: a cut with keys moves on evenly.
TEST(LayeredMesh, ACutEndsWhereItIsAsked)
{
    const LayeredScene scene = two_pressed_balls();
    for (const double at : {0.0, 0.003, 0.0137}) {
        const auto cut =
            layered_mesh(scene, {.cell = 0.01, .cut = LayeredMeshOptions::Cut::z, .cut_at = at});
        ASSERT_FALSE(cut.triangles().empty());
        float most = -1;
        for (const auto& p : cut.positions) most = std::max(most, p.z());
        EXPECT_EQ(most, static_cast<float>(at));
        EXPECT_EQ(cut.normals.size(), cut.positions.size());
    }
}

}  // namespace physics
