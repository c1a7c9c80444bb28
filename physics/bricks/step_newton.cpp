#include "physics/bricks/step_newton.hpp"

#include "physics/bricks/free_fall.hpp"
#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/guess_limits.hpp"
#include "physics/bricks/pinned_parts.hpp"
#include "physics/bricks/radial_on_way.hpp"
#include "physics/bricks/rigid_energy.hpp"
#include "physics/bricks/rigid_guesses.hpp"
#include "physics/bricks/stage_touches.hpp"
#include "physics/bricks/step_descent.hpp"
#include "physics/bricks/step_leaps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

// What is touched is looked for in the rounds before this one. From it on, steps take friction
// nearly by its derivative, and are shortened where they go too far.
constexpr int first_wary_round = 2;

// Contacts come and go between rounds, so that none of them need be solved exactly.
constexpr double contact_accuracy = 0.05;
// What is touched is looked for again where the forces balance so far, as a share of those at work.
// Friction yields by loads that are held: there, they are held anew at what pushes then, until both
// agree so far, as a share of all. That happens so often at most, and only in so many of the rounds
// that there may be, as a share.
constexpr double near_enough = 0.1;
constexpr double friction_accuracy = 0.02;
constexpr int most_held = 10;
constexpr double time_to_hold = 0.6;

// Free corners set off as the steady forces have them, unless they then touch something.
void fall(Stage& stage)
{
    const StepFrame& frame = stage.frame;
    for (std::size_t i = 0; i < frame.n; ++i) {
        if (frame.mass[i] > 0) stage.w[i] += stage.tau * frame.steady[i] / frame.mass[i];
    }
    take_rigid_motion(stage);
    place(stage);
    find_touches(stage);
    stage.contacts = touching(stage);
    if (stage.contacts.empty()) return;
    stage.w = stage.v0;
    place(stage);
    stage.contacts.clear();
}

// Adds loads that depend on where the body is, as they are where the stage is about to end: at x^
// of parts that turn freely, elsewhere as guessed. Taken where it starts, the forces of a pressure
// would have torques about the places where it ends, and turn what spins ever faster.
void add_following(Stage& stage)
{
    const StepFrame& frame = stage.frame;
    if (frame.following.empty() && stage.radial.empty()) return;
    Aligned<double> ahead = stage.x0;
    for (std::size_t k = 0; k < frame.n; k += 4) {
        const double* const base = stage.base.empty() ? nullptr : &stage.base[k];
        const bool turns = base && (base[0] != 0 || base[1] != 0 || base[2] != 0);
        const double* const velocity = turns ? base : &stage.w[k];
        for (std::size_t i = 0; i < 3; ++i) ahead[k + i] += stage.tau * velocity[i];
    }
    add_following_forces(frame.following, frame.body, ahead.data(), stage.wind);
    take_radial_on_way(stage, std::move(ahead));
}

void linearise_here(Stage& stage)
{
    linearise(stage, stage.x);
    stage.at_start = false;
}

void linearise_at_base(Stage& stage)
{
    if (stage.base.empty()) {
        linearise(stage, stage.x0);
    } else {
        for (std::size_t i = 0; i < stage.frame.n; ++i) {
            stage.x[i] = stage.x0[i] + stage.tau * stage.base[i];
        }
        linearise(stage, stage.x);
    }
    stage.at_start = true;
}

// The midpoint rule keeps what it is given: what one linearisation stretches parts by that turn and
// touch something would come back as motion.
bool one_round(const StepOptions& options)
{
    return options.newton_iterations == 1 && options.integrator != Integrator::implicit_midpoint;
}

// What the step before lengthened stiff sheets by must not hold them across in this one
// (shell/shell_cell.hpp). Turns of a part as a whole lengthen nothing. What touches something is
// held all the same: without that, contact keeps a cloth shaking that is to come to rest.
void look_back(Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    const double tau = stage.tau;
    if (!has_sheets(body) || !one_round(stage.frame.options)) return;
    std::vector<std::uint8_t> touches(std::max<std::size_t>(body.parts, 1), 0);
    for (const PointContact& c : stage.contacts) {
        for (std::size_t a = 0; a < c.count; ++a) touches[body.part_of(c.corners[a])] = 1;
    }
    Aligned<double> came(stage.frame.n, 0);
    for (std::size_t i = 0; i < came.size(); ++i) {
        if (i / 4 >= body.corners || touches[body.part_of(i / 4)] != 0) continue;
        came[i] = tau * (stage.v0[i] - (stage.base.empty() ? 0 : stage.base[i]));
    }
    if (!stage.elasticity.look_back(came.data(), tau)) return;
    stage.linear_at[3] = 1;  // K is not that of forces there alone, for whoever asks for it next
}

// Linear about x0 + tau b, with the residual and A of w as it was guessed.
void start_rounds(Stage& stage, StepSolver& solver)
{
    stage.wary = false;
    start_rigid_parts(stage);
    place(stage);
    find_touches(stage);
    stage.contacts = touching(stage);
    turn_free_parts(stage);
    turn_pinned_parts(stage);
    turn_rigid_parts(stage);
    add_following(stage);
    lift_free_parts(stage);
    linearise_at_base(stage);
    look_back(stage);
    place(stage);
    if (!stage.base.empty()) {
        find_touches(stage);
        stage.contacts = touching(stage);
    }
    const bool free = stage.frame.loads.pins.empty() && stage.contacts.empty();
    if (free) fall(stage);
    find_residual(stage);
    prepare(solver, stage);
}

// What stays as it is from round to round.
struct Rounds {
    Rounds(const Stage& stage, double at_work, double its_share)
        : one(one_round(stage.frame.options)), touches(may_touch(stage)), share(its_share),
          target(share * stage.frame.options.tolerance * at_work)
    {}

    bool one;       // linear forces alone were asked for
    bool touches;   // it may
    double share;   // of the forces at work that the tolerance is told of, see least_share()
    double target;  // the norm of the residual that is small enough
};

// The norm of what is left over where w leads.
double measure(Stage& stage, StepSolver& solver)
{
    prepare(solver, stage);
    return norm(solver, stage.r);
}

// In place of rounds where the motion is violent.
void go_down(Stage& stage, StepSolver& solver, double at_work, StepRecord& record)
{
    if (!stage.rigid.none()) {  // of which a search for the lowest point knows nothing
        record.violent = true;
        return;
    }
    const Descent how{.target = std::max(stage.frame.options.tolerance, 1e-3) * at_work};
    if (descend(stage, solver, how, record) != Descended::arrived) record.violent = true;
}

// stage.delta is solved for, and w goes along it.
void take_delta(Stage& stage, StepSolver& solver, const Rounds& rounds, double size,
                StepRecord& record)
{
    const double goal = stage.contacts.empty()
                            ? std::max(rounds.target, 1e-3 * stage.frame.options.tolerance * size)
                            : std::max(0.5 * rounds.target, contact_accuracy * size);
    const Solved solved = solve_linear(solver, stage, goal);
    record.report.iterations += solved.iterations;
    if (!solved.converged) record.short_of_iterations = true;
    for (std::size_t i = 0; i < stage.frame.n; ++i) stage.w[i] += stage.delta[i];
}

// Finds what touches where w leads. Returns the norm of what is left over, 0 where nothing touches.
// `from` and `slope`, of the round's start, are those of draw_back().
double take_contacts(Stage& stage, StepSolver& solver, const Rounds& rounds, int round,
                     const Aligned<double>& from, double slope)
{
    const bool wary = round >= first_wary_round;
    const bool apart = stage.contacts.empty();
    if (wary) {
        place(stage);
    } else {
        const Aligned<double> before = stage.x;
        place(stage);
        firm_up(stage, before);
        find_touches(stage);
    }
    if (round == first_wary_round) hold_first_loads(stage);
    stage.wary = round + 1 >= first_wary_round;
    stage.contacts = touching(stage);
    if (apart && rounds.one && stage.contacts.empty()) return 0;  // it passed by
    if (!rounds.one) linearise_here(stage);
    find_residual(stage);
    if (wary) draw_back(stage, from, slope);
    return measure(stage, solver);
}

// Where the forces balance, looks for more that is touched, and at the loads that friction yields
// by. `must`: they change. Returns the norm of what is left over then.
double join(Stage& stage, StepSolver& solver, bool must, double size)
{
    if (!find_touches(stage) && !must) return size;
    hold_loads(stage);
    stage.contacts = touching(stage);
    find_residual(stage);
    return measure(stage, solver);
}

// Of several models, one may be so light that the tolerance for all leaves it unsolved: the share
// of the forces at work on the part with the least, of those on the part with the most. 1 for one
// model.
double least_share(const Stage& stage, const StepSolver& solver, const AtWork& at)
{
    constexpr double least = 1e-3;  // single precision goes no further
    const CornerBody& body = stage.frame.body;
    if (body.models < 2) return 1;
    const auto outside = norms_of_parts(solver, body, at.outside);
    const auto elastic = norms_of_parts(solver, body, at.elastic);
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (std::size_t p = 0; p < body.parts; ++p) {
        const double size = std::max(outside[p], elastic[p]);
        if (!(size > 0)) continue;  // nothing acts on it
        low = std::min(low, size);
        high = std::max(high, size);
    }
    return high > 0 ? std::max(least, low / high) : 1;
}

// Rounds of Newton's method from what start_rounds() left. `at_work` is the norm of the forces at
// work there, `share` that of least_share().
void go_rounds(Stage& stage, StepSolver& solver, double size, double at_work, double share,
               StepRecord& record)
{
    const StepOptions& options = stage.frame.options;
    Rounds rounds(stage, at_work, share);
    // Where nothing acts yet on what flies near something, no round gets below the rounding.
    const double rounding = rounds.touches ? rounding_of(stage, solver) : 0;
    rounds.target = std::max(rounds.target, rounding);
    const double first = size;
    constexpr int cheap = 4;  // times as many rounds with rigid parts
    const int rounds_of_contact = options.contact_iterations * (stage.rigid.none() ? 1 : cheap);
    const int most = std::max(options.newton_iterations, may_touch(stage) ? rounds_of_contact : 1);
    bool joined = !rounds.touches;
    int held = 0;  // how often loads were
    Aligned<double> from;
    for (int round = 0; round < most && size > rounds.target; ++round) {
        if (round >= first_wary_round) from = stage.w;
        take_delta(stage, solver, rounds, size, record);
        // What is touched is not known yet in the first round: it is judged by the last.
        if (round == 0 && !rounds.touches && is_violent(stage)) {
            return go_down(stage, solver, at_work, record);
        }
        if (!may_touch(stage)) return;  // linear forces alone: solved
        if (round == 0) {               // what is at rest may be moved by a pin or a collider alone
            at_work =
                std::max(at_work, std::min(first, norm(solver, physics::at_work(stage).inertia)));
            rounds.target = std::max(share * options.tolerance * at_work, rounding);
        }
        size = take_contacts(stage, solver, rounds, round, from, dot(stage.r, stage.delta));
        if (!std::isfinite(size)) return;
        if (rounds.touches && size > 0 &&
            size <= (joined ? rounds.target : std::max(rounds.target, near_enough * at_work))) {
            const bool loads = held < most_held && round < time_to_hold * most &&
                               friction_off(stage) > friction_accuracy;
            if (loads) ++held;
            size = join(stage, solver, loads || !joined, size);
            joined = !loads;
        }
    }
    if (rounds.touches && is_violent(stage)) return go_down(stage, solver, at_work, record);
    if (size <= 1.0001 * rounds.target) return;
    record.unsettled = true;
    record.left = std::max(record.left, size / at_work);
}

// What solves of a stage are measured by: go_rounds().
struct Scale {
    double at_work = 0, share = 1;
};

// A few rounds more with what touches as it was found, up to the tolerance of the forces where the
// stage ends: its residual is told as a share of these.
void polish(Stage& stage, StepSolver& solver, const Scale& scale, StepRecord& record)
{
    constexpr int most = 8;
    for (int i = 0; i < most; ++i) {
        place(stage);
        stage.contacts = touching(stage);
        find_residual(stage);
        const double size = measure(stage, solver);
        const Rounds rounds(stage, forces_at_work(stage, solver), scale.share);
        if (!(size > rounds.target)) return;
        take_delta(stage, solver, rounds, size, record);
    }
}

// Rigid parts went along lines about where they were guessed to end: guesses anew, and solves
// again, until they end there. `found` and `before`: before the stage was solved. `again`: it was,
// and has other places since.
void go_on_turned(Stage& stage, StepSolver& solver, const Scale& scale, const FoundTouches& found,
                  const StepRecord& before, bool again, StepRecord& record)
{
    constexpr double too_far = 1;  // cubes
    constexpr int patience = 5;    // solves in which joined parts come no nearer by half
    const bool joined = !stage.frame.loads.joints.empty();
    const int most = joined ? 40 : 10;
    const bool may_halve = stage.halvings < most_halvings;
    const GuessLimits limits(stage);
    RigidGuesses guesses;
    guesses.begin(stage.rigid);
    std::vector<double> off = take_rigid_motion(stage);
    double here = limits.most(off), last = here, least = here;
    int waited = 0;
    if (!std::isfinite(here)) return;
    const auto goes_on = [&](int i) {
        if (again && i == 0) return true;
        if (i >= most || here <= 1) return false;
        // What touches on one side and then on the other comes no nearer, though near enough.
        if (joined) return waited < patience || limits.too_far(off);
        return i < 3 || here < 0.7 * last;
    };
    for (int i = 0; goes_on(i); ++i) {
        if (may_halve && *std::max_element(off.begin(), off.end()) > too_far) break;
        last = here;
        record.unsettled = before.unsettled, record.violent = before.violent;
        record.left = before.left;
        if (joined) guesses.aim(stage.rigid);
        turn_rigid_parts(stage);
        guesses.begin(stage.rigid);
        go_back_to(found, stage);
        stage.wary = false;
        if (!stage.frame.loads.pins.matter.cubes.empty()) linearise_at_base(stage);
        place(stage);
        find_touches(stage);
        stage.contacts = touching(stage);
        find_residual(stage);
        go_rounds(stage, solver, measure(stage, solver), scale.at_work, scale.share, record);
        off = take_rigid_motion(stage);
        here = limits.most(off);
        ++waited;
        if (here < 0.5 * least) least = here, waited = 0;
    }
    if (limits.too_far(off)) record.unsettled = true, record.left = 1;
    if (record.unsettled || record.violent) return;
    polish(stage, solver, scale, record);
}

// Solves the stage by all of the second derivative, from what start_rounds() left. False, with
// nothing but its cost recorded, where something was touched on the way or is then.
bool go_untouched(Stage& stage, StepSolver& solver, StepRecord& record)
{
    const StepOptions& options = stage.frame.options;
    const StepRecord before = record;
    const bool struck = stage.struck;
    if (options.leaps) leap(stage, solver, options.tolerance, record);
    const Descent how{
        .rounds = options.newton_iterations, .tolerance = options.tolerance, .hessian = true};
    const bool arrived = descend(stage, solver, how, record) == Descended::arrived;
    if (may_touch(stage)) {
        place(stage);
        find_touches(stage);
        if (!stage.contacts.empty() || !touching(stage).empty() || stage.struck != struck) {
            const auto iterations = record.report.iterations;
            record = before;
            record.report.iterations = iterations;
            stage.struck = struck;
            return false;
        }
    }
    if (!arrived) record.unsettled = true;
    return true;
}

}  // namespace

void solve_stage(Stage& stage, StepSolver& solver, StepRecord& record)
{
    const bool whole =
        stage.frame.options.newton_iterations > 1 && !stage.frame.body.sheets && stage.rigid.none();
    struct {
        Aligned<double> x0, v0, w, wind, radial;
    } began;
    if (whole && may_touch(stage)) {
        began = {stage.x0, stage.v0, stage.w, stage.wind, stage.radial};
    }
    const FoundTouches found = stage.rigid.none() ? FoundTouches{} : found_so_far(stage);
    start_rounds(stage, solver);
    if (whole && stage.contacts.empty()) {
        if (go_untouched(stage, solver, record)) return;
        stage.x0 = began.x0, stage.v0 = began.v0, stage.w = began.w;
        stage.wind = began.wind, stage.radial = began.radial;
        start_rounds(stage, solver);
    }
    record.touched |= may_touch(stage);
    const double size = norm(solver, stage.r);
    const AtWork at = at_work(stage);
    // What contacts push back at first, far into what they touch, is no force at work. What they
    // have to do is to stop the body. Of rigid parts that is told by the round that did it.
    Aligned<double> momentum;
    times_mass(stage, stage.v0, momentum);
    const double push = !stage.rigid.none() ? 0 : std::min(size, norm(solver, momentum));
    const Scale scale{std::max({push, norm(solver, at.outside), norm(solver, at.elastic)}),
                      least_share(stage, solver, at)};
    const StepRecord before = record;
    go_rounds(stage, solver, size, scale.at_work, scale.share, record);
    if (stage.rigid.none()) return;
    go_on_turned(stage, solver, scale, found, before, false, record);
    const auto settled = [&] { return !record.unsettled && !record.violent; };
    HeldPlaces places;
    if (!settled() || !places.take_means(stage)) return;
    go_on_turned(stage, solver, scale, found, before, true, record);
    using Which = HeldPlaces::Which;
    if (!places.take_ends(stage, settled() ? Which::struck : Which::all)) return;
    go_on_turned(stage, solver, scale, found, before, true, record);
}

void find_forces_at_start(Stage& stage)
{
    stage.wary = false;
    place(stage);
    stage.contacts = touching(stage);
    add_following(stage);
    linearise(stage, stage.x0);
    stage.at_start = true;
    find_residual(stage);
}

std::vector<Vec3> reactions_of(const Stage& stage)
{
    std::vector<Vec3> out(stage.frame.loads.pins.corner.size(), Vec3::Zero());
    for_held_axes(stage.frame, [&](std::size_t pin, std::size_t axis, std::size_t number) {
        out[pin][static_cast<Eigen::Index>(axis)] = -1 / stage.tau * stage.r[number];
    });
    return out;
}

void find_leftover(Stage& stage, StepSolver& solver, StepRecord& record)
{
    place(stage);
    if (!all_finite(stage.x)) return;
    linearise_here(stage);
    find_residual(stage);
    record.reaction = reactions_of(stage);
    prepare(solver, stage);
    const double size = norm(solver, stage.r);
    const double scale = forces_at_work(stage, solver);
    if (scale > 0) record.report.residual = std::max(record.report.residual, size / scale);
    // A solve in single precision ends within its own rounding of the tolerance.
    const double target = 1.001 * stage.frame.options.tolerance * scale;
    if (!(size <= std::max(target, rounding_of(stage, solver)))) record.report.converged = false;
}

}  // namespace physics
