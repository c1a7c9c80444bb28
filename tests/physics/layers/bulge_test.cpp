#include "physics/layers/bulge.hpp"

#include "geometry/base/random.hpp"
#include "geometry/fields/polygonize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "layer_fixtures.hpp"
#include "physics/layers/deformed_layer.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace physics {

using namespace layer_fixtures;

namespace {

// The left one of two balls, at this far from the right one's surface, off the contact.
Vec3 beside_right(double t)
{
    return Vec3(h, 0, 0) + (1 + t) * Vec3(-0.6, 0.8, 0);
}

Thing floor_thing(double surface)
{
    Transform at = Transform::Identity();
    at.translate(Vec3(0, surface - 1, 0));
    return {layer_of({{.kind = SkeletonKind::plane, .points = {}}}, unit), 0.1,
            LayerMatter{.rigid = true}, std::vector{at}};
}

// Outward normal of the deformed surface on the ray from `o` along `d`, between 0 and `far`.
Vec3 normal_on(const DeformedLayer& layer, const Vec3& o, const Vec3& d, double far)
{
    double inside = 0, outside = far;
    while (outside - inside > 1e-13) {
        const double t = 0.5 * (inside + outside);
        (value_at(layer, o + t * d).f > 1 ? inside : outside) = t;
    }
    return -value_at(layer, o + inside * d).gradient.normalized();
}

}  // namespace

// The values follow from the two cubics: 0 and slope k at 0, a and slope 0 at x1, 0 and slope 0 at
// w; x1 is 3 a / k for a low bulge and w / 2 for a high one.
TEST(Bulge, RisesWithSlopeKToItsHeightAndFallsToNothingAtItsWidth)
{
    for (const double a : {0.001, 0.05, 0.4}) {
        const BulgeShape shape{a, 0.2, 10, false};
        const double x1 = std::min(0.1, 3 * a / 10);
        EXPECT_NEAR(bulge_at(shape, 1e-9).first, 1e-8, 1e-13);
        EXPECT_NEAR(bulge_at(shape, x1).first, a, 1e-14);
        EXPECT_NEAR(bulge_at(shape, x1).second, 0, 1e-12);
        EXPECT_NEAR(bulge_at(shape, 0.5 * (x1 + 0.2)).first, 0.5 * a, 1e-14);
        EXPECT_EQ(bulge_at(shape, 0.2).first, 0);
        EXPECT_NEAR(bulge_at(shape, 0.2 * (1 - 1e-9)).second, 0, 1e-6);
        double last = 0;
        for (int i = 1; i < 1000; ++i) {
            const double t = 0.2 * i / 1000;
            const auto [A, slope] = bulge_at(shape, t);
            const double step = 1e-7;
            EXPECT_NEAR(slope,
                        (bulge_at(shape, t + step).first - bulge_at(shape, t - step).first) /
                            (2 * step),
                        1e-5 * (1 + std::abs(slope)) + 100 * (std::abs(t - x1) < step ? 1 : 0));
            if (t <= x1 || t - 0.2 / 1000 > x1) {
                EXPECT_EQ(A >= last, t <= x1) << t;
            }
            last = A;
        }
    }
}

TEST(Bulge, RisesUprightAgainstARigidBody)
{
    const BulgeShape shape{0.05, 0.2, 10, true};
    EXPECT_NEAR(bulge_at(shape, 1e-12).first, 0.05 * std::sqrt(2 * 1e-12 / 0.015), 1e-9);
    EXPECT_NEAR(bulge_at(shape, 0.015).first, 0.05, 1e-15);
    EXPECT_NEAR(bulge_at(shape, 0.0075).first, 0.05 * std::sqrt(0.75), 1e-15);
    EXPECT_EQ(bulge_at(shape, 0.2).first, 0);
}

// In metres, however low the bulge is and even where the other's field has ended (1 m from its
// surface): 98 % of the way there 3 (1 - v)^2 is left of it, about.
TEST(Bulge, ReachesAsFarAsItsWidthSays)
{
    for (const double width : {0.1, 0.2, 0.7, 1.3}) {
        for (const double height : {0.01, 0.1, 0.5}) {
            std::list<Thing> things = two_balls(0.05);
            for (Thing& thing : things) {
                thing.matter.bulge_width = width;
                thing.matter.bulge_height = height;
            }
            const std::vector<ContactBody> both = bodies(things);
            const DeformedLayer layer = deformed(both, 0, find_contacts(both));
            const auto bulge = [&](double t) {
                const Vec3 p = beside_right(t);
                Meeting meeting;
                Box box;
                box.add(p);
                gather(both, 0, geometry::no_skeleton, box, meeting, width);
                const geometry::FieldValue other = geometry::value_at(*both[1].field, p);
                return bulge_at(meeting, meeting.others[0], layer.bulges, p, other.f,
                                other.gradient)
                    .A;
            };
            const double a = layer.bulges.height[1];
            EXPECT_GT(bulge(0.98 * width), 5e-4 * a) << width << " " << height;
            EXPECT_EQ(bulge(1.001 * width), 0) << width << " " << height;
        }
    }
}

// One-sided normals of a ball on a floor, just inside and just outside the rim of the contact.
TEST(Bulge, ASoftBallLeavesARigidFloorWithoutACrease)
{
    std::list<Thing> things;
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), 0.04);
    things.push_back(floor_thing(-h));
    const std::vector<ContactBody> both = bodies(things);
    const DeformedLayer layer = deformed(both, 0, find_contacts(both));
    const double rim = std::sqrt(1 - h * h);
    for (const double step : {1e-3, 1e-4, 1e-5}) {
        const Vec3 normal = normal_on(layer, {rim + step, 0.3, 0}, -Vec3::UnitY(), 1.5);
        EXPECT_LT(std::acos(std::min(1.0, -normal.y())), 0.01 + 10 * step);
    }
    DeformedLayer bare = layer;
    bare.bulges = {};
    const Vec3 normal = normal_on(bare, {rim + 1e-4, 0.3, 0}, -Vec3::UnitY(), 1.5);
    EXPECT_GT(std::acos(-normal.y()), 0.4);
}

// Two balls of one body that do not blend, as the two bodies of two_balls(): the surface is C1 at
// the rim of their contact, x = 0, and outside it is where the two bodies' surfaces are.
TEST(Bulge, PartsOfOneBodyBulgeAsTwoBodiesDo)
{
    ImplicitLayer layer = layer_of({point({-h, 0, 0}), point({h, 0, 0})}, unit);
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    LayerMatter matter{.bulge_width = 0.3, .bulge_height = 0.5, .self_contact = true};
    std::list<Thing> one, two;
    one.emplace_back(layer, 0.05, matter);
    const std::vector<ContactBody> body = bodies(one);
    const DeformedLayer whole = deformed(body, 0, find_contacts(body));
    ASSERT_GT(whole.bulges.highest(), 0);
    for (const double x : {-h, h})
        two.emplace_back(layer_of({point({x, 0, 0})}, unit), 0.05, matter);
    const std::vector<ContactBody> both = bodies(two);
    const DeformedLayer left = deformed(both, 0, find_contacts(both));
    EXPECT_NEAR(whole.bulges.highest(), left.bulges.highest(), 1e-9);
    const geometry::Random random(5);
    for (std::uint64_t i = 0; i < 500; ++i) {
        const Vec3 p(-0.4 * random.unit(3 * i), 0.3 + 0.5 * random.unit(3 * i + 1),
                     0.3 * random.unit(3 * i + 2));
        if (geometry::value_at(*both[1].field, p).f >= 1) continue;
        EXPECT_NEAR(value_at(whole, p).f, value_at(left, p).f, 1e-8);
    }
    const double rim = std::sqrt(1 - h * h);
    const Vec3 normal = normal_on(whole, {-1e-5, rim - 0.2, 0}, Vec3::UnitY(), 0.5);
    EXPECT_GT(normal.x(), 0.98);  // it leaves along the common surface; 0.9 without a bulge
}

TEST(Bulge, BulgesOfTwoLayersDoNotMeet)
{
    for (const double width : {0.1, 0.3, 2.0}) {
        for (const double height : {0.1, 0.5, 10.0}) {
            std::list<Thing> things = two_balls(0.06);
            for (Thing& thing : things) {
                thing.matter.bulge_width = width;
                thing.matter.bulge_height = height;
            }
            const std::vector<ContactBody> both = bodies(things);
            const Contacts found = find_contacts(both);
            const DeformedLayer a = deformed(both, 0, found), b = deformed(both, 1, found);
            const geometry::Random random(2);
            for (std::uint64_t i = 0; i < 700; ++i) {
                const Vec3 p(0.4 * random.unit(3 * i) - 0.2, 1.4 * random.unit(3 * i + 1) - 0.7,
                             1.4 * random.unit(3 * i + 2) - 0.7);
                EXPECT_FALSE(value_at(a, p).f > 1 + 1e-12 && value_at(b, p).f > 1 + 1e-12)
                    << width << " " << height << " " << p.transpose();
            }
        }
    }
}

// Skeletons of unlike profiles, blended, and a second body: the gradient that meshing goes by.
TEST(Bulge, ItsGradientIsItsDerivativeWhereUnlikeSkeletonsBlend)
{
    std::list<Thing> things;
    LayerMatter matter{.bulge_width = 0.8, .bulge_height = 0.5};
    things.emplace_back(layer_of({point({-h, 0, 0})}, unit), 0.06, matter);
    ImplicitLayer mixed = layer_of({point({h, 0, 0}), point({h + 0.2, 0.7, 0})}, unit);
    mixed.contributions[1] = {.thickness = 0.6, .stiffness = 2, .radius = 1.6};
    things.emplace_back(mixed, 0.06, matter);
    things.push_back(floor_thing(-0.9));
    const std::vector<ContactBody> all = bodies(things);
    const DeformedLayer layer = deformed(all, 0, find_contacts(all));
    const geometry::Random random(1);
    int checked = 0;
    for (std::uint64_t i = 0; i < 300; ++i) {
        const Vec3 p(-1.8 + 2 * random.unit(3 * i), 2 * random.unit(3 * i + 1) - 1,
                     2 * random.unit(3 * i + 2) - 1);
        const double step = 1e-6;
        Vec3 central, one_sided;
        const auto at = value_at(layer, p);
        for (int axis = 0; axis < 3; ++axis) {
            const double a = value_at(layer, p - step * Vec3::Unit(axis)).f;
            const double b = value_at(layer, p + step * Vec3::Unit(axis)).f;
            central[axis] = (b - a) / (2 * step);
            one_sided[axis] = (b - at.f) / step;
        }
        if ((central - one_sided).norm() > 1e-3) continue;
        ++checked;
        EXPECT_LT((central - at.gradient).norm(), 1e-3) << p.transpose();
    }
    EXPECT_GT(checked, 230);
}

}  // namespace physics
