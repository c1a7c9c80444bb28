#include "physics/implicit_step.hpp"

#include "physics/conjugate_gradients.hpp"
#include "physics/contact.hpp"
#include "physics/outside_forces.hpp"
#include "physics/pins.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

// A contact as the linear solver sees it.
template <class T> struct ContactBlock {
    std::array<std::uint32_t, 8> corners;
    std::array<T, 8> weight;
    std::array<T, 6> matrix;  // xx xy xz yy yz zz

    // y += W^T matrix W p
    void add_times(const T* p, T* y) const
    {
        T u[3] = {0, 0, 0};
        for (std::size_t a = 0; a < 8; ++a) {
            const T* from = p + 4 * std::size_t{corners[a]};
            for (std::size_t i = 0; i < 3; ++i) u[i] += weight[a] * from[i];
        }
        const T f[3] = {matrix[0] * u[0] + matrix[1] * u[1] + matrix[2] * u[2],
                        matrix[1] * u[0] + matrix[3] * u[1] + matrix[4] * u[2],
                        matrix[2] * u[0] + matrix[4] * u[1] + matrix[5] * u[2]};
        for (std::size_t a = 0; a < 8; ++a) {
            T* to = y + 4 * std::size_t{corners[a]};
            for (std::size_t i = 0; i < 3; ++i) to[i] += weight[a] * f[i];
        }
    }
};

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

bool all_finite(const Aligned<double>& v)
{
    double sum = 0;  // any NaN or infinity ends up in it
    for (const double value : v) sum += value * 0;
    return sum == 0;
}

class ImplicitStepper {
public:
    ImplicitStepper(const CornerBody& body, Elasticity& elasticity, const Loads& loads,
                    double frame, const StepOptions& options)
        : body_(body), elasticity_(elasticity), loads_(loads), frame_(frame), options_(options),
          n_(body.numbers)
    {
        for (Aligned<double>* v :
             {&x_, &v_, &start_, &outside_, &windy_, &drag_, &mass_, &damping_, &fixed_, &w_}) {
            v->assign(n_, 0);
        }
        force_.assign(elasticity.room(), 0);
        product_.assign(elasticity.room(), 0);
        low_.numbers = high_.numbers = n_;
        low_.room = high_.room = elasticity.room();
        low_.multiply = [this](const float* p, float* y) {
            elasticity_.multiply(p, y);
            for (const auto& contact : low_contacts_) contact.add_times(p, y);
        };
        high_.multiply = [this](const double* p, double* y) {
            elasticity_.multiply(p, y);
            for (const auto& contact : high_contacts_) contact.add_times(p, y);
        };
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                mass_[4 * k + i] = body.mass[k];
                damping_[4 * k + i] = body.damping_of(k);
            }
        }
        for (const auto k : loads.pins.corner) {
            for (std::size_t i = 0; i < 3; ++i) fixed_[4 * body.slot_of(k) + i] = 1;
        }
        block_of_.assign(body.corners, none);
        add_steady_forces(body, loads.forces, outside_);
        for (const Force& f : loads.forces) windy_weather_ |= f.kind == Force::Kind::wind;
    }

    void run(State& state)
    {
        load(state);
        start_ = x_;
        const double share = 1.0 / options_.substeps;
        for (int i = 0; i < options_.substeps; ++i) {
            const double end = i + 1 == options_.substeps ? 1.0 : (i + 1) * share;
            if (!step_or_halves(i * share, end, 0)) break;
        }
        store(state);
        state.time += frame_;
        state.report = std::move(report_);
    }

private:
    static constexpr std::uint32_t none = 0xffffffff;
    // Most contacts settle in a few rounds with steps that never reverse a slip. From this round on
    // steps take friction nearly by its derivative, and are shortened where they go too far.
    static constexpr int first_wary_round = 3;

    // From share `begin` to share `end` of the frame; in halves where the whole fails.
    bool step_or_halves(double begin, double end, int depth)
    {
        const Aligned<double> x = x_, v = v_;
        depth_ = depth;
        step(begin, end);
        if (all_finite(x_) && all_finite(v_)) return true;
        x_ = x, v_ = v;
        if (depth == 8) {
            report_.converged = false;
            report_.warnings.emplace_back(
                "the step could not be taken, not even in 256 parts; the "
                "state stays as it was. Is something pulled to infinity?");
            return false;
        }
        const double middle = 0.5 * (begin + end);
        return step_or_halves(begin, middle, depth + 1) && step_or_halves(middle, end, depth + 1);
    }

    void step(double begin, double end)
    {
        const double dt = (end - begin) * frame_;
        ++report_.steps;
        switch (options_.integrator) {
        case Integrator::implicit_euler:
            stage(dt, end);
            break;
        case Integrator::implicit_midpoint: {
            const Aligned<double> x = x_, v = v_;
            stage(0.5 * dt, 0.5 * (begin + end));
            for (std::size_t i = 0; i < n_; ++i) {
                x_[i] = 2 * x_[i] - x[i];
                v_[i] = 2 * v_[i] - v[i];
            }
            break;
        }
        case Integrator::sdirk2: {
            const double gamma = 1 - 1 / std::sqrt(2.0);
            const Aligned<double> x = x_, v = v_;
            stage(gamma * dt, begin + gamma * (end - begin));
            // Slopes of the first stage: velocity v_, acceleration (v_ - v) / (gamma dt).
            for (std::size_t i = 0; i < n_; ++i) {
                x_[i] = x[i] + (1 - gamma) * dt * v_[i];
                v_[i] = v[i] + (1 - gamma) / gamma * (v_[i] - v[i]);
            }
            stage(gamma * dt, end);
            break;
        }
        }
        // Pinned corners arrive exactly, and move as their targets do.
        const auto& pins = loads_.pins;
        for (std::size_t i = 0; i < pins.corner.size(); ++i) {
            const std::size_t at = 4 * body_.slot_of(pins.corner[i]);
            for (std::size_t k = 0; k < 3; ++k) {
                x_[at + k] = pinned(i, k, end);
                v_[at + k] = (pinned(i, k, 1) - start_[at + k]) / frame_;
            }
        }
    }

    double pinned(std::size_t pin, std::size_t axis, double share) const
    {
        const double from = start_[4 * body_.slot_of(loads_.pins.corner[pin]) + axis];
        const double to = loads_.pins.target[pin][static_cast<Eigen::Index>(axis)];
        return share == 1 ? to : from + share * (to - from);
    }

    // Implicit Euler from x_, v_ over tau seconds up to share `end` of the frame.
    void stage(double tau, double end)
    {
        tau_ = tau;
        x0_ = x_, v0_ = v_;
        std::fill(windy_.begin(), windy_.end(), 0);
        std::fill(drag_.begin(), drag_.end(), 0);
        if (windy_weather_) {
            add_wind(body_, loads_.forces, x0_.data(), v0_.data(), windy_, drag_);
        }
        colliders_.clear();
        for (const Collider& c : loads_.colliders) {
            colliders_.push_back(pose_collider(c, end, frame_, body_.h));
        }
        w_ = v0_;
        for (std::size_t i = 0; i < loads_.pins.corner.size(); ++i) {
            const std::size_t at = 4 * body_.slot_of(loads_.pins.corner[i]);
            for (std::size_t k = 0; k < 3; ++k)
                w_[at + k] = (pinned(i, k, end) - x0_[at + k]) / tau;
        }
        solve();
        balance_free_parts();
        for (std::size_t i = 0; i < n_; ++i) x_[i] = x0_[i] + tau * w_[i];
        v_ = w_;
    }

    // Elastic forces and their damping add up to nothing over a part. What is left of
    //   sum M (v0 - w) + tau (f_out - D w)
    // of one that nothing holds or touches is therefore the solver's error alone: w moves as a
    // whole to undo it, and linear momentum is right to round-off whatever the tolerance.
    void balance_free_parts()
    {
        free_.assign(body_.parts, 1);
        for (const auto k : loads_.pins.corner) free_[body_.part_of(body_.slot_of(k))] = 0;
        for (const Contact& c : contacts_) free_[body_.part_of(c.corners[0])] = 0;
        missing_.assign(body_.parts, {0, 0, 0});
        inertia_.assign(body_.parts, {0, 0, 0});
        for (std::size_t k = 0; k < body_.corners; ++k) {
            const std::size_t part = body_.part_of(k);
            if (free_[part] == 0) continue;
            for (std::size_t i = 4 * k, a = 0; a < 3; ++i, ++a) {
                const double drag = damping_[i] + drag_[i];
                missing_[part][a] +=
                    mass_[i] * (v0_[i] - w_[i]) + tau_ * (outside_[i] + windy_[i] - drag * w_[i]);
                inertia_[part][a] += mass_[i] + tau_ * drag;
            }
        }
        for (std::size_t k = 0; k < body_.corners; ++k) {
            const std::size_t part = body_.part_of(k);
            if (free_[part] == 0) continue;
            for (std::size_t a = 0; a < 3; ++a) {
                w_[4 * k + a] += missing_[part][a] / inertia_[part][a];
            }
        }
    }

    // The inverse at rest, or the diagonal, by the work that each should take. The diagonal takes
    // iterations by the square root of the condition, the inverse a few and up to 25 for each
    // contact, of which it knows nothing. It is kept for steps of the length that was asked for,
    // not of those that were halved.
    void choose_preconditioner()
    {
        low_.precondition = {};
        if (depth_ > 0) return;
        double inertia = 0, whole = 0;
        for (const double d : high_.diagonal) inertia += d;
        Aligned<double> diagonal(n_, 0);
        elasticity_.add_diagonal(diagonal.data());
        for (const double d : diagonal) whole += d;
        const double with_diagonal =
            0.75 * std::sqrt(whole / inertia) * std::log(2 / options_.tolerance);
        const double with_inverse = 6 + 25 * static_cast<double>(contacts_.size());
        if (with_diagonal < std::max(20.0, with_inverse)) return;
        std::vector<double> mass(body_.corners);
        for (std::size_t k = 0; k < body_.corners; ++k) {
            mass[k] = body_.mass[k] + tau_ * body_.damping_of(k);
        }
        const double cost =
            elasticity_.prepare_inverse(tau_ * tau_, tau_, mass, loads_.pins.corner);
        if (!(cost * with_inverse < with_diagonal)) return;
        low_.precondition = [this](const float* r, float* z) { elasticity_.apply_inverse(r, z); };
    }

    void solve()
    {
        linearise(x0_);
        at_start_ = true;
        wary_ = false;
        place();
        contacts_ = touching();
        const bool free = loads_.pins.corner.empty() && contacts_.empty();
        if (free) fall();
        residual();
        prepare_preconditioner();
        double size = norm(r_);
        const double reference = std::max({size, norm_of_forces(outside_), norm_of_forces(force_)});
        const double target = options_.tolerance * reference;
        const int rounds = std::max(options_.newton_iterations,
                                    colliders_.empty() ? 1 : options_.contact_iterations);
        for (int round = 0; round < rounds && size > target; ++round) {
            wary_ = round + 1 >= first_wary_round;  // of what touches after this round's step
            if (round > 0 && round < options_.newton_iterations) {
                linearise(x_);
                at_start_ = false;
                residual();
                prepare_preconditioner();
            }
            const Solved solved = solve_linear(target);
            report_.iterations += solved.iterations;
            if (round >= first_wary_round) from_ = w_;
            const double slope = dot(r_, delta_);
            for (std::size_t i = 0; i < n_; ++i) w_[i] += delta_[i];
            if (!solved.converged) short_of_iterations_ = true;
            if (round == 0 && violent()) {
                report_.residual = std::max(report_.residual, descend(reference) / reference);
                return;
            }
            if (round + 1 == options_.newton_iterations && colliders_.empty()) {
                size = solved.residual;
                break;
            }
            place();
            contacts_ = touching();
            if (round + 1 < options_.newton_iterations) {
                linearise(x_);
                at_start_ = false;
            }
            residual();
            if (round >= first_wary_round) draw_back(slope);
            prepare_preconditioner();
            size = norm(r_);
            if (!std::isfinite(size)) return;
        }
        if (reference > 0) report_.residual = std::max(report_.residual, size / reference);
        if (!(size <= 1.0001 * target)) unsettled_ = true;
    }

    // Contacts that come and go, stick and slip, can make whole Newton steps go round in circles.
    // The residual is (but for the lag of friction) minus the gradient of a convex function of w:
    // where it points back along the step by more than half of how it pointed on at from_, the
    // step went too far. It ends between, where the function is nearly lowest.
    void draw_back(double slope)
    {
        double low = 0, at_low = slope, high = 1, at_high = dot(r_, delta_);
        for (int i = 0; i < 6 && at_high < -0.5 * slope; ++i) {
            const double share = std::clamp(at_low / (at_low - at_high), 0.1, 0.9);
            const double step = low + share * (high - low);
            for (std::size_t k = 0; k < n_; ++k) w_[k] = from_[k] + step * delta_[k];
            place();
            contacts_ = touching();
            residual();
            const double here = dot(r_, delta_);
            if (std::abs(here) <= 0.5 * slope) return;
            if (here > 0) {
                low = step, at_low = here;
            } else {
                high = step, at_high = here;
            }
        }
    }

    static double dot(const Aligned<double>& a, const Aligned<double>& b)
    {
        double sum = 0;
        for (std::size_t k = 0; k < b.size(); ++k) sum += a[k] * b[k];
        return sum;
    }

    // Whether the linear forces were asked too much: a cube between neighbours in one stage.
    bool violent() const { return !(tau_ * elasticity_.largest_difference(w_.data()) < body_.h); }

    // Phi but for the damping, whose matrix changes with x. Contacts that rub add nothing.
    double potential(const Aligned<double>& w)
    {
        for (std::size_t i = 0; i < n_; ++i) x_[i] = x0_[i] + tau_ * w[i];
        double sum = elasticity_.energy(x_.data());
        for (std::size_t i = 0; i < n_; ++i) {
            const double push = outside_[i] + windy_[i] - 0.5 * (damping_[i] + drag_[i]) * w[i];
            const double jump = w[i] - v0_[i];
            sum += 0.5 * mass_[i] * jump * jump - tau_ * push * w[i];
        }
        if (!colliders_.empty()) {
            for (const Contact& c : touching()) sum += c.energy;
        }
        return sum;
    }

    // Goes down Phi by Newton steps. Returns the residual's norm.
    double descend(double reference)
    {
        constexpr int most = 30;
        // Beyond this the linear solution of an ordinary step would be no better.
        const double target = std::max(options_.tolerance, 1e-3) * reference;
        double phi = set_off_lowest();
        at_start_ = false;
        double size = 0;
        for (int i = 0;; ++i) {
            place();
            contacts_ = touching();
            linearise(x_);
            residual();
            prepare_preconditioner();
            size = norm(r_);
            if (size <= target || !std::isfinite(size)) break;
            const bool tried = i < most;
            if (tried) report_.iterations += solve_linear(0.1 * size).iterations;
            if (!tried || !search_along_delta(phi)) {
                violent_ = true;
                break;
            }
        }
        place();
        return size;
    }

    // w_ becomes the lowest of the linear solution, going on as before, and standing still. Returns
    // its Phi.
    double set_off_lowest()
    {
        Aligned<double> best(n_, 0), on = v0_;
        for (std::size_t i = 0; i < n_; ++i) {
            if (fixed_[i] != 0) on[i] = best[i] = w_[i];
        }
        double phi = potential(best);
        for (Aligned<double>* w : {&on, &w_}) {
            const double here = potential(*w);
            if (here < phi) phi = here, best.swap(*w);
        }
        w_.swap(best);
        return phi;
    }

    // w_ goes as far along delta_ as lowers Phi enough (Armijo's condition); whether it went at
    // all.
    bool search_along_delta(double& phi)
    {
        constexpr int halvings = 12;
        // Damping with K as it is here: 1/2 (w + a delta)^T C (w + a delta), less that at w.
        elasticity_.weigh(0, tau_);
        elasticity_.multiply(delta_.data(), product_.data());
        double slope = 0, linear = 0, square = 0;
        for (std::size_t k = 0; k < n_; ++k) {
            slope += r_[k] * delta_[k];
            linear += w_[k] * product_[k];
            square += delta_[k] * product_[k];
        }
        Aligned<double> trial(n_);
        double step = 1;
        for (int i = 0; i < halvings; ++i, step *= 0.5) {
            for (std::size_t k = 0; k < n_; ++k) trial[k] = w_[k] + step * delta_[k];
            const double next = potential(trial);
            const double damped = step * (linear + 0.5 * step * square);
            if (next + damped > phi - 1e-4 * step * slope || !std::isfinite(next)) continue;
            phi = next;
            w_.swap(trial);
            return true;
        }
        return false;
    }

    // Free corners set off as the steady forces have them.
    void fall()
    {
        for (std::size_t i = 0; i < n_; ++i) {
            if (mass_[i] > 0) w_[i] += tau_ * outside_[i] / mass_[i];
        }
        place();
        contacts_ = touching();
        if (contacts_.empty()) return;
        w_ = v0_;
        place();
        contacts_.clear();
    }

    void place()
    {
        x_.resize(n_);
        for (std::size_t i = 0; i < n_; ++i) x_[i] = x0_[i] + tau_ * w_[i];
    }

    std::vector<Contact> touching() const
    {
        constexpr double nearly =
            0.95;  // the derivative itself may leave a slip with no resistance
        return find_contacts(body_.skin, body_.h, x_.data(), w_.data(), colliders_, tau_,
                             wary_ ? nearly : 0);
    }

    void linearise(const Aligned<double>& x) { elasticity_.forces(x.data(), force_.data()); }

    // r = M (v0 - w) + tau (f + f_out - D w), with f linear about x0 or as it is at x.
    void residual()
    {
        elasticity_.weigh(at_start_ ? tau_ * tau_ : 0, tau_);
        elasticity_.multiply(w_.data(), product_.data());
        r_.resize(n_);
        for (std::size_t i = 0; i < n_; ++i) {
            r_[i] =
                mass_[i] * (v0_[i] - w_[i]) +
                tau_ * (force_[i] + outside_[i] + windy_[i] - (damping_[i] + drag_[i]) * w_[i]) -
                product_[i];
        }
        elasticity_.weigh(tau_ * tau_, tau_);
        for (const Contact& c : contacts_) {
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t i = 0; i < 3; ++i) {
                    r_[4 * std::size_t{c.corners[a]} + i] +=
                        tau_ * double(c.weight[a]) * c.force[static_cast<Eigen::Index>(i)];
                }
            }
        }
    }

    // D, the inverse of A's diagonal, and blocks where contacts are.
    void prepare_preconditioner()
    {
        auto& d = high_.diagonal;
        d.resize(n_);
        for (std::size_t i = 0; i < n_; ++i) d[i] = mass_[i] + tau_ * (damping_[i] + drag_[i]);
        Aligned<double> whole = d;
        elasticity_.add_diagonal(whole.data());
        auto& inverse = high_.inverse;
        inverse.resize(n_);
        for (std::size_t i = 0; i < n_; ++i) {
            inverse[i] = fixed_[i] == 0 && whole[i] > 0 ? 1 / whole[i] : 0;
        }

        high_contacts_.clear();
        high_.blocks.clear();
        for (const Contact& c : contacts_) {
            ContactBlock<double> block{c.corners, {}, {}};
            for (std::size_t i = 0; i < 6; ++i) {
                block.matrix[i] = tau_ * tau_ * c.stiffness[i] + tau_ * c.drag[i];
            }
            for (std::size_t a = 0; a < 8; ++a) {
                const double weight = double(c.weight[a]);
                block.weight[a] = weight;
                const auto k = c.corners[a];
                if (weight == 0 || fixed_[4 * std::size_t{k}] != 0) continue;
                if (block_of_[k] == none) {
                    block_of_[k] = static_cast<std::uint32_t>(high_.blocks.size());
                    const double own = whole[4 * std::size_t{k}];
                    high_.blocks.push_back({k, {own, 0, 0, own, 0, own}});
                }
                auto& sum = high_.blocks[block_of_[k]].inverse;
                for (std::size_t i = 0; i < 6; ++i) sum[i] += weight * weight * block.matrix[i];
            }
            high_contacts_.push_back(block);
        }
        for (auto& block : high_.blocks) {
            block.inverse = inverse_of(block.inverse);
            block_of_[block.slot] = none;
            for (std::size_t i = 0; i < 3; ++i) inverse[4 * std::size_t{block.slot} + i] = 0;
        }
    }

    double norm(const Aligned<double>& r) const
    {
        double sum = 0;
        for (std::size_t i = 0; i < n_; ++i) sum += r[i] * r[i] * high_.inverse[i];
        double z[3];
        for (const auto& block : high_.blocks) {
            CornerBlock<double> at_zero{0, block.inverse};
            sum += at_zero.apply(r.data() + 4 * std::size_t{block.slot}, z);
        }
        return std::sqrt(sum);
    }

    double norm_of_forces(const Aligned<double>& f) const { return tau_ * norm(f); }

    // delta_ with A delta = r up to a residual of `target`: in single precision, again on what is
    // left over where that is not enough, and in double where single gets nowhere.
    Solved solve_linear(double target)
    {
        Solved out;
        delta_.assign(n_, 0);
        rest_ = r_;
        double size = norm(rest_);
        if (!std::isfinite(size)) return {false, 0, size};
        copy_low();
        choose_preconditioner();
        bool refined = false;
        while (size > target) {
            const double goal = std::max(target, 1e-5 * size);
            double scale = 0;
            for (const double value : rest_) scale = std::max(scale, std::abs(value));
            low_work_.r.resize(n_);
            for (std::size_t i = 0; i < n_; ++i) {
                low_work_.r[i] = static_cast<float>(rest_[i] / scale);
            }
            const int left = options_.solver_iterations - out.iterations;
            const Solved part = conjugate_gradients(low_, goal / scale, left, low_work_);
            out.iterations += part.iterations;
            for (std::size_t i = 0; i < n_; ++i) delta_[i] += scale * double(low_work_.x[i]);
            if (!refined && goal >= 1e-4 * size && part.converged) {
                size = part.residual * scale;
                break;
            }
            refined = true;
            const double before = size;
            size = leftover();
            if (!(size < 0.1 * before) || !std::isfinite(size)) {
                solve_high(target, out);
                return out;
            }
            if (out.iterations >= options_.solver_iterations) break;
        }
        out.residual = size;
        out.converged = size <= target;
        return out;
    }

    // rest_ = r - A delta
    double leftover()
    {
        high_.multiply(delta_.data(), product_.data());
        for (std::size_t i = 0; i < n_; ++i) {
            rest_[i] = r_[i] - product_[i] - high_.diagonal[i] * delta_[i];
        }
        return norm(rest_);
    }

    void solve_high(double target, Solved& out)
    {
        if (!all_finite(delta_)) std::fill(delta_.begin(), delta_.end(), 0);
        leftover();
        high_work_.r = rest_;
        const int left = options_.solver_iterations - out.iterations;
        const Solved part = conjugate_gradients(high_, target, left, high_work_);
        for (std::size_t i = 0; i < n_; ++i) delta_[i] += high_work_.x[i];
        out.iterations += part.iterations;
        out.residual = part.residual;
        out.converged = part.converged;
    }

    void copy_low()
    {
        low_.diagonal.assign(high_.diagonal.begin(), high_.diagonal.end());
        low_.inverse.assign(high_.inverse.begin(), high_.inverse.end());
        low_.blocks.clear();
        for (const auto& b : high_.blocks) {
            CornerBlock<float> low{b.slot, {}};
            for (std::size_t i = 0; i < 6; ++i) low.inverse[i] = static_cast<float>(b.inverse[i]);
            low_.blocks.push_back(low);
        }
        low_contacts_.clear();
        for (const auto& c : high_contacts_) {
            ContactBlock<float> low{c.corners, {}, {}};
            for (std::size_t i = 0; i < 8; ++i) low.weight[i] = static_cast<float>(c.weight[i]);
            for (std::size_t i = 0; i < 6; ++i) low.matrix[i] = static_cast<float>(c.matrix[i]);
            low_contacts_.push_back(low);
        }
    }

    void load(const State& state)
    {
        for (std::size_t k = 0; k < body_.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                const auto axis = static_cast<Eigen::Index>(i);
                x_[4 * body_.slot_of(k) + i] = state.x[k][axis];
                v_[4 * body_.slot_of(k) + i] = state.v[k][axis];
            }
        }
    }

    void store(State& state)
    {
        for (std::size_t k = 0; k < body_.corners; ++k) {
            const std::size_t at = 4 * body_.slot_of(k);
            state.x[k] = Vec3(x_[at], x_[at + 1], x_[at + 2]);
            state.v[k] = Vec3(v_[at], v_[at + 1], v_[at + 2]);
        }
        say_what_fell_short();
    }

    void say_what_fell_short()
    {
        if (!short_of_iterations_ && !unsettled_ && !violent_) return;
        report_.converged = false;
        const std::string what =
            short_of_iterations_ ? "the linear solver ran out of iterations: raise "
                                   "step.solver_iterations"
            : violent_           ? "the motion is too violent for the step: raise step.substeps"
            : colliders_.empty() ? "raise step.newton_iterations or step.substeps"
                                 : "contact did not settle: raise step.contact_iterations or "
                                   "step.substeps";
        report_.warnings.push_back("forces were left unbalanced beyond step.tolerance; " + what);
    }

    const CornerBody& body_;
    Elasticity& elasticity_;
    const Loads& loads_;
    double frame_;  // s
    StepOptions options_;
    std::size_t n_;

    Aligned<double> x_, v_;             // where the step has got to
    Aligned<double> start_;             // x at the start of the frame
    Aligned<double> x0_, v0_;           // at the start of the stage
    Aligned<double> w_, from_;          // velocities sought; before a wary round
    Aligned<double> outside_;           // N, steady forces
    Aligned<double> windy_, drag_;      // N, N s/m
    Aligned<double> mass_, damping_;    // kg, kg/s
    Aligned<double> fixed_;             // 1: pinned
    Aligned<double> force_, product_;   // elastic forces; K w
    Aligned<double> r_, rest_, delta_;  // residual, what a solve leaves of it, change of w
    double tau_ = 0;                    // s
    int depth_ = 0;                     // times the step was halved
    bool at_start_ = true;              // forces are linear about x0_, not evaluated at x_
    bool windy_weather_ = false;
    bool wary_ = false;                           // of friction in contacts to be found
    std::vector<std::uint8_t> free_;              // parts that nothing holds or touches
    std::vector<std::array<double, 3>> missing_;  // of each part, N s
    std::vector<std::array<double, 3>> inertia_;  // of each part, kg
    // What stopped a solve before its tolerance was met.
    bool short_of_iterations_ = false, unsettled_ = false, violent_ = false;
    std::vector<PosedCollider> colliders_;
    std::vector<Contact> contacts_;
    std::vector<ContactBlock<float>> low_contacts_;
    std::vector<ContactBlock<double>> high_contacts_;
    std::vector<std::uint32_t> block_of_;  // of each slot while blocks are added up
    LinearSystem<float> low_;
    LinearSystem<double> high_;
    ConjugateVectors<float> low_work_;
    ConjugateVectors<double> high_work_;
    Report report_;
};

void check_state(const CornerBody& body, const State& state)
{
    const auto expected = std::to_string(body.corners);
    if (state.x.size() != body.corners || state.v.size() != body.corners) {
        throw std::invalid_argument("state: expected " + expected + " corners, found " +
                                    std::to_string(state.x.size()) +
                                    ". Was it made with other cubes?");
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        if (!state.x[k].allFinite() || !state.v[k].allFinite()) {
            throw std::invalid_argument("state: corner " + std::to_string(k) +
                                        " has a position or velocity that is not finite");
        }
    }
}

}  // namespace

double Elasticity::prepare_inverse(double, double, const std::vector<double>&,
                                   const std::vector<std::uint32_t>&)
{
    return std::numeric_limits<double>::infinity();
}

void Elasticity::apply_inverse(const float*, float*) {}

State advance_implicitly(const CornerBody& body, Elasticity& elasticity, State state,
                         const Loads& loads, double dt, const StepOptions& options)
{
    if (!(std::isfinite(dt) && dt > 0)) {
        throw std::invalid_argument("expected a time step above 0 s, found " + std::to_string(dt));
    }
    if (options.substeps < 1) throw std::invalid_argument("expected at least one substep");
    check_state(body, state);
    check_pins(loads.pins, body.corners);
    check_forces(loads.forces);
    ImplicitStepper(body, elasticity, loads, dt, options).run(state);
    return state;
}

State rest_state(const CornerBody& body)
{
    State state;
    state.x.resize(body.corners);
    state.v.assign(body.corners, Vec3::Zero());
    for (std::size_t k = 0; k < body.corners; ++k) {
        const double* at = body.rest.data() + 4 * body.slot_of(k);
        state.x[k] = Vec3(at[0], at[1], at[2]);
    }
    return state;
}

}  // namespace physics
