#include "physics/lattice/lattice.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/body/following_forces.hpp"
#include "physics/lattice/match_shapes.hpp"
#include "physics/lattice/plastic_flow.hpp"
#include "physics/lattice/step_motion.hpp"
#include "physics/lattice/step_pull.hpp"
#include "physics/lattice/step_report.hpp"
#include "physics/lattice/step_weights.hpp"
#include "physics/lattice/tear_links.hpp"
#include "physics/state/balls.hpp"
#include "physics/state/pins.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {

namespace {

bool all_finite(const State& state)
{
    // Any NaN or infinity ends up in the sum.
    double sum = geometry::ordered_sum<double>(
        state.x.size(), particles_a_task, 0.0, [&](std::size_t begin, std::size_t end) {
            double part = 0;
            for (std::size_t i = begin; i < end; ++i) {
                for (int d = 0; d < 3; ++d) part += 0 * state.x[i][d] + 0 * state.v[i][d];
            }
            return part;
        });
    for (const BallState& b : state.balls) sum += (0 * (b.x + b.v + b.spin)).sum();
    return sum == 0;
}

// What a step that failed goes back to: a copy that is made on all threads where it is long, for
// its time is mostly that of finding room.
State copied(State& state)
{
    const auto copy_of = [](const std::vector<Vec3>& from) {
        std::vector<Vec3> to(from.size());
        geometry::parallel_for(
            from.size(), particles_a_task, [&](std::size_t begin, std::size_t end) {
                std::copy(from.begin() + std::ptrdiff_t(begin), from.begin() + std::ptrdiff_t(end),
                          to.begin() + std::ptrdiff_t(begin));
            });
        return to;
    };
    std::vector<Vec3> x, v;
    x.swap(state.x);
    v.swap(state.v);
    State copy = state;  // all the rest of it, whatever that is
    x.swap(state.x);
    v.swap(state.v);
    copy.x = copy_of(state.x);
    copy.v = copy_of(state.v);
    return copy;
}

void check(const LatticeOptions& options)
{
    const auto positive = [](double v) { return std::isfinite(v) && v >= 0; };
    if (options.substeps < 1 || !(options.rate >= 0) || !(options.damping >= 0) ||
        !(options.bend >= 0)) {
        throw std::invalid_argument(fmt::format(
            "expected substeps of at least 1 and a rate, bend and damping of at least 0, "
            "found substeps {}, rate {}, bend {} and damping {}",
            options.substeps, options.rate, options.bend, options.damping));
    }
    check_plastic(options.plastic);
    if (!positive(options.tear)) {
        throw std::invalid_argument(
            fmt::format("expected a tear of at least 0, found {}", options.tear));
    }
    if (!positive(options.contact.distance) || !positive(options.contact.friction)) {
        throw std::invalid_argument(
            fmt::format("expected a contact distance and friction of at least 0, found distance {} "
                        "and friction {}",
                        options.contact.distance, options.contact.friction));
    }
}

template <class T>
void run_frame(const LatticeBody& body, State& state, const Loads& loads, double dt,
               const LatticeOptions& options)
{
    StepState<T> step(body, state, loads, dt, options);
    begin_frame(step);
    use_regions(step);
    find_origin(step);
    const double crossed = step.membrane_share.empty() ? 0 : cells_crossed(step);
    const bool changing = any_change(loads.forces);
    for (int i = 1; i <= options.substeps; ++i) {
        geometry::stop_if_asked();
        const double share = double(i) / options.substeps;
        if (changing) find_forces(step, share);
        find_goals(step);
        pull(step);
        push_from_outside(step);
        collide(step, share);
        move(step, share);
        if (body.torn && options.tear > 0 && tear_links(step)) use_regions(step);
    }
    state.time += dt;
    find_plastic_strain(step);
    report_frame(step, crossed);
}

}  // namespace

State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const LatticeOptions& options)
{
    const std::size_t n = body.base.corners;
    if (state.x.size() != n || state.v.size() != n) {
        throw std::invalid_argument(fmt::format(
            "expected a state of {} corners, found {} positions and {} velocities: it belongs to "
            "other cubes",
            n, state.x.size(), state.v.size()));
    }
    if (!all_finite(state)) throw std::invalid_argument("expected finite positions and velocities");
    if (!(dt > 0) || !std::isfinite(dt)) {
        throw std::invalid_argument(fmt::format("expected a time step above 0 s, found {}", dt));
    }
    check(options);
    check_pins(loads.pins, n);
    require_all_axes(loads.pins, "method lattice");
    require_corners(loads.pins, "method lattice");
    require_no_following(loads.forces, "method lattice");
    check_forces(loads.forces);
    check_balls(loads.balls);
    State before = copied(state);
    if (options.precision == Precision::single) {
        run_frame<float>(body, state, loads, dt, options);
    } else {
        run_frame<double>(body, state, loads, dt, options);
    }
    if (all_finite(state)) return state;
    before.time += dt;
    before.report = {};
    before.report.converged = false;
    before.report.warnings.emplace_back(
        "The step diverged; the last state was kept. Check for very large forces or pin targets.");
    return before;
}

namespace {

// What `of` says of a frame of one substep that begins at rest.
int asked_at_rest(const LatticeBody& body, double dt, int (*of)(const FrameState&))
{
    LatticeOptions options = body.options;
    options.substeps = 1;
    State state = rest_state(body);
    const Loads loads;
    StepState<double> step(body, state, loads, dt, options);
    begin_frame(step);
    use_regions(step);
    return of(step);
}

}  // namespace

int least_substeps(const LatticeBody& body, double dt)
{
    return asked_at_rest(body, dt, least_substeps);
}

int enough_substeps(const LatticeBody& body, double dt)
{
    constexpr int most_by_itself = 1000;  // a warning tells of more that are needed
    if (body.options.stiffness != Stiffness::material) return 1;
    const int asked = asked_at_rest(body, dt, [](const FrameState& step) {
        return std::max(least_substeps(step), substeps_for_volume(step));
    });
    return std::clamp(asked, 1, most_by_itself);
}

State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const StepOptions& step)
{
    LatticeOptions options = body.options;
    options.substeps = step.substeps == 0 ? enough_substeps(body, dt) : step.substeps;
    return advance(body, std::move(state), loads, dt, options);
}

}  // namespace physics
