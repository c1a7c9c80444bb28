// Surfaces that rays find in each pixel, beside fine meshes of the same surfaces.

#include "geometry/fields/iso_extent.hpp"
#include "geometry/fields/polygonize.hpp"
#include "pictures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstdlib>

namespace {

using namespace tests;
using geometry::Vec3;
using geometry::Vec3f;
using render::Antialias;
using render::FieldSurface;
using render::Image;
using render::Look;
using render::Scene;

// Points 0.3 thick, blended: a layer, and what its field needs to live.
struct Blobs {
    explicit Blobs(const std::vector<Vec3>& centres)
    {
        geometry::ImplicitLayer layer;
        for (const Vec3& c : centres) {
            layer.skeletons.push_back({.kind = geometry::SkeletonKind::point, .points = {c}});
            layer.contributions.push_back({.thickness = 0.3, .stiffness = 4, .radius = 0.7});
            layer.frame.push_back(0);
        }
        const std::vector<geometry::Transform> frames{geometry::Transform::Identity()};
        field = geometry::make_field(layer, frames);
    }
    FieldSurface surface() const
    {
        FieldSurface out;
        out.field = geometry::iso_field(field);
        out.cells = geometry::iso_cells(out.field);
        out.extent = geometry::surface_box(out.field, out.cells);
        out.material.colour = {0.8f, 0.3f, 0.2f};
        return out;
    }
    render::Surface mesh(double cell) const
    {
        geometry::TriMesh mesh = geometry::polygonize(geometry::iso_field(field), cell);
        auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
        topology->materials.resize(1);
        topology->materials[0].colour = {0.8f, 0.3f, 0.2f};
        topology->material.assign(topology->triangles.size(), 0);
        mesh.topology = std::move(topology);
        return tests::surface(std::move(mesh));
    }

    geometry::Field field;
};

const Blobs two({{-0.2, 0.35, 0}, {0.25, 0.4, 0.1}});

render::Camera camera_above()
{
    return {{1, 2, 5}, {0, 0.3, 0}, {0, 1, 0}, 0.4};
}

// A floor, and a card that goes through the blobs.
Scene stage(float opacity)
{
    Scene scene;
    scene.ground = 0.0;
    scene.stage = box_about_origin(1);
    geometry::TriMesh card = geometry::grid(1.2, 1.2, 1, 1);
    for (Vec3f& p : card.positions) p = Vec3f(p.x(), 0.6f + p.z(), 0.12f);
    for (Vec3f& n : card.normals) n = Vec3f::UnitZ();
    scene.surfaces = {surface(std::move(card))};
    scene.surfaces[0].opacity = opacity;
    return scene;
}

Image with_field(const Look& look, float opacity = 1)
{
    Scene scene = stage(opacity);
    scene.fields.push_back(two.surface());
    return render::draw(scene, camera_above(), look);
}

Image with_mesh(const Look& look, float opacity = 1)
{
    static const render::Surface fine = two.mesh(0.01);
    Scene scene = stage(opacity);
    scene.surfaces.push_back(fine);
    return render::draw(scene, camera_above(), look);
}

// How many pixels differ by more than `levels` in some colour.
int differing(const Image& a, const Image& b, int levels)
{
    int count = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const auto p = pixel(a, x, y), q = pixel(b, x, y);
            int most = 0;
            for (std::size_t k = 0; k < 3; ++k) most = std::max(most, std::abs(p[k] - q[k]));
            count += most > levels;
        }
    }
    return count;
}

Look picture_look(Antialias antialias, bool soft)
{
    Look look = plain_look(120);
    look.antialias = antialias;
    look.shadow = render::ShadowQuality::medium;
    look.soft = soft;
    look.style = soft ? render::Style::studio : render::Style::plain;
    return look;
}

// The blobs cover some 3000 of 14400 pixels; their rim, and where they go through the card, is 200
// pixels long. The mesh lies inside by up to 0.01^2 / (8 * 0.3) m, a five-hundredth of a pixel.
TEST(TraceFields, LookAsTheirFineMeshesAtAllQualities)
{
    for (const Antialias antialias :
         {Antialias::none, Antialias::fxaa, Antialias::samples4, Antialias::samples16}) {
        for (const float opacity : {1.0f, 0.5f}) {
            const Look look = picture_look(antialias, antialias == Antialias::samples4);
            const Image rays = with_field(look, opacity), mesh = with_mesh(look, opacity);
            EXPECT_LE(differing(rays, mesh, 6), 8) << int(antialias) << ", opacity " << opacity;
            EXPECT_LE(differing(rays, mesh, 40), 1) << int(antialias) << ", opacity " << opacity;
        }
    }
}

TEST(TraceFields, GiveTheSameBytesForAnyNumberOfThreads)
{
    const Look look = picture_look(Antialias::samples4, true);
    std::vector<std::uint8_t> one;
    {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
        one = with_field(look).rgba;
    }
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
    EXPECT_EQ(with_field(look).rgba, one);
}

// Two bodies that share a plane, seen from above along it, and a light behind: where they end there
// is no pixel of anything else between them.
TEST(TraceFields, LeaveNoPixelFreeBetweenTwoThatTouch)
{
    const Blobs left({{-0.2, 0, 0}}), right({{0.2, 0, 0}});
    Scene scene;
    for (const Blobs* blobs : {&left, &right}) {
        FieldSurface s = blobs->surface();
        const geometry::Field &own = blobs->field,
                              &other = blobs == &left ? right.field : left.field;
        // As contact deforms it: f + c - g where the other one holds.
        s.field.steepness = nullptr;
        s.field.ask = [&own, &other](const geometry::FieldBlock& block,
                                     geometry::BlockValues& values) {
            for (std::size_t i = 0; i < block.count; ++i) {
                const auto f = geometry::value_at(own, block.point(i));
                const auto g = geometry::value_at(other, block.point(i));
                const bool held = g.f > 1;
                values.f[i] = f.f - (held ? g.f : 1);
                const Vec3 gradient = held ? Vec3(f.gradient - g.gradient) : f.gradient;
                values.gx[i] = gradient.x();
                values.gy[i] = gradient.y();
                values.gz[i] = gradient.z();
            }
        };
        s.cells = geometry::iso_cells(s.field);
        scene.fields.push_back(std::move(s));
    }
    Look look = plain_look(200);
    const render::Camera above{{0, 4, 0.01}, {0, 0, 0}, {0, 0, -1}, 0.3};
    const Image image = render::draw(scene, above, look);
    // 2 tan(0.15) 4 m in 200 pixels: 6.05 mm each. The circle where they meet has radius
    // sqrt(0.3^2 - 0.2^2) = 0.224 m, seen edge-on, as 37 pixels up and down from the middle.
    for (int y = 100 - 35; y < 100 + 35; ++y) {
        for (int x = 96; x < 104; ++x) EXPECT_TRUE(covered(image, x, y)) << x << ", " << y;
    }
}

TEST(TraceFields, SayWhichAttributeTheyHave)
{
    Scene scene;
    scene.fields.push_back(two.surface());
    scene.fields[0].paint.by = render::Paint::By::attribute;
    scene.fields[0].paint.attribute = "speed";
    scene.fields[0].attribute = "compression";
    try {
        render::draw(scene, camera_above(), plain_look());
        FAIL() << "drawn by an attribute that it does not have";
    } catch (const std::invalid_argument& wrong) {
        EXPECT_NE(std::string(wrong.what()).find("they have compression"), std::string::npos);
    }
}

}  // namespace
