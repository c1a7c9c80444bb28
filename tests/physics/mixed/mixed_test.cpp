// Solids and sheets in one simulation: each moves as it does alone, and both push each other.

#include "physics/mixed/mixed.hpp"

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/cube_mass.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/state_models.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/shell/shell_fixtures.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double frame = 1.0 / 24;  // s
constexpr double gravity = 9.81;
constexpr double thickness = 0.004;  // m

// A square of ni by ni cells about the origin, at height 0.
Cubes cloth(int ni, double a, double damping = 2)
{
    return geometry::plane_cubes(geometry::rectangle_cells(ni, ni),
                                 {1, a, {-0.5 * a * ni, 0, -0.5 * a * ni}}, thickness,
                                 {"cloth", 300, 1e6, 0.3, damping, 0.002});
}

// A box of n cubes an edge, h each, with the middle of its underside there.
Cubes block(int n, double h, const Vec3& foot, const Stuff& stuff)
{
    Cubes out = fixtures::box(n, n, n, h, stuff);
    out.origin = foot - Vec3(0.5 * n * h, 0, 0.5 * n * h);
    return out;
}

Loads weight_on(const Pins& pins = {})
{
    Loads loads;
    loads.forces.push_back({Force::Kind::gravity, Vec3(0, -gravity, 0)});
    loads.pins = pins;
    return loads;
}

Pins rim_of(const Cubes& sheet, int ni, std::uint32_t first)
{
    Pins pins = held_where(sheet, [&](const Vec3i& at) { return near_border(at, ni, ni, 1); });
    for (auto& corner : pins.corner) corner += first;
    return pins;
}

// What is of some corners of a state.
std::span<const Vec3> some(const std::vector<Vec3>& of, std::size_t first, std::size_t count)
{
    return std::span(of).subspan(first, count);
}

double lowest(std::span<const Vec3> x)
{
    double low = x[0].y();
    for (const Vec3& p : x) low = std::min(low, p.y());
    return low;
}

struct Momenta {
    Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};
// Of bricks, which come first and have their mass spread, and of a sheet, whose mass is lumped.
Momenta momenta(const Cubes& bricks, const Cubes& sheet, const State& state)
{
    std::vector<Vec3> own = brick_momenta(
        bricks, {state.v.begin(), state.v.begin() + std::ptrdiff_t(bricks.corner_count())});
    for (const double mass : geometry::corner_masses(sheet)) {
        own.push_back(mass * state.v[own.size()]);
    }
    Momenta out;
    for (std::size_t k = 0; k < own.size(); ++k) {
        const Vec3& p = own[k];
        out.linear += p;
        out.angular += state.x[k].cross(p);
    }
    return out;
}

double largest_way(std::span<const Vec3> a, std::span<const Vec3> b)
{
    double most = 0;
    for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, (a[k] - b[k]).norm());
    return most;
}

constexpr Stuff wood{
    .density = 500, .young = 1e6, .poisson = 0.3, .mass_damping = 1, .stiffness_damping = 0.002};

BrickOptions touching(bool rigid = false)
{
    BrickOptions out;
    out.contact.on = true;
    if (rigid) out.rigid = {1, 0};
    return out;
}

// A sheet of triangles 3 m above a box takes nothing of a force in the box, at a corner of it or
// beside it.
TEST(MixedForce, AForceAtAPointIsOfWhatIsNearest)
{
    const Cubes box = block(4, 0.25, Vec3(0, -0.5, 0), wood);
    geometry::TriMesh high = geometry::grid(1, 1, 4, 4);
    for (auto& p : high.positions) p.y() += 3;
    const Cubes sheet = sheet_of(high, 0.01);
    const BodyModel models[] = {{&box, nullptr}, {&sheet, nullptr}};
    const MixedBody body = make_mixed(models, {}, {});
    const auto corners = static_cast<std::uint32_t>(box.corner_count());
    struct Case {
        Vec3 place;
        bool on_sheet;
    };
    for (const auto& [place, on_sheet] :
         {Case{{0, 0, 0}, false}, Case{{0.5, 0.5, 0.5}, false}, Case{{0, 1.5, 0}, false},
          Case{{0, 2, 0}, true}, Case{{0.1, 3, 0.1}, true}}) {
        Force push;
        push.kind = Force::Kind::point;
        push.position = place;
        push.radius = 0;
        push.force = Vec3(10, 0, 0);
        Loads loads;
        loads.forces.push_back(push);
        const State state = advance(body, rest_state(body), loads, frame);
        Vec3 of_box = Vec3::Zero(), of_sheet = Vec3::Zero();
        for (std::uint32_t k = 0; k < state.v.size(); ++k) {
            (k < corners ? of_box : of_sheet) += state.v[k];
        }
        EXPECT_EQ(of_box.x() > 1e-6, !on_sheet) << place.transpose();
        EXPECT_EQ(of_sheet.x() > 1e-6, on_sheet) << place.transpose();
    }
}

// A box that comes to a net of ni by ni cells, which its rim holds.
struct BoxAndNet {
    BoxAndNet(Cubes its_box, Cubes its_net, int ni, bool rigid,
              const geometry::TriMesh* surface = nullptr)
        : box(std::move(its_box)), net(std::move(its_net)),
          corners(static_cast<std::uint32_t>(box.corner_count()))
    {
        const BodyModel models[] = {{&box, surface}, {&net, nullptr}};
        body = make_mixed(models, touching(rigid), {});
        loads = weight_on(rim_of(net, ni, corners));
        state = rest_state(body);
    }

    void fly(const Vec3& velocity) { std::fill_n(state.v.begin(), corners, velocity); }
    void go(int frames)
    {
        for (int i = 0; i < frames; ++i) state = advance(body, std::move(state), loads, frame);
    }
    double low_of_box() const { return lowest(some(state.x, 0, corners)); }
    double low_of_net() const { return lowest(some(state.x, corners, net.corner_count())); }
    double weight() const { return geometry::total_mass(box) * gravity; }
    Vec3 push_on_box() const
    {
        const StateModel of_box{0, 0, corners, 0, static_cast<std::uint32_t>(box.count())};
        return contact_force(state, {.body = &of_box});
    }

    Cubes box, net;
    std::uint32_t corners;  // of the box
    MixedBody body;
    Loads loads;
    State state;
};

}  // namespace

// A beam that is held at one end and a cloth that is held by its rim, far apart, under gravity.
TEST(Mixed, EachKindMovesAsItDoesAlone)
{
    constexpr int ni = 6;
    const Cubes sheet = cloth(ni, 0.1);
    Cubes beam = fixtures::box(5, 1, 1, 0.1, wood);
    beam.origin = {2, 0, 0};
    const BodyModel models[] = {{&sheet, nullptr}, {&beam, nullptr}};  // the sheet first
    const MixedBody both = make_mixed(models, touching(), {});
    const ShellBody alone_sheet = make_shell(sheet);
    const BricksBody alone_beam = make_bricks(beam);
    const auto k = static_cast<std::uint32_t>(sheet.corner_count());
    const Pins end = held_where(beam, [](const Vec3i& at) { return at.x() == 0; });
    Pins all = rim_of(sheet, ni, 0);
    for (std::size_t p = 0; p < end.corner.size(); ++p) {
        all.corner.push_back(k + end.corner[p]);
        all.target.push_back(end.target[p]);
    }
    const StepOptions exact{.newton_iterations = 20, .tolerance = 1e-8};
    State state = rest_state(both), own_sheet = rest_state(alone_sheet),
          own_beam = rest_state(alone_beam);
    for (int i = 0; i < 6; ++i) {
        state = advance(both, std::move(state), weight_on(all), frame, exact);
        own_sheet = advance(alone_sheet, std::move(own_sheet), weight_on(rim_of(sheet, ni, 0)),
                            frame, exact);
        own_beam = advance(alone_beam, std::move(own_beam), weight_on(end), frame, exact);
    }
    EXPECT_GT(largest_way(own_sheet.x, rest_state(alone_sheet).x), 0.02);
    EXPECT_GT(largest_way(own_beam.x, rest_state(alone_beam).x), 0.01);
    EXPECT_LT(largest_way(some(state.x, 0, k), own_sheet.x), 1e-6);
    EXPECT_LT(largest_way(some(state.x, k, beam.corner_count()), own_beam.x), 1e-6);
    ASSERT_EQ(state.stress.size(), sheet.count() + beam.count());
    EXPECT_TRUE(std::isnan(state.stress[0]));
    for (std::size_t c = 0; c < beam.count(); ++c) {
        EXPECT_NEAR(double(state.stress[sheet.count() + c]), double(own_beam.stress[c]),
                    1e-3 * double(own_beam.stress[c]) + 1);
    }
}

class MixedAtRest : public testing::TestWithParam<bool> {};

// A box of 4 kg on a net that is held by its rim.
TEST_P(MixedAtRest, ABoxOnANetIsHeldByItsWeight)
{
    BoxAndNet on(block(4, 0.05, {0.01, 0.01, 0}, wood), cloth(12, 0.08), 12, GetParam());
    double most_below = 0;
    for (int i = 0; i < 72; ++i) {
        on.go(1);
        most_below = std::max(most_below, on.low_of_net() - on.low_of_box());
    }
    EXPECT_LT(most_below, 0.01 * 0.05);
    const double weight = on.weight(), net = geometry::total_mass(on.net) * gravity;
    Vec3 held = Vec3::Zero();
    for (const Reaction& r : on.state.reactions) held += r.force.cast<double>();
    EXPECT_NEAR(held.y(), weight + net, 0.02 * weight);
    const Vec3 pushed = on.push_on_box();
    EXPECT_NEAR(pushed.y(), weight, 0.02 * weight);
    EXPECT_LT(pushed.x() * pushed.x() + pushed.z() * pushed.z(), 1e-4 * pushed.y() * pushed.y());
    double fastest = 0;
    for (const Vec3& v : on.state.v) fastest = std::max(fastest, v.norm());
    EXPECT_LT(fastest, 0.01);
}

INSTANTIATE_TEST_SUITE_P(ElasticAndRigid, MixedAtRest, testing::Bool());

class MixedHit : public testing::TestWithParam<bool> {};

// A box flies into a sheet that nothing holds.
TEST_P(MixedHit, MomentaAreKept)
{
    constexpr int ni = 8;
    Stuff free = wood;
    free.mass_damping = 0;
    const Cubes box = block(2, 0.1, {0.05, 0.05, 0.02}, free);
    const Cubes sheet = cloth(ni, 0.1, 0);
    const BodyModel models[] = {{&box, nullptr}, {&sheet, nullptr}};
    const MixedBody body = make_mixed(models, touching(GetParam()), {});
    State state = rest_state(body);
    for (std::size_t k = 0; k < box.corner_count(); ++k) state.v[k] = {1, -3, 0};
    const Momenta before = momenta(box, sheet, state);
    double gone = 0;
    for (int i = 0; i < 6; ++i) {
        state = advance(body, std::move(state), {}, frame);
        const Momenta now = momenta(box, sheet, state);
        EXPECT_LT((now.linear - before.linear).norm(), 1e-12 * before.linear.norm()) << i;
        // A rigid body is solved along lines, and turned where it ends.
        const double off = GetParam() ? 3e-3 : 1e-6;
        EXPECT_LT((now.angular - before.angular).norm(), off * before.angular.norm()) << i;
    }
    for (std::size_t k = box.corner_count(); k < state.x.size(); ++k) {
        gone = std::max(gone, -state.v[k].y());
    }
    EXPECT_GT(gone, 0.5);
}

INSTANTIATE_TEST_SUITE_P(ElasticAndRigid, MixedHit, testing::Bool());

class MixedFast : public testing::TestWithParam<double> {};

// A box that goes several of its lengths in a step, at a sheet that is held by its rim.
TEST_P(MixedFast, ABoxDoesNotPassThroughANet)
{
    BoxAndNet at(block(2, 0.05, {0.013, 0.3, 0.02}, wood), cloth(10, 0.06), 10, false);
    at.fly({0, -GetParam(), 0});
    for (int i = 0; i < 12; ++i) {
        at.go(1);
        ASSERT_GT(at.low_of_box(), at.low_of_net() - 0.1 * 0.05) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Speeds, MixedFast, testing::Values(5.0, 15.0, 40.0, 150.0, 350.0));

class MixedSmall : public testing::TestWithParam<double> {};

// A box of half a cell, which no corner of the sheet comes to lie in.
TEST_P(MixedSmall, ABoxDoesNotPassBetweenTheCornersOfANet)
{
    BoxAndNet at(block(2, 0.02, {0.04, 0.3, 0.037}, wood), cloth(8, 0.08), 8, true);
    at.fly({0, -GetParam(), 0});
    for (int i = 0; i < 24; ++i) {
        at.go(1);
        ASSERT_GT(at.low_of_box(), at.low_of_net() - 0.1 * 0.02) << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Speeds, MixedSmall, testing::Values(0.0, 10.0, 60.0, 150.0, 350.0));

// A cloth comes to rest on the top of a box that is held, of cubes larger than the cloth's cells:
// between the points of the box, the corners of the cloth find its face.
TEST(Mixed, AClothLiesOnTheFaceOfACoarseBox)
{
    constexpr int ni = 10;
    const Cubes box = block(2, 0.2, {0, -0.41, 0}, wood);
    const Cubes sheet = cloth(ni, 0.03);
    const BodyModel models[] = {{&box, nullptr}, {&sheet, nullptr}};
    const MixedBody body = make_mixed(models, touching(true), {});
    const auto k = static_cast<std::uint32_t>(box.corner_count());
    const Loads loads = weight_on(held_where(box, [](const Vec3i& at) { return at.y() == 0; }));
    State state = rest_state(body);
    for (int i = 0; i < 24; ++i) state = advance(body, std::move(state), loads, frame);
    const auto on_top = some(state.x, k, sheet.corner_count());
    double highest = on_top[0].y();
    for (const Vec3& p : on_top) highest = std::max(highest, p.y());
    EXPECT_NEAR(lowest(on_top), -0.01 + 0.5 * thickness, 0.05 * thickness);
    EXPECT_NEAR(highest, -0.01 + 0.5 * thickness, 0.05 * thickness);
}

// A box whose mesh faces inward.
TEST(Mixed, ABoxOnANetMayBeInsideOut)
{
    geometry::TriMesh mesh = geometry::box({0.2, 0.2, 0.2}, {4, 4, 4});
    geometry::MeshTopology turned;
    for (geometry::Triangle t : mesh.triangles()) {
        std::swap(t[1], t[2]);
        turned.triangles.push_back(t);
    }
    mesh.topology = std::make_shared<const geometry::MeshTopology>(turned);
    for (auto& p : mesh.positions) p += geometry::Vec3f(0.013f, 0.11f, 0.02f);
    BoxAndNet on(block(4, 0.05, {0.013, 0.01, 0.02}, wood), cloth(8, 0.1), 8, true, &mesh);
    on.go(48);
    EXPECT_NEAR(on.push_on_box().y(), on.weight(), 0.05 * on.weight());
}

// The underside of a box lies 0.5 mm beyond the middle of a net at the start.
TEST(Mixed, ABoxThatStartsInANetComesOut)
{
    BoxAndNet in(block(4, 0.05, {0.013, -0.0005, 0.02}, wood), cloth(8, 0.1), 8, true);
    in.go(48);
    EXPECT_NEAR(in.push_on_box().y(), in.weight(), 0.05 * in.weight());
    EXPECT_GT(in.low_of_box(), in.low_of_net());
}

TEST(Mixed, WhatItCannotDoIsRefused)
{
    const Cubes box = block(2, 0.1, {0, 0.1, 0}, wood), sheet = cloth(4, 0.1);
    const BodyModel models[] = {{&box, nullptr}, {&sheet, nullptr}};
    const auto refused = [&](const BrickOptions& bricks, const ShellOptions& shell) {
        EXPECT_THROW(make_mixed(models, bricks, shell), std::invalid_argument);
    };
    ShellOptions yields;
    yields.plastic.yield = 0.1;
    refused({}, yields);
    BrickOptions rigid;
    rigid.rigid = {0, 1};
    refused(rigid, {});
    EXPECT_THROW(make_mixed({models, 1}, {}, {}), std::invalid_argument);
    const MixedBody body = make_mixed(models, {}, {});
    Pins along{{static_cast<std::uint32_t>(box.corner_count())}, {Vec3::Zero()}};
    along.axes = {1};
    EXPECT_THROW(advance(body, rest_state(body), weight_on(along), frame), std::invalid_argument);
}
