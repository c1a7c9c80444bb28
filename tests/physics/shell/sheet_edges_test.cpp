// Sheets on the edges and corners of colliders, which lie between the sheet's points.

#include "physics/body/collider_touches.hpp"
#include "physics/body/sheet_edges.hpp"

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "tests/physics/shell/shell_fixtures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double gravity = 9.81;
constexpr double cloth_thickness = 0.004;  // m

// A box whose top is at y = 0 and whose sides are turned about y.
Collider table(const Vec3& half, double degrees)
{
    Collider out;
    out.kind = Collider::Kind::box;
    out.half_size = half;
    out.pose = geometry::placement({0, -half.y(), 0}, {0, degrees, 0}, Vec3::Ones(), Vec3::Zero());
    out.before = out.pose;
    return out;
}

// The same as a mesh of squares.
Collider as_mesh(const Collider& box, int divisions)
{
    geometry::TriMesh mesh = geometry::box(2 * box.half_size, geometry::Vec3i::Constant(divisions));
    geometry::move(mesh, box.pose);
    Collider out;
    out.kind = Collider::Kind::mesh;
    out.mesh = std::make_shared<const geometry::TriMesh>(std::move(mesh));
    return out;
}

// Places on the edges of the box around its top, and the way out of it there.
struct EdgePlace {
    Vec3 p, out;
};
std::vector<EdgePlace> rim(const Collider& box)
{
    std::vector<EdgePlace> all;
    const Vec3 h = box.half_size;
    const auto add = [&](const Vec3& p, const Vec3& out) {
        all.push_back({box.pose * p, box.pose.linear() * out.normalized()});
    };
    for (int i = 0; i <= 60; ++i) {
        const double along = i / 30.0 - 1;
        for (const double side : {-1.0, 1.0}) {
            add({along * h.x(), h.y(), side * h.z()}, {0, 1, side});
            add({side * h.x(), h.y(), along * h.z()}, {side, 1, 0});
        }
    }
    for (const double x : {-1.0, 1.0}) {
        for (const double z : {-1.0, 1.0}) add({x * h.x(), h.y(), z * h.z()}, {x, 1, z});
    }
    return all;
}

// How far a triangle lies behind a place, against the way out, up to `most` (m); 0: it is not.
double behind(const EdgePlace& at, const std::array<Vec3, 3>& t, double most)
{
    const Vec3 u = t[1] - t[0], v = t[2] - t[0], n = u.cross(v);
    const double depth = n.dot(at.p - t[0]) / n.dot(at.out);
    if (!(depth > 0 && depth < most)) return 0;
    const Vec3 way = at.p - depth * at.out - t[0];
    const double b = n.dot(way.cross(v)) / n.dot(n), c = n.dot(u.cross(way)) / n.dot(n);
    return b >= 0 && c >= 0 && b + c <= 1 ? depth : 0;
}

// How far the box stands out of the sheet at its edges, and how many places are looked at that have
// the sheet before or behind them.
struct StandsOut {
    double most = 0;
    int covered = 0;
};
StandsOut stands_out(const Collider& box, const Cubes& cubes, const State& state)
{
    const geometry::TriMesh mesh = geometry::plane_mesh(cubes);
    StandsOut out;
    for (const EdgePlace& at : rim(box)) {
        double most = 0, before = 0;
        for (const auto& t : mesh.triangles()) {
            const std::array<Vec3, 3> p{state.x[t[0]], state.x[t[1]], state.x[t[2]]};
            most = std::max(most, behind(at, p, 0.5 * cubes.size));
            before = std::max(before, behind({at.p, -at.out}, p, 0.5 * cubes.size));
        }
        out.most = std::max(out.most, most);
        if (most > 0 || before > 0) ++out.covered;
    }
    return out;
}

double fastest(const State& state)
{
    double most = 0;
    for (const Vec3& v : state.v) most = std::max(most, v.norm());
    return most;
}

Cubes cloth(int ni, int nj, double a, double damping)
{
    return geometry::plane_cubes(geometry::rectangle_cells(ni, nj),
                                 {1, a, {-0.5 * a * ni, 0, -0.5 * a * nj}}, cloth_thickness,
                                 {"cloth", 300, 1e6, 0.3, damping, 0.002});
}

}  // namespace

// At a step a frame, of a cloth that is hardly damped. It takes 70 frames or up to 200, as rounding
// has it: the height is one from which it takes 70.
TEST(SheetEdges, AClothComesToRestOnATable)
{
    constexpr double a = 0.05;
    Cubes cubes =
        geometry::plane_cubes(geometry::rectangle_cells(30, 30), {1, a, {-0.75, 0.782, -0.75}},
                              0.003, {"cloth", 300, 2e5, 0.3, 0.5, 0.002});
    ShellOptions options;
    options.bend = 0.05;
    options.contact.self = true;
    const ShellBody body = make_shell(cubes, options);
    Loads loads;
    loads.forces = {weight({0, -gravity, 0})};
    Collider box;
    box.kind = Collider::Kind::box;
    box.half_size = {0.5, 0.025, 0.5};
    box.pose.translation() = Vec3(0, 0.725, 0);
    box.before = box.pose;
    box.friction = 0.4;
    loads.colliders = {box};
    State state = rest_state(body);
    for (int frame = 0; frame < 144; ++frame) {
        state = advance(body, std::move(state), loads, 1.0 / 24, {.contact_iterations = 60});
    }
    EXPECT_LT(fastest(state), 2e-3);
}

TEST(SheetEdges, ATableDoesNotStandOutOfItsCloth)
{
    constexpr double a = 0.05;
    const Cubes cubes = cloth(10, 10, a, 4);
    ShellOptions options;
    options.bend = 0.1;
    const ShellBody body = make_shell(cubes, options);
    const Collider box = table({0.15, 0.3, 0.12}, 25);
    for (const Collider& collider : {box, as_mesh(box, 7)}) {
        Loads loads;
        loads.forces = {weight({0, -gravity, 0})};
        loads.colliders = {collider};
        State state = rest_state(body);
        for (Vec3& x : state.x) x.y() += 0.01;
        for (int i = 0; i < 60; ++i) state = advance(body, state, loads, 1.0 / 24, {.substeps = 2});
        const StandsOut out = stands_out(box, cubes, state);
        EXPECT_GT(out.covered, 200);
        EXPECT_LT(out.most, 1e-4) << "at rest";
        EXPECT_LT(fastest(state), 1e-3);
    }
}

TEST(SheetEdges, ABoxThatIsDrivenUpIntoAHangingClothStaysBelowIt)
{
    // From 3 cm below it to 8 cm above, at 1 m/s; the cloth is held by two of its sides.
    constexpr double a = 0.05;
    const Cubes cubes = cloth(8, 8, a, 1);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.forces = {weight({0, -gravity, 0})};
    loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] == 0 || at[0] == 8; });
    Collider box = table({0.07, 0.1, 0.08}, 30);
    box.pose.translation().y() -= 0.03;
    loads.colliders = {box};
    State state = rest_state(body);
    for (int i = 0; i < 12; ++i) {
        Collider& now = loads.colliders[0];
        now.before = now.pose;
        if (i < 11) now.pose.translation().y() += 0.01;
        state = advance(body, state, loads, 0.01);
        EXPECT_LT(stands_out(now, cubes, state).most, 0.02 * a) << i;
    }
    EXPECT_GT(state.x[4 + 9 * 4].y(), 0.07);
}

TEST(SheetEdges, AClothOverAnEdgeHoldsAndSlidesAsFrictionLets)
{
    // Of a strip, a length lies on a table and the rest hangs down. The table's friction holds
    // mu w lying, and the edge multiplies that by e^(mu pi / 2) (Eytelwein): with mu = 0.4 the
    // strip holds up to 0.75 times as much hanging as lying. Cells are straight, so that it needs
    // about twice as much to come over the edge row by row; an edge that stood through it would
    // hold it for good.
    constexpr double a = 0.01, length = 0.24;
    const Cubes cubes = cloth(24, 2, a, 0);
    ShellOptions options;
    options.bend = 0.01;
    const ShellBody body = make_shell(cubes, options);
    Loads loads;
    loads.forces = {weight({0, -gravity, 0})};
    loads.colliders = {table({1, 1, 1}, 0)};
    loads.colliders[0].friction = 0.4;
    for (const double hanging : {0.085, 0.175}) {  // 0.55 and 2.7 of what lies
        State state = rest_state(body);
        for (Vec3& x : state.x) {
            const double over = x.x() - 0.5 * length + hanging;
            x = over < 0 ? Vec3(1 + over, 0.5 * cloth_thickness, x.z())
                         : Vec3(1 + 0.5 * cloth_thickness, -over, x.z());
        }
        const auto go = [&](int steps) {
            for (int i = 0; i < steps; ++i) state = advance(body, state, loads, 1.0 / 48);
            return state.x.front().x();
        };
        const double settled = go(48), way = go(12) - settled;
        if (hanging < 0.1) {
            EXPECT_LT(std::abs(way), 1e-5) << "it creeps";
        } else {
            EXPECT_GT(way, 0.005) << "it sticks";
        }
    }
}

// One cell over an edge of a large box, and over its corner: what is found against what is so.
TEST(SheetEdges, AreAsFarFromACellAsTheyAre)
{
    const Cubes cubes = cloth(1, 1, 0.1, 0);
    const ShellBody body = make_shell(cubes);
    const auto found = [&](const Collider& collider, const std::vector<Vec3>& at) {
        const std::vector<PosedCollider> posed{pose_collider(collider, 1, 1, 0.1, false, 0)};
        const Aligned<double> x = by_slot(body.base, at), v(x.size(), 0);
        return find_collider_touches(body.base, x.data(), v.data(), posed, {}, 0.01);
    };
    // The edge along z at (1, 0, z), the cell 1 cm behind it: its sides along x and the diagonal
    // cross that, 45 degrees down.
    const double s = std::sqrt(0.5);
    std::vector<Vec3> at;
    for (const auto& corner : cubes.corner) {
        const double along = corner[0] - 0.4;
        at.push_back(Vec3(1, 0, 0) - Vec3(s, s, 0) * 0.01 + Vec3(s, -s, 0) * 0.1 * along +
                     Vec3(0, 0, 0.1 * corner[2]));
    }
    const Collider box = table(Vec3::Ones(), 0);
    for (const Collider& collider : {box, as_mesh(box, 3)}) {
        int sides = 0;
        for (const PlaneTouch& touch : found(collider, at)) {
            if (touch.point < 4) continue;
            ++sides;
            EXPECT_NEAR(touch.gap(by_slot(body.base, at).data()), -0.01, 1e-6);
            EXPECT_NEAR((touch.normal - Vec3(s, s, 0)).norm(), 0, 1e-5);
        }
        EXPECT_EQ(sides, 3);
    }
    // The corner (1, 0, 1) in the middle of a triangle, 1 cm before the cell.
    const Vec3 n = Vec3::Ones().normalized(), u = Vec3(1, -1, 0).normalized(), w = n.cross(u);
    for (std::size_t k = 0; k < at.size(); ++k) {
        const double b = 0.1 * (cubes.corner[k][0] - 0.65), c = 0.1 * (cubes.corner[k][2] - 0.35);
        at[k] = Vec3(1, 0, 1) - 0.01 * n + b * u + c * w;
    }
    for (const Collider& collider : {box, as_mesh(box, 3)}) {
        int corners = 0;
        for (const PlaneTouch& touch : found(collider, at)) {
            if ((touch.normal - n).norm() > 1e-5) continue;
            ++corners;
            EXPECT_NEAR(touch.gap(by_slot(body.base, at).data()), -0.01, 1e-6);
        }
        EXPECT_EQ(corners, 1);
    }
}
