// What rays of samples and the closed forms of cores give a rigid body, against its surface's mesh.

#include "geometry/fields/polygonize.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mass_properties.hpp"
#include "geometry/mesh/primitive.hpp"
#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics::skeleton_mass_test {

using namespace layered_fixtures;

TEST(SkeletonMass, IsThatOfTheMeshOfTheSurface)
{
    const auto solid = [](SkeletonKind kind, const Vec3& half) {
        Skeleton s{.kind = kind, .points = {}, .half_size = half};
        s.place.translate(Vec3(0.2, 0.1, -0.3))
            .rotate(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
        return s;
    };
    const auto stretched = [](Skeleton s) {
        const Mat3 axes = Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()).matrix();
        s.stretch = axes * Vec3(1, 2, 1.5).asDiagonal() * axes.transpose();
        return s;
    };
    Skeleton sheet = solid(SkeletonKind::sheet, {1, 1, 1});
    sheet.mesh = std::make_shared<const geometry::SkeletonMesh>(geometry::grid(0.8, 0.5, 3, 3));
    const std::vector<Skeleton> each{
        solid(SkeletonKind::torus, {0.6, 0.15, 1}),
        solid(SkeletonKind::torus, {0.5, 0, 1}),
        solid(SkeletonKind::cylinder, {0.3, 0.4, 1}),
        solid(SkeletonKind::cone, {0.4, 0.4, 0.2}),
        solid(SkeletonKind::cone, {0.4, 0.4, 0}),
        {.kind = SkeletonKind::curve,
         .points = {{-0.5, 0, 0}, {-0.2, 0.3, 0}, {0.2, 0.1, 0.2}, {0.5, 0.2, 0.1}}},
        sheet,
        stretched({.kind = SkeletonKind::point, .points = {{0.1, 0, 0}}}),
        stretched({.kind = SkeletonKind::segment, .points = {{-0.2, 0, 0}, {0.3, 0.1, 0}}}),
        stretched(
            {.kind = SkeletonKind::triangle, .points = {{-0.2, 0, 0}, {0.3, 0.1, 0}, {0, 0, 0.4}}}),
        stretched({.kind = SkeletonKind::curve,
                   .points = {{-0.5, 0, 0}, {-0.2, 0.3, 0}, {0.2, 0.1, 0.2}}}),
        // A curve through narrowed positions would be 5 % shorter than the narrowed one.
        {.kind = SkeletonKind::curve,
         .points = {{0, 0, 0}, {0.3, 1.2, 0}, {3, 1.2, 0}, {3.3, 0, 0}},
         .stretch = Vec3(5, 1, 1).asDiagonal()}};
    for (std::size_t i = 0; i < each.size(); ++i) {
        const ImplicitLayer layer = soft_layer({each[i]});
        const LayeredBody body = make_layered_body(layer, BaseKind::rigid, 1, 0.04);
        const Transform here = Transform::Identity();
        const geometry::MassProperties mesh = geometry::mass_properties(geometry::polygonize(
            geometry::iso_field(geometry::make_field(layer, {&here, 1})), 0.015));
        // Meshes are inscribed, samples a little less so: some (h / r)^2.
        EXPECT_NEAR(body.base.mass[0], mesh.mass, 0.02 * mesh.mass) << "skeleton " << i;
        EXPECT_LT((body.base.frames[0].translation() - mesh.centre).norm(), 3e-3)
            << "skeleton " << i;
        EXPECT_LT((body.base.inertia[0] - mesh.inertia).norm(), 0.03 * mesh.inertia.norm())
            << "skeleton " << i;
    }
}

// Whether one frame carries both or two.
TEST(SkeletonMass, CountsWhatSkeletonsHaveInCommonOnce)
{
    const auto solid = [](SkeletonKind kind, double x, const Vec3& half) {
        Skeleton s{.kind = kind, .points = {}, .half_size = half};
        s.place.translate(Vec3(x, 0, 0)).rotate(Eigen::AngleAxisd(0.3, Vec3::UnitX()));
        return s;
    };
    const Skeleton box = solid(SkeletonKind::box, 0, {0.3, 0.2, 0.2});
    Skeleton mesh = solid(SkeletonKind::mesh, -0.25, {1, 1, 1});
    mesh.mesh = std::make_shared<const geometry::SkeletonMesh>(geometry::icosphere(0.17, 3));
    const Vec3 small(0.15, 0.1, 0.12);
    for (const Skeleton& other :
         {solid(SkeletonKind::box, 0.25, small), solid(SkeletonKind::cylinder, 0.25, small), mesh,
          solid(SkeletonKind::ellipsoid, 0.05, small), point({0.1, 0, 0})}) {
        ImplicitLayer layer = soft_layer({box, other}, true);
        for (auto& c : layer.contributions)
            c = {.thickness = 0.02, .stiffness = 30, .radius = 0.06};
        const std::vector<Transform> here(2, Transform::Identity());
        const geometry::MassProperties whole = geometry::mass_properties(
            geometry::polygonize(geometry::iso_field(geometry::make_field(layer, here)), 0.015));
        const LayeredBody still = make_layered_body(layer, BaseKind::still, 1, 0.02);
        EXPECT_NEAR(still.volume[0] + still.volume[1], whole.mass, 0.01 * whole.mass);
        layer.frame = {0, 0};
        const Base one = make_layered_body(layer, BaseKind::rigid, 1, 0.02).base;
        EXPECT_NEAR(one.mass[0], whole.mass, 0.01 * whole.mass);
        EXPECT_LT((one.frames[0].translation() - whole.centre).norm(), 3e-3);
        EXPECT_LT((one.inertia[0] - whole.inertia).norm(), 0.02 * whole.inertia.norm());
    }
}

}  // namespace physics::skeleton_mass_test
