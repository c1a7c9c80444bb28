// Sheets that touch themselves and each other.

#include "physics/body/sheet_contact.hpp"
#include "tests/physics/shell/shell_fixtures.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <numbers>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double g = 9.81;

ShellOptions that_touch(double friction = 0.3)
{
    ShellOptions out;
    out.contact.self = true;
    out.contact.friction = friction;
    return out;
}

bool goes_through(const Vec3& a, const Vec3& b, const std::array<Vec3, 3>& t)
{
    const Vec3 n = (t[1] - t[0]).cross(t[2] - t[0]);
    const double from = n.dot(a - t[0]), to = n.dot(b - t[0]);
    if ((from > 0) == (to > 0)) return false;
    const Vec3 x = a + from / (from - to) * (b - a);
    for (std::size_t i = 0; i < 3; ++i) {
        if (n.dot((t[(i + 1) % 3] - t[i]).cross(x - t[i])) <= 0) return false;
    }
    return true;
}

// Triangles that a side of another one goes through which has no corner of theirs: brute force.
int crossings(const ShellBody& body, const State& state)
{
    const auto& triangles = body.base.sheets->triangle;
    int out = 0;
    for (const auto& t : triangles) {
        const std::array<Vec3, 3> at{state.x[t[0]], state.x[t[1]], state.x[t[2]]};
        for (const auto& s : triangles) {
            bool joined = false;
            for (const auto k : s) joined |= k == t[0] || k == t[1] || k == t[2];
            for (std::size_t i = 0; i < 3 && !joined; ++i) {
                if (goes_through(state.x[s[i]], state.x[s[(i + 1) % 3]], at)) ++out;
            }
        }
    }
    return out;
}

double farthest(const State& a, const State& b)
{
    double most = 0;
    for (std::size_t k = 0; k < a.x.size(); ++k) most = std::max(most, (a.x[k] - b.x[k]).norm());
    return most;
}

double deepest(const State& state)
{
    double most = 0;
    for (const Grip& grip : state.grips) most = std::max(most, double(grip.depth));
    return most;
}

Vec3 momentum_of(const ShellBody& body, const State& state)
{
    Vec3 out = Vec3::Zero();
    for (std::size_t k = 0; k < state.v.size(); ++k) out += body.base.mass[k] * state.v[k];
    return out;
}

Vec3 moment_of(const ShellBody& body, const State& state)
{
    Vec3 out = Vec3::Zero();
    for (std::size_t k = 0; k < state.v.size(); ++k) {
        out += body.base.mass[k] * state.x[k].cross(state.v[k]);
    }
    return out;
}

// Two sheets of one plane, the small one of 3 by 3 cells `above` the middle of the large one, which
// has 5 by 5 or more, and turned, so that no edges are parallel.
constexpr double cell = 0.05, thick = 0.004;
Cubes two_pieces(int large = 5)
{
    auto cells = geometry::rectangle_cells(large, large);
    for (const auto& [i, j] : geometry::rectangle_cells(3, 3)) cells.push_back({i + 20, j});
    return geometry::plane_cubes(cells, {1, cell, {0, 0, 0}}, thick,
                                 {"sheet", 500, 1e7, 0.3, 0, 0});
}
bool is_small(const Cubes& cubes, std::size_t k)
{
    return cubes.corner[k].x() >= 20;
}
State one_above(const Cubes& cubes, const ShellBody& body, double above)
{
    State out = rest_state(body);
    const Eigen::AngleAxisd turn(0.4, Vec3::UnitY());
    for (std::size_t k = 0; k < out.x.size(); ++k) {
        if (!is_small(cubes, k)) continue;
        const Vec3 from_middle = out.x[k] - cell * Vec3(21.5, 0, 1.5);
        out.x[k] = cell * Vec3(2.5, 0, 2.5) + turn * from_middle + Vec3(0, above, 0);
    }
    return out;
}

}  // namespace

TEST(SheetContact, PiecesThatCollideKeepTheirMomenta)
{
    const Cubes cubes = two_pieces();
    const ShellBody body = make_shell(cubes, that_touch());
    State state = one_above(cubes, body, 0.1);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (is_small(cubes, k)) state.v[k] = {1, -3, 0.5};
    }
    const Vec3 before = momentum_of(body, state), moment = moment_of(body, state);
    bool met = false;
    for (int i = 0; i < 8; ++i) {
        state = advance(body, state, {}, 1.0 / 48);
        met |= deepest(state) > 0;
        EXPECT_LT((momentum_of(body, state) - before).norm(), 1e-12 * before.norm());
        EXPECT_LT((moment_of(body, state) - moment).norm(), 1e-12 * moment.norm());
    }
    EXPECT_TRUE(met);
    EXPECT_EQ(crossings(body, state), 0);
    // The small one took the large one along.
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (!is_small(cubes, k)) {
            EXPECT_LT(state.v[k].y(), -0.01);
        }
    }
}

TEST(SheetContact, StopsWhatComesAtThirtyMetresASecond)
{
    // In one step of 1/24 s it would go 1.25 m, 25 cells, and through the other after 8 cells.
    const Cubes cubes = two_pieces();
    const ShellBody body = make_shell(cubes, that_touch());
    Loads loads;
    loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] < 6; });
    State state = one_above(cubes, body, 0.4);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (is_small(cubes, k)) state.v[k] = {0, -30, 0};
    }
    for (int i = 0; i < 4; ++i) {
        state = advance(body, state, loads, 1.0 / 24);
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            if (is_small(cubes, k)) {
                EXPECT_GT(state.x[k].y(), 0) << i;
            }
        }
    }
    EXPECT_EQ(crossings(body, state), 0);
}

TEST(SheetContact, ACardThatSpinsBesideASheetStaysOnItsSide)
{
    // Its rim, 0.15 m from its middle, is 1 cm before the sheet. At 10 rad/s and 1/24 s a step, the
    // stage of a free spin starts sqrt(1 + (10 / 24)^2) times as far out: 2.5 mm behind the sheet.
    const Cubes card =
        geometry::plane_cubes(geometry::rectangle_cells(6, 6), {1, cell, {-0.15, 0, -0.15}}, thick,
                              {"card", 500, 1e8, 0.3, 0, 0});
    const Cubes held =
        geometry::plane_cubes(geometry::rectangle_cells(8, 8), {0, cell, {0.16, -0.21, -0.19}},
                              thick, {"sheet", 500, 1e8, 0.3, 0, 0});
    const ShellBody body =
        make_shell(BodyModels(std::vector<BodyModel>{{&card}, {&held}}, ModelKind::plane));
    State state = rest_state(body);
    Loads loads;
    for (auto k = static_cast<std::uint32_t>(card.corner_count()); k < state.x.size(); ++k) {
        loads.pins.corner.push_back(k), loads.pins.target.push_back(state.x[k]);
    }
    for (std::size_t k = 0; k < card.corner_count(); ++k) {
        state.v[k] = Vec3(0, 0, 10).cross(state.x[k]) + Vec3(0.05, 0, 0);
    }
    // It touches nothing in the first step.
    const ShellBody apart =
        make_shell(BodyModels(std::vector<BodyModel>{{&card}, {&held}}, ModelKind::plane), [] {
            ShellOptions out;
            out.contact.on = false;
            return out;
        }());
    EXPECT_LT(
        farthest(advance(body, state, loads, 1.0 / 24), advance(apart, state, loads, 1.0 / 24)),
        1e-9);
    bool met = false;
    for (int i = 0; i < 12; ++i) {
        state = advance(body, state, loads, 1.0 / 24);
        met |= deepest(state) > 0;
        EXPECT_EQ(crossings(body, state), 0) << i;
        for (std::size_t k = 0; k < card.corner_count(); ++k) EXPECT_LT(state.x[k].x(), 0.16) << i;
    }
    EXPECT_TRUE(met);
}

TEST(SheetContact, AnEdgeLiesOnAnEdge)
{
    // Two upright sheets at right angles: the lower edge of the one crosses the upper edge of the
    // other, which is held, in the middle. No point of either comes near a cell of the other.
    const auto upright = [](int axis, const Vec3& origin) {
        return geometry::plane_cubes({{0, 0}, {1, 0}, {2, 0}}, {axis, 0.1, origin}, thick,
                                     {"sheet", 500, 1e7, 0.3, 0, 0});
    };
    const Cubes held = upright(2, {0, -0.1, 0}), falls = upright(0, {0.15, 0.01, -0.15});
    const ShellBody body =
        make_shell(BodyModels(std::vector<BodyModel>{{&held}, {&falls}}, ModelKind::plane));
    Loads loads;
    loads.pins = held_where(held, [](const Vec3i&) { return true; });
    loads.forces = {weight({0, -g, 0})};
    State state = rest_state(body);
    for (int i = 0; i < 6; ++i) state = advance(body, state, loads, 1.0 / 24);
    double lowest = 1;
    for (std::size_t k = held.corner_count(); k < state.x.size(); ++k) {
        lowest = std::min(lowest, state.x[k].y());
    }
    EXPECT_NEAR(lowest, thick, 0.1 * thick);  // in free fall it would be at -0.3 m
}

TEST(SheetContact, SlidesOnASheetAsFrictionLets)
{
    // As on a collider: a = g (sin 30 - 0.3 cos 30), and with mu = 0.7 above tan 30 it stays.
    const double down = g / 2, into = g * std::sqrt(0.75), seconds = 0.25;
    for (const double friction : {0.3, 0.7}) {
        const Cubes cubes = two_pieces();
        const ShellBody body = make_shell(cubes, that_touch(friction));
        Loads loads;
        loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] < 6; });
        loads.forces = {weight({down, -into, 0})};
        State state = one_above(cubes, body, thick);
        const State before = state;
        for (int i = 0; i < 12; ++i) state = advance(body, state, loads, seconds / 12);
        const double expected = seconds * std::max(0.0, down - friction * into);
        double mean = 0;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            if (is_small(cubes, k)) mean += state.v[k].x() / 16;
        }
        EXPECT_NEAR(mean, expected, 0.03 * seconds * down) << friction;
        EXPECT_LT(deepest(state), 0.1 * thick);
        if (friction > 0.6) {
            EXPECT_LT(farthest(before, state), 0.1 * thick);
        }
    }
}

TEST(SheetContact, StaysUpWhileItSlidesFromCellToCell)
{
    // At 240 steps a second, over cells of 0.0125 m at 1 to 2 m/s: each point crosses a side of a
    // triangle every other step, and must not sink in at each. With twenty times its weight on it
    // it becomes firmer from a twentieth of the thickness on.
    constexpr double a = 0.0125;
    const Cubes large = sheet(40, 5, a, thick), small = [&] {
        Cubes out = sheet(3, 2, a, thick);
        out.origin = {0.01, thick, 0.02};
        return out;
    }();
    const ShellBody body = make_shell(
        BodyModels(std::vector<BodyModel>{{&large}, {&small}}, ModelKind::plane), that_touch(0));
    Loads loads;
    loads.pins = held_where(large, [](const Vec3i&) { return true; });
    loads.forces = {weight({0, -20 * g, 0})};
    State state = rest_state(body);
    for (std::size_t k = large.corner_count(); k < state.x.size(); ++k) state.v[k] = {1.8, 0, 0.03};
    for (int i = 0; i < 48; ++i) {
        state = advance(body, state, loads, 1.0 / 240);
        EXPECT_LT(deepest(state), 0.08 * thick) << i;
    }
    EXPECT_GT(state.x[large.corner_count()].x(), 0.36);
}

TEST(SheetContact, PiecesTouchWhereTheyAreNeighboursOnTheGrid)
{
    // Two pieces of one column each, a column apart: one falls on the other, which is held.
    const Cubes cubes =
        geometry::plane_cubes({{0, 0}, {0, 1}, {0, 2}, {2, 0}, {2, 1}, {2, 2}},
                              {1, cell, {0, 0, 0}}, thick, {"sheet", 500, 1e7, 0.3, 0, 0});
    const ShellBody body = make_shell(cubes, that_touch());
    Loads loads;
    loads.pins = held_where(cubes, [](const Vec3i& at) { return at[0] < 2; });
    loads.forces = {weight({0, -g, 0})};
    State state = rest_state(body);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (cubes.corner[k].x() >= 2) state.x[k] += Vec3(-2.01 * cell, 2 * thick, 0);
    }
    for (int i = 0; i < 6; ++i) state = advance(body, state, loads, 1.0 / 24);
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        if (cubes.corner[k].x() >= 2) {
            EXPECT_NEAR(state.x[k].y(), thick, 0.1 * thick);  // in free fall at -0.3 m
        }
    }
}

TEST(SheetContact, WhatAllPointsHaveInCommonBringsNothingNearer)
{
    const Cubes cubes = two_pieces();
    const ShellBody body = make_shell(cubes, that_touch());
    const auto x0 = by_slot(body.base, one_above(cubes, body, 2 * thick).x);
    const auto touches = [&](const Vec3& way) {
        Aligned<double> x1 = x0;
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            Eigen::Map<Vec3>(x1.data() + 4 * k) += way;
        }
        std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
        for (const auto& t : find_sheet_touches(body.base, {x0.data(), x1.data(), 0.04, {}}, {})) {
            out.emplace_back(t.point, t.other);
        }
        return out;
    };
    const auto still = touches({0, 0, 0});
    EXPECT_GT(still.size(), 16u);  // each point of the small one, and edges
    EXPECT_EQ(touches({0.5, -1, 0.25}), still);
}

TEST(SheetContact, SheetsOfDifferentCellsMoveAsEachDoesAlone)
{
    // Far apart, each pinned along a row, they have nothing in common but the steps.
    const Cubes coarse = sheet(3, 3, 0.1, 0.01), fine = [] {
        Cubes out = sheet(4, 4, 0.02, 0.002);
        out.origin = {5, 0, 0};
        return out;
    }();
    const std::array<const Cubes*, 2> each{&coarse, &fine};
    const auto start = [](const ShellBody& body) {
        State out = rest_state(body);
        for (std::size_t k = 0; k < out.x.size(); ++k) out.v[k] = {0, 0.3, 0};
        return out;
    };
    const auto run = [&](const ShellBody& body, const Pins& pins) {
        Loads loads;
        loads.pins = pins;
        loads.forces = {weight({0, -g, 0})};
        State state = start(body);
        const StepOptions exact{.newton_iterations = 40, .tolerance = 1e-10};
        for (int i = 0; i < 6; ++i) state = advance(body, state, loads, 1.0 / 24, exact);
        return state;
    };
    const ShellBody both =
        make_shell(BodyModels(std::vector<BodyModel>{{&coarse}, {&fine}}, ModelKind::plane));
    const auto row = [](const Vec3i& at) { return at[0] == 0; };
    std::array<Pins, 2> pins{held_where(coarse, row), held_where(fine, row)};
    Pins all = pins[0];
    for (std::size_t p = 0; p < pins[1].corner.size(); ++p) {
        all.corner.push_back(pins[1].corner[p] + static_cast<std::uint32_t>(coarse.corner_count()));
        all.target.push_back(pins[1].target[p]);
    }
    const State together = run(both, all);
    std::size_t first = 0;
    for (std::size_t m = 0; m < 2; ++m) {
        const State alone = run(make_shell(*each[m]), pins[m]);
        for (std::size_t k = 0; k < alone.x.size(); ++k) {
            EXPECT_LT((together.x[first + k] - alone.x[k]).norm(), 1e-6 * each[m]->size) << m;
        }
        first += alone.x.size();
    }
}

TEST(SheetContact, AStripThatFallsOnItsEdgeComesToRestInFolds)
{
    // 0.6 m of it, upright and slightly bent, so that it buckles and piles up.
    constexpr double a = 0.0375;
    const Cubes cubes = geometry::plane_cubes(geometry::rectangle_cells(16, 2), {1, a, {0, 0, 0}},
                                              thick, {"strip", 500, 2e5, 0.3, 1, 0.002});
    const ShellBody body = make_shell(cubes, that_touch());
    Loads loads;
    loads.forces = {weight({0, -g, 0})};
    loads.colliders.resize(1);
    State state = rest_state(body);
    for (Vec3& x : state.x) x = {1e-3 * std::sin(3 * x.x()) + 0.002 * x.z(), 0.02 + x.x(), x.z()};
    State before = state;
    bool touched = false;
    for (int i = 0; i < 36; ++i) {
        before = state;
        state = advance(body, state, loads, 1.0 / 24, {.substeps = 2});
        EXPECT_EQ(crossings(body, state), 0) << i;
        touched |= deepest(state) > 0;
    }
    EXPECT_TRUE(touched);
    EXPECT_LT(farthest(before, state), 1e-3);
    EXPECT_LT(deepest(state), 0.1 * thick);
}

TEST(SheetContact, SheetsOfSeveralModelsTouch)
{
    // A small sheet of finer cells comes to rest on a large one that is held, half of the one and
    // half of the other thickness above it. Without contact it falls on.
    const Cubes large = sheet(4, 4, 0.1, 0.01), small = [&] {
        Cubes out = sheet(3, 3, 0.04, 0.004);
        out.origin = {0.13, 0.012, 0.14};
        return out;
    }();
    const BodyModels models(std::vector<BodyModel>{{&large}, {&small}}, ModelKind::plane);
    const ShellBody body = make_shell(models);
    Loads loads;
    loads.pins = held_where(large, [](const Vec3i&) { return true; });
    loads.forces = {weight({0, -g, 0})};
    State state = rest_state(body);
    for (int i = 0; i < 12; ++i) state = advance(body, state, loads, 1.0 / 24);
    for (std::size_t k = large.corner_count(); k < state.x.size(); ++k) {
        EXPECT_NEAR(state.x[k].y(), 0.007, 0.1 * 0.007);
    }
    ShellOptions off;
    off.contact.on = false;
    State fallen = rest_state(body);
    const ShellBody loose = make_shell(models, off);
    for (int i = 0; i < 12; ++i) fallen = advance(loose, fallen, loads, 1.0 / 24);
    EXPECT_LT(fallen.x.back().y(), -0.5);
}

TEST(SheetContact, GivesTheSameBytesForAnyNumberOfThreads)
{
    const Cubes cubes = two_pieces(18);  // 333 cells: several tasks
    const ShellBody body = make_shell(cubes, that_touch());
    const auto run = [&](std::size_t threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        State state = one_above(cubes, body, 0.005);
        Loads loads;
        loads.forces = {weight({0, -g, 0})};
        loads.colliders.resize(1);
        for (int i = 0; i < 2; ++i) state = advance(body, state, loads, 1.0 / 24);
        return state;
    };
    const State one = run(1), two = run(2);
    EXPECT_EQ(one.x, two.x);
    EXPECT_EQ(one.v, two.v);
}
