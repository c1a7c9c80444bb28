// Lines thinner than a pixel, and how far the edges of a picture are from those of one that has
// many samples.

#include "pictures.hpp"
#include "render/mesh_surface.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace {

using namespace tests;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;
using render::Antialias;
using render::Camera;
using render::Image;
using render::Look;
using render::Scene;

constexpr double pixel_size = 4.0 / 128;  // m, of a picture of 128 pixels that is 4 m wide

Camera camera_before()
{
    return {{0, 0, 10}, {0, 0, 0}, {0, 1, 0}, 2 * std::atan(0.2)};
}

// A black strip across the middle, `width` pixels wide, turned by `angle` from upright.
TriMesh strip(double width, double angle, double length = 5)
{
    TriMesh mesh = geometry::grid(1, 1, 1, 1);
    const double c = std::cos(angle), s = std::sin(angle);
    for (Vec3f& p : mesh.positions) {
        const double x = p.x() * width * pixel_size, y = -length * p.z();
        p = Vec3f(float(c * x + s * y), float(c * y - s * x), 0);
    }
    for (Vec3f& n : mesh.normals) n = Vec3f::UnitZ();
    return mesh;
}

Image drawn(const std::vector<TriMesh>& meshes, Antialias antialias, int size = 128)
{
    Scene scene;
    for (const TriMesh& mesh : meshes) {
        scene.surfaces.push_back(surface(mesh));
        scene.surfaces.back().paint = {render::Paint::By::constant, {0, 0, 0}, {}, {}};
        scene.surfaces.back().receives = false;
    }
    scene.stage = box_about_origin(2);
    Look look = plain_look(size);
    look.style = render::Style::studio;
    look.backdrop_top = look.backdrop_horizon = {0.5f, 0.5f, 0.5f};
    look.antialias = antialias;
    return render::draw(scene, camera_before(), look);
}

// Rows of the picture, or columns of one that is more level than upright, that show nothing of the
// strip.
int gaps(double angle, Antialias antialias)
{
    const Image image = drawn({strip(0.4, angle)}, antialias);
    const bool level = std::abs(std::tan(angle)) > 1;
    const int white = pixel(image, level ? 64 : 2, level ? 2 : 64)[1];
    int count = 0;
    for (int along = 16; along < 112; ++along) {
        int darkest = 255;
        for (int across = 0; across < 128; ++across) {
            const auto p = level ? pixel(image, along, across) : pixel(image, across, along);
            darkest = std::min(darkest, p[1]);
        }
        count += darkest > white - 12 ? 1 : 0;  // a 20th of the ink that a whole pixel has
    }
    return count;
}

// The hangers of a bridge, at 13 slants: 96 rows or columns each. The samples of a pixel lie in
// different quarters both across and up, so that a strip of 0.4 pixels meets one at least.
TEST(ThinLines, HangersOfTwoFifthsOfAPixelAreUnbroken)
{
    int gaps_of_one_sample = 0;
    for (int step = 0; step <= 12; ++step) {
        const double angle = step * std::numbers::pi / 24 + 0.02;
        EXPECT_EQ(gaps(angle, Antialias::samples4), 0) << angle;
        EXPECT_EQ(gaps(angle, Antialias::samples16), 0) << angle;
        gaps_of_one_sample += gaps(angle, Antialias::none);
    }
    EXPECT_GT(gaps_of_one_sample, 300) << "the test sees gaps";
}

// Light of 64 samples a pixel, as a share of white: of a picture eight times as wide and high.
std::vector<double> reference(const std::vector<TriMesh>& meshes)
{
    const Image fine = drawn(meshes, Antialias::none, 8 * 128);
    std::vector<double> light(128 * 128, 0.0);
    for (int y = 0; y < fine.height; ++y) {
        for (int x = 0; x < fine.width; ++x) {
            const float level = float(pixel(fine, x, y)[1]) / 255;
            light[std::size_t(128 * (y / 8) + x / 8)] +=
                double(render::linear_from_srgb(level)) / 64;
        }
    }
    return light;
}

// The mean square of the difference, in light.
double aliasing(const Image& image, const std::vector<double>& right)
{
    double sum = 0;
    for (std::size_t i = 0; i < right.size(); ++i) {
        const double light = double(render::linear_from_srgb(float(image.rgba[4 * i + 1]) / 255));
        sum += (light - right[i]) * (light - right[i]);
    }
    return sum / double(right.size());
}

// A fan of strips of 0.4 to 6 pixels. The errors of n samples that lie independently have 1 / n of
// the energy of one's; those of a lattice along an edge have less.
TEST(ThinLines, StandardHasAFractionOfTheAliasingOfDraft)
{
    std::vector<TriMesh> fan;
    for (int i = 0; i < 12; ++i) {
        fan.push_back(strip(0.4 + 0.5 * i, (i + 0.3) * std::numbers::pi / 12, 3));
    }
    const std::vector<double> right = reference(fan);
    const double draft = aliasing(drawn(fan, Antialias::none), right);
    const double preview = aliasing(drawn(fan, Antialias::fxaa), right);
    const double standard = aliasing(drawn(fan, Antialias::samples4), right);
    const double final = aliasing(drawn(fan, Antialias::samples16), right);
    EXPECT_LT(preview, draft);
    EXPECT_LT(standard, 0.2 * draft);  // 0.13 of it
    EXPECT_LT(final, 0.3 * standard);  // 0.20 of it
}

// Red edges of a grey box, seen from the upper right corner: the three that meet at the opposite
// corner are hidden, and the other nine show. A parallel view is from 1000 times as far away.
TEST(ThinLines, HiddenEdgesStayHiddenInAParallelViewToo)
{
    const TriMesh box = geometry::box({1, 1, 1}, {1, 1, 1});
    Scene scene;
    scene.surfaces.push_back(surface(box));
    scene.lines.push_back(render::edge_lines(box));
    scene.lines.back().colour = {1, 0, 0};
    scene.stage = box_about_origin(0.5);
    const Camera near{{4, 3, 5}, {0, 0, 0}, {0, 1, 0}, 0.4};
    for (const Camera& camera : {near, render::parallel_from(near)}) {
        const Look look = plain_look(256);
        const Image image = render::draw(scene, camera, look);
        int seen = 0, hidden = 0;
        const std::vector<Vec3f>& ends = scene.lines[0].ends;
        for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
            const Vec3 middle = 0.5 * (ends[i] + ends[i + 1]).cast<double>();
            if ((middle.array().abs() > 0.4).count() < 2) continue;  // a diagonal of a side
            const Vec3 at = 256 * *render::place_in_picture(camera, middle, 1);
            const int x = int(at.x()), y = int(at.y());
            int red = 0;
            for (int k = 0; k < 25; ++k) {
                const auto p = pixel(image, x - 2 + k % 5, y - 2 + k / 5);
                red += p[0] > 2 * p[1] + 40 ? 1 : 0;
            }
            const bool shows = middle.maxCoeff() > 0.4;
            (shows ? seen : hidden) += 1;
            EXPECT_EQ(red > 0, shows) << middle.transpose() << " from " << camera.eye.norm();
        }
        EXPECT_EQ(seen, 9);
        EXPECT_EQ(hidden, 3);
    }
}

}  // namespace
