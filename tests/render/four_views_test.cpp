// Four views in one picture: what each shows, at one scale and in line.

#include "render/four_views.hpp"
#include "tests/render/pictures.hpp"

#include <gtest/gtest.h>

namespace {

using geometry::Box;
using geometry::Vec3;
using geometry::Vec3f;
using render::Image;

// A block of 4 x 2 x 1 m.
render::Scene block()
{
    render::Scene scene;
    scene.surfaces.push_back(tests::surface(geometry::box({4, 2, 1}, {1, 1, 1})));
    return scene;
}

struct Extent {
    int left = 9999, right = -1, top = 9999, bottom = -1;
    int width() const { return right - left + 1; }
    int height() const { return bottom - top + 1; }
};

// Of what is not the backdrop, in the lower and right part or elsewhere, below the words' heights.
Extent drawn_in(const Image& image, bool right, bool low)
{
    Extent e;
    const int w = image.width / 2, h = image.height / 2;
    for (int y = low ? h + 2 : 0; y < (low ? 2 * h : h - 2); ++y) {
        for (int x = right ? w + 2 : 0; x < (right ? 2 * w : w - 2); ++x) {
            const auto p = tests::pixel(image, x, y);
            const bool backdrop = p[0] <= 2 && p[1] <= 2;
            const bool word = (y % h) > h - 40 && (x % w) < 60;
            if (backdrop || word) continue;
            e.left = std::min(e.left, x), e.right = std::max(e.right, x);
            e.top = std::min(e.top, y), e.bottom = std::max(e.bottom, y);
        }
    }
    return e;
}

TEST(FourViews, ShowThreeSidesAtOneScaleInLine)
{
    const render::Scene scene = block();
    const Box box = render::bounds(scene);
    const render::Camera camera = render::fit(box, 0.6, 0.4, 0.5, 1, 0.1);
    const Image image = render::four_views(scene, box, camera, 0.1, tests::plain_look(402));
    ASSERT_EQ(image.width, 402);
    // Each part is 200 pixels wide: 4 m take 80 % of that, 160 pixels, so that a metre has 40.
    const Extent top = drawn_in(image, false, false), front = drawn_in(image, false, true),
                 side = drawn_in(image, true, true), seen = drawn_in(image, true, false);
    EXPECT_NEAR(front.width(), 160, 2);
    EXPECT_NEAR(front.height(), 80, 2);
    EXPECT_NEAR(top.width(), 160, 2);
    EXPECT_NEAR(top.height(), 40, 2);
    EXPECT_NEAR(side.width(), 40, 2);
    EXPECT_NEAR(side.height(), 80, 2);
    EXPECT_NEAR(top.left, front.left, 1);
    EXPECT_NEAR(side.top, front.top, 1);
    EXPECT_GT(seen.width(), 60);
}

TEST(FourViews, KeepTheCamerasPictureAndItsLight)
{
    const render::Scene scene = block();
    const Box box = render::bounds(scene);
    const render::Camera camera = render::fit(box, 0.6, 0.4, 0.5, 1, 0.1);
    render::Look look = tests::plain_look(130);
    look.linear = render::Linear::whole;
    const Image image = render::four_views(scene, box, camera, 0.1, look);
    look.width = look.height = 64;
    const Image alone = render::draw(scene, camera, look);
    for (int y = 0; y < 64; y += 5) {
        for (int x = 0; x < 64; x += 5) {
            EXPECT_EQ(tests::pixel(image, 66 + x, y), tests::pixel(alone, x, y));
            const auto there = std::size_t(130 * y + 66 + x), here = std::size_t(64 * y + x);
            EXPECT_EQ(image.depth[there], alone.depth[here]);
            EXPECT_EQ(image.light[4 * there + 1], alone.light[4 * here + 1]);
        }
    }
    look.width = 12;
    EXPECT_THROW(render::four_views(scene, box, camera, 0.1, look), std::invalid_argument);
}

}  // namespace
