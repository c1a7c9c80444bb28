// Rigid parts that hit each other, or colliders, gain no energy by it.

#include "geometry/base/random.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace physics {
namespace {

using geometry::Cubes;

constexpr double throw_frame = 1.0 / 24;

// Numbers from -1 to 1.
struct Any {
    geometry::Random random;
    std::uint64_t at = 0;

    explicit Any(std::uint64_t seed) : random(seed) {}
    double one() { return 2 * random.unit(at++) - 1; }
    Vec3 three() { return {one(), one(), one()}; }
};

// Rigid boxes, each with how it starts to move.
struct Throw {
    std::vector<Cubes> boxes;
    std::vector<Vec3> velocity, spin;
    PartContactOptions contact = {.friction = 0};
    Loads loads;
    Vec3 against = Vec3::Zero();  // m/s: energy is that of motion against what moves so
    double weight = 0;            // m/s^2: and that of height

    void add(const Cubes& box, const Vec3& at, const Vec3& its_velocity, const Vec3& its_spin)
    {
        boxes.push_back(box);
        boxes.back().origin = at;
        velocity.push_back(its_velocity);
        spin.push_back(its_spin);
    }
    // visit(box, first corner, behind its last)
    void for_boxes(const std::function<void(std::size_t, std::size_t, std::size_t)>& visit) const
    {
        std::size_t first = 0;
        for (std::size_t b = 0; b < boxes.size(); ++b) {
            const std::size_t end = first + boxes[b].corner_count();
            visit(b, first, end);
            first = end;
        }
    }
    BricksBody body() const
    {
        std::vector<BodyModel> models;
        for (const Cubes& box : boxes) models.push_back({&box});
        return make_bricks(
            BodyModels(models),
            {.contact = contact, .rigid = std::vector<std::uint8_t>(boxes.size(), 1)});
    }
    State start(const BricksBody& of) const
    {
        State state = rest_state(of);
        for_boxes([&](std::size_t b, std::size_t first, std::size_t end) {
            Vec3 centre = Vec3::Zero();
            for (auto k = first; k < end; ++k) centre += state.x[k] / double(end - first);
            for (auto k = first; k < end; ++k) {
                state.v[k] = velocity[b] + spin[b].cross(state.x[k] - centre);
            }
        });
        return state;
    }
    fixtures::BrickMotion motion(const State& state) const
    {
        fixtures::BrickMotion out;
        for_boxes([&](std::size_t b, std::size_t first, std::size_t end) {
            State own;
            for (auto k = first; k < end; ++k) {
                own.x.push_back(state.x[k]), own.v.push_back(state.v[k] - against);
                const double mass = geometry::total_mass(boxes[b]) / double(end - first);
                out.energy += mass * weight * state.x[k].y();
            }
            const auto of = fixtures::brick_motion(boxes[b], own);
            out.energy += of.energy, out.linear += of.linear, out.angular += of.angular;
        });
        return out;
    }
};

// How a scene went.
struct Went {
    double rise = 0;                 // the most that a frame added to the energy, as a share of it
    double left = 0;                 // of the energy, at the end
    double linear = 0, angular = 0;  // shares by which the momenta changed at most
    bool hit = false;
};
Went run(Throw& scene, int substeps, int frames, const std::function<void(int)>& before = {})
{
    const BricksBody body = scene.body();
    State state = scene.start(body);
    const auto first = scene.motion(state);
    auto last = first;
    Went out;
    for (int frame = 0; frame < frames; ++frame) {
        if (before) before(frame);
        state = advance(body, state, scene.loads, throw_frame, {.substeps = substeps});
        const auto now = scene.motion(state);
        out.rise = std::max(out.rise, now.energy / last.energy - 1);
        out.linear = std::max(out.linear, (now.linear - first.linear).norm());
        out.angular = std::max(out.angular, (now.angular - first.angular).norm());
        last = now;
    }
    out.left = last.energy / first.energy;
    out.hit = out.linear > 1e-3 * first.linear.norm();
    out.linear /= first.linear.norm();
    out.angular /= first.angular.norm();
    return out;
}

Collider floor_of(double bounce)
{
    Collider out;
    out.bounce = bounce, out.friction = 0;
    return out;
}

Throw thrown_down(std::uint64_t seed, double bounce)
{
    Any any(seed);
    Throw scene;
    const int n = static_cast<int>(seed % 3), m = static_cast<int>(seed / 3 % 2);
    scene.add(fixtures::box(2 + 2 * n, 2 + 2 * m, 4, 0.05), {0, 0.25, 0},
              {0, -1.25 + 0.75 * any.one(), 0}, 5 * any.three());
    scene.loads.colliders.push_back(floor_of(bounce));
    return scene;
}

// Corner after corner hits, in any part of a step. Energy is told to 1e-7 by the way a part turns
// in a step (rigid_part.hpp). With all of it, points that come again within a step lose some.
TEST(ImpactEnergy, ASpinningBoxGainsNothingFromAFloor)
{
    for (const double bounce : {0.5, 1.0}) {
        for (const int substeps : {0, 1, 4}) {
            for (std::uint64_t seed = 0; seed < 8; ++seed) {
                Throw scene = thrown_down(seed, bounce);
                const Went went = run(scene, substeps, 20);
                EXPECT_LT(went.rise, 1e-6) << bounce << " " << substeps << " " << seed;
                EXPECT_TRUE(went.hit);
                if (bounce == 1) {
                    EXPECT_GT(went.left, 0.9) << substeps << " " << seed;
                }
            }
        }
    }
}

// The same above a floor that rises: what is kept is the energy in its frame.
TEST(ImpactEnergy, ASpinningBoxGainsNothingAgainstAFloorThatMoves)
{
    constexpr double speed = 1.5;
    for (const int substeps : {0, 1, 4}) {
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
            Throw scene = thrown_down(seed, 1);
            scene.against.y() = speed;
            const auto height = [&](int at) {
                const double y = at * speed * throw_frame;
                return geometry::Transform(Eigen::Translation3d(0, y, 0));
            };
            const Went went = run(scene, substeps, 12, [&](int frame) {
                scene.loads.colliders[0].before = height(frame);
                scene.loads.colliders[0].pose = height(frame + 1);
            });
            EXPECT_LT(went.rise, 1e-3) << substeps << " " << seed;
            EXPECT_GT(went.left, 0.9) << substeps << " " << seed;
        }
    }
}

// Energy of motion and height. What hits loses about (g tau)^2 / 2 of it by implicit Euler: 3 % in
// a step of 1/24 s at 2.5 m/s, and corners hit several times.
TEST(ImpactEnergy, ASpinningBoxThatFallsGainsNothing)
{
    for (const int substeps : {0, 1, 4}) {
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
            Throw scene = thrown_down(seed, 1);
            scene.loads.forces.push_back({});
            scene.weight = 9.81;
            const Went went = run(scene, substeps, 20);
            EXPECT_LT(went.rise, 1e-3) << substeps << " " << seed;
            EXPECT_GT(went.left, 0.8) << substeps << " " << seed;
        }
    }
}

// Edges and corners hit faces and edges, again and again. What does not bounce may come out of
// where it is inside at 5 mm/s.
TEST(ImpactEnergy, TwoSpinningBoxesKeepTheirMomentaAndGainNothing)
{
    for (const double bounce : {0.0, 0.5, 1.0}) {
        for (const int substeps : {0, 1, 4}) {
            for (std::uint64_t seed = 0; seed < 4; ++seed) {
                Any any(seed + 7);
                Throw scene;
                scene.contact.bounce = bounce;
                const int n = static_cast<int>(seed);
                scene.add(fixtures::box(2 + n % 3, 2 + n / 3 % 2, 3, 0.1), Vec3::Zero(),
                          Vec3(0.4, 0, -0.2) + 0.3 * any.three(), 4 * any.three());
                scene.add(fixtures::box(3, 1 + n % 2, 2 + n % 4, 0.1),
                          {0.1 * any.one(), 0.65, 0.1 * any.one()},
                          Vec3(0.4, -2, -0.2) + 0.3 * any.three(), 4 * any.three());
                const Went went = run(scene, substeps, 20);
                EXPECT_LT(went.rise, 1e-4) << bounce << " " << substeps << " " << seed;
                EXPECT_LT(went.linear, 1e-12) << bounce << " " << substeps << " " << seed;
                EXPECT_LT(went.angular, 1e-11) << bounce << " " << substeps << " " << seed;
                if (bounce == 1) {
                    EXPECT_GT(went.left, 0.9) << substeps << " " << seed;
                }
            }
        }
    }
}

// A gas of eight boxes, with and without friction, that hit each other and six walls.
TEST(ImpactEnergy, EightBoxesInAClosedBoxGainNothing)
{
    for (const double bounce : {0.5, 1.0}) {
        for (const int substeps : {0, 1, 4}) {
            const double friction = substeps == 4 ? 0.3 : 0;
            Any any(substeps == 1 ? 11 : 12);
            Throw scene;
            scene.contact = {.friction = friction, .bounce = bounce};
            for (int b = 0; b < 8; ++b) {
                const int nx = any.one() > 0 ? 3 : 1, ny = any.one() > 0 ? 2 : 1;
                const Vec3 at(((b & 1) != 0 ? 0.05 : -0.45) + (nx == 1 ? 0.1 : 0),
                              (b & 2) != 0 ? 0.1 : -0.35, (b & 4) != 0 ? 0.1 : -0.35);
                const Vec3 off = 0.02 * any.three(), velocity = 1.9 * any.three();
                scene.add(fixtures::box(nx, ny, 2, 0.1), at + off, velocity, 3.5 * any.three());
            }
            for (int wall = 0; wall < 6; ++wall) {
                Collider c = floor_of(bounce);
                c.kind = Collider::Kind::box;
                c.friction = friction;
                c.half_size = Vec3::Constant(1.5);
                c.half_size[wall / 2] = 0.5;
                const Vec3 at = (wall % 2 == 0 ? 1.0 : -1.0) * Vec3::Unit(wall / 2);
                c.pose = c.before = geometry::Transform(Eigen::Translation3d(at));
                scene.loads.colliders.push_back(c);
            }
            const Went went = run(scene, substeps, 16);
            EXPECT_LT(went.rise, 1e-5) << bounce << " " << substeps;
            EXPECT_TRUE(went.hit);
            if (bounce == 1 && friction == 0) {
                EXPECT_GT(went.left, 0.8) << substeps;
            }
        }
    }
}

// Face to face, masses 1 : 2. Newton's law by both parts' own momenta:
//   v' = V - e m_other / M (v - v_other),   V that of the centre of mass
// Weights of points are floats, and turn the boxes by as little.
TEST(ImpactEnergy, ACentralImpactIsNewtonsLaw)
{
    for (const double bounce : {0.3, 1.0}) {
        for (const int substeps : {0, 1, 4}) {
            Throw scene;
            scene.contact.bounce = bounce;
            scene.add(fixtures::box(2, 2, 2, 0.1), Vec3::Zero(), Vec3::Zero(), Vec3::Zero());
            scene.add(fixtures::box(2, 4, 2, 0.1), {0, 0.35, 0}, {0, -3, 0}, Vec3::Zero());
            const BricksBody body = scene.body();
            State state = scene.start(body);
            for (int frame = 0; frame < 4; ++frame) {
                state = advance(body, state, {}, throw_frame, {.substeps = substeps});
            }
            const double mean = -2;
            for (const Vec3& v : {state.v.front(), state.v.back()}) {
                EXPECT_LT(std::hypot(v.x(), v.z()), 1e-6) << bounce << " " << substeps;
            }
            EXPECT_NEAR(state.v.front().y(), mean - bounce * 2, 1e-6) << bounce << " " << substeps;
            EXPECT_NEAR(state.v.back().y(), mean + bounce * 1, 1e-6) << bounce << " " << substeps;
        }
    }
}

}  // namespace
}  // namespace physics
