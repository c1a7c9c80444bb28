#include "physics/bricks/settle.hpp"

#include "physics/body/following_forces.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace physics {
namespace {

constexpr double forever = 1e4;  // s

// What slides along an axis may still be stopped by a collider.
void check_held(const CornerBody& body, const Loads& loads)
{
    const std::vector<std::uint8_t> held = axes_of_parts(loads.pins, body);
    const auto free = std::count(held.begin(), held.end(), std::uint8_t{0});
    if (free > 0) {
        throw std::invalid_argument(
            fmt::format("{} of {} parts of the body have no pin: they would fall for ever, and "
                        "have no equilibrium. Pin each part, or start from the given shape",
                        free, body.parts));
    }
    if (!loads.colliders.empty()) return;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto slides = std::count_if(held.begin(), held.end(),
                                          [&](auto axes) { return (axes >> axis & 1) == 0; });
        if (slides == 0) continue;
        throw std::invalid_argument(fmt::format(
            "{} of {} parts of the body have no pin that holds the {} axis: they would slide along "
            "it for ever, and have no equilibrium. Hold one corner of each along it by another "
            "Pin, or start from the given shape",
            slides, body.parts, "xyz"[axis]));
    }
}

State step_from_rest(const BricksBody& body, State state, const Loads& loads, double seconds,
                     const StepOptions& options)
{
    std::fill(state.v.begin(), state.v.end(), Vec3::Zero());
    return advance(body, std::move(state), loads, seconds, options);
}

}  // namespace

State settle(const BricksBody& body, State state, const Loads& loads, const StepOptions& options)
{
    check_pins(loads.pins, body.base.corners);
    check_held(body.base, loads);
    StepOptions still = options;
    still.integrator = Integrator::implicit_euler;
    still.substeps = 1;
    still.leaps = true;
    still.newton_iterations = std::max(options.newton_iterations, 50);
    still.contact_iterations = std::max(options.contact_iterations, 50);
    const double time = state.time;
    State end = step_from_rest(body, state, loads, forever, still);
    auto iterations = end.report.iterations;
    const auto step = [&](const State& from, double seconds) {
        State to = step_from_rest(body, from, loads, seconds, still);
        iterations += to.report.iterations;
        return to;
    };
    // By way of where it creeps to in steps that grow, each of which begins at rest.
    for (double seconds = 0.01; !end.report.converged && seconds < forever; seconds *= 3) {
        state = step(state, seconds);
        if (seconds * 3 >= forever) end = step(state, forever);
    }
    // Loads that follow the body push as the shape before has it.
    bool flutters = false;
    double moved = 0;  // m, in the last round
    if (std::any_of(loads.forces.begin(), loads.forces.end(), follows)) {
        constexpr int most = 100;
        constexpr double still_enough = 1e-7;  // of a cube's edge
        bool settled = false;
        for (int i = 0; i < most && !settled && end.report.converged; ++i) {
            const State before = std::exchange(end, step(end, forever));
            moved = 0;
            for (std::size_t k = 0; k < end.x.size(); ++k) {
                moved = std::max(moved, (end.x[k] - before.x[k]).norm());
            }
            settled = moved <= still_enough * body.base.h;
        }
        flutters = end.report.converged && !settled;
        end.report.converged &= settled;
    }
    end.report.iterations = iterations;
    std::fill(end.v.begin(), end.v.end(), Vec3::Zero());
    end.time = time;
    end.still_frames = 0;
    if (flutters) {
        end.report.warnings = {fmt::format(
            "No equilibrium was found: the shape still moves by {:.2g} m under loads that follow "
            "it. Lower them, or start from the given shape and let it come to rest.",
            moved)};
    } else if (!end.report.converged) {
        end.report.warnings = {fmt::format(
            "No equilibrium was found: {:.2g} of the forces are not balanced. The shape may buckle "
            "or be too soft for its loads. Start from the given shape and let it come to rest.",
            end.report.residual)};
    }
    return end;
}

}  // namespace physics
