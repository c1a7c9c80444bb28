#include "physics/layers/layer_contact_border.hpp"

#include "tests/physics/layers/layer_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using namespace layer_fixtures;

using std::numbers::pi;
const double exact_radius = std::sqrt(1 - h * h);  // 0.43589

double radius_error(double spacing)
{
    const std::list<Thing> things = two_balls(spacing);
    const std::vector<ContactBody> both = bodies(things);
    const LayerContactBorder border = find_border(both, find_contacts(both));
    EXPECT_EQ(border.patches.size(), 2u);
    double worst = 0;
    for (const ContactPatch& patch : border.patches) {
        EXPECT_TRUE(patch.whole);
        worst = std::max(worst, std::abs(std::sqrt(patch.area / pi) - exact_radius));
    }
    return worst;
}

}  // namespace

// The contact's disc is flat, so all that errs is its border's cubics: on a circle of order 6.
TEST(LayerContactBorder, TheRadiusOfTwoEqualBallsConvergesWithOrderSix)
{
    const double coarse = radius_error(0.16), fine = radius_error(0.04);
    EXPECT_LT(coarse, 1e-4);
    EXPECT_LT(fine, 1e-8);
    EXPECT_GT(std::log(coarse / fine) / std::log(4.0), 5.0);
    for (const double spacing : {0.1, 0.07, 0.05}) EXPECT_LT(radius_error(spacing), 1e-6);
}

TEST(LayerContactBorder, PointsLieOnTheSeparatingCircleAndTangentsAlongIt)
{
    const std::list<Thing> things = two_balls(0.1);
    const std::vector<ContactBody> both = bodies(things);
    const LayerContactBorder border = find_border(both, find_contacts(both));
    ASSERT_GT(border.pieces.size(), 20u);
    std::array<double, 2> length{};
    for (const BorderPiece& piece : border.pieces) {
        for (std::size_t end = 0; end < 2; ++end) {
            const Vec3 p = piece.point[end];
            EXPECT_NEAR(p.x(), 0, 1e-13);
            EXPECT_NEAR(p.norm(), exact_radius, 1e-13);
            EXPECT_NEAR(piece.tangent[end].dot(p), 0, 1e-12);
            const double way = p.cross(piece.tangent[end]).x();  // anticlockwise, too
            EXPECT_NEAR(piece.body == 0 ? way : -way, exact_radius, 1e-12);
        }
        length[piece.body] += (piece.point[1] - piece.point[0]).norm();
        // The contact to the left, seen from outside: anticlockwise about the outward x.
        const double turn = piece.point[0].cross(piece.point[1]).x();
        EXPECT_GT(piece.body == 0 ? turn : -turn, 0);
    }
    for (const ContactPatch& patch : border.patches) {
        EXPECT_GT(patch.length, length[patch.body]);
        EXPECT_NEAR(patch.length, 2 * pi * exact_radius, 1e-4);
    }
}

// A hard ball (k = 4) in a soft one (k = 1): f_1 = f_2 is a curved surface, 4 (1 - r_1) = 1 - r_2,
// whose area comes from its meridian by quadrature.
TEST(LayerContactBorder, ACurvedContactsAreaConvergesWithOrderTwo)
{
    const auto area_error = [](double spacing) {
        Contribution hard = unit;
        hard.stiffness = 2.5;
        std::list<Thing> things;
        Transform at = Transform::Identity();
        at.translate(Vec3(-0.8, 0, 0)).rotate(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()));
        things.emplace_back(layer_of({point({0, 0, 0})}, hard), spacing, LayerMatter{},
                            std::vector{at});
        at.setIdentity();
        at.translate(Vec3(0.8, 0, 0));
        things.emplace_back(layer_of({point({0, 0, 0})}, unit), spacing, LayerMatter{},
                            std::vector{at});
        const std::vector<ContactBody> both = bodies(things);
        // The surface 2.5 (1 - r_1) = 1 - r_2 by its distance from the axis.
        const auto x_at = [](double rho) {
            double low = -0.3, high = 0.3;
            for (int i = 0; i < 60; ++i) {
                const double x = 0.5 * (low + high);
                const double r1 = std::hypot(x + 0.8, rho), r2 = std::hypot(x - 0.8, rho);
                (2.5 * (1 - r1) > 1 - r2 ? low : high) = x;
            }
            return 0.5 * (low + high);
        };
        constexpr int rings = 2000;
        double exact = 0, rho = 0, x = x_at(0);
        for (int i = 1; i <= rings; ++i) {  // frusta
            const double next = 0.6 * i / rings, next_x = x_at(next);
            exact += pi * (rho + next) * std::hypot(next - rho, next_x - x);
            rho = next;
            x = next_x;
        }
        const LayerContactBorder border = find_border(both, find_contacts(both));
        return std::abs(border.patches.at(0).area / exact - 1);
    };
    const double coarse = area_error(0.12), fine = area_error(0.03);
    EXPECT_LT(fine, 1e-3);
    EXPECT_GT(std::log(coarse / fine) / std::log(4.0), 1.7);
}

TEST(LayerContactBorder, ARigidFloorIsLeftOnACircleToo)
{
    std::list<Thing> things;
    things.emplace_back(layer_of({point({0.1, 0, 0.2})}, unit), 0.05);
    Transform floor = Transform::Identity();
    floor.translate(Vec3(0, -1.9, 0));
    things.emplace_back(layer_of({{.kind = SkeletonKind::plane, .points = {}}}, unit), 0.1,
                        LayerMatter{.rigid = true}, std::vector{floor});
    const std::vector<ContactBody> both = bodies(things);
    const LayerContactBorder border = find_border(both, find_contacts(both));
    ASSERT_EQ(border.patches.size(), 1u);
    EXPECT_NEAR(std::sqrt(border.patches[0].area / pi), exact_radius, 1e-6);
}

TEST(LayerContactBorder, IsEmptyWithoutContactAndTheSameForAnyNumberOfThreads)
{
    EXPECT_TRUE(find_border({}, {}).patches.empty());
    std::vector<double> areas;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const std::list<Thing> things = two_balls(0.06);
        const std::vector<ContactBody> both = bodies(things);
        areas.push_back(find_border(both, find_contacts(both)).patches[0].area);
    }
    EXPECT_EQ(areas[0], areas[1]);
    EXPECT_EQ(areas[0], areas[2]);
}

}  // namespace physics
