// Bodies of bricks ring for 100,000 steps with neither gain nor loss.

#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"
#include "tests/physics/state_measures.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;
using geometry::Cubes;

struct Ringing {
    Cubes cubes = fixtures::box(3, 1, 1, 0.1, {.young = 1e6});
    BricksBody body = make_bricks(cubes);
    Loads loads;
    State state = rest_state(body);

    // Held at one end, and bent and twisted a little.
    Ringing()
    {
        loads.pins.corner = fixtures::first_layer(cubes);
        for (const auto k : loads.pins.corner) {
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            const Vec3 p = cubes.corner_position(k);
            state.x[k] += Vec3(0, 0.15 * p.x() * p.x(), 0.3 * p.x() * (p.y() - 0.05));
        }
    }
    double energy() const
    {
        return fixtures::brick_motion(cubes, state).energy + strain(body, state).energy;
    }
    void step(int steps, double dt)
    {
        for (int i = 0; i < steps; ++i) {
            state = advance(body, std::move(state), loads, dt,
                            {.integrator = Integrator::implicit_midpoint});
        }
    }
    // The mean over some steps: where little moves, a step leaves its error to the next ones.
    double mean_energy(int steps, double dt)
    {
        double sum = 0;
        for (int i = 0; i < steps; ++i) {
            step(1, dt);
            sum += energy();
        }
        return sum / steps;
    }
};

TEST(Ringing, ABentBodyRingsFor100000StepsWithoutATrend)
{
    constexpr double dt = 1.0 / 240;
    Ringing body;
    const double before = body.mean_energy(500, dt);
#ifdef ASPIC_SANITIZED  // steps take many times as long
    body.step(5'000, dt);
#else
    body.step(99'000, dt);
#endif
    const double after = body.mean_energy(500, dt);
    EXPECT_GT(before, 0.5 * Ringing().energy());
    EXPECT_NEAR(after, before, 0.01 * before);
}

}  // namespace
