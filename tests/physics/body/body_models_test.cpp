#include "geometry/mesh/mesh.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/state_models.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

namespace physics {
namespace {

using geometry::Cubes;

Cubes block(int n, double h, const Vec3& origin, const fixtures::Stuff& stuff = {})
{
    Cubes out = fixtures::box(n, n, n, h, stuff);
    out.origin = origin;
    return out;
}

Vec3 mean(const std::vector<Vec3>& of, std::size_t begin, std::size_t end)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = begin; k < end; ++k) sum += of[k];
    return sum / static_cast<double>(end - begin);
}

// Bodies of two sizes.
struct Two {
    Cubes low, high;

    BodyModels models() const { return BodyModels(std::vector<BodyModel>{{&low}, {&high}}); }
    std::size_t lows() const { return low.corner_count(); }
    std::size_t all() const { return lows() + high.corner_count(); }
};

template <class Body> State stepped(const Body& body, State state, const Loads& loads, int frames)
{
    for (int i = 0; i < frames; ++i) {
        state = advance(body, state, loads, 1.0 / 24, {.tolerance = 1e-8});
    }
    EXPECT_TRUE(fixtures::finite(state));
    return state;
}

// A beam of cubes of h, one end held, under gravity and a force; twisted at the start.
struct Held {
    Cubes cubes;
    Loads loads;

    Held(double h, int length, const Vec3& origin)
        : cubes(fixtures::box(length, 2, 2, h, {.young = 3e5, .stiffness_damping = 1e-3}))
    {
        cubes.origin = origin;
        loads.forces.push_back({});
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k].x() > 0) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner_position(k));
        }
    }
};

// A force at a place in the upper cubes of one box, 5 cm below another box: all of it is the first
// one's, though corners of the other are within a cube of the place.
TEST(BodyModels, AForceAtAPointIsOfTheBodyThatHoldsIt)
{
    Two two{fixtures::box(4, 4, 4, 0.25), fixtures::box(4, 4, 4, 0.25)};
    two.low.origin = Vec3(-0.5, -0.5, -0.5), two.high.origin = Vec3(-0.5, 0.55, -0.5);
    const BricksBody body = make_bricks(two.models(), {.contact = {.on = false}});
    for (const double radius : {0.0, 0.02}) {
        Force push;
        push.kind = Force::Kind::point;
        push.position = Vec3(0, 0.45, 0);
        push.radius = radius;
        push.force = Vec3(10, 0, 0);
        Loads loads;
        loads.forces.push_back(push);
        const State state = stepped(body, rest_state(body), loads, 1);
        EXPECT_EQ(mean(state.v, two.lows(), two.all()).norm(), 0) << radius;
        EXPECT_GT(mean(state.v, 0, two.lows()).x(), 1e-4) << radius;
    }
}

// Bodies that do not meet move as each does alone, whatever the sizes of the others' cubes.
TEST(BodyModels, BodiesApartMoveAsEachAlone)
{
    const Held one(0.1, 6, Vec3::Zero()), other(0.03, 9, Vec3(0, 0, 5));
    const Two two{one.cubes, other.cubes};
    Loads loads = one.loads;
    const auto first = static_cast<std::uint32_t>(two.lows());
    for (std::size_t i = 0; i < other.loads.pins.corner.size(); ++i) {
        loads.pins.corner.push_back(first + other.loads.pins.corner[i]);
        loads.pins.target.push_back(other.loads.pins.target[i]);
    }
    Force wind;
    wind.kind = Force::Kind::wind;
    wind.velocity = Vec3(0, 0, 8);
    Held windy = one, windy_other = other;
    for (Loads* some : {&loads, &windy.loads, &windy_other.loads}) some->forces.push_back(wind);
    const auto check = [&](const auto& body, const auto& alone, const auto& other_alone) {
        const State state = stepped(body, rest_state(body), loads, 10);
        const State a = stepped(alone, rest_state(alone), windy.loads, 10);
        const State b = stepped(other_alone, rest_state(other_alone), windy_other.loads, 10);
        ASSERT_EQ(state.x.size(), a.x.size() + b.x.size());
        EXPECT_GT((a.x.back() - one.cubes.corner_position(a.x.size() - 1)).norm(), 1e-2);
        for (std::size_t k = 0; k < a.x.size(); ++k) {
            EXPECT_LT((state.x[k] - a.x[k]).norm(), 1e-6);
        }
        for (std::size_t k = 0; k < b.x.size(); ++k) {
            EXPECT_LT((state.x[a.x.size() + k] - b.x[k]).norm(), 1e-6);
        }
        for (std::size_t c = 0; c < state.stress.size(); ++c) {
            const float alone_stress =
                c < a.stress.size() ? a.stress[c] : b.stress[c - a.stress.size()];
            EXPECT_NEAR(state.stress[c], alone_stress, 1e-3f * alone_stress + 1);
        }
    };
    check(make_bricks(two.models()), make_bricks(one.cubes), make_bricks(other.cubes));
    check(make_springs(two.models()), make_springs(one.cubes), make_springs(other.cubes));
}

// A heavy block of fine cubes on a block of coarse ones comes to rest on it, and not in it.
TEST(BodyModels, ABodyOfFineCubesRestsOnOneOfCoarseCubes)
{
    const fixtures::Stuff stuff{.young = 1e6, .stiffness_damping = 0.01};
    const Two two{block(3, 0.1, Vec3::Zero(), stuff),
                  block(4, 0.04, Vec3(0.07, 0.32, 0.07), stuff)};
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    const auto check = [&](const auto& body) {
        const State state = stepped(body, rest_state(body), loads, 48);
        const State later = stepped(body, state, loads, 12);
        double top = 0, bottom = 1;
        for (std::size_t k = 0; k < two.all(); ++k) {
            EXPECT_LT((later.x[k] - state.x[k]).norm(), 1e-4);
            if (k >= two.lows()) {
                bottom = std::min(bottom, later.x[k].y());
            } else if (two.low.corner[k].y() == 3 && two.low.corner[k].x() % 3 > 0 &&
                       two.low.corner[k].z() % 3 > 0) {
                top = std::max(top, later.x[k].y());  // the four corners below it
            }
        }
        EXPECT_NEAR(top, bottom, 0.01 * 0.04);
        EXPECT_NEAR(top, 0.3, 0.005);
    };
    check(make_bricks(two.models(), {.contact = {}}));
    check(make_springs(two.models(), {.contact = {}}));
}

// Two blocks of one mass, one of coarse and one of fine cubes, thrown at each other. Momentum is
// kept; with bounce 0.5 they part at half the speed of 4 m/s that they met with.
TEST(BodyModels, BodiesOfDifferentSizesBounceOffEachOther)
{
    const fixtures::Stuff stuff{.young = 1e9, .stiffness_damping = 1e-4};
    const Two two{block(2, 0.1, Vec3::Zero(), stuff), block(5, 0.04, Vec3(0, 0.35, 0), stuff)};
    const BricksBody body = make_bricks(two.models(), {.contact = {.bounce = 0.5}});
    State state = rest_state(body);
    for (std::size_t k = 0; k < two.all(); ++k) state.v[k].y() = k < two.lows() ? 2 : -2;
    state = stepped(body, state, {}, 8);
    const double low = mean(state.v, 0, two.lows()).y(),
                 high = mean(state.v, two.lows(), two.all()).y();
    EXPECT_NEAR(low + high, 0, 0.01);
    EXPECT_NEAR(high - low, 2, 0.06);
}

TEST(BodyModels, AnyNumberOfModelsOfOneSizeAreTheBlocksOfOneModel)
{
    const fixtures::Stuff stuff{.young = 1e6, .stiffness_damping = 0.01};
    std::vector<geometry::Vec3i> cells;
    const Cubes two = fixtures::box(2, 2, 2, 0.1);
    for (int i = 0; i < 3; ++i) {
        for (const auto& c : two.cell) cells.push_back(c + geometry::Vec3i(0, 3 * i, 0));
    }
    const Cubes together = fixtures::cubes_on(cells, 0.1, stuff);
    std::vector<Cubes> apart;
    for (int i = 0; i < 3; ++i) apart.push_back(block(2, 0.1, Vec3(0, 0.3 * i, 0), stuff));
    const BodyModels models(std::vector<BodyModel>{{&apart[0]}, {&apart[1]}, {&apart[2]}});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    const BricksBody one = make_bricks(together, {.contact = {}}),
                     three = make_bricks(models, {.contact = {}});
    const State a = stepped(one, rest_state(one), loads, 12);
    const State b = stepped(three, rest_state(three), loads, 12);
    for (std::size_t k = 0; k < a.x.size(); ++k) {
        const Vec3 rest = together.corner_position(k);
        const auto at_rest = rest_state(three).x;
        for (std::size_t j = 0; j < at_rest.size(); ++j) {
            if ((at_rest[j] - rest).norm() > 1e-9) continue;
            EXPECT_LT((a.x[k] - b.x[j]).norm(), 1e-5);
        }
    }
}

// A cantilever of 10 g bends as it does alone, although a block of 13.8 t lands beside it: neither
// its mass nor its tolerance depends on the other.
TEST(BodyModels, ALightBodyMovesBesideAHeavyOneAsAlone)
{
    Cubes light = fixtures::box(20, 2, 2, 0.005, {.young = 1e5});
    light.origin = Vec3(5, 0.5, 0);
    const Cubes heavy = fixtures::box(6, 6, 6, 0.2, {.density = 8000, .young = 1e6});
    Loads loads;
    loads.forces.push_back({});
    loads.colliders.push_back({});
    loads.colliders[0].pose.translation().y() = loads.colliders[0].before.translation().y() = -0.5;
    for (std::uint32_t k = 0; k < light.corner_count(); ++k) {
        if (light.corner[k].x() > 0) continue;
        loads.pins.corner.push_back(k);
        loads.pins.target.push_back(light.corner_position(k));
    }
    const BricksBody alone = make_bricks(light);
    const BricksBody both = make_bricks(BodyModels(std::vector<BodyModel>{{&light}, {&heavy}}));
    State a = rest_state(alone), b = rest_state(both);
    const std::size_t tip = light.corner_count() - 1;
    for (int frame = 0; frame < 15; ++frame) {
        a = advance(alone, a, loads, 1.0 / 24);
        b = advance(both, b, loads, 1.0 / 24);
        EXPECT_NEAR(b.x[tip].y(), a.x[tip].y(), 0.002) << frame;
    }
    EXPECT_LT(a.x[tip].y(), 0.45);
}

// Coarse cubes slide over a rippled sheet, although cubes of 2 mm lie elsewhere.
TEST(BodyModels, ACoarseBodyStaysOnASheetBesideAFineOne)
{
    geometry::TriMesh sheet;
    auto topology = std::make_shared<geometry::MeshTopology>();
    constexpr int n = 120;
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= 4; ++j) {
            const double x = 0.05 * i - 1;
            sheet.positions.emplace_back(float(x), float(0.03 * std::sin(x / 0.2 * 6.283)),
                                         float(j - 2));
        }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        for (std::uint32_t j = 0; j < 4; ++j) {
            const std::uint32_t a = 5 * i + j, b = a + 5;
            topology->triangles.push_back({a, a + 1, b});
            topology->triangles.push_back({b, a + 1, b + 1});
        }
    }
    sheet.topology = topology;
    Loads loads;
    loads.forces.push_back({});
    Collider collider;
    collider.kind = Collider::Kind::mesh;
    collider.sheet = true;
    collider.friction = 0;
    collider.mesh = std::make_shared<const geometry::TriMesh>(std::move(sheet));
    loads.colliders.push_back(collider);
    Cubes coarse = fixtures::box(4, 3, 4, 0.15, {.density = 300, .young = 2e5});
    coarse.origin = Vec3(0, 0.05, -0.3);
    const Cubes fine = block(3, 0.002, Vec3(0, 1, 20));
    const BricksBody body = make_bricks(BodyModels(std::vector<BodyModel>{{&coarse}, {&fine}}));
    State state = rest_state(body);
    for (std::size_t k = 0; k < coarse.corner_count(); ++k) state.v[k].x() = 5;
    for (int frame = 0; frame < 20; ++frame) state = advance(body, state, loads, 1.0 / 24);
    for (std::size_t k = 0; k < coarse.corner_count(); ++k) EXPECT_GT(state.x[k].y(), -0.06);
}

TEST(BodyModels, RefuseWhatIsNoBody)
{
    const Cubes cubes = block(2, 0.1, Vec3::Zero());
    const Cubes none;
    EXPECT_THROW(BodyModels(std::vector<BodyModel>{}), std::invalid_argument);
    EXPECT_THROW(BodyModels(std::vector<BodyModel>{{&cubes}, {&none}}), std::invalid_argument);
    Cubes short_mass = block(2, 0.2, Vec3(1, 0, 0));
    short_mass.mass.pop_back();
    EXPECT_THROW(BodyModels(std::vector<BodyModel>{{&cubes}, {&short_mass}}),
                 std::invalid_argument);
    Cubes flat = block(2, 0.2, Vec3(1, 0, 0));
    flat.size = 0;
    EXPECT_THROW(make_bricks(BodyModels(std::vector<BodyModel>{{&cubes}, {&flat}})),
                 std::invalid_argument);
}

std::shared_ptr<const Cubes> shared(const Cubes& cubes)
{
    return std::make_shared<const Cubes>(cubes);
}

TEST(StateModels, APartIsFoundByItsCubes)
{
    const auto a = shared(block(2, 0.1, Vec3::Zero())), b = shared(block(3, 0.2, Vec3(1, 0, 0)));
    const std::vector models{a, b};
    auto state = std::make_shared<State>();
    for (std::size_t k = 0; k < a->corner_count() + b->corner_count(); ++k) {
        state->x.emplace_back(double(k), 0, 0);
        state->v.emplace_back(0, double(k), 0);
    }
    for (std::size_t c = 0; c < a->count() + b->count(); ++c) {
        state->stress.push_back(float(c));
        state->plastic_strain.push_back(2 * float(c));
    }
    state->models = number_models(models);
    const auto part = state_of(state, *b);
    ASSERT_EQ(part->x.size(), b->corner_count());
    EXPECT_EQ(part->x[0].x(), double(a->corner_count()));
    EXPECT_EQ(part->v.back().y(), double(state->v.size() - 1));
    ASSERT_EQ(part->stress.size(), b->count());
    EXPECT_EQ(part->stress[0], float(a->count()));
    ASSERT_EQ(part->plastic_strain.size(), b->count());
    EXPECT_EQ(part->plastic_strain[0], 2 * float(a->count()));
    EXPECT_THROW(state_of(state, block(2, 0.1, Vec3(0, 0, 0.1))), std::invalid_argument);

    // Pins of the second model's corners.
    auto pins = std::make_shared<Pins>();
    pins->corner = {0, 4};
    pins->target.resize(2, Vec3::Zero());
    pins->cubes = mark_of(*b);
    const auto first = static_cast<std::uint32_t>(a->corner_count());
    EXPECT_EQ(pins_of_all(pins, state->models)->corner, (std::vector{first, first + 4}));
    pins->cubes = 1;
    EXPECT_THROW(pins_of_all(pins, state->models), std::invalid_argument);
}

TEST(StateModels, OneModelIsTheStateItself)
{
    const auto a = shared(block(2, 0.1, Vec3::Zero()));
    const auto state = std::make_shared<const State>();
    EXPECT_TRUE(number_models(std::vector{a}).empty());
    EXPECT_EQ(state_of(state, *a), state);
    EXPECT_EQ(state_of(nullptr, *a), nullptr);
    EXPECT_THROW(number_models(std::vector{a, shared(*a)}), std::invalid_argument);
}

}  // namespace
}  // namespace physics
