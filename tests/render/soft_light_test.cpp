// Soft shadows, shade in corners and the looks, against closed forms.

#include "geometry/mesh/normals.hpp"
#include "pictures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace tests;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using render::Camera;
using render::Image;
using render::Look;
using render::Scene;
using render::Style;

Look soft_look(int size)
{
    Look look = plain_look(size);
    look.style = Style::studio;
    look.soft = true;
    look.shadow = render::ShadowQuality::medium;
    look.floor = Vec3f::Constant(0.5f);
    return look;
}

// Where a square picture shows the floor point (x, 0, z).
std::array<double, 2> floor_pixel(const Image& image, const Camera& camera, double x, double z)
{
    const geometry::Mat3 axes = render::camera_axes(camera);
    const Vec3 q = axes * (Vec3(x, 0, z) - camera.eye);
    const double half = image.height / 2.0, tan_y = std::tan(camera.field_of_view / 2);
    return {half + half * q[0] / (q[2] * tan_y), half - half * q[1] / (q[2] * tan_y)};
}

// Linear brightness of the floor point (x, 0, z), 0 .. 1.
double brightness_at(const Image& image, const Camera& camera, double x, double z)
{
    const std::array<double, 2> at = floor_pixel(image, camera, x, z);
    return render::linear_from_srgb(float(pixel(image, int(at[0]), int(at[1]))[1]) / 255);
}

// A card held level over the floor at `height`, lit from straight above by a light that spans 10
// degrees; its edge runs along z at x = 0. The camera looks at the floor from the side, where the
// card hides nothing of x > -0.6 or so.
Image penumbra(double height, Camera& camera)
{
    Scene scene;
    TriMesh mesh = geometry::grid(1.2, 2.4, 4, 4);
    for (Vec3f& p : mesh.positions) p += Vec3f(-0.6f, float(height), 0);
    scene.surfaces = {surface(std::move(mesh))};
    scene.ground = 0;
    scene.stage = box_about_origin(1);
    camera = {{3.4, 2.0, 0}, {0.1, 0, 0}, {0, 1, 0}, 2 * std::atan(0.16)};
    Look look = soft_look(400);
    look.light_elevation = std::numbers::pi / 2;
    look.light = Vec3f::Constant(0.8f);
    look.light_size = 10 * std::numbers::pi / 180;
    look.occlusion = 0;
    return render::draw(scene, camera, look);
}

// The light is a disc of half-width a, so the edge of a card h above the floor darkens the floor
// over |x| < h tan a: at x the disc's lit part is the segment beyond x / (h tan a) = s, a share of
// 1 - (acos s - s sqrt(1 - s^2)) / pi. It reaches 3/4 at s = 0.404: the quarter and three quarters
// points lie 0.808 h tan a apart.
TEST(SoftLight, ThePenumbraGrowsWithTheDistanceAsTheSizeOfTheLightSays)
{
    for (const double height : {0.2, 0.4, 0.6}) {
        Camera camera;
        const Image image = penumbra(height, camera);
        const double dark = brightness_at(image, camera, -0.35, 0);
        const double bright = brightness_at(image, camera, 0.35, 0);
        ASSERT_GT(bright, dark + 0.2) << height;
        double quarter = 9, three = 9;
        for (double x = -0.2; x < 0.2; x += 0.001) {
            const double share = (brightness_at(image, camera, x, 0) - dark) / (bright - dark);
            if (quarter == 9 && share > 0.25) quarter = x;
            if (three == 9 && share > 0.75) three = x;
        }
        const double expected = 0.808 * height * std::tan(5 * std::numbers::pi / 180);
        // A pixel is 0.006 m there, the map's texels 0.003 m.
        EXPECT_NEAR(three - quarter, expected, 0.25 * expected + 0.008) << height;
        EXPECT_NEAR(0.5 * (three + quarter), 0, 0.01) << height;
    }
}

// Along the card's edge the light is the same, so each row of the picture has one brightness, also
// where it begins and ends. A row differs from one end to the other by the camera's perspective, by
// less than 0.01: the edge runs across the picture.
TEST(SoftLight, APenumbraIsAsEvenAtThePicturesEdgeAsInside)
{
    Camera camera;
    const Image image = penumbra(0.6, camera);
    for (int y = 150; y < 300; ++y) {
        for (const int x : {0, 1, 2, 397, 398, 399}) {
            EXPECT_NEAR(pixel(image, x, y)[1], pixel(image, x < 200 ? 12 : 387, y)[1], 1)
                << x << ' ' << y;
        }
    }
}

// A ball that touches the floor hides from a floor point at distance d the share F = R^3 / D^3 of
// the light from all around, D^2 = R^2 + d^2: the form factor of a sphere, cos(angle) (R / D)^2.
TEST(SoftLight, TheShadeUnderABallFollowsItsFormFactor)
{
    Scene scene;
    TriMesh ball = geometry::icosphere(0.5, 5);
    for (Vec3f& p : ball.positions) p.y() += 0.5f;
    scene.surfaces = {surface(std::move(ball))};
    scene.ground = 0;
    scene.stage = box_about_origin(1.5);
    Look look = soft_look(400);
    look.light = Vec3f::Zero();
    look.sky = look.bounce = Vec3f::Constant(0.9f);
    const Camera camera{{0, 3, 4}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.3)};
    const Image with = render::draw(scene, camera, look);
    look.occlusion = 0;
    const Image without = render::draw(scene, camera, look);
    double before = 1;
    for (const double d : {0.30, 0.36, 0.45, 0.6, 0.8}) {
        const double shade =
            1 - brightness_at(with, camera, d, 0.3) / brightness_at(without, camera, d, 0.3);
        const double away = std::hypot(d, 0.3);
        const double expected = std::pow(0.5 / std::hypot(0.5, away), 3);
        // Points in the picture stand for the surroundings; what is behind them has a thickness.
        EXPECT_NEAR(shade, expected, 0.06) << d;
        EXPECT_LT(shade, before + 0.01) << d;
        before = shade;
    }
    const double farther = 1 - std::pow(0.5 / std::hypot(0.5, 1.0, 1.0), 3);
    EXPECT_NEAR(brightness_at(with, camera, 1.0, 1.0),
                farther * brightness_at(without, camera, 1.0, 1.0), 0.006);
}

// Four legs, as of a chair, are thinner than what parts the places that shade is found by. The
// shade of a place on the floor changes evenly as the camera goes around them: of 3 x 3 pixels, it
// hardly differs from the mean of the pictures before and after.
TEST(SoftLight, TheShadeOfThinLegsDoesNotFlicker)
{
    Scene scene;
    for (const float x : {-0.4f, 0.4f}) {
        for (const float z : {-0.4f, 0.4f}) {
            TriMesh leg = geometry::box({0.07, 1, 0.07}, {1, 1, 1});
            for (Vec3f& p : leg.positions) p += Vec3f(x, 0.5f, z);
            scene.surfaces.push_back(surface(std::move(leg)));
        }
    }
    scene.ground = 0;
    scene.stage = box_about_origin(0.8);
    Look look = soft_look(240);
    look.light = Vec3f::Zero();
    look.sky = look.bounce = Vec3f::Constant(0.9f);
    std::vector<std::vector<double>> levels;
    for (int frame = 0; frame < 5; ++frame) {
        const double turn = 0.3 + 0.006 * frame;
        const Camera camera{
            {4 * std::sin(turn), 2.4, 4 * std::cos(turn)}, {0, 0.2, 0}, {0, 1, 0}, 0.5};
        const Image image = render::draw(scene, camera, look);
        std::vector<double> of_frame;
        for (double x = -0.9; x < 0.95; x += 0.1) {
            for (double z = -0.25; z < 0.95; z += 0.1) {
                const std::array<double, 2> at = floor_pixel(image, camera, x, z);
                double sum = 0;
                for (int k = 0; k < 9; ++k) {
                    sum += pixel(image, int(at[0]) + k % 3 - 1, int(at[1]) + k / 3 - 1)[1];
                }
                of_frame.push_back(sum / 9);
            }
        }
        levels.push_back(std::move(of_frame));
    }
    std::vector<double> off;
    for (std::size_t k = 1; k + 1 < levels.size(); ++k) {
        for (std::size_t i = 0; i < levels[k].size(); ++i) {
            const double even = 0.5 * (levels[k - 1][i] + levels[k + 1][i]);
            off.push_back(std::abs(levels[k][i] - even));
        }
    }
    std::sort(off.begin(), off.end());
    // The rest lies beside the legs, which pass over it.
    EXPECT_LT(off[off.size() * 9 / 10], 0.75);  // 0.6
    const auto [darkest, lightest] = std::minmax_element(levels[0].begin(), levels[0].end());
    EXPECT_GT(*lightest - *darkest, 10);
}

// A column on the floor, lit from the right by a light of half a degree, which hides from the floor
// what lies beside and left of it: up to 0.6 / tan 50 deg. In pixels whose surroundings of 2.5
// pixels are all lit, or all in the shadow, the floor is as bright as that, right up to the foot.
TEST(SoftLight, AtAFootTheFloorHasItsOwnLight)
{
    const double radius = 0.25, height = 0.6, elevation = 50 * std::numbers::pi / 180;
    Scene scene;
    TriMesh column = geometry::cylinder(radius, height, 96, 1);
    for (Vec3f& p : column.positions) p.y() += 0.3f;
    scene.surfaces = {surface(std::move(column))};
    scene.ground = 0;
    scene.stage = box_about_origin(1);
    Look look = soft_look(300);
    look.light_azimuth = std::numbers::pi / 2;
    look.light_elevation = elevation;
    look.light_size = 0.5 * std::numbers::pi / 180;
    look.occlusion = 0;
    const Camera camera{{0.4, 1.6, 4}, {-0.1, 0.1, 0}, {0, 1, 0}, 2 * std::atan(0.12)};
    const Image image = render::draw(scene, camera, look);
    const geometry::Mat3 axes = render::camera_axes(camera);
    enum class Seen { column, lit, dark };
    const auto at = [&](double px, double py) {
        const double half = image.height / 2.0, tan_y = std::tan(camera.field_of_view / 2);
        const Vec3 ray =
            axes.transpose() * Vec3((px - half) / half * tan_y, -(py - half) / half * tan_y, 1);
        // Where the ray meets the wall below the top, if it does.
        const double a = ray[0] * ray[0] + ray[2] * ray[2];
        const double b = camera.eye[0] * ray[0] + camera.eye[2] * ray[2];
        const double c = camera.eye[0] * camera.eye[0] + camera.eye[2] * camera.eye[2];
        const double root = b * b - a * (c - radius * radius);
        const Vec3 floor = camera.eye - camera.eye[1] / ray[1] * ray;
        if (std::hypot(floor[0], floor[2]) < radius) return Seen::column;
        if (root > 0) {
            const double y = camera.eye[1] + (-b - std::sqrt(root)) / a * ray[1];
            if (y >= 0 && y < height) return Seen::column;
            if (y >= height && camera.eye[1] + (-b + std::sqrt(root)) / a * ray[1] < height)
                return Seen::column;
        }
        const double deep = radius * radius - floor[2] * floor[2];
        const double back = -height / std::tan(elevation) - std::sqrt(std::max(deep, 0.0));
        return deep > 0 && floor[0] < 0 && floor[0] > back ? Seen::dark : Seen::lit;
    };
    const auto bright = [&](int x, int y) {
        return render::linear_from_srgb(float(pixel(image, x, y)[1]) / 255);
    };
    const double lit = bright(270, 250), dark = bright(60, 175);
    ASSERT_EQ(at(270.5, 250.5), Seen::lit);
    ASSERT_EQ(at(60.5, 175.5), Seen::dark);
    ASSERT_GT(lit, dark + 0.2);
    int looked_at = 0, wrong = 0;
    for (int y = 140; y < 225; ++y) {
        for (int x = 90; x < 265; ++x) {
            const Seen here = at(x + 0.5, y + 0.5);
            bool by_the_foot = false, even = here != Seen::column;
            for (int k = 0; k < 16 && even; ++k) {
                const double by = k < 8 ? 2.5 : 8, angle = k * std::numbers::pi / 4;
                const Seen there =
                    at(x + 0.5 + by * std::cos(angle), y + 0.5 + by * std::sin(angle));
                by_the_foot = by_the_foot || there == Seen::column;
                if (k < 8 && there != Seen::column) even = there == here;
            }
            // A pixel that the column covers in part is not the floor's alone.
            for (int k = 0; k < 8 && even; ++k) {
                const double angle = k * std::numbers::pi / 4;
                even = at(x + 0.5 + std::cos(angle), y + 0.5 + std::sin(angle)) != Seen::column;
            }
            if (!even || !by_the_foot) continue;
            ++looked_at;
            const double share = (bright(x, y) - dark) / (lit - dark);
            wrong += std::abs(share - (here == Seen::lit ? 1 : 0)) > 0.3 ? 1 : 0;
        }
    }
    EXPECT_GT(looked_at, 500);
    EXPECT_LE(wrong, 3);
}

// A slab on the floor, turned by 7 degrees and lit from behind: its shadow lies before it, height /
// tan 60 deg = 0.022 m deep, which is 2.8 rows of the picture. Pixels that lie wholly in it are
// dark, and those that lie wholly before it are lit, though light is found in every second row.
TEST(SoftLight, AShadowOfTwoRowsIsNotDotted)
{
    const double height = 0.038, front = 0.3, turned = 7 * std::numbers::pi / 180;
    const double deep = height / std::tan(60 * std::numbers::pi / 180);
    Scene scene;
    TriMesh slab = geometry::box({1.2, height, 2 * front}, {1, 1, 1});
    const geometry::Mat3 turn = Eigen::AngleAxisd(turned, Vec3::UnitY()).toRotationMatrix();
    for (Vec3f& p : slab.positions) {
        p = (turn * (p.cast<double>() + Vec3(0, height / 2, 0))).cast<float>();
    }
    geometry::compute_normals(slab, 0.5);
    scene.surfaces = {surface(std::move(slab))};
    scene.ground = 0;
    scene.stage = box_about_origin(0.7);
    Look look = soft_look(300);
    look.light_azimuth = std::numbers::pi + turned;
    look.light_elevation = 60 * std::numbers::pi / 180;
    look.light_size = 0.5 * std::numbers::pi / 180;
    look.occlusion = 0;
    const Camera camera{{0, 2, 4}, {0, 0, front}, {0, 1, 0}, 2 * std::atan(0.12)};
    const Image image = render::draw(scene, camera, look);
    const geometry::Mat3 axes = render::camera_axes(camera);
    // How far before the slab's front the floor is that is seen at (x, y), metres.
    const auto before = [&](double x, double y) {
        const double half = image.height / 2.0, tan_y = std::tan(camera.field_of_view / 2);
        const Vec3 ray =
            axes.transpose() * Vec3((x - half) / half * tan_y, (half - y) / half * tan_y, 1);
        return (turn.transpose() * (camera.eye - camera.eye[1] / ray[1] * ray))[2] - front;
    };
    const auto bright = [&](int x, int y) {
        return render::linear_from_srgb(float(pixel(image, x, y)[1]) / 255);
    };
    const double lit = bright(150, 250), row = before(150, 151) - before(150, 150);
    int in_shadow = 0, wrong = 0;
    for (int x = 60; x < 240; ++x) {
        for (int y = 100; y < 200; ++y) {
            const double far = std::min(before(x, y), before(x + 1, y));
            const double near = std::max(before(x, y + 1), before(x + 1, y + 1));
            // The shadow map is a third of a row off.
            const bool dark = far > 0 && near < deep - 0.4 * row;
            if (!dark && far < deep + 0.4 * row) continue;
            in_shadow += dark ? 1 : 0;
            wrong += (bright(x, y) < 0.75 * lit) != dark ? 1 : 0;
        }
    }
    EXPECT_GT(in_shadow, 150);
    EXPECT_EQ(wrong, 0);
}

// A leg on the floor. Its shadow ends where the shadow map does, which fits what casts it: beyond
// that edge the floor is lit evenly. Down each column it only becomes brighter.
TEST(SoftLight, BesideTheShadowMapTheFloorIsLit)
{
    int crossed = 0, dips = 0;
    for (const double azimuth : {-0.9, 0.75}) {
        Scene scene;
        TriMesh leg = geometry::box({0.1, 0.7, 0.1}, {1, 1, 1});
        for (Vec3f& p : leg.positions) p.y() += 0.35f;
        geometry::compute_normals(leg, 0.5);
        scene.surfaces = {surface(std::move(leg))};
        scene.ground = 0;
        scene.stage = box_about_origin(0.7);
        Look look = soft_look(300);
        look.light_azimuth = azimuth * std::numbers::pi;
        look.light_elevation = 50 * std::numbers::pi / 180;
        look.light_size = 0.5 * std::numbers::pi / 180;
        look.occlusion = 0;
        const Camera camera{{0.9, 1.6, 2.2}, {0.15, 0, 0}, {0, 1, 0}, 2 * std::atan(0.25)};
        const Image image = render::draw(scene, camera, look);
        const auto bright = [&](int x, int y) { return int(pixel(image, x, y)[1]); };
        for (int x = 20; x < 280; ++x) {
            int darkest = 299;
            for (int y = 299; y >= 0; --y) {
                if (bright(x, y) < bright(x, darkest)) darkest = y;
            }
            if (bright(x, darkest) > 0.8 * bright(x, 299)) continue;
            ++crossed;
            int most = 0, dip = 0;
            for (int y = darkest; y < 300; ++y) {
                most = std::max(most, bright(x, y));
                dip = std::max(dip, most - bright(x, y));
            }
            dips += dip > 6 ? 1 : 0;
        }
    }
    EXPECT_GT(crossed, 100);
    EXPECT_EQ(dips, 0);
}

// A ball with a card's shadow on the floor, and another ball, or none, 100 m away.
TEST(SoftLight, TheShadowStaysAsFineAsItIsWhateverFliesFarAway)
{
    for (const bool soft : {false, true}) {
        const auto picture = [&](double away) {
            Scene scene;
            TriMesh card = geometry::grid(1, 1, 4, 4);
            for (Vec3f& p : card.positions) p.y() = 0.5f;
            TriMesh ball = geometry::icosphere(0.2, 2);
            for (Vec3f& p : ball.positions) p += Vec3f(0, 0.4f, 0) + Vec3f(float(away), 0, 0);
            scene.surfaces = {surface(std::move(card)), surface(std::move(ball))};
            scene.ground = 0;
            scene.stage = box_about_origin(1);
            Look look = soft_look(200);
            look.soft = soft;
            return render::draw(scene, {{0, 3, 4}, {0, 0, 0}, {0, 1, 0}, 0.6}, look);
        };
        const Image near = picture(60), far = picture(600);
        EXPECT_TRUE(near.rgba == far.rgba);
        EXPECT_GT(covered_pixels(near), 10'000);
    }
}

// What each look is for.
TEST(SoftLight, EachLookShowsWhatItPromises)
{
    Scene scene;
    scene.surfaces = {surface(geometry::icosphere(1, 4))};
    scene.surfaces[0].paint.by = render::Paint::By::constant;
    scene.surfaces[0].paint.colour = {0.05f, 0.2f, 0.6f};
    const Camera camera{{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.2)};
    const auto picture = [&](Style style) {
        Look look = soft_look(128);
        look.style = style;
        return render::draw(scene, camera, look);
    };
    const auto middle = [](const Image& image) { return pixel(image, 64, 64); };
    const auto studio = middle(picture(Style::studio));
    EXPECT_GT(studio[2], studio[1] + 30);  // the material's blue
    EXPECT_GT(studio[1], studio[0] + 30);
    const auto clay = middle(picture(Style::clay));
    EXPECT_GT(clay[0], clay[2]);  // one warm clay, whatever the material
    const Image diagram = picture(Style::diagram);
    EXPECT_LT(pixel(diagram, 64 - 32, 64)[2], 80);   // ink along the outline: radius 32.2 pixels
    EXPECT_GT(pixel(diagram, 64 - 29, 64)[2], 120);  // and no wider than 2 pixels
    EXPECT_NEAR(pixel(diagram, 60, 50)[2], pixel(diagram, 55, 55)[2], 2);  // flat
    // A matcap does not see the light: from anywhere it is the same.
    Look look = soft_look(128);
    look.style = Style::matcap;
    const Image one = render::draw(scene, camera, look);
    look.light_azimuth += 2;
    EXPECT_TRUE(one.rgba == render::draw(scene, camera, look).rgba);
}

// A long slab whose corners are far from the stage, which it passes: its top is nearer to a low
// light than all that the shadow map was made for. Nothing stands between.
TEST(SoftLight, ASlabThatReachesBeforeTheShadowMapIsLitAllOver)
{
    Scene scene;
    TriMesh slab = geometry::box({1, 0.2, 1}, {1, 1, 1});
    for (Vec3f& p : slab.positions) p.y() -= 0.1f;
    TriMesh thing = geometry::box({0.1, 0.02, 0.1}, {1, 1, 1});
    for (Vec3f& p : thing.positions) p.y() += 0.01f;
    scene.surfaces = {surface(std::move(slab)), surface(std::move(thing))};
    scene.stage.add(Vec3(-0.05, -0.2, -0.05));
    scene.stage.add(Vec3(0.05, 0.02, 0.05));
    scene.ground = -0.2;
    const Camera camera{{0, 2, 0.001}, {0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.25)};
    Look look = soft_look(200);
    look.light_elevation = 0.6;
    look.occlusion = 0;
    const Image image = render::draw(scene, camera, look);
    double low = 1, high = 0;
    for (double x = -0.45; x < 0.46; x += 0.05) {
        for (double z = -0.45; z < 0.46; z += 0.05) {
            if (std::hypot(x, z) < 0.15) continue;  // the thing and its shadow
            const double here = brightness_at(image, camera, x, z);
            low = std::min(low, here), high = std::max(high, here);
        }
    }
    EXPECT_GT(high, 0.1);
    EXPECT_GT(low, 0.95 * high);
}

}  // namespace
