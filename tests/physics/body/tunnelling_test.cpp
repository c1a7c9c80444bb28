// Small things thrown at thin things: boxes, meshes with an inside, sheets, standing and moving.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/body/collider_contact.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <numbers>
#include <numeric>

namespace {

using namespace physics;
using geometry::Transform;
using geometry::TriMesh;

constexpr double frame_time = 1.0 / 24;

enum class Wall { box, mesh, front, back };

// A wall of 2 mm or a sheet across x = 0 at the start, and `speed` (m/s) along x; it is 400 m wide,
// so that nothing passes beside it.
class Walls {
public:
    Walls(Wall kind, double speed) : kind_(kind), speed_(speed)
    {
        const Transform turned(
            Eigen::AngleAxisd((kind == Wall::back ? -1 : 1) * std::numbers::pi / 2, Vec3::UnitZ()));
        shape_ = kind == Wall::mesh ? geometry::box({0.002, 400, 400}, {1, 1, 1})
                                    : geometry::grid(400, 400, 1, 1);
        if (kind == Wall::mesh) return;
        for (auto& p : shape_.positions) p = (turned * p.cast<double>()).cast<float>();
    }

    // For the frame that ends at `seconds`.
    Collider at(double seconds) const
    {
        Collider out;
        out.friction = 0.3;
        if (kind_ == Wall::box) {
            out.kind = Collider::Kind::box;
            out.half_size = Vec3(0.001, 200, 200);
            out.pose = Transform(Eigen::Translation3d(speed_ * seconds, 0, 0));
            out.before = Transform(Eigen::Translation3d(speed_ * (seconds - frame_time), 0, 0));
            return out;
        }
        out.kind = Collider::Kind::mesh;
        out.sheet = kind_ != Wall::mesh;
        out.mesh = moved(seconds);
        out.mesh_before = speed_ == 0 ? nullptr : moved(seconds - frame_time);
        return out;
    }

private:
    std::shared_ptr<const TriMesh> moved(double seconds) const
    {
        auto out = std::make_shared<TriMesh>(shape_);
        for (auto& p : out->positions) p.x() += static_cast<float>(speed_ * seconds);
        return out;
    }

    Wall kind_;
    double speed_;
    TriMesh shape_;
};

// How far beyond the wall the middle of a body's outside comes in 10 frames of one step, m. Corners
// within touch nothing, and those of a lattice go on for a step.
template <class Body>
double beyond(const Body& body, State state, const std::vector<std::uint32_t>& outside,
              const Walls& walls, double wall)
{
    double most = -std::numeric_limits<double>::infinity();
    for (int i = 1; i <= 10; ++i) {
        Loads loads;
        loads.colliders.push_back(walls.at(i * frame_time));
        state = advance(body, state, loads, frame_time, StepOptions{});
        double mean = 0;
        for (const auto k : outside) mean += state.x[k].x() / double(outside.size());
        most = std::max(most, mean - wall * i * frame_time);
    }
    return most;
}

// At the wall, not through it, and not still in the air.
void arrives(double most_beyond, const std::string& what)
{
    EXPECT_LT(most_beyond, 0.03) << what;
    EXPECT_GT(most_beyond, -0.2) << what;
}

TEST(Tunnelling, NothingGetsThroughAThinWall)
{
    const auto cubes = fixtures::box(3, 3, 3, 0.05, {.young = 1e6, .stiffness_damping = 0.001});
    const auto outside = fixtures::corners_where(
        cubes, [](const auto& c) { return (c.array() == 0).any() || (c.array() == 3).any(); });
    const BricksBody bricks = make_bricks(cubes);
    const SpringsBody springs = make_springs(cubes);
    const LatticeBody lattice = make_lattice(cubes);
    for (const Wall kind : {Wall::box, Wall::mesh, Wall::front, Wall::back}) {
        for (const double wall : {0.0, -6.0}) {
            const Walls walls(kind, wall);
            for (const double speed : {5.0, 30.0, 150.0, 500.0}) {
                State state = rest_state(bricks);
                const auto turn = Eigen::AngleAxisd(0.6, Vec3(1, 2, 3).normalized());
                for (Vec3& p : state.x) p = turn * p - Vec3(0.4 + 0.03 * speed, 0, 0);
                for (Vec3& v : state.v) v = Vec3(speed, -0.3 * speed, 0.1 * speed);
                const auto what = fmt::format("wall {} at {} m/s, body at {} m/s",
                                              static_cast<int>(kind), wall, speed);
                arrives(beyond(bricks, state, outside, walls, wall), "bricks " + what);
                arrives(beyond(springs, state, outside, walls, wall), "springs " + what);
                if (speed < 100) {
                    arrives(beyond(lattice, state, outside, walls, wall), "lattice " + what);
                }
            }
        }
    }
}

// What the wall pushes back at the first guess, metres into it, is no measure for what may be left
// unbalanced: of a share of that, the body could stop in the air.
TEST(Tunnelling, WhatComesFarInAStepStopsAtTheWall)
{
    const auto cubes = fixtures::box(4, 4, 4, 0.05, {.density = 1000, .young = 3.5e6});
    const SpringsBody springs = make_springs(cubes);
    std::vector<std::uint32_t> all(cubes.corner_count());
    std::iota(all.begin(), all.end(), 0);
    State state = rest_state(springs);
    const auto turn = Eigen::AngleAxisd(1.2, Vec3(1, 2, 3).normalized());
    for (Vec3& p : state.x) p = turn * p - Vec3(1.65, 0, 0);
    for (Vec3& v : state.v) v = Vec3(46.3, -31.3, -0.6);
    arrives(beyond(springs, state, all, Walls(Wall::box, 0), 0), "springs at 56 m/s");
}

// A point 3 mm behind the wall of a box 4 mm thick, nearest to its far side.
TEST(Tunnelling, WhatHeldAPointTellsItsSide)
{
    Collider plate;
    plate.kind = Collider::Kind::box;
    plate.half_size = Vec3(1, 0.002, 1);
    const PosedCollider posed = pose_collider(plate, 1, frame_time, 0.05);
    const Vec3 p(0.1, -0.001, 0.2);
    EXPECT_NEAR(touch(posed, p, Vec3::Zero(), frame_time).normal.y(), -1, 1e-12);
    const Grip held{0, 0, {}, Eigen::Vector3f::UnitY(), 0.003f};
    const Touch t = touch(posed, p, Vec3::Zero(), frame_time, &held);
    EXPECT_NEAR(t.normal.y(), 1, 1e-12);
    EXPECT_NEAR(t.gap, -0.003, 1e-9);
}

TEST(Tunnelling, ASheetHasTwoSidesButForWhatStartsALittleBehindIt)
{
    Collider sheet;
    sheet.kind = Collider::Kind::mesh;
    sheet.sheet = true;
    sheet.mesh = std::make_shared<const TriMesh>(geometry::grid(2, 2, 3, 3));
    const auto gap = [&](bool first, double y, double up) {
        const PosedCollider posed = pose_collider(sheet, 1, frame_time, 0.05, first);
        const Touch t = touch(posed, Vec3(0.1, y + up * frame_time, 0), Vec3(0, up, 0), frame_time);
        return t.gap * t.normal.y();  // below 0 where it is to go down
    };
    EXPECT_NEAR(gap(false, -0.04, 0), -0.04, 1e-6);    // before its back
    EXPECT_NEAR(gap(false, -0.04, 2.4), 0.06, 1e-6);   // went 6 cm up through it: is to go down
    EXPECT_NEAR(gap(false, 0.04, -2.4), -0.06, 1e-6);  // down: is to go up
    EXPECT_NEAR(gap(true, -0.04, 0), -0.04, 1e-6);     // inside, as it starts
    const Touch inside = touch(pose_collider(sheet, 1, frame_time, 0.05, true), Vec3(0.1, -0.04, 0),
                               Vec3::Zero(), frame_time);
    EXPECT_LT(inside.gap, 0);
    EXPECT_NEAR(gap(true, -0.3, 12), 0.2, 1e-6);  // from far behind
}

// In the first frame a sheet goes 8 cm down, its front up, towards a point that stands behind it.
TEST(Tunnelling, ASheetTakesToItsFrontOnlyWhatStartsALittleBehindIt)
{
    Collider sheet;
    sheet.kind = Collider::Kind::mesh;
    sheet.sheet = true;
    TriMesh mesh = geometry::grid(2, 2, 3, 3);
    sheet.mesh_before = std::make_shared<const TriMesh>(mesh);
    for (auto& p : mesh.positions) p.y() -= 0.08f;
    sheet.mesh = std::make_shared<const TriMesh>(mesh);
    const auto at = [&](double y, double share, double dt) {
        const PosedCollider posed = pose_collider(sheet, share, frame_time, 0.05, true);
        return touch(posed, Vec3(0.1, y, 0), Vec3::Zero(), dt);
    };
    for (const int steps : {1, 4}) {
        for (int k = 1; k <= steps; ++k) {
            const double share = double(k) / steps, dt = frame_time / steps;
            // It starts 9 cm behind, within two cubes of 5 cm, and is to come to the front.
            const Touch near = at(-0.09, share, dt);
            EXPECT_NEAR(near.normal.y(), 1, 1e-6) << k;
            EXPECT_NEAR(near.gap, -0.09 + 0.08 * share, 1e-6) << k;
            // It starts 12 cm behind, and the sheet comes to 4 cm: it stays before the back.
            EXPECT_GT(at(-0.12, share, dt).gap, 0) << k;
        }
    }
}

// A valley of two slopes, and blocks that slide down one and up the other: from step to step their
// points come behind the next face by more than they were behind the last.
TEST(Tunnelling, WhatSlidesOverACreaseStaysAboveTheSheet)
{
    TriMesh valley = geometry::grid(8, 8, 2, 1);
    for (auto& p : valley.positions) p.y() = 0.3f * std::abs(p.x());
    Loads loads;
    loads.forces.push_back({});
    Collider sheet;
    sheet.kind = Collider::Kind::mesh;
    sheet.mesh = std::make_shared<const TriMesh>(valley);
    sheet.friction = 0;
    sheet.sheet = true;
    loads.colliders.push_back(sheet);
    const auto cubes = fixtures::box(4, 2, 3, 0.05, {.young = 1e6, .stiffness_damping = 0.002});
    const auto lowest_of = [&](State state, const auto& body, int substeps) {
        for (Vec3& p : state.x) p += Vec3(-0.9, 0.29, -0.1);
        double lowest = 1;
        for (int i = 0; i < 60; ++i) {
            state = advance(body, state, loads, frame_time, StepOptions{.substeps = substeps});
            for (const Vec3& p : state.x) {
                lowest = std::min(lowest, p.y() - 0.3 * std::abs(p.x()));
            }
        }
        return lowest;
    };
    const BricksBody bricks = make_bricks(cubes);
    const LatticeBody lattice = make_lattice(cubes);
    for (const int substeps : {1, 4}) {
        EXPECT_GT(lowest_of(rest_state(bricks), bricks, substeps), -0.03) << substeps;
    }
    EXPECT_GT(lowest_of(rest_state(lattice), lattice, 4), -0.03);
}

}  // namespace
