// Soft shadow and shade of a box on the floor, against rays: 256 towards the disc of the light, 512
// to all sides. The bounds are at most half as much again as what is behind
// them.

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

constexpr int size = 160;
const Vec3 low{-0.3, 0, -0.25}, high{0.3, 0.5, 0.25};  // m, of the box

// Whether a ray from the floor meets the box.
bool is_blocked(const Vec3& from, const Vec3& along)
{
    double begin = 0, end = 1e9;
    for (int d = 0; d < 3; ++d) {
        double a = (low[d] - from[d]) / along[d], b = (high[d] - from[d]) / along[d];
        if (a > b) std::swap(a, b);
        begin = std::max(begin, a);
        end = std::min(end, b);
    }
    return begin < end;
}

// Directions of a disc or of a hemisphere: points of a spiral that has one area each.
std::vector<Vec3> spread_over_disc(int count, const Vec3& towards, double radius)
{
    const Vec3 u = towards.unitOrthogonal(), v = towards.cross(u);
    std::vector<Vec3> out;
    for (int i = 0; i < count; ++i) {
        const double r = radius * std::sqrt((i + 0.5) / count), turn = i * 2.399963229728653;
        out.push_back(Vec3(towards + r * std::cos(turn) * u + r * std::sin(turn) * v));
    }
    return out;
}

// By their cosine: above the points of the unit disc (Nusselt).
std::vector<Vec3> spread_over_hemisphere(int count)
{
    std::vector<Vec3> out = spread_over_disc(count, Vec3::UnitY(), 1);
    for (Vec3& d : out) {
        d.y() = 0;
        d.y() = std::sqrt(std::max(1e-6, 1 - d.squaredNorm()));
    }
    return out;
}

double share_free(const Vec3& from, const std::vector<Vec3>& directions)
{
    int free = 0;
    for (const Vec3& d : directions) free += is_blocked(from, d) ? 0 : 1;
    return double(free) / double(directions.size());
}

const Camera camera{{1.2, 2.2, 3.4}, {0, 0.1, 0}, {0, 1, 0}, 2 * std::atan(0.3)};

Look look_of_the_test()
{
    Look look = plain_look(size);
    look.style = render::Style::studio;
    look.soft = true;
    look.shadow = render::ShadowQuality::medium;
    look.floor = Vec3f::Constant(0.5f);
    look.light = Vec3f::Zero();
    look.sky = look.bounce = Vec3f::Zero();
    look.light_azimuth = -1.3;
    look.light_elevation = 0.8;
    look.light_size = 10 * std::numbers::pi / 180;
    return look;
}

Image picture(const Look& look)
{
    Scene scene;
    TriMesh box = geometry::box(high - low, {1, 1, 1});
    for (Vec3f& p : box.positions) p += (0.5 * (low + high)).cast<float>();
    scene.surfaces = {surface(std::move(box))};
    scene.ground = 0;
    scene.stage = box_about_origin(1);
    return render::draw(scene, camera, look);
}

// What a display is sent of a grey, in levels: the tone map takes the 4 % that surfaces mirror
// away.
double level_of(double light)
{
    const double off = light < 0.08 ? light - 6.25 * light * light : 0.04;
    return 255 * double(render::srgb_from_linear(float(light - off)));
}

struct Error {
    double mean = 0;   // levels of 255
    double most = 0;   // likewise, of all but a hundredth of the pixels
    double shade = 0;  // the mean of how much darker than free floor rays say it is
};

// Of the floor's pixels that lie within 0.9 m of the middle, where `light(place)` is the share of
// the light of a free floor that gets there.
template <class Light> Error error_of(const Image& image, double free, const Light& light)
{
    const geometry::Mat3 axes = render::camera_axes(camera);
    const double half = size / 2.0, tan_y = std::tan(camera.field_of_view / 2);
    Error error;
    std::vector<double> all;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const Vec3 ray = axes.transpose() * Vec3((x + 0.5 - half) / half * tan_y,
                                                     (half - y - 0.5) / half * tan_y, 1);
            if (ray.y() >= 0) continue;
            const Vec3 place = camera.eye - camera.eye.y() / ray.y() * ray;
            // A pixel's room off the box, whose own pixels are not the floor's.
            if (place.norm() > 0.9 || is_blocked(place, -ray)) continue;
            const Vec3 beside =
                place.cwiseMax(low - Vec3::Constant(0.03)).cwiseMin(high + Vec3::Constant(0.03));
            if ((place - beside).norm() < 1e-9) continue;
            const double level = level_of(free * light(place));
            all.push_back(std::abs(pixel(image, x, y)[1] - level));
            error.shade += level_of(free) - level;
        }
    }
    std::sort(all.begin(), all.end());
    for (const double e : all) error.mean += e / double(all.size());
    error.most = all[all.size() * 99 / 100];
    error.shade /= double(all.size());
    return error;
}

TEST(RayTracedLight, ThePenumbraOfABoxIsThatOfADiscOfLight)
{
    Look look = look_of_the_test();
    look.light = Vec3f::Constant(0.9f);
    look.occlusion = 0;
    const Vec3 sun = render::direction(look.light_azimuth, look.light_elevation);
    const auto rays = spread_over_disc(256, sun, std::tan(0.5 * look.light_size));
    const double free = 0.5 * 0.9 * sun.y();
    const Error error =
        error_of(picture(look), free, [&](const Vec3& p) { return share_free(p, rays); });
    EXPECT_GT(error.shade, 15);
    EXPECT_LT(error.mean, 0.8);  // 0.54
    EXPECT_LT(error.most, 12);   // 8.0
}

TEST(RayTracedLight, TheShadeByABoxIsWhatItHidesOfTheSky)
{
    Look look = look_of_the_test();
    look.sky = look.bounce = Vec3f::Constant(0.9f);
    const auto rays = spread_over_hemisphere(512);
    const Error error =
        error_of(picture(look), 0.5 * 0.9, [&](const Vec3& p) { return share_free(p, rays); });
    EXPECT_GT(error.shade, 10);
    EXPECT_LT(error.mean, 3);   // 2.5: of what the picture shows, as thick as it is taken to be
    EXPECT_LT(error.most, 20);  // 16
}

}  // namespace
