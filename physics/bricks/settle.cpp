#include "physics/bricks/settle.hpp"

#include "physics/body/following_forces.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/bricks/joints.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace physics {
namespace {

constexpr double forever = 1e4;  // s

// Of each part the axes along which pins hold it, or what it is joined to.
std::vector<std::uint8_t> held_with_joints(const CornerBody& body, const Loads& loads)
{
    std::vector<std::uint8_t> out = axes_of_parts(loads.pins, body);
    if (loads.joints.empty()) return out;
    const std::vector<std::uint32_t> first = joined_parts(body, loads.joints);
    for (std::size_t p = 0; p < out.size(); ++p) out[first[p]] |= out[p];
    for (std::size_t p = 0; p < out.size(); ++p) out[p] = out[first[p]];
    return out;
}

// What slides along an axis, or falls, may still be stopped by a collider.
void check_held(const CornerBody& body, const Loads& loads, const std::vector<std::uint8_t>& held)
{
    if (!loads.colliders.empty()) return;
    const auto free = std::count(held.begin(), held.end(), std::uint8_t{0});
    // What is pinned may carry what is not.
    if (free > 0 && (free == std::ptrdiff_t(body.parts) || !body.shapes)) {
        throw std::invalid_argument(fmt::format(
            "{} of {} parts of the body have no pin, and there is no collider to lie on: they "
            "would "
            "fall for ever, and have no equilibrium. Pin each part, link a ground or another "
            "collider, or start from the given shape",
            free, body.parts));
    }
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

// How far corners are from where they were, m.
double farthest_moved(const State& from, const State& to)
{
    double moved = 0;
    for (std::size_t k = 0; k < to.x.size(); ++k) {
        moved = std::max(moved, (to.x[k] - from.x[k]).norm());
    }
    return moved;
}

// Where parts without pins come to lie: in steps that each begin at rest, so that nothing swings or
// bounces, until none moves them. Damping makes that slower.
State lie_down(const BricksBody& body, State state, const Loads& loads, const StepOptions& options)
{
    constexpr int most = 300;
    constexpr double still_enough = 1e-5;  // of a cube's edge, in a step
    constexpr double longest = 0.25;       // s: what is in the air falls by 0.6 m
    const State start = state;
    double moved = 0, seconds = 1.0 / 48;
    int iterations = 0;
    const auto rests = [&] {
        return moved <= still_enough * body.base.h && state.report.converged;
    };
    for (int i = 0; i < most; ++i) {
        State next = step_from_rest(body, state, loads, seconds, options);
        iterations += next.report.iterations;
        moved = farthest_moved(state, next);
        const bool longer = seconds < longest;
        seconds = std::min(1.5 * seconds, longest);
        state = std::move(next);
        if (!longer && rests()) break;
    }
    state.report.iterations = iterations;
    if (rests()) return state;
    const double far = farthest_moved(start, state);
    if (moved > std::min(body.base.h, 0.1)) {
        throw std::invalid_argument(fmt::format(
            "no equilibrium was found: parts without pins are {:.2g} m from where they began, and "
            "still move by {:.2g} m in a quarter of a second. They fall beside the colliders, or a "
            "long way, or slide or roll. Put something below them, pin them, or start from the "
            "given "
            "shape",
            far, moved));
    }
    state.report.converged = false;
    state.report.warnings.insert(
        state.report.warnings.begin(),
        fmt::format(
            "No equilibrium was found: parts without pins still move by {:.2g} m in a quarter "
            "of a second. They may slide, roll or tip over, or be damped too much. Start from "
            "the given shape and let it come to rest.",
            moved));
    return state;
}

State at_its_start(State end, double time)
{
    std::fill(end.v.begin(), end.v.end(), Vec3::Zero());
    end.time = time;
    end.still_frames = 0;
    return end;
}

}  // namespace

State settle(const BricksBody& body, State state, const Loads& loads, const StepOptions& options)
{
    check_pins(loads.pins, body.base.corners);
    const std::vector<std::uint8_t> held = held_with_joints(body.base, loads);
    check_held(body.base, loads, held);
    StepOptions still = options;
    still.integrator = Integrator::implicit_euler;
    still.substeps = 1;
    still.leaps = true;
    still.newton_iterations = std::max(options.newton_iterations, 50);
    still.contact_iterations = std::max(options.contact_iterations, 50);
    const double time = state.time;
    if (std::count(held.begin(), held.end(), std::uint8_t{0}) > 0) {
        return at_its_start(lie_down(body, std::move(state), loads, still), time);
    }
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
            moved = farthest_moved(before, end);
            settled = moved <= still_enough * body.base.h;
        }
        flutters = end.report.converged && !settled;
        end.report.converged &= settled;
    }
    end.report.iterations = iterations;
    end = at_its_start(std::move(end), time);
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
