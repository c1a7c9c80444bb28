#include "geometry/mesh/mesh.hpp"
#include "physics/layers/layer_contact.hpp"

#include "geometry/base/random.hpp"
#include "geometry/fields/polygonize.hpp"
#include "physics/layers/deformed_layer.hpp"
#include "physics/layers/layer_stops.hpp"
#include "tests/physics/layers/layer_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

namespace physics {
namespace {

using namespace layer_fixtures;

using geometry::Mat3;
using std::numbers::pi;

double force_error(double spacing)
{
    const std::list<Thing> things = two_balls(spacing);
    const Contacts found = find_contacts(bodies(things));
    // F = 2 pi k (r0 a^2 / 2 - (r0^3 - h^3) / 3), a^2 = r0^2 - h^2: the stress k (r0 - r) over the
    // disc of radius a, rho d rho = r dr.
    const double a_sq = 1 - h * h;
    const double exact = 2 * pi * (a_sq / 2 - (1 - h * h * h) / 3);
    EXPECT_NEAR(exact, 0.0293215, 5e-8);
    return std::abs(-found.wrenches[0][0].force.x() - exact);
}

// Two balls as they are, and both stretched alike: all that is found is stretched with them.
void expect_stretched_alike(const Contribution& contribution)
{
    const Mat3 axes = Eigen::AngleAxisd(0.3, Vec3(1, 2, -1).normalized()).matrix();
    const Mat3 stretch = axes * Vec3(3, 1, 1.5).asDiagonal() * axes.transpose();
    const double volume = 4.5;
    LayerMatter matter{.stiffness = 1, .friction = 0, .bulge_width = 0.3, .bulge_height = 0.5};
    const auto contacts_of = [&](const Mat3& a, double spacing) {
        std::list<Thing> things;
        for (const double side : {-1.0, 1.0}) {
            Skeleton ball = point({0, 0, 0});
            ball.stretch = a;
            Transform at = Transform::Identity();
            at.translate(a * Vec3(side * h, 0.02, 0.03));
            things.emplace_back(layer_of({ball}, contribution), spacing, matter, std::vector{at});
        }
        return find_contacts(bodies(things));
    };
    const Contacts plain = contacts_of(Mat3::Identity(), 0.1);
    const Contacts wide = contacts_of(stretch, 0.1 * std::sqrt(volume));
    ASSERT_GT(plain.contacts.size(), 50u);
    ASSERT_EQ(wide.contacts.size(), plain.contacts.size());
    double area = 0, expected = 0;
    for (std::size_t i = 0; i < plain.contacts.size(); ++i) {
        const LayerContact &a = plain.contacts[i], &b = wide.contacts[i];
        EXPECT_EQ(a.sample, b.sample);
        EXPECT_LT((stretch * a.position - b.position).norm(), 1e-9);
        EXPECT_NEAR(a.compression, b.compression, 1e-9);
        const Vec3 normal = stretch.inverse() * a.normal;  // of a plane that is stretched
        EXPECT_LT((normal.normalized() - b.normal).norm(), 1e-9);
        // An area grows by det A |A^-1 n|; what a sample at the rim has of it is shared otherwise.
        area += b.area;
        expected += volume * normal.norm() * a.area;
    }
    EXPECT_NEAR(area, expected, 2e-3 * expected);
    ASSERT_GT(plain.drawn.size(), 50u);
    ASSERT_EQ(wide.drawn.size(), plain.drawn.size());
    for (std::size_t i = 0; i < plain.drawn.size(); ++i) {
        EXPECT_LT((stretch * plain.drawn[i].position - wide.drawn[i].position).norm(), 1e-6);
    }
}

}  // namespace

TEST(LayerContact, StretchedLayersMeetWhereNarrowedOnesDo)
{
    expect_stretched_alike(unit);
    // Bulges that reach beyond the influence.
    expect_stretched_alike({.thickness = 1, .stiffness = 1, .radius = 1.15, .stiffening = 0});
}

// What samples at the rim stand for is cut there, and the samples' weights integrate smooth
// functions with order 3 to 4, so that the error falls evenly: by 10 or more at each halving, a
// little under that where the rim's ghosts, known to first order, begin to show (order 3).

TEST(LayerContact, TwoEqualBallsPressWithTheForceOfTheIntegral)
{
    double last = force_error(0.16);
    EXPECT_LT(last, 5e-4);
    for (const double spacing : {0.08, 0.04, 0.02}) {
        const double now = force_error(spacing);
        EXPECT_GT(std::log2(last / now), 2.8) << spacing;  // order of convergence
        last = now;
        if (spacing == 0.04) {
            EXPECT_LT(now, 1e-6);
        }
    }
    EXPECT_LT(last, 1e-7);
}

// To first order in the gap, wherever the ellipsoid is.
TEST(LayerContact, AStretchedRigidLayerStopsAtItsSurface)
{
    Skeleton oval = point({0, 0, 0});
    oval.stretch = Vec3(1, 3, 1.5).asDiagonal();
    const geometry::Field field =
        geometry::make_field(layer_of({oval}, unit), std::vector{Transform::Identity()});
    const geometry::Random random(3);
    for (std::uint64_t i = 0; i < 50; ++i) {
        const Vec3 out = Vec3(random.unit(3 * i) - 0.5, random.unit(3 * i + 1) - 0.5,
                              random.unit(3 * i + 2) - 0.5)
                             .normalized();
        const Vec3 on = oval.stretch * out;
        const Vec3 normal = (oval.stretch.inverse() * out).normalized();
        const LayerStop stop = stop_at_rigid(field, {0, {0}}, on + 1e-4 * normal);
        EXPECT_NEAR(stop.gap, 1e-4, 1e-7);
        EXPECT_NEAR(stop.normal.dot(normal), 1, 1e-6);
        EXPECT_NEAR(stop.normal.norm(), 1, 1e-12);
    }
}

// The same stress on a rigid plane, whose own field is another.
TEST(LayerContact, ABallPressesOnAPlaneWithTheSameForce)
{
    LayerMatter rigid;
    rigid.rigid = true;
    Skeleton plane{.kind = SkeletonKind::plane, .points = {}};
    plane.place.translate(Vec3(0, -1, 0));
    Transform at = Transform::Identity();
    at.translate(Vec3(0, h, 0)).rotate(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()));
    const double a_sq = 1 - h * h, exact = 2 * pi * (a_sq / 2 - (1 - h * h * h) / 3);
    const std::vector<std::pair<double, double>> bounds{{0.16, 5e-4}, {0.08, 2e-5}, {0.04, 1e-6}};
    for (const auto& [spacing, bound] : bounds) {
        std::list<Thing> things;
        things.emplace_back(layer_of({point({0, 0, 0})}, unit), spacing,
                            LayerMatter{.stiffness = 1, .friction = 0}, std::vector{at});
        things.emplace_back(layer_of({plane}, unit), 1.0, rigid);
        const Contacts found = find_contacts(bodies(things));
        EXPECT_NEAR(found.wrenches[0][0].force.y(), exact, bound) << spacing;
        double area = 0;
        for (const LayerContact& contact : found.contacts) area += contact.area;
        // Cut by chords: order 2.
        EXPECT_NEAR(area / (pi * a_sq), 1, 3 * spacing * spacing) << spacing;
    }
}

// Two balls that slip past each other and part: lambda (V_j - V_i) on each bit of the disc, lambda
// the mean of both.
TEST(LayerContact, FrictionAndDampingAreViscosityTimesAreaTimesSlip)
{
    constexpr double spacing = 0.04;
    std::list<Thing> things = two_balls(spacing);
    const Vec3 still = find_contacts(bodies(things)).wrenches[0][0].force;
    things.front().matter.friction = 2;
    things.back().matter.friction = 4;
    things.front().twists[0].linear = {-0.2, 0.5, 0};
    things.back().twists[0].linear = {0.1, 0, -0.3};
    const Vec3 moving = find_contacts(bodies(things)).wrenches[0][0].force;
    const Vec3 exact = 3 * pi * (1 - h * h) * Vec3(0.3, -0.5, -0.3);
    // The area is cut by chords: order 2.
    EXPECT_LT((moving - still - exact).norm(), 3 * spacing * spacing * exact.norm());
}

// However sticky the layer, along a rigid thing it gets no more than `grip` times the pressure.
TEST(LayerContact, GripLimitsTheFrictionOnRigidThings)
{
    Skeleton plane{.kind = SkeletonKind::plane, .points = {}};
    plane.place.translate(Vec3(0, -1, 0));
    Transform at = Transform::Identity();
    at.translate(Vec3(0, h, 0)).rotate(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()));
    std::list<Thing> things;
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), 0.04,
                        LayerMatter{.stiffness = 1, .friction = 1e6}, std::vector{at});
    things.emplace_back(layer_of({plane}, unit), 1.0, LayerMatter{.grip = 0.3, .rigid = true});
    things.front().twists[0].linear = {0.6, 0, 0.8};
    const Vec3 force = find_contacts(bodies(things)).wrenches[0][0].force;
    // Samples at the rim stand for less load than area times compression: order 2.
    EXPECT_LT((force - force.y() * Vec3(-0.18, 1, -0.24)).norm(), 5e-3 * force.y());
}

// Where a skeleton stands to what it is pressed against is told before it gets there.
TEST(LayerContact, AStopTellsHowFarASkeletonIsFromAnotherBody)
{
    LayerMatter rigid;
    rigid.rigid = true;
    Skeleton plane{.kind = SkeletonKind::plane, .points = {}};
    plane.place.translate(Vec3(0, -1, 0));
    for (const double height : {0.6, 0.3, 0.0, -0.2}) {
        Transform at = Transform::Identity();
        at.translate(Vec3(0.2, height, 0));
        std::list<Thing> things;
        things.emplace_back(layer_of({point({0, 0, 0})}, unit), 0.2, LayerMatter{},
                            std::vector{at});
        things.emplace_back(layer_of({plane}, unit), 1.0, rigid);
        const Contacts found = find_contacts(bodies(things));
        if (height > 0.5) {  // all rays end on their outer halves
            EXPECT_TRUE(found.stops.empty());
            continue;
        }
        ASSERT_EQ(found.stops.size(), 1u) << height;
        EXPECT_NEAR(found.stops[0].gap, height, 1e-12);
        EXPECT_LT((found.stops[0].normal - Vec3::UnitY()).norm(), 1e-12);
        EXPECT_LT((found.stops[0].position - Vec3(0.2, height, 0)).norm(), 1e-12);
    }
    // A soft one of twice the stiffness: 1 + 2 (1 - x) is this one's 1 + 1 at x = 0.5.
    Contribution hard = unit;
    hard.stiffness = 2;
    std::list<Thing> things;
    Transform at = Transform::Identity();
    at.translate(Vec3(0.8, 0, 0));
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), 0.2, LayerMatter{}, std::vector{at});
    things.emplace_back(layer_of({point({0, 0, 0})}, hard), 0.2);
    const Contacts found = find_contacts(bodies(things));
    ASSERT_GE(found.stops.size(), 1u);
    EXPECT_EQ(found.stops[0].body, 0u);
    EXPECT_NEAR(found.stops[0].gap, 0.3, 1e-12);
}

TEST(LayerContact, SamplesInContactLieOnOneCommonDisc)
{
    const std::list<Thing> things = two_balls(0.04);
    const std::vector<ContactBody> both = bodies(things);
    const Contacts found = find_contacts(both);
    ASSERT_GT(found.contacts.size(), 50u);
    double radius = 0;
    for (const LayerContact& contact : found.contacts) {
        EXPECT_NEAR(contact.position.x(), 0, 1e-12);  // by symmetry the plane between
        // On both deformed surfaces at once.
        for (std::uint32_t b = 0; b < 2; ++b) {
            EXPECT_NEAR(value_at(deformed(both, b, found), contact.position).f, 1, 1e-9);
        }
        radius = std::max(radius, contact.position.norm());
        EXPECT_NEAR(std::abs(contact.normal.x()), 1, 1e-12);
    }
    EXPECT_LT(radius, std::sqrt(1 - h * h) + 1e-9);
    EXPECT_GT(radius, std::sqrt(1 - h * h) - 0.04);
}

// Samples stop within round-off of f = c, on either side: in reach of another's field, but outside
// its surface, that is no contact, and must rub against nothing.
TEST(LayerContact, BodiesWithinInfluenceButApartDoNotTouch)
{
    std::list<Thing> things;
    Contribution hard = unit;
    hard.stiffness = 2.5;  // makes more of the samples' round-off
    Transform at = Transform::Identity();
    at.translate(Vec3(-0.8, 0, 0)).rotate(Eigen::AngleAxisd(0.4, Vec3(1, 2, 2).normalized()));
    things.emplace_back(layer_of({point({0, 0, 0})}, hard), 0.03, LayerMatter{}, std::vector{at});
    at.setIdentity();
    at.translate(Vec3(0.8, 0, 0));
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), 0.03, LayerMatter{}, std::vector{at});
    // Both surfaces are balls of radius 1 about x = -0.8 and 0.8: they cross at 0.6 from the axis.
    for (const LayerContact& contact : find_contacts(bodies(things)).contacts) {
        EXPECT_LT(std::hypot(contact.position.y(), contact.position.z()), 0.6 + 1e-9);
    }
}

// The border is where f_i = f_j = c: found along the deformed surface's meridian by bisection.
TEST(LayerContact, TheContactRadiusIsExact)
{
    const std::list<Thing> things = two_balls(0.1);
    const std::vector<ContactBody> both = bodies(things);
    double inside = 0, outside = 1;
    while (outside - inside > 1e-12) {
        const double rho = 0.5 * (inside + outside);
        const Vec3 p(0, rho * 0.6, rho * 0.8);
        (geometry::value_at(*both[0].field, p).f > 1 ? inside : outside) = rho;
    }
    EXPECT_NEAR(inside, 0.43589, 5e-7 + 1e-6);
}

TEST(LayerContact, ActionIsReactionInForceAndTorque)
{
    std::list<Thing> things = two_balls(0.05);
    things.front().twists[0] = {{1, 2, 3}, {0.3, -0.2, 0.5}};
    things.front().matter.friction = 2;
    things.back().matter.stiffness = 5;
    const Contacts found = find_contacts(bodies(things));
    const Wrench a = found.wrenches[0][0], b = found.wrenches[1][0];
    EXPECT_LT((a.force + b.force).norm(), 1e-14 * a.force.norm() * 1e2);
    const Vec3 total =
        a.torque + b.torque + Vec3(-h, 0, 0).cross(a.force) + Vec3(h, 0, 0).cross(b.force);
    EXPECT_LT(total.norm(), 1e-12 * a.force.norm());
}

// One-sided normals on the meridian just inside and outside the border. The compression side is
// flat; outside the bulge leaves with the same normal.
TEST(LayerContact, TheDeformedSurfaceIsSmoothAcrossTheContactsBorder)
{
    const std::list<Thing> things = two_balls(0.04);
    const std::vector<ContactBody> both = bodies(things);
    const Contacts found = find_contacts(both);
    const DeformedLayer left = deformed(both, 0, found);
    const auto normal_near = [&](double rho) {  // on the surface, at this distance from the axis
        double inside = -0.5, outside = 0.3;
        while (outside - inside > 1e-13) {
            const double x = 0.5 * (inside + outside);
            (value_at(left, {x, rho, 0}).f > 1 ? inside : outside) = x;
        }
        return Vec3(-value_at(left, {inside, rho, 0}).gradient.normalized());
    };
    const double border = std::sqrt(1 - h * h);
    for (const double step : {1e-3, 1e-4, 1e-5}) {
        const double angle =
            std::acos(std::min(1.0, normal_near(border - step).dot(normal_near(border + step))));
        EXPECT_LT(angle, 30 * step + 2e-6);  // vanishes with the step: no crease
    }
    // Without a bulge the sphere meets the disc at acos(h): 0.45 rad.
    DeformedLayer bare = left;
    bare.bulges = {};
    const Vec3 outside_normal(0.9, border, 0);
    EXPECT_GT(std::acos(outside_normal.normalized().x()), 0.4);
}

TEST(LayerContact, TheDeformedGradientIsTheDerivativeOfTheDeformedField)
{
    std::list<Thing> things = two_balls(0.05);
    LayerMatter rigid{.rigid = true};
    Skeleton plane{.kind = SkeletonKind::plane, .points = {}};
    Transform floor = Transform::Identity();
    floor.translate(Vec3(0, -1.9, 0));
    things.emplace_back(layer_of({plane}, unit), 0.1, rigid, std::vector{floor});
    const std::vector<ContactBody> all = bodies(things);
    const Contacts found = find_contacts(all);
    const DeformedLayer layer = deformed(all, 0, found);
    ASSERT_GT(layer.bulges.highest(), 0);
    const geometry::Random random(1);
    int checked = 0;
    for (std::uint64_t i = 0; i < 500; ++i) {
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
        EXPECT_LT((central - at.gradient).norm(), 1e-3);
    }
    EXPECT_GT(checked, 400);
}

// A ball pressed to depth d into a rigid floor: it fits the floor, and the force is K times the
// integral of the compression f - c = k (r0 - r) over the flat cut, as between two balls.
TEST(LayerContact, ASoftBallFitsARigidFloor)
{
    std::list<Thing> things;
    LayerMatter soft{.stiffness = 3, .friction = 0};
    LayerMatter rigid{.rigid = true};
    things.emplace_back(layer_of({point({0.1, 0, 0.2})}, unit), 0.03, soft);
    Transform floor = Transform::Identity();
    floor.translate(Vec3(0, -1.9, 0));  // solid surface 1 above it: at y = -0.9
    things.emplace_back(layer_of({{.kind = SkeletonKind::plane, .points = {}}}, unit), 0.1, rigid,
                        std::vector{floor});
    const Contacts found = find_contacts(bodies(things));
    const double exact = 3 * 2 * pi * ((1 - h * h) / 2 - (1 - h * h * h) / 3);
    EXPECT_NEAR(found.wrenches[0][0].force.y(), exact, 1e-4);
    EXPECT_LT(std::hypot(found.wrenches[0][0].force.x(), found.wrenches[0][0].force.z()), 1e-4);
    for (const LayerContact& contact : found.contacts) {
        EXPECT_NEAR(contact.position.y(), -0.9, 1e-12);
    }
}

// Two parts of one object that do not blend press like two objects.
TEST(LayerContact, PartsThatDoNotBlendCollide)
{
    ImplicitLayer layer = layer_of({point({-h, 0, 0}), point({h, 0, 0})}, unit);
    layer.frame = {0, 1};
    layer.skeletons[0].points[0].setZero();
    layer.skeletons[1].points[0].setZero();
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    std::vector<Transform> frames(2, Transform::Identity());
    frames[0].translate(Vec3(-h, 0, 0));
    frames[1].translate(Vec3(h, 0, 0));
    LayerMatter matter{.stiffness = 1, .friction = 0, .self_contact = true};
    std::list<Thing> things;
    things.emplace_back(layer, 0.02, matter, frames);
    const Contacts found = find_contacts(bodies(things));
    EXPECT_NEAR(found.wrenches[0][0].force.x(), -0.0293215, 2e-5);
    EXPECT_NEAR(found.wrenches[0][1].force.x(), 0.0293215, 2e-5);
    things.front().matter.self_contact = false;
    EXPECT_TRUE(find_contacts(bodies(things)).contacts.empty());
}

TEST(LayerContact, TheDeformedMeshStopsAtTheCommonSurface)
{
    const std::list<Thing> things = two_balls(0.05);
    const std::vector<ContactBody> both = bodies(things);
    const Contacts found = find_contacts(both);
    const auto left = geometry::polygonize(iso_field(deformed(both, 0, found)), 0.06);
    ASSERT_FALSE(left.triangles().empty());
    for (const auto& p : left.positions) EXPECT_LT(p.x(), 1e-3);
}

TEST(LayerContact, ASkeletonEntirelyInsideAnotherStaysFinite)
{
    std::list<Thing> things;
    const Contribution small{.thickness = 0.2, .stiffness = 2, .radius = 0.4};
    things.emplace_back(layer_of({point({0, 0, 0})}, unit), 0.2);
    things.emplace_back(layer_of({point({0.1, 0, 0})}, small), 0.1);
    const Contacts found = find_contacts(bodies(things));
    for (const auto& body : found.wrenches) EXPECT_TRUE(body[0].force.allFinite());
}

// A skeleton pushed beyond the floor's surface is still pressed back out, harder than before.
TEST(LayerContact, ASkeletonBeyondTheSurfaceIsStillPressedOut)
{
    const auto push = [](double height) {
        std::list<Thing> things;
        LayerMatter rigid{.rigid = true};
        things.emplace_back(layer_of({point({0, height, 0})}, unit), 0.1);
        Transform floor = Transform::Identity();
        floor.translate(Vec3(0, -1, 0));
        things.emplace_back(layer_of({{.kind = SkeletonKind::plane, .points = {}}}, unit), 0.1,
                            rigid, std::vector{floor});
        return find_contacts(bodies(things)).wrenches[0][0].force.y();
    };
    EXPECT_GT(push(-0.3), 0.5 * push(0.3));
    EXPECT_GT(push(-0.3), 0);
}

TEST(LayerContact, TheSameBitsForAnyNumberOfThreads)
{
    std::vector<Vec3> forces;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const std::list<Thing> things = two_balls(0.04);
        forces.push_back(find_contacts(bodies(things)).wrenches[0][0].force);
    }
    EXPECT_EQ(forces[0], forces[1]);
    EXPECT_EQ(forces[0], forces[2]);
}

TEST(LayerContact, NoBodiesTouchNothingAndMismatchedInputThrows)
{
    EXPECT_TRUE(find_contacts({}).contacts.empty());
    std::list<Thing> things = two_balls(0.2);
    things.back().layer.isovalue = 2;
    things.back().field = geometry::make_field(things.back().layer, things.back().frames);
    EXPECT_THROW(find_contacts(bodies(things)), std::invalid_argument);
    things = two_balls(0.2);
    things.back().twists.clear();
    EXPECT_THROW(find_contacts(bodies(things)), std::invalid_argument);
}

}  // namespace physics
