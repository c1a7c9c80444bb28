// The part of a picture in which anything is drawn.

#include "render/drawn_part.hpp"

#include "render/make_draw_list.hpp"
#include "tests/render/pictures.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::Vec3;

render::Scene ball_at(const Vec3& centre)
{
    render::Scene scene;
    geometry::TriMesh mesh = geometry::uv_sphere(0.3, 24, 12);
    for (auto& p : mesh.positions) p += centre.cast<float>();
    scene.surfaces.push_back(tests::surface(std::move(mesh)));
    scene.stage = tests::box_about_origin(1);
    return scene;
}

render::DrawnPart part_of(const render::Scene& scene, const render::Camera& camera,
                          const render::Look& look)
{
    const render::DrawList list = render::make_draw_list(scene, camera, look);
    return render::drawn_part(render::draw_job(list, look));
}

const render::Camera from_aside{{3, 1.5, 4}, {0, 0, 0}, {0, 1, 0}, 0.7};

TEST(DrawnPart, HoldsAllThatIsDrawnAndNotMuchMore)
{
    render::Look look = tests::plain_look(160);
    look.height = 120;
    for (const Vec3& centre : {Vec3(0, 0, 0), Vec3(0.7, 0.5, 0.3), Vec3(-0.6, -0.8, -0.2)}) {
        const render::Scene scene = ball_at(centre);
        const render::DrawnPart part = part_of(scene, from_aside, look);
        const render::Image image = render::draw(scene, from_aside, look);
        int inside = 0;
        for (int y = 0; y < image.height; ++y) {
            for (int x = 0; x < image.width; ++x) {
                if (!tests::covered(image, x, y)) continue;
                const bool in_part = x > part.x && x < part.x + part.width - 1 && y > part.y &&
                                     y < part.y + part.height - 1;
                ASSERT_TRUE(in_part) << x << ' ' << y;
                ++inside;
            }
        }
        // A ball fills 0.52 of its box, seen from any side no less than a quarter; less the rim.
        EXPECT_GT(inside, part.width * part.height / 5);
    }
}

TEST(DrawnPart, SmoothsTheEdgesOfAThingToItsRim)
{
    // With light from nowhere a ball is black on blue: pixels on its rim alone are in between.
    render::Look look = tests::plain_look(96);
    look.light = look.sky = look.bounce = {0, 0, 0};
    look.antialias = render::Antialias::samples4;
    const render::Image image = render::draw(ball_at({0, 0, 0}), from_aside, look);
    const auto between = [&](int x, int y) {
        const int blue = tests::pixel(image, x, y)[2];
        return blue > 20 && blue < 175;
    };
    std::array<int, 4> sides{};  // left, right, upper and lower half
    for (int y = 0; y < 96; ++y) {
        for (int x = 0; x < 96; ++x) {
            if (!between(x, y)) continue;
            ++sides[x < 48 ? 0 : 1];
            ++sides[y < 48 ? 2 : 3];
        }
    }
    // The circle has a radius of 0.3 m * 48 pixels / (5.2 m * tan 0.35) = 7.6 pixels: where it is
    // steeper than 45 degrees, on either side, it crosses 2 * 7.6 / sqrt 2 = 10.7 rows.
    for (const int side : sides) EXPECT_GE(side, 10);
}

TEST(DrawnPart, IsAllOfThePictureWhereThingsReachUpToTheEye)
{
    const render::Camera inside{{0, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0.7};
    const render::DrawnPart part = part_of(ball_at({0, 0, 0}), inside, tests::plain_look(64));
    EXPECT_EQ(part.x, 0);
    EXPECT_EQ(part.y, 0);
    EXPECT_EQ(part.width, 64);
    EXPECT_EQ(part.height, 64);
}

TEST(DrawnPart, IsEmptyWhereAllIsBesideThePicture)
{
    const render::Camera beside{{0, 0, 4}, {8, 0, 0}, {0, 1, 0}, 0.3};
    const render::DrawnPart part = part_of(ball_at({0, 0, 0}), beside, tests::plain_look(64));
    EXPECT_EQ(part.width * part.height, 0);
}

}  // namespace
