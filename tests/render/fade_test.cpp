#include "render/fade.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/mesh/primitive.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::TriMesh;
using geometry::Vec3f;

TriMesh red_box()
{
    TriMesh mesh = geometry::box({1, 1, 1}, {1, 1, 1});
    auto topology = *mesh.topology;
    geometry::Material red;
    red.colour = {1, 0, 0};
    red.opacity = 0.5f;
    topology.materials = {red};
    mesh.topology = std::make_shared<const geometry::MeshTopology>(topology);
    return mesh;
}

TEST(Fade, EndsWhenAsked)
{
    const auto box = std::make_shared<const TriMesh>(red_box());
    const std::vector<std::shared_ptr<const TriMesh>> meshes{box, box};
    std::stop_source source;
    const std::stop_token token = source.get_token();
    const geometry::StopScope scope(&token);
    EXPECT_EQ(render::onion_skin(meshes, {}).positions.size(), 2 * box->positions.size());
    source.request_stop();
    EXPECT_THROW(render::onion_skin(meshes, {}), geometry::Stopped);
}

// Half way in display values: sRGB 0.5 is 0.2140 as light.
TEST(Fade, ColoursAreMixedAsTheEyeSeesThem)
{
    const TriMesh mesh = red_box();
    const TriMesh half = render::faded(mesh, {1, 1, 1}, 0.5f, 0.4f);
    const geometry::Material& material = half.topology->materials.at(0);
    EXPECT_LT((material.colour - Vec3f(1, 0.2140f, 0.2140f)).norm(), 1e-3f);
    EXPECT_FLOAT_EQ(material.opacity, 0.2f);
    EXPECT_EQ(half.positions, mesh.positions);
    EXPECT_EQ(half.topology->triangles, mesh.topology->triangles);
    // Nothing of it changes nothing, all of it everything.
    const auto colour_at = [&](float share) {
        return render::faded(mesh, {0, 0, 1}, share, 1).topology->materials.at(0).colour;
    };
    EXPECT_LT((colour_at(0) - Vec3f(1, 0, 0)).norm(), 1e-5f);
    EXPECT_LT((colour_at(1) - Vec3f(0, 0, 1)).norm(), 1e-5f);
}

TEST(Fade, WhatHasNoMaterialFadesToo)
{
    TriMesh mesh = geometry::box({1, 1, 1}, {1, 1, 1});
    const TriMesh plain = render::faded(mesh, {0, 0, 1}, 1, 1);
    ASSERT_EQ(plain.topology->materials.size(), 1u);
    EXPECT_LT((plain.topology->materials[0].colour - Vec3f(0, 0, 1)).norm(), 1e-5f);
    // Vertices that are seen in their own colours still are.
    mesh.colours.assign(mesh.positions.size(), {0, 1, 0});
    const TriMesh out = render::faded(mesh, {1, 1, 1}, 1, 1);
    ASSERT_EQ(out.topology->materials.size(), 1u);
    EXPECT_EQ(out.topology->materials[0], geometry::Material{});
    for (const Vec3f& c : out.colours) EXPECT_LT((c - Vec3f(1, 1, 1)).norm(), 1e-5f);
    TriMesh cloud;
    cloud.positions = {{0, 0, 0}, {1, 0, 0}};
    const TriMesh pale = render::faded(cloud, {1, 1, 1}, 1, 1);
    ASSERT_EQ(pale.colours.size(), 2u);
    EXPECT_LT((pale.colours[0] - Vec3f(1, 1, 1)).norm(), 1e-5f);
}

// Three boxes: the last comes first and keeps its colour, the middle one is half as pale as the
// first, in display values, and half as clear.
TEST(Fade, AnOnionSkinIsPalerTheEarlier)
{
    std::vector<std::shared_ptr<const TriMesh>> boxes;
    for (const float x : {0.0f, 2.0f, 4.0f}) {
        TriMesh mesh = red_box();
        for (Vec3f& p : mesh.positions) p.x() += x;
        boxes.push_back(std::make_shared<const TriMesh>(mesh));
    }
    const TriMesh all = render::onion_skin(boxes, {{1, 1, 1}, 1, 0});
    ASSERT_EQ(all.positions.size(), 3 * boxes[0]->positions.size());
    EXPECT_EQ(all.positions.front(), boxes[2]->positions.front());
    EXPECT_EQ(all.positions.back(), boxes[0]->positions.back());
    const auto& materials = all.topology->materials;
    const auto of_face = [&](std::size_t f) { return materials[all.topology->material[f]]; };
    const std::size_t faces = boxes[0]->triangles().size();
    EXPECT_LT((of_face(0).colour - Vec3f(1, 0, 0)).norm(), 1e-5f);
    EXPECT_LT((of_face(faces).colour - Vec3f(1, 0.2140f, 0.2140f)).norm(), 1e-3f);
    EXPECT_LT((of_face(2 * faces).colour - Vec3f(1, 1, 1)).norm(), 1e-5f);
    EXPECT_FLOAT_EQ(of_face(0).opacity, 0.5f);
    EXPECT_FLOAT_EQ(of_face(faces).opacity, 0.25f);
    EXPECT_FLOAT_EQ(of_face(2 * faces).opacity, 0);
    // One alone is as it was.
    const TriMesh one = render::onion_skin(std::span(boxes).first(1), {{1, 1, 1}, 1, 0});
    EXPECT_LT((one.topology->materials[0].colour - Vec3f(1, 0, 0)).norm(), 1e-5f);
}

TEST(Fade, AListOfNumbersIsReadOrRefused)
{
    EXPECT_EQ(render::numbers_in("1, 12 24,-3"), (std::vector<int>{1, 12, 24, -3}));
    EXPECT_EQ(render::numbers_in(" 7 "), (std::vector<int>{7}));
    for (const char* text : {"", " , ", "1, two", "1.5", "3x", "99999999999"}) {
        EXPECT_THROW(render::numbers_in(text), std::invalid_argument) << text;
    }
}

}  // namespace
