#include "physics/bricks/step_solver.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/math/for_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace physics {
namespace {

using geometry::no_index;

std::array<double, 6> inverse_of(const std::array<double, 6>& m)
{
    const double c00 = m[3] * m[5] - m[4] * m[4], c01 = m[2] * m[4] - m[1] * m[5];
    const double c02 = m[1] * m[4] - m[2] * m[3];
    const double det = m[0] * c00 + m[1] * c01 + m[2] * c02;
    return {c00 / det,
            c01 / det,
            c02 / det,
            (m[0] * m[5] - m[2] * m[2]) / det,
            (m[1] * m[2] - m[0] * m[4]) / det,
            (m[0] * m[3] - m[1] * m[1]) / det};
}

// The inverse between the axes that are not fixed; 0 of the others.
std::array<double, 6> inverse_of_free(std::array<double, 6> m, const double* fixed)
{
    if (fixed[0] == 0 && fixed[1] == 0 && fixed[2] == 0) return inverse_of(m);
    constexpr std::array<std::array<std::size_t, 2>, 6> axes{
        {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}};
    const auto is_fixed = [&](std::size_t i) {
        return fixed[axes[i][0]] != 0 || fixed[axes[i][1]] != 0;
    };
    for (std::size_t i = 0; i < 6; ++i) {
        if (is_fixed(i)) m[i] = axes[i][0] == axes[i][1] ? 1 : 0;
    }
    std::array<double, 6> out = inverse_of(m);
    for (std::size_t i = 0; i < 6; ++i) {
        if (is_fixed(i)) out[i] = 0;
    }
    return out;
}

// `whole` is the diagonal of A but for the contacts. Where contacts are, their corners' blocks
// stand in place of the diagonal's inverse.
void add_contact_blocks(StepSolver& solver, const Stage& stage, const Aligned<double>& whole)
{
    auto& blocks = solver.high.linear.blocks;
    solver.high.contacts.clear();
    blocks.clear();
    for (const PointContact& c : stage.contacts) {
        ContactBlock<double> block{{}, {}, 0, {}};
        for (std::size_t i = 0; i < 6; ++i) {
            block.matrix[i] = stage.tau * stage.tau * c.stiffness[i] + stage.tau * c.drag[i];
        }
        for (std::size_t a = 0; a < c.count; ++a) {
            const double weight = double(c.weight[a]);
            if (weight == 0) continue;
            const auto k = c.corners[a];
            block.corners[block.count] = k;
            block.weight[block.count++] = weight;
            const double* fixed = &stage.frame.fixed[4 * std::size_t{k}];
            if (fixed[0] + fixed[1] + fixed[2] == 3) continue;
            if (stage.rigid.of_corner(k) != RigidBodies::not_rigid) continue;
            auto& at = solver.block_of[k];
            if (at == no_index) {
                at = static_cast<std::uint32_t>(blocks.size());
                const double* const own = &whole[4 * std::size_t{k}];
                blocks.push_back({k, {own[0], 0, 0, own[1], 0, own[2]}});
            }
            auto& sum = blocks[at].inverse;
            for (std::size_t i = 0; i < 6; ++i) sum[i] += weight * weight * block.matrix[i];
        }
        solver.high.contacts.push_back(block);
    }
    for (auto& block : blocks) {
        block.inverse =
            inverse_of_free(block.inverse, &stage.frame.fixed[4 * std::size_t{block.slot}]);
        solver.block_of[block.slot] = no_index;
        for (std::size_t i = 0; i < 3; ++i) {
            solver.high.linear.inverse[4 * std::size_t{block.slot} + i] = 0;
        }
    }
}

void copy_low(const StepSystem<double>& high, StepSystem<float>& low)
{
    copy_numbers(high.linear.diagonal, low.linear.diagonal);
    copy_numbers(high.linear.inverse, low.linear.inverse);
    low.linear.blocks.clear();
    for (const auto& b : high.linear.blocks) {
        CornerBlock<float> block{b.slot, {}};
        for (std::size_t i = 0; i < 6; ++i) block.inverse[i] = static_cast<float>(b.inverse[i]);
        low.linear.blocks.push_back(block);
    }
    low.contacts.clear();
    for (const auto& c : high.contacts) {
        ContactBlock<float> block{c.corners, {}, c.count, {}};
        for (std::size_t i = 0; i < c.count; ++i) {
            block.weight[i] = static_cast<float>(c.weight[i]);
        }
        for (std::size_t i = 0; i < 6; ++i) block.matrix[i] = static_cast<float>(c.matrix[i]);
        low.contacts.push_back(block);
    }
}

// Work in products with A, as it should be before it is done.
struct Plan {
    double all = 0;
    double an_iteration = 1;
};

// Multigrid, or the diagonal where that should take less.
Plan plan_multigrid(StepSolver& solver, const Stage& stage, const std::vector<double>& mass,
                    double with_diagonal)
{
    // Measured: a cycle costs four products and the coarse grids about two, and takes the residual
    // down by 4 in full cubes, by 2 in cubes filled a thousandth.
    constexpr double products_a_cycle = 6.5;
    const StepFrame& frame = stage.frame;
    Elasticity& elasticity = stage.elasticity;
    const double cycles = 1.2 * std::log(2 / frame.options.tolerance) +
                          25 * static_cast<double>(stage.contacts.size());
    const double work = products_a_cycle * cycles;
    if (with_diagonal < work || solver.direct.work < work) return {with_diagonal, 1};
    const double largest =
        elasticity.prepare_coarse(stage.tau * stage.tau, stage.tau, mass, frame.held);
    if (largest == 0) return {with_diagonal, 1};
    solver.multigrid.start(largest);
    solver.multigrid.held_along = frame.held_along;
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {  // which are solved beside it
        for (const auto slot : stage.rigid.corners(i)) {
            for (std::uint32_t a = 0; a < 3; ++a) {
                solver.multigrid.held_along.push_back(4 * slot + a);
            }
        }
    }
    solver.low.linear.precondition = [&elasticity, &solver](const float* r, float* z) {
        solver.multigrid.apply(solver.low.linear, elasticity, r, z);
    };
    return {work, products_a_cycle};
}

// z = the inverse at rest of r, between the numbers that are free.
void apply_inverse(Elasticity& elasticity, const StepFrame& frame, const float* r, float* z,
                   Aligned<float>& loose)
{
    if (frame.held_along.empty()) return elasticity.apply_inverse(r, z);
    loose.assign(r, r + frame.n);
    for (const auto i : frame.held_along) loose[i] = 0;
    elasticity.apply_inverse(loose.data(), z);
    for (const auto i : frame.held_along) z[i] = 0;
}

// Adds the contacts to the inverse at rest, where the last solve took longer than that.
void add_responses(StepSolver& solver, const Stage& stage)
{
    constexpr std::size_t most = 200;  // contacts: of more, the matrix between them takes longer
    const auto& contacts = solver.low.contacts;
    if (contacts.empty() || contacts.size() > most) return;
    solver.responses.start(stage.tau, stage.linear_at);
    const std::size_t missing = solver.responses.missing(contacts);
    if (missing > 2 * static_cast<std::size_t>(solver.took)) return;
    constexpr std::size_t most_numbers = 30'000'000;  // of all responses, 120 MB
    const auto numbers = [&] {
        return (3 * solver.responses.known.size() + missing) * stage.elasticity.room();
    };
    if (numbers() > most_numbers) solver.responses.keep(contacts);
    if (numbers() > most_numbers) return;
    auto& precondition = solver.low.linear.precondition;
    solver.responses.make(contacts, stage.frame.fixed, stage.elasticity.room(), precondition);
    precondition = [&solver, inverse = std::move(precondition)](const float* r, float* z) {
        inverse(r, z);
        solver.responses.take_contacts(z);
    };
}

// The inverse at rest, multigrid, or the diagonal, by the work that each should take. The diagonal
// takes iterations by the square root of the condition. The other two take a few and up to 25 for
// each contact, of which the inverse and the coarse grids know nothing. What they prepare is kept
// for steps of the length that was asked for, not of those that were halved.
Plan choose_preconditioner(StepSolver& solver, const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    Elasticity& elasticity = stage.elasticity;
    solver.low.linear.precondition = {};
    Aligned<double> diagonal;
    fill_numbers(diagonal, frame.n, 0.0);
    elasticity.add_diagonal(diagonal.data());
    const double inertia = sum_of(solver.high.linear.diagonal), whole = sum_of(diagonal);
    const double with_diagonal =
        0.75 * std::sqrt(whole / inertia) * std::log(2 / frame.options.tolerance);
    if (with_diagonal < 20) return {with_diagonal, 1};
    solver.direct.count(stage);
    const double with_inverse = 6 + 25 * static_cast<double>(stage.contacts.size());
    if (stage.halvings > 0 || with_diagonal < with_inverse) {
        return {with_diagonal, 1};
    }
    std::vector<double> mass(frame.body.corners);
    for (std::size_t k = 0; k < mass.size(); ++k) {
        mass[k] = frame.body.mass[k] + stage.tau * frame.body.damping_of(k);
    }
    const double cost =
        elasticity.prepare_inverse(stage.tau * stage.tau, stage.tau, mass, frame.held);
    if (cost * with_inverse < with_diagonal) {
        solver.low.linear.precondition = [&elasticity, &solver, &frame](const float* r, float* z) {
            apply_inverse(elasticity, frame, r, z, solver.loose);
        };
        add_responses(solver, stage);
        return {cost * with_inverse, cost + 1};
    }
    return plan_multigrid(solver, stage, mass, with_diagonal);
}

template <class T>
void use_elasticity(const StepSolver& solver, const Stage& stage, StepSystem<T>& system)
{
    const Elasticity& elasticity = stage.elasticity;
    system.linear.multiply = [&elasticity, &system](const T* p, T* y) {
        elasticity.multiply(p, y);
        for (const auto& contact : system.contacts) contact.add_times(p, y);
    };
    const RigidBodies& rigid = stage.rigid;
    if (rigid.none()) return;
    system.linear.multiply = [&solver, &rigid, both = std::move(system.linear.multiply)](const T* p,
                                                                                         T* y) {
        both(p, y);
        for (std::size_t i = 0; i < rigid.count(); ++i) {
            for (const auto slot : rigid.corners(i)) {
                for (std::size_t k = 4 * std::size_t{slot}, end = k + 3; k < end; ++k) {
                    y[k] += static_cast<T>(solver.lumped[k]) * p[k];
                }
            }
        }
        rigid.even_out(y);
    };
}

// Lets rigid parts be solved by their own factor, beside what solves the elastic ones. Before it
// is asked, z is what the diagonal and the blocks make of r.
template <class T> void join_rigid(StepSolver& solver, const Stage& stage, LinearSystem<T>& linear)
{
    const RigidBodies& rigid = stage.rigid;
    if (rigid.none()) return;
    linear.precondition = [&solver, &rigid, elastic = std::move(linear.precondition),
                           loose = Aligned<T>(stage.frame.n)](const T* r, T* z) mutable {
        if (elastic) {
            std::copy_n(r, loose.size(), loose.begin());
            const Vec3 zero = Vec3::Zero();
            for (std::size_t i = 0; i < rigid.count(); ++i) rigid.spread(i, zero, zero, &loose[0]);
            elastic(loose.data(), z);
        }
        solver.rigid.solve(r, z);
    };
}

// rest = r - A delta. Returns its norm.
double leftover(StepSolver& solver, Stage& stage)
{
    solver.high.linear.multiply(stage.delta.data(), stage.product.data());
    for_numbers(stage.frame.n, [&](std::size_t i) {
        solver.rest[i] =
            stage.r[i] - stage.product[i] - solver.high.linear.diagonal[i] * stage.delta[i];
    });
    return norm(solver, solver.rest);
}

// Goes on from delta in double precision, for at most so many iterations.
void solve_high(StepSolver& solver, Stage& stage, double target, double most, Solved& out)
{
    if (!all_finite(stage.delta)) std::fill(stage.delta.begin(), stage.delta.end(), 0);
    const bool begins = std::all_of(stage.delta.begin(), stage.delta.end(),
                                    [](double value) { return value == 0; });
    if (begins) {
        solver.rest = stage.r;
    } else {
        leftover(solver, stage);
    }
    solver.high.work.r = solver.rest;
    const int left = stage.frame.options.solver_iterations - out.iterations;
    const int limit = static_cast<int>(std::min<double>(left, most));
    const Solved part = conjugate_gradients(solver.high.linear, target, limit, solver.high.work);
    for_numbers(stage.frame.n, [&](std::size_t i) { stage.delta[i] += solver.high.work.x[i]; });
    out.iterations += part.iterations;
    out.residual = part.residual;
    out.converged = part.converged;
}

// delta += about A^-1 rest, up to a residual of `goal`, in single precision.
Solved add_low(StepSolver& solver, Stage& stage, double goal, int iterations)
{
    auto& work = solver.low.work;
    const auto& rest = solver.rest;
    const double scale =
        greatest_over(rest.size(), [&](std::size_t i) { return std::abs(rest[i]); });
    work.r.resize(stage.frame.n);
    for_numbers(stage.frame.n,
                [&](std::size_t i) { work.r[i] = static_cast<float>(rest[i] / scale); });
    Solved part = conjugate_gradients(solver.low.linear, goal / scale, iterations, work);
    for_numbers(stage.frame.n, [&](std::size_t i) { stage.delta[i] += scale * double(work.x[i]); });
    part.residual *= scale;
    return part;
}

// The share of a factor's time that another way gets before the factor is made after all.
constexpr double patient_share = 0.5;

// Goes on from delta with a factor of A: with one that is there as long as that takes less than a
// new one. False: A has none.
bool solve_directly(StepSolver& solver, Stage& stage, double target, Solved& out)
{
    StepDirect& direct = solver.direct;
    if (!std::isfinite(direct.work)) return false;
    auto& precondition = solver.high.linear.precondition;
    const auto& held_along = stage.frame.held_along;
    const bool elastic = stage.rigid.none();
    precondition = [&solver, &direct, &held_along, elastic](const double* r, double* z) {
        direct.factor->solve(r, z);
        for (const auto i : held_along) z[i] = 0;
        if (elastic) return;
        if (solver.joined.ready()) {
            solver.joined.join(r, z);
        } else {
            solver.rigid.solve(r, z);
        }
    };
    bool sound = true;
    out.converged = false;
    if (direct.serves(stage)) {
        // Contacts come and go between rounds: it may be too old to get there at all.
        const double most = patient_share * direct.work / direct.work_an_iteration;
        solve_high(solver, stage, target, std::max(2.0, most), out);
    }
    if (!out.converged) {
        sound = direct.make(stage, elastic ? solver.high.linear.diagonal : solver.lumped);
        solver.joined.forget();
        if (sound && !elastic) {
            solver.joined.make(stage.rigid, solver.rigid.blocks(), solver.high.contacts,
                               stage.frame.fixed, *direct.factor);
        }
        if (sound) solve_high(solver, stage, target, stage.frame.options.solver_iterations, out);
    }
    precondition = {};
    return sound;
}

// Goes on from delta in double precision, with rigid parts solved at once.
void solve_with_rigid(StepSolver& solver, Stage& stage, double target, Solved& out)
{
    join_rigid(solver, stage, solver.high.linear);
    solve_high(solver, stage, target, stage.frame.options.solver_iterations, out);
    solver.high.linear.precondition = {};
}

// Single precision, and once more on what that leaves over, as long as it gets somewhere.
void solve_low(StepSolver& solver, Stage& stage, double target, int most, Solved& out)
{
    bool refined = false;
    double size = norm(solver, solver.rest);
    while (size > target) {
        const double goal = std::max(target, 1e-5 * size);
        const Solved part = add_low(solver, stage, goal, most - out.iterations);
        out.iterations += part.iterations;
        if (!refined && goal >= 1e-4 * size && part.converged) {
            size = part.residual;
            break;
        }
        refined = true;
        const double before = size;
        size = leftover(solver, stage);
        if (!(size < 0.1 * before) || !std::isfinite(size) || out.iterations >= most) break;
    }
    out.residual = size;
    out.converged = size <= target;
    solver.took = out.iterations;
}

// solve_linear() where the elasticity is coupled.
Solved solve_coupled(StepSolver& solver, Stage& stage, double target)
{
    const int most = stage.frame.options.solver_iterations;
    Solved out;
    fill_numbers(stage.delta, stage.frame.n, 0.0);
    copy_numbers(stage.r, solver.rest);
    const double size = norm(solver, solver.rest);
    if (!std::isfinite(size)) return {false, 0, size};
    use_elasticity(solver, stage, solver.low);
    use_elasticity(solver, stage, solver.high);
    copy_low(solver.high, solver.low);
    if (!stage.rigid.none()) {
        const auto multiply = [&](const double* p, double* y) { stage.elasticity.multiply(p, y); };
        solver.rigid.look(stage.rigid, multiply, stage.elasticity.room(), solver.lumped);
        solver.rigid.make(solver.high.contacts);
    }
    if (stage.rigid.all()) {
        solve_with_rigid(solver, stage, target, out);
        return out;
    }
    const Plan plan = choose_preconditioner(solver, stage);
    join_rigid(solver, stage, solver.low.linear);
    StepDirect& direct = solver.direct;
    const double patience = patient_share * direct.work;
    const double by_now = direct.others_took * std::log(size / target) * plan.an_iteration;
    if (direct.work < plan.all || patience < by_now) {
        if (solve_directly(solver, stage, target, out)) return out;
        if (stage.elasticity.uses_hessian()) return {false, out.iterations, size};
    }
    const double limit = std::max(20.0, patience / plan.an_iteration);
    solve_low(solver, stage, target, static_cast<int>(std::min<double>(most, limit)), out);
    if (out.converged) return out;
    const double gain = std::log(std::max(1.01, size / out.residual));
    direct.others_took = std::max(direct.others_took, out.iterations / gain);
    if (solve_directly(solver, stage, target, out)) return out;
    if (out.iterations < most) solve_with_rigid(solver, stage, target, out);
    return out;
}

}  // namespace

StepSolver::StepSolver(const Stage& stage)
{
    low.linear.numbers = high.linear.numbers = stage.frame.n;
    low.linear.room = high.linear.room = stage.elasticity.room();
    block_of.assign(stage.frame.body.corners, no_index);
}

void prepare(StepSolver& solver, const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    auto& diagonal = solver.high.linear.diagonal;
    diagonal.resize(frame.n);
    Aligned<double> whole(frame.n);
    for_numbers(frame.n, [&](std::size_t i) {
        whole[i] = diagonal[i] = frame.mass[i] + stage.tau * (frame.damping[i] + stage.drag[i]);
    });
    stage.elasticity.couple(1, stage.tau);
    stage.elasticity.add_diagonal(whole.data());
    stage.elasticity.couple(0, 0);
    auto& inverse = solver.high.linear.inverse;
    inverse.resize(frame.n);
    for_numbers(frame.n, [&](std::size_t i) {
        inverse[i] = frame.fixed[i] == 0 && whole[i] > 0 ? 1 / whole[i] : 0;
    });
    add_contact_blocks(solver, stage, whole);
    if (stage.rigid.none()) return;
    solver.lumped = diagonal;
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {  // products with A have it all
        for (const auto slot : stage.rigid.corners(i)) {
            for (std::size_t k = 4 * std::size_t{slot}, end = k + 3; k < end; ++k) {
                diagonal[k] = 0, inverse[k] = 1 / frame.mass[k];
            }
        }
    }
}

double norm(const StepSolver& solver, const Aligned<double>& r)
{
    const LinearSystem<double>& linear = solver.high.linear;
    double sum =
        sum_over(linear.numbers, [&](std::size_t i) { return r[i] * r[i] * linear.inverse[i]; });
    double z[3];
    for (const auto& block : linear.blocks) {
        const CornerBlock<double> at_zero{0, block.inverse};
        sum += at_zero.apply(r.data() + 4 * std::size_t{block.slot}, z);
    }
    return std::sqrt(sum);
}

std::vector<double> norms_of_parts(const StepSolver& solver, const CornerBody& body,
                                   const Aligned<double>& r)
{
    const LinearSystem<double>& linear = solver.high.linear;
    std::vector<double> sum(body.parts, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        for (std::size_t i = 4 * k; i < 4 * k + 3; ++i) {
            sum[body.part_of(k)] += r[i] * r[i] * linear.inverse[i];
        }
    }
    double z[3];
    for (const auto& block : linear.blocks) {
        const CornerBlock<double> at_zero{0, block.inverse};
        sum[body.part_of(block.slot)] += at_zero.apply(r.data() + 4 * std::size_t{block.slot}, z);
    }
    for (double& s : sum) s = std::sqrt(s);
    return sum;
}

Solved solve_linear(StepSolver& solver, Stage& stage, double target)
{
    stage.elasticity.couple(1, stage.tau);
    const Solved out = solve_coupled(solver, stage, target);
    stage.elasticity.couple(0, 0);
    return out;
}

}  // namespace physics
