// What touches sheets of triangles: themselves, each other, colliders, wind and pressure.

#include "geometry/mesh/primitive.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/body/overlaps.hpp"
#include "physics/body/press_on.hpp"
#include "physics/body/sheet_crossings.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double sheet_thickness = 0.005;

// A tube along z of 0.6 m about, open at its ends, of soft rubber.
Cubes soft_tube()
{
    const double radius = 0.1;
    geometry::TriMesh mesh;
    constexpr int around = 24, along = 6;
    auto topology = std::make_shared<geometry::MeshTopology>();
    for (int j = 0; j <= along; ++j) {
        for (int i = 0; i < around; ++i) {
            const double angle = 2 * std::numbers::pi * i / around;
            mesh.positions.push_back(
                Vec3(radius * std::cos(angle), radius * std::sin(angle) + radius + 0.01, 0.026 * j)
                    .cast<float>());
        }
    }
    for (std::uint32_t j = 0; j < along; ++j) {
        for (std::uint32_t i = 0; i < around; ++i) {
            const std::uint32_t a = j * around + i, b = j * around + (i + 1) % around;
            topology->triangles.push_back({a, b, b + around});
            topology->triangles.push_back({a, b + around, a + around});
        }
    }
    mesh.topology = topology;
    Cubes out =
        geometry::make_sheet(mesh, sheet_thickness, {"rubber", 1000, 2e5, 0.3, 2, 0.005}).cubes;
    return out;
}

Collider floor_at(double height)
{
    Collider out;
    out.kind = Collider::Kind::plane;
    out.pose.translation() = Vec3(0, height, 0);
    out.before = out.pose;
    out.friction = 0.5;
    return out;
}

// Sides of triangles that go through triangles which have no corner of theirs: brute force.
int crossings_of(const Cubes& cubes, const State& state)
{
    int out = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto t = geometry::sheet_triangle(cubes, c);
        const Vec3 a = state.x[t[0]], u = state.x[t[1]] - a, v = state.x[t[2]] - a;
        for (std::size_t d = 0; d < cubes.count(); ++d) {
            const auto s = geometry::sheet_triangle(cubes, d);
            bool joined = false;
            for (const auto k : s) joined |= k == t[0] || k == t[1] || k == t[2];
            for (std::size_t i = 0; i < 3 && !joined; ++i) {
                const Vec3 from = state.x[s[i]], way = state.x[s[(i + 1) % 3]] - from;
                Eigen::Matrix3d m;
                m << u, v, -way;
                if (std::abs(m.determinant()) < 1e-18) continue;
                const Vec3 at = m.inverse() * (from - a);
                if (at.x() > 0 && at.y() > 0 && at.x() + at.y() < 1 && at.z() > 0 && at.z() < 1) {
                    ++out;
                }
            }
        }
    }
    return out;
}

}  // namespace

TEST(TriangleContact, ASheetLiesOnABall)
{
    const Cubes cubes = sheet_of(
        squares({10, 10, 0.05}, [](double x, double z) { return Vec3(x - 0.25, 0.22, z - 0.25); }),
        sheet_thickness, 0.3, 3e5, 300);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    Collider ball;
    ball.kind = Collider::Kind::sphere;
    ball.radius = 0.2;
    ball.friction = 0.6;
    loads.colliders = {ball};
    State state = rest_state(body);
    double deepest = 0;
    for (int frame = 0; frame < 24; ++frame) {
        state = advance(body, std::move(state), loads, 1.0 / 24, {.substeps = 2});
        for (const Vec3& x : state.x) deepest = std::max(deepest, ball.radius - x.norm());
    }
    EXPECT_LT(deepest, 0.05 * cubes.size);
    double highest = -1, lowest = 1;
    for (const Vec3& x : state.x) {
        highest = std::max(highest, x.y());
        lowest = std::min(lowest, x.y());
    }
    EXPECT_NEAR(highest, ball.radius + sheet_thickness / 2, 0.001);
    EXPECT_LT(lowest, 0.1);
}

TEST(TriangleContact, ATubeThatCollapsesLiesOnItselfAtItsThickness)
{
    const Cubes cubes = soft_tube();
    ShellOptions options;
    options.contact.self = true;
    options.bend = 0.05;
    const ShellBody body = make_shell(cubes, options);
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    loads.colliders = {floor_at(0)};
    State state = rest_state(body);
    for (int frame = 0; frame < 36; ++frame) {
        state = advance(body, std::move(state), loads, 1.0 / 24,
                        {.substeps = 4, .contact_iterations = 60});
        EXPECT_EQ(crossings_of(cubes, state), 0) << frame;
    }
    // The middle of its roof lies on the middle of its floor.
    double roof = 0, ground = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        const Vec3 p = cubes.corner_position(k);
        if (std::abs(p.x()) > 1e-6 || std::abs(p.z() - 0.078) > 1e-6) continue;
        (p.y() > 0.11 ? roof : ground) = state.x[k].y();
    }
    EXPECT_NEAR(roof - ground, sheet_thickness, 0.15 * sheet_thickness);
}

TEST(TriangleContact, TwoSheetsRestOnEachOther)
{
    const auto level = [](double y, double by) {
        return [=](double x, double z) { return Vec3(x + by, y, z + by); };
    };
    const Cubes large = sheet_of(squares({8, 8, 0.05}, level(0.001, 0)), sheet_thickness);
    const Cubes small = sheet_of(squares({4, 4, 0.05}, level(0.05, 0.083)), sheet_thickness);
    const BodyModel models[] = {{&large, nullptr}, {&small, nullptr}};
    const ShellBody body = make_shell(BodyModels(models, ModelKind::plane));
    Loads loads;
    loads.forces = {weight({0, -9.81, 0})};
    loads.colliders = {floor_at(0)};
    State state = rest_state(body);
    for (int frame = 0; frame < 24; ++frame) {
        state = advance(body, std::move(state), loads, 1.0 / 24,
                        {.substeps = 4, .contact_iterations = 60});
    }
    for (std::size_t k = large.corner_count(); k < state.x.size(); ++k) {
        EXPECT_NEAR(state.x[k].y(), 1.5 * sheet_thickness, 0.2 * sheet_thickness);
        EXPECT_LT(state.v[k].norm(), 0.02);
    }
}

// Grids that meet in their very corners, too.
TEST(TriangleContact, SheetsThatCrossAtRestAreFoundWhereTheyDo)
{
    const auto level = squares({4, 4, 0.05}, [](double x, double z) { return Vec3(x, 0, z); });
    const Cubes lying = sheet_of(level, sheet_thickness);
    for (const double by : {-0.1, -0.11, -0.3, 0.02}) {
        const auto upright = [&](double x, double y) { return Vec3(x, y + by, 0.1); };
        const Cubes standing = sheet_of(squares({4, 4, 0.05}, upright), sheet_thickness);
        const BodyModel models[] = {{&lying, nullptr}, {&standing, nullptr}};
        const ShellBody body = make_shell(BodyModels(models, ModelKind::plane));
        const auto found = sheet_crossings(body.base);
        const bool cross = by > -0.2 && by < 0;
        ASSERT_EQ(found.size(), cross ? 1u : 0u) << by;
        if (!cross) continue;
        EXPECT_EQ(found[0].models, std::pair(std::size_t{0}, std::size_t{1}));
        EXPECT_NEAR(found[0].place.y(), 0, 1e-7);
        EXPECT_NEAR(found[0].place.z(), 0.1, 1e-7);
        const std::shared_ptr<const Cubes> both[] = {std::make_shared<const Cubes>(lying),
                                                     std::make_shared<const Cubes>(standing)};
        const auto told = told_of_overlaps(both, body.base);
        ASSERT_EQ(told.size(), 1u);
        EXPECT_EQ(told[0].find("Sheets 1 and 2 cross each other at rest near ("), 0u) << told[0];
    }
}

// A strip that goes once round and through its own beginning.
TEST(TriangleContact, ASheetThatCrossesItselfAtRestIsFound)
{
    for (const bool crosses : {true, false}) {
        const auto winding = [&](double s, double z) {
            const double angle = 2 * std::numbers::pi * s;  // s from 0 to 1.25
            const double radius = 0.2 + (crosses ? 0.2 * (s - 0.55) * (s - 0.55) : 0.1 * s);
            return Vec3(radius * std::cos(angle), radius * std::sin(angle), z);
        };
        const Cubes cubes = sheet_of(squares({50, 4, 0.025}, winding), sheet_thickness);
        ShellOptions options;
        const auto count = [&](bool self) {
            options.contact.self = self;
            return sheet_crossings(make_shell(cubes, options).base).size();
        };
        EXPECT_EQ(count(true), crosses ? 1u : 0u);
        EXPECT_EQ(count(false), 0u);
    }
}

TEST(TriangleContact, WindTakesASheetOfTrianglesAsOneOfSquares)
{
    const Cubes triangles = sheet_of(squares({6, 4, 0.1}), sheet_thickness);
    const Cubes cells = sheet(6, 4, 0.1, sheet_thickness);
    Force wind;
    wind.kind = Force::Kind::wind;
    wind.velocity = {1, 3, 2};
    wind.air_density = 1.2;
    wind.drag = 1.1;
    std::array<Vec3, 2> push;
    std::size_t at = 0;
    for (const Cubes* cubes : {&triangles, &cells}) {
        const ShellBody body = make_shell(*cubes);
        const Aligned<double> v(body.base.numbers, 0);
        Aligned<double> f(body.base.numbers, 0), drag(body.base.numbers, 0);
        add_wind(body.base, {&wind, 1}, body.base.rest.data(), v.data(), f, drag);
        push[at] = Vec3::Zero();
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            push[at] += Eigen::Map<const Vec3>(f.data() + 4 * k);
        }
        ++at;
    }
    EXPECT_GT(push[1].norm(), 1);
    EXPECT_LT((push[0] - push[1]).norm(), 1e-5 * push[1].norm());
}

TEST(TriangleContact, ABalloonGrowsByItsPressure)
{
    // A thin ball under pressure p has the stress p R / 2 h both ways: it grows by
    // p R (1 - nu) / (2 E h) of its radius.
    constexpr double radius = 0.5, thickness = 0.002, young = 1e6, nu = 0.3, pressure = 50;
    const geometry::TriMesh mesh = geometry::icosphere(radius, 3);
    const Cubes cubes =
        geometry::make_sheet(mesh, thickness, {"skin", 1000, young, nu, 20, 0.01}).cubes;
    const ShellBody body = make_shell(cubes);
    Force force;
    force.kind = Force::Kind::pressure;
    force.pressure = -pressure;  // from within
    force.surface = std::make_shared<PressedSurface>(press_on(cubes, mesh, "").surface);
    Loads loads;
    loads.forces = {force};
    State state = rest_state(body);
    for (int frame = 0; frame < 24; ++frame) {
        state = advance(body, std::move(state), loads, 1.0 / 24);
    }
    double mean = 0;
    for (const Vec3& x : state.x) mean += x.norm() / double(state.x.size());
    const double grows = pressure * radius * (1 - nu) / (2 * young * thickness);
    EXPECT_NEAR(mean / radius - 1, grows, 0.03 * grows);
}

TEST(TriangleContact, LayersThatLieCloserThanTheirThicknessAtRestDoNotPushEachOther)
{
    // A hem: two layers of 2 mm, 1 mm apart, joined along a rim, whose vertices do not face.
    const Squares grid{4, 4, 0.05, Cut::alike, 0};
    geometry::TriMesh mesh = squares(grid);
    const geometry::TriMesh upper =
        squares(grid, [](double x, double z) { return Vec3(x + 0.0225, 0.001, z + 0.0225); });
    const auto n = static_cast<std::uint32_t>(mesh.positions.size());
    auto topology = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    mesh.positions.insert(mesh.positions.end(), upper.positions.begin(), upper.positions.end());
    for (auto t : upper.triangles()) {
        for (auto& v : t) v += n;
        topology->triangles.push_back(t);
    }
    for (std::uint32_t i = 0; i < 4; ++i) {
        topology->triangles.push_back({i, i + 1, i + n});
        topology->triangles.push_back({i + 1, i + 1 + n, i + n});
    }
    mesh.topology = topology;
    const Cubes cubes = sheet_of(mesh, 0.002);
    ShellOptions options;
    options.contact.self = true;
    const ShellBody body = make_shell(cubes, options);
    State state = rest_state(body);
    const State before = state;
    for (int frame = 0; frame < 5; ++frame) {
        state = advance(body, std::move(state), {}, 1.0 / 24, {.sleep = false});
    }
    double most = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        most = std::max(most, (state.x[k] - before.x[k]).norm());
    }
    EXPECT_LT(most, 1e-6);
}

TEST(TriangleContact, APointForceActsWhereItIs)
{
    const Cubes cubes = sheet_of(squares({8, 8, 0.1}), sheet_thickness);
    const ShellBody body = make_shell(cubes);
    Force force;
    force.kind = Force::Kind::point;
    force.force = {0, 1, 0};
    for (const Vec3& at : {Vec3(0.53, 0, 0.53), Vec3(0.5333, 0, 0.4667), Vec3(0.8, 0, 0.35)}) {
        for (const double radius : {0.0, 0.02, 0.05, 0.15}) {
            if (at.x() > 0.7 && radius > 0) continue;  // a part of it would lie beyond the rim
            force.position = at;
            force.radius = radius;
            Aligned<double> f(body.base.numbers, 0);
            add_steady_forces(body.base, {&force, 1}, f);
            Vec3 centre = Vec3::Zero();
            double sum = 0;
            for (std::size_t k = 0; k < body.base.corners; ++k) {
                sum += f[4 * k + 1];
                centre += f[4 * k + 1] * cubes.corner_position(k);
            }
            EXPECT_NEAR(sum, 1, 1e-9);
            EXPECT_LT((centre - at).norm(), 1e-6 + 0.02 * radius) << radius;
        }
    }
}
