#include "physics/bricks/step_descent.hpp"

#include "physics/bricks/joints.hpp"
#include "physics/bricks/stage_touches.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

constexpr double share_off = 1e-15;  // by which rounding moves a place

struct Phi {
    double value = 0;
    double size = 0;  // of its largest terms, whose rounding it holds
};

// Phi but for the damping with the stiffness, whose matrix changes with x. Contacts that rub add
// nothing. stage.x is where w leads.
Phi potential(Stage& stage, const Aligned<double>& w)
{
    const StepFrame& frame = stage.frame;
    for (std::size_t i = 0; i < frame.n; ++i) stage.x[i] = stage.x0[i] + stage.tau * w[i];
    stage.linear_at.clear();
    double sum = stage.elasticity.energy(stage.x.data()), size = std::abs(sum);
    for (std::size_t i = 0; i < frame.n; ++i) stage.jump[i] = w[i] - stage.v0[i];
    times_mass(stage, stage.jump, stage.momentum);
    for (std::size_t i = 0; i < frame.n; ++i) {
        const double push = frame.steady[i] + stage.wind[i] - 0.5 * stage.drag[i] * w[i];
        const double kinetic = 0.5 * stage.jump[i] * stage.momentum[i];
        const double work = stage.tau * push * w[i];
        sum += kinetic - work;
        size += std::abs(kinetic) + std::abs(work);
    }
    if (!frame.body.mass_damping.empty()) {
        times_damping(stage, w, stage.momentum);
        const double lost = 0.5 * stage.tau * dot(stage.momentum, w);
        sum += lost, size += lost;
    }
    if (may_touch(stage)) {
        for (const PointContact& c : touching(stage)) sum += c.energy;
    }
    return {sum, size};
}

// w becomes the lowest of the linear solution, going on as before, and standing still. Returns its
// Phi.
Phi start_from_lowest(Stage& stage)
{
    const std::size_t n = stage.frame.n;
    Aligned<double> best(n, 0), on = stage.v0;
    for (std::size_t i = 0; i < n; ++i) {
        if (stage.frame.fixed[i] != 0) on[i] = best[i] = stage.w[i];
    }
    // What is found touching at any of them, Phi of all of them counts.
    for (Aligned<double>* w : {&best, &on, &stage.w}) {
        stage.w.swap(*w);
        place(stage);
        find_touches(stage, Known::kept);
        stage.w.swap(*w);
    }
    Phi phi = potential(stage, best);
    for (Aligned<double>* w : {&on, &stage.w}) {
        const Phi here = potential(stage, *w);
        if (here.value < phi.value) phi = here, best.swap(*w);
    }
    stage.w.swap(best);
    return phi;
}

// w goes as far along delta as lowers Phi enough (Armijo's condition, but for what rounding hides
// of it: `noise` is rounding_of the stage), and delta becomes that. Returns which share of delta it
// is, 0 where it cannot go at all.
double search_along_delta(Stage& stage, double noise, Phi& phi)
{
    constexpr int halvings = 12;
    const std::size_t n = stage.frame.n;
    // Damping with K as it is here: 1/2 u^T C u with u = w + a delta - b, less that at w.
    stage.elasticity.weigh(0, stage.tau);
    stage.elasticity.multiply(stage.delta.data(), stage.product.data());
    double slope = 0, linear = 0, square = 0;
    for (std::size_t k = 0; k < n; ++k) {
        slope += stage.r[k] * stage.delta[k];
        const double base = stage.base.empty() ? 0 : stage.base[k];
        linear += (stage.w[k] - base) * stage.product[k];
        square += stage.delta[k] * stage.product[k];
    }
    Aligned<double> trial(n);
    // Of terms, and of the positions that the elastic energy is of.
    const double rounding = 1e-14 * phi.size + 0.1 * noise * std::sqrt(phi.size);
    double step = 1;
    for (int i = 0; i < halvings; ++i, step *= 0.5) {
        for (std::size_t k = 0; k < n; ++k) trial[k] = stage.w[k] + step * stage.delta[k];
        const Phi next = potential(stage, trial);
        const double damped = step * (linear + 0.5 * step * square);
        const double enough = phi.value - 1e-4 * step * slope + rounding;
        if (!(next.value + damped <= enough) || !std::isfinite(next.value)) continue;
        phi = next;
        stage.w.swap(trial);
        for (double& d : stage.delta) d *= step;
        return step;
    }
    return 0;
}

// delta with which Newton's method goes on from stage.w: the closer to the end, the more exactly.
void find_delta(Stage& stage, StepSolver& solver, const Descent& how, double size, double target,
                StepRecord& record)
{
    const double loose = how.hessian ? std::clamp(std::sqrt(target / size), 1e-3, 0.1) : 0.1;
    const double goal = std::max(loose * size, 0.5 * target);
    Solved solved = solve_linear(solver, stage, goal);
    record.report.iterations += solved.iterations;
    if (!solved.converged && how.hessian) {
        stage.elasticity.use_hessian(false);
        solved = solve_linear(solver, stage, goal);
        record.report.iterations += solved.iterations;
    }
    stage.elasticity.use_hessian(how.hessian);
    if (!solved.converged) record.short_of_iterations = true;
}

// Where damping makes a step from `from` overshoot, it is shortened.
void end_near_lowest(Stage& stage, const Aligned<double>& from, double slope, Phi& phi)
{
    place(stage);
    linearise(stage, stage.x);
    find_residual(stage);
    if (!(dot(stage.r, stage.delta) < -0.5 * slope)) return;
    draw_back(stage, from, slope);
    phi = potential(stage, stage.w);
}

}  // namespace

bool is_violent(const Stage& stage)
{
    Aligned<double> w;
    if (!stage.rigid.none()) {  // rigid parts are asked nothing
        w = stage.w;
        for (std::size_t i = 0; i < stage.rigid.count(); ++i) {
            stage.rigid.spread(i, Vec3::Zero(), Vec3::Zero(), w.data());
        }
    }
    return !(stage.tau * stage.elasticity.largest_rate((w.empty() ? stage.w : w).data()) < 1);
}

void draw_back(Stage& stage, const Aligned<double>& from, double slope)
{
    double low = 0, at_low = slope, high = 1, at_high = dot(stage.r, stage.delta);
    for (int i = 0; i < 6 && at_high < -0.5 * slope; ++i) {
        const double share = std::clamp(at_low / (at_low - at_high), 0.1, 0.9);
        const double step = low + share * (high - low);
        for (std::size_t k = 0; k < stage.frame.n; ++k) {
            stage.w[k] = from[k] + step * stage.delta[k];
        }
        place(stage);
        stage.contacts = touching(stage);
        if (!stage.at_start) linearise(stage, stage.x);
        find_residual(stage);
        const double here = dot(stage.r, stage.delta);
        if (std::abs(here) <= 0.5 * slope) return;
        if (here > 0) {
            low = step, at_low = here;
        } else {
            high = step, at_high = here;
        }
    }
}

Descended descend(Stage& stage, StepSolver& solver, const Descent& how, StepRecord& record)
{
    Phi phi = start_from_lowest(stage);
    stage.at_start = false;
    Descended end = Descended::arrived;
    Aligned<double> from;  // w before a round
    for (int i = 0;; ++i) {
        place(stage);
        stage.contacts = touching(stage);
        stage.elasticity.use_hessian(how.hessian);
        linearise(stage, stage.x);
        find_residual(stage);
        prepare(solver, stage);
        const double size = norm(solver, stage.r);
        const double scale = how.tolerance > 0 ? forces_at_work(stage, solver) : 0;
        const double target =
            std::max({how.target, how.tolerance * scale, rounding_of(stage, solver)});
        if (!std::isfinite(size)) break;
        if (size <= target) {
            if (i == how.rounds) break;
            const bool firmer = firm_up(stage, stage.x);
            if (!find_touches(stage) && !firmer) break;
            phi = potential(stage, stage.w);
            continue;
        }
        if (i == how.rounds) {
            end = Descended::out_of_rounds;
            break;
        }
        find_delta(stage, solver, how, size, target, record);
        if (how.hessian) from = stage.w;
        double slope = dot(stage.r, stage.delta);
        slope *= search_along_delta(stage, rounding_of(stage, solver), phi);
        if (slope == 0) {
            end = Descended::stuck;
            break;
        }
        if (how.hessian) end_near_lowest(stage, from, slope, phi);
    }
    stage.elasticity.use_hessian(false);
    place(stage);
    return end;
}

double forces_at_work(const Stage& stage, const StepSolver& solver)
{
    const AtWork at = at_work(stage);
    return std::max({norm(solver, at.outside), norm(solver, at.elastic), norm(solver, at.inertia)});
}

// Joints pull where rounding moves places, each on its own.
static double rounding_of_joints(const Stage& stage, const StepSolver& solver)
{
    constexpr double both = 2;  // the start of the stage and its end
    if (stage.frame.loads.joints.empty()) return 0;
    std::vector<PointContact> joints;
    add_joints(stage, stage.x, joints);
    Aligned<double> r(stage.frame.n, 0);
    for (const PointContact& joint : joints) {
        for (std::size_t i = 0; i < 3; ++i) {
            double size = 0;  // m, of the places that its gap is the difference of
            const auto number = [&](std::size_t a) {
                return 4 * std::size_t{joint.corners[a]} + i;
            };
            for (std::size_t a = 0; a < joint.count; ++a) {
                size += std::abs(double(joint.weight[a]) * stage.x[number(a)]);
            }
            const double pull = both * share_off * size * stage.tau * joint.stiffness[0];
            for (std::size_t a = 0; a < joint.count; ++a) {
                double& all = r[number(a)];
                all = std::hypot(all, pull * double(joint.weight[a]));
            }
        }
    }
    if (!stage.rigid.none()) stage.rigid.even_out(r.data());
    return norm(solver, r);
}

double rounding_of(const Stage& stage, const StepSolver& solver)
{
    const Aligned<double>& inverse = solver.high.linear.inverse;
    double sum = 0;
    for (std::size_t i = 0; i < stage.frame.n; ++i) {
        if (inverse[i] > 0) sum += stage.x[i] * stage.x[i] / inverse[i];
    }
    return share_off * std::sqrt(sum) / stage.tau + rounding_of_joints(stage, solver);
}

}  // namespace physics
