#pragma once

// A bar that hangs on a hinge, as a pendulum of a known period.

#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <cmath>
#include <numbers>
#include <vector>

namespace fixtures {

// A bar of 0.1 x 0.6 x 0.1 m hangs on one edge of its upper end, which is a hinge: two pinned
// corners. It swings about the way in which its centre is below the hinge, 9.46 degrees from how it
// starts, with
//   T = 2 pi sqrt(I / (m g d)) (1 + angle^2 / 16),  I / m = (0.1^2 + 0.6^2) / 12 + d^2,
//   d^2 = 0.05^2 + 0.3^2
struct HingedBar {
    geometry::Cubes cubes;
    physics::Loads loads;
    double period = 0;  // s

    explicit HingedBar(const Stuff& stuff) : cubes(box(1, 6, 1, 0.1, stuff))
    {
        loads.forces.push_back({});
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k].y() < 6 || cubes.corner[k].x() > 0) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        const double d_sq = 0.05 * 0.05 + 0.3 * 0.3, angle = std::atan(0.05 / 0.3);
        period = 2 * std::numbers::pi * std::sqrt((0.37 / 12 + d_sq) / (9.81 * std::sqrt(d_sq))) *
                 (1 + angle * angle / 16);
    }

    // When its lower end goes back for the first four times, s: two periods end with the last.
    // Steps take dt seconds, `frames` of them at most. `state` is moved.
    std::vector<double> turns(const physics::BricksBody& body, physics::State& state, double dt,
                              int frames) const
    {
        std::vector<double> out;
        double before = 0;
        for (int frame = 0; frame < frames && out.size() < 4; ++frame) {
            state = advance(body, state, loads, dt);
            const double speed = state.v[0].x();
            if (before != 0 && (speed > 0) != (before > 0)) {
                out.push_back(state.time - dt * speed / (speed - before));
            }
            before = speed;
        }
        return out;
    }
};

}  // namespace fixtures
