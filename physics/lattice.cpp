#include "physics/lattice.hpp"

#include "geometry/parallel.hpp"
#include "physics/balls.hpp"
#include "physics/lattice_contact.hpp"
#include "physics/lattice_pull.hpp"
#include "physics/match_regions.hpp"
#include "physics/outside_forces.hpp"
#include "physics/pins.hpp"
#include "physics/report_texts.hpp"
#include "physics/rotation.hpp"
#include "physics/torn_regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace physics {

namespace {

constexpr std::size_t grain = 2048;
constexpr std::size_t strips_grain = 32;  // of a membrane, up to 64 cells each

// The next of 1, 2, 5, 10, 20 ... : so that frames that differ a little advise the same.
double round_number(double v)
{
    const double ten = std::pow(10, std::floor(std::log10(v)));
    for (const double times : {1, 2, 5}) {
        if (v <= times * ten) return times * ten;
    }
    return 10 * ten;
}

// alpha of a rate s over dt.
double share_of(double rate_sq, double dt)
{
    return std::min(1.0, rate_sq * dt * dt);
}

// Calls with(i) for i below n, on all threads.
template <class With> void for_each(std::size_t n, const With& with)
{
    geometry::parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) with(i);
    });
}

// The largest of(i) for i below n, or 0; `piece` of them a task.
template <class Of> double largest_of(std::size_t n, const Of& of, std::size_t piece = grain)
{
    struct Largest {
        double value = 0;
        Largest operator+(const Largest& o) const { return {std::max(value, o.value)}; }
    };
    const auto of_piece = [&](std::size_t begin, std::size_t end) {
        Largest most;
        for (std::size_t i = begin; i < end; ++i) most.value = std::max(most.value, of(i));
        return most;
    };
    return geometry::ordered_sum<Largest>(n, piece, {}, of_piece).value;
}

template <class T> class Stepper {
public:
    using Vec = Eigen::Matrix<T, 3, 1>;
    using Mat = Eigen::Matrix<T, 3, 3>;

    Stepper(const LatticeBody& body, State& state, const Loads& loads, double frame,
            const LatticeOptions& options)
        : body_(body), state_(state), loads_(loads), options_(options), frame_(frame),
          dt_(frame / options.substeps), n_(body.base.corners), flat_(body.flat_axis >= 0),
          in_plane_(body.options.plane == PlaneMotion::in_plane), sums_(body.whole.regions)
    {
        for (const auto k : loads.pins.corner) start_.push_back(state.x[k]);
        touches_ = !loads.colliders.empty() || !loads.balls.empty() || body.options.contact.on;
        if (touches_) {
            for (const double m : body.base.mass) inverse_mass_.push_back(m > 0 ? 1 / m : 0);
            for (const auto k : loads.pins.corner) inverse_mass_[k] = 0;
        }
        const std::size_t slots = body.whole.regions.slots(), kept = 4 * slots + 3 * n_;
        has_before_ = state.rotation.size() == kept;
        if (!has_before_) state.rotation.assign(kept, 0.0f);
        plastic_ = body.options.plastic.yield > 0;
        const std::size_t plastic = plastic_ ? 6 * slots : 0;
        if (state.plastic.size() != plastic) state.plastic.assign(plastic, 0.0f);
        if (!body.torn) state.broken.clear();

        std::vector<Force> points;
        for (const Force& f : loads.forces) {
            if (f.kind == Force::Kind::gravity) gravity_ += f.acceleration;
            if (f.kind == Force::Kind::point) points.push_back(f);
            if (f.kind == Force::Kind::wind) windy_ = true;
        }
        if (!points.empty() || windy_) {
            steady_.assign(body.base.numbers, 0);
            add_steady_forces(body.base, points, steady_);
        }
        damped_ = largest_of(n_, [&](std::size_t i) { return body.base.damping_of(i); }) > 0;
        mass_ =
            geometry::ordered_sum<double>(n_, grain, 0, [&](std::size_t begin, std::size_t end) {
                const auto from = body.base.mass.begin();
                return std::accumulate(from + std::ptrdiff_t(begin), from + std::ptrdiff_t(end),
                                       0.0);
            });
        use_regions(state.broken);
        if (state.balls.size() != loads.balls.size()) state.balls = place_balls(loads.balls);
    }

    void run()
    {
        take_origin_after([](std::size_t) {});
        const double crossed = cells_crossed();
        for (int i = 1; i <= options_.substeps; ++i) step(double(i) / options_.substeps);
        state_.time += frame_;
        state_.report = {};
        state_.report.steps = options_.substeps;
        if (crossed > most_crossed) {
            state_.report.converged = false;
            const double needed = round_number(options_.substeps * crossed / most_crossed);
            state_.report.warnings.push_back(
                "the plane is thrown about faster than its steps can follow, and heats up; " +
                (needed <= most_substeps
                     ? fmt::format("take {} substeps or more", needed)
                     : fmt::format("{} substeps would not do: is it pushed that hard on purpose?",
                                   most_substeps)));
        }
        warn_of_wide_regions();
        warn_of_inverted();
        if (options_.stiffness == Stiffness::material && resolved_ > 1) {
            const int least = least_substeps();
            const bool more = least <= most_substeps;
            state_.report.converged = false;
            state_.report.warnings.push_back(
                bends_in_space()
                    ? fmt::format("the plane is softer than its material: cells of {:.3g} m can be "
                                  "that stiff only at {} substeps or more; {}make larger cells",
                                  body_.base.h, least, more ? "take more substeps or " : "")
                    : fmt::format("the lattice is softer than its material: regions of half width "
                                  "{} can be that stiff only at {} substeps or more; widen the "
                                  "regions{} or set a rate",
                                  body_.whole.regions.half_width, least,
                                  more ? ", take more substeps" : ""));
        }
    }

    // Measured on cantilevers: solids bend a fifth to a third too far at a fifth of their length,
    // planes half too far at a tenth.
    void warn_of_wide_regions()
    {
        const int w = body_.whole.regions.half_width, length = body_.slender;
        const bool plane = bends_in_space();
        if (options_.stiffness != Stiffness::material || (flat_ && !plane) || length < 6) return;
        if ((plane ? 12 : 5) * w < length || w == 1) return;
        state_.report.warnings.push_back(fmt::format(
            "regions of half width {} are wide for a body {} cubes long: it bends too far for its "
            "material; take a half width of {}, or smaller cubes",
            w, length, std::max(1, length / (plane ? 16 : 10))));
    }

    // A lattice comes back from anything, so what is less than a quarter does not matter. Only the
    // skin's are counted.
    void warn_of_inverted()
    {
        if (flat_ || !state_.broken.empty()) return;
        const CornerRuns& cubes = body_.base.skin.corners;
        std::size_t count = 0;
        cubes.for_each(0, cubes.size(), [&](std::size_t, const CornerRuns::Corners& corners) {
            Mat3 sides = Mat3::Zero();
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t d = 0; d < 3; ++d) {
                    sides.col(Eigen::Index(d)) +=
                        (a >> d & 1 ? 0.25 : -0.25) * state_.x[corners[a]];
                }
            }
            count += sides.determinant() < 0;
        });
        if (4 * count < cubes.size() || count == 0) return;
        state_.report.warnings.push_back(told_of_inverted(count, cubes.size()));
    }

    int least_substeps() const
    {
        return int(std::min(1e9, std::ceil(options_.substeps * resolved_)));
    }

private:
    bool bends_in_space() const { return flat_ && !in_plane_; }

    // Measures from the middle of the particles after `visit` has been at the pieces begin .. end
    // of them, which may move them and returns the sum of their places.
    template <class Visit> void take_origin(const Visit& visit)
    {
        const Vec3 sum = geometry::ordered_sum<Vec3>(n_, grain, Vec3::Zero(), visit);
        origin_ = sum / double(n_);
    }
    // The same particle by particle.
    template <class Visit> void take_origin_after(const Visit& visit)
    {
        take_origin([&](std::size_t begin, std::size_t end) {
            Vec3 sum = Vec3::Zero();
            for (std::size_t i = begin; i < end; ++i) {
                visit(i);
                sum += state_.x[i];
            }
            return sum;
        });
    }

    // How many cells the ends of a plane's links pass each other by in a substep, at most.
    double cells_crossed() const
    {
        if (membrane_share_.empty()) return 0;
        const Membrane& membrane = body_.membrane;
        const auto& v = state_.v;
        const auto fastest_of = [&](std::size_t strip) {
            double most = 0;
            membrane.for_each_cell(strip, strip + 1, [&](std::size_t, const Membrane::Cell& cell) {
                for (const std::size_t side : {1u, 2u}) {
                    most = std::max(most, (v[cell[side]] - v[cell[0]]).squaredNorm());
                }
            });
            return most;
        };
        const double fastest_sq = largest_of(membrane.strip.size(), fastest_of, strips_grain);
        return std::sqrt(fastest_sq) * dt_ / body_.base.h;
    }

    void step(double share)
    {
        find_goals();
        pull();
        push_from_outside();
        collide(share);
        move(share);
        if (body_.torn && options_.tear > 0) tear();
    }

    // The regions of the lattice without `broken`, and the weights of each.
    void use_regions(const std::vector<std::uint32_t>& broken)
    {
        held_regions_ =
            body_.torn && !broken.empty() ? body_.torn->find(body_.whole, broken) : nullptr;
        matched_ = held_regions_ ? held_regions_.get() : &body_.whole;
        sums_.exceptional.resize(4 * matched_->regions.exceptions.nodes());
        torn_skin_.reset();
        if (touches_ && held_regions_) {
            torn_skin_.emplace(body_.base.skin, body_.torn->lattice(), broken, body_.base.h);
        }
        torn_corners_ =
            broken.empty() ? std::vector<std::uint8_t>{} : torn_corners(body_.membrane, broken);

        const bool material = options_.stiffness == Stiffness::material;
        const std::size_t slots = matched_->regions.slots();
        const bool bends = bends_in_space();
        // Regions of a plane in space resist bending, and of stretch only what is left to them.
        const auto rate_sq = [&](std::size_t s) {
            const double stretch =
                material ? double(matched_->rate_sq[s]) : options_.rate * options_.rate;
            if (!bends) return stretch;
            return options_.bend * (material ? double(matched_->bend_sq[s]) : stretch);
        };
        const double largest = largest_of(slots, [&](std::size_t s) {
            return matched_->regions.particle[s] != none ? rate_sq(s) : 0;
        });
        resolved_ = std::sqrt(largest) * dt_;
        const double stiffest = bends ? share_membrane() : 0;
        stiffness_ = share_of(largest, dt_) + stiffest;
        const double tau = body_.damping + options_.damping;
        // Steps are stable below stiffness + 2 damping = 4.
        damping_ = tau > 0 ? std::min(-std::expm1(-tau * (largest * dt_ + stiffest / dt_)),
                                      (4 - stiffness_) / 3)
                           : 0;

        if (bends) take_twist();
        weigh_pins();
        weight_.resize(slots);
        const double scale = stiffness_ > 0 ? 1 / stiffness_ : 0;
        for_each(slots, [&](std::size_t s) {
            const bool some = matched_->regions.particle[s] != none;
            weight_[s] = some ? T(share_of(rate_sq(s), dt_) * scale) : T(0);
        });
        for_each(membrane_share_.size(), [&](std::size_t c) { membrane_share_[c] *= T(scale); });
        sum_weights();
    }

    // What of the membrane's stiffness steps this long can bear, dt^2 E V / h^2 of each cell, less
    // what regions resist too. Returns the largest share of a particle.
    double share_membrane()
    {
        const Membrane& membrane = body_.membrane;
        const double w = matched_->regions.half_width;
        const double m2 = mean_square_place(w), bent = 3 * (mean_fourth_place(w) - m2 * m2) / m2;
        const bool material = options_.stiffness == Stiffness::material;
        const double rate_sq = std::min(options_.rate * options_.rate, 1e200);
        std::vector<double> share(membrane.cells());
        for_each(share.size(), [&](std::size_t c) {
            const double bend = options_.bend * (material ? double(membrane.bend[c]) / bent : 1);
            const double stiffness =
                material ? double(membrane.stiffness[c]) : rate_sq * m2 * double(membrane.mass[c]);
            share[c] = bend < 1 ? (1 - bend) * stiffness * dt_ * dt_ : 0;
        });
        membrane_share_.clear();
        if (!(largest_of(share.size(), [&](std::size_t c) { return share[c]; }) > 0)) return 0;

        std::vector<double> sum = sum_at_corners(membrane, share, n_);
        for_each(n_, [&](std::size_t i) { sum[i] *= 2 / body_.base.mass[i]; });
        const double largest = largest_of(n_, [&](std::size_t i) { return sum[i]; });
        resolved_ = std::max(resolved_, std::sqrt(largest / most_membrane));
        membrane_share_.resize(share.size());
        const auto bear = [&](std::size_t c, const Membrane::Cell& cell) {
            double most = 0;
            for (const auto k : cell) most = std::max(most, sum[k]);
            membrane_share_[c] =
                T(most > most_membrane ? share[c] * (most_membrane / most) : share[c]);
        };
        geometry::parallel_for(
            membrane.strip.size(), strips_grain,
            [&](std::size_t begin, std::size_t end) { membrane.for_each_cell(begin, end, bear); });
        return std::min(largest, most_membrane);
    }

    // A wall that holds corners goes on behind them, where the lattice may end. So regions weigh
    // them by more, until what is held in the region of each counts as much as what is not: 2w
    // times, for one layer of corners at the end of a beam. Without, the end gives way, and
    // cantilevers sag by up to three times as much.
    void weigh_pins()
    {
        const auto& pins = loads_.pins.corner;
        if (pins.empty()) return;
        const LatticeRegions& regions = matched_->regions;
        with_pins_ = matched_->mass;
        auto& f = sums_.particles;
        for_each(n_, [&](std::size_t i) { f[i] = Quad<T>(T(body_.base.mass[i]), 0, 0, 0); });
        for (const auto k : pins) f[k] = Quad<T>(0, T(body_.base.mass[k]), 0, 0);
        std::vector<float> times(n_, 1.0f);
        std::vector<std::uint8_t> holds(regions.slots(), 0);
        collect<T>(regions, sums_, [&](std::size_t first, std::span<const Quad<T>> slots) {
            for (std::size_t s = first; s < first + slots.size() / 4; ++s) {
                const Quad<T>& sum = slots[4 * (s - first)];
                if (!(sum[1] > 0)) continue;  // without a particle it is 0
                times[regions.particle[s]] = float(sum[0] / sum[1]);
                holds[s] = 1;
            }
        });
        const auto most = 2.0f * float(regions.half_width);
        const float least = bends_in_space() ? 2.0f : 1.0f;
        for (const auto k : pins) {
            with_pins_[k] = matched_->mass[k] * std::clamp(times[k], least, most);
        }
        if (!bends_in_space()) return;
        if constexpr (std::is_same_v<T, float>) own_twist_ = matched_->twist;
        find_own_twist(with_pins_, [&](std::size_t s) { return holds[s] != 0; });
    }

    // That of the body, or as exact as the sums are.
    void take_twist()
    {
        if constexpr (std::is_same_v<T, float>) {
            twist_ = matched_->twist.data();
        } else {
            find_own_twist(matched_->mass, [](std::size_t) { return true; });
        }
    }

    // Of the slots that `which` says, where particles weigh `mass`.
    void find_own_twist(const std::vector<float>& mass,
                        const std::function<bool(std::size_t)>& which)
    {
        const LatticeRegions& regions = matched_->regions;
        const auto steps_from_first = [&](std::size_t i) {
            std::array<double, 2> out;
            for (std::size_t d = 0; d < 2; ++d) {
                const double* const rest = body_.base.rest.data() + regions.axes[d];
                out[d] = std::round((rest[4 * i] - rest[0]) / body_.base.h);
            }
            return out;
        };
        find_twist(regions, mass, steps_from_first, which, own_twist_);
        twist_ = own_twist_.data();
    }

    // Sums of weights over the regions that hold each particle: they do not change with motion.
    void sum_weights()
    {
        spread<T>(matched_->regions, sums_, [&](std::size_t first, std::span<Quad<T>> slots) {
            for (std::size_t k = 0; 4 * k < slots.size(); ++k) slots[4 * k][0] = weight_[first + k];
        });
        const auto& g = sums_.particles;
        held_weight_.resize(n_);
        for_each(n_, [&](std::size_t i) { held_weight_[i] = g[i][0]; });
    }

    // The sums of T_r X_i, weighed, into the particles' quads.
    void find_goals()
    {
        const auto& mass = with_pins_.empty() ? matched_->mass : with_pins_;
        auto& f = sums_.particles;
        geometry::parallel_for(n_, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const T m = T(mass[i]);
                const Vec3 p = state_.x[i] - origin_;
                f[i] = Quad<T>(m * T(p[0]), m * T(p[1]), m * T(p[2]), m);
            }
        });
        collect_and_spread<T>(
            matched_->regions, sums_, [&](std::size_t first, std::span<Quad<T>> slots) {
                if (std::is_same_v<T, float> && !plastic_ && !in_plane_) {
                    match_rigid(first, slots);
                    return;
                }
                for (std::size_t s = 0; 4 * s < slots.size(); s += batch) {
                    const auto some =
                        slots.subspan(4 * s, std::min(4 * batch, slots.size() - 4 * s));
                    if (in_plane_) {
                        match_in_plane(first + s, some);
                    } else {
                        match_shapes(first + s, some);
                    }
                }
            });
    }

    // How far a plane's region is bent like a saddle, as far as it may stay so, into s[3]: (1 -
    // phi) / B P. s is its sums. Returns a of its psi.
    T keep_twist(std::size_t slot, Quad<T>* s) const
    {
        const auto& [b, c, loose] = twist_[slot];
        const T inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
        const auto about_middle = [&](int q) -> Quad<T> { return s[q] - s[q][3] * inverse * s[0]; };
        const Quad<T> bent = about_middle(3) - b * about_middle(1) - c * about_middle(2);
        const T a = inverse * (s[3][3] - b * s[1][3] - c * s[2][3]);
        s[3] = loose * bent;
        s[3][3] = T(0);
        return a;
    }

    // Adds what keep_twist() left in s[3] to what is spread, times the slot's weight.
    void add_twist(std::size_t slot, T a, Quad<T>* s) const
    {
        s[3] *= weight_[slot];
        s[0] -= a * s[3];
        s[1] -= twist_[slot].b * s[3];
        s[2] -= twist_[slot].c * s[3];
    }

    // A_r of a slot, with the columns of rest axes; s is its sums.
    Mat moment_matrix(const Quad<T>* s) const
    {
        const LatticeRegions& regions = matched_->regions;
        const T inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
        Mat m = Mat::Zero();
        for (std::size_t d = 1; d <= regions.sides(); ++d) {
            m.col(regions.axes[d - 1]) =
                (s[d] - (s[d][3] * inverse) * s[0]).template head<3>().matrix();
        }
        return m;
    }

    // match_shapes() where nothing flows and sums are single, many regions at a time.
    void match_rigid(std::size_t first, std::span<Quad<T>> slots)
    {
        if constexpr (std::is_same_v<T, float>) {
            match_slots(slots.size() / 4, slots.data()->data(), weight_.data() + first,
                        flat_ ? &twist_[first].b : nullptr, state_.rotation.data() + 4 * first,
                        matched_->regions.axes, float(body_.base.h));
        }
    }

    // From sums over regions to their rigid motions, with weights. At most a batch.
    void match_shapes(std::size_t begin, std::span<Quad<T>> slots)
    {
        const LatticeRegions& regions = matched_->regions;
        const std::size_t count = slots.size() / 4;
        alignas(64) T a[9 * batch], q[4 * batch];
        float* const rotation = state_.rotation.data();
        for (std::size_t k = 0; k < count; ++k) {
            Mat m = moment_matrix(&slots[4 * k]);
            if (plastic_) m = (m * rest_shape(begin + k)).eval();
            if (flat_) complete(m);
            for (int i = 0; i < 9; ++i) a[std::size_t(i) * batch + k] = m(i / 3, i % 3);
            for (std::size_t c = 0; c < 4; ++c) q[c * batch + k] = T(rotation[4 * (begin + k) + c]);
        }
        extract_rotations(count, a, batch, q, batch);
        const T h = T(body_.base.h);
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t slot = begin + k;
            Quad<T>* const s = &slots[4 * k];
            const Eigen::Quaternion<T> turn(q[k], q[batch + k], q[2 * batch + k], q[3 * batch + k]);
            for (std::size_t c = 0; c < 4; ++c) rotation[4 * slot + c] = float(q[c * batch + k]);
            Mat r = turn.toRotationMatrix();
            if (plastic_) {
                flow(slot, moment_matrix(s), r);
                r = (r * rest_shape(slot)).eval();
            }
            const T weight = weight_[slot], inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
            const Vec centre = inverse * s[0].template head<3>().matrix();
            Vec moved = centre;
            const T twisted = flat_ ? keep_twist(slot, s) : T(0);
            for (std::size_t d = 1; d <= regions.sides(); ++d) {
                const Vec column = h * r.col(regions.axes[d - 1]);
                moved -= (s[d][3] * inverse) * column;  // C_r - X_r, lattice steps
                s[d] = Quad<T>(weight * column[0], weight * column[1], weight * column[2], T(0));
            }
            moved *= weight;
            s[0] = Quad<T>(moved[0], moved[1], moved[2], T(0));
            if (flat_) add_twist(slot, twisted, s);
        }
    }

    // The same in two dimensions: rotations have a closed form.
    void match_in_plane(std::size_t begin, std::span<Quad<T>> slots)
    {
        const LatticeRegions& regions = matched_->regions;
        const int u = regions.axes[0], v = regions.axes[1];
        const std::size_t count = slots.size() / 4;
        alignas(64) T a[4 * batch], turn[2 * batch];
        float* const rotation = state_.rotation.data();
        for (std::size_t k = 0; k < count; ++k) {
            Mat m = moment_matrix(&slots[4 * k]);
            if (plastic_) m = (m * rest_shape(begin + k)).eval();
            a[k] = m(u, u);
            a[batch + k] = m(u, v);
            a[2 * batch + k] = m(v, u);
            a[3 * batch + k] = m(v, v);
            for (std::size_t c = 0; c < 2; ++c) {
                turn[c * batch + k] = T(rotation[4 * (begin + k) + c]);
            }
        }
        extract_rotations_2d(count, a, batch, turn, batch);
        const T h = T(body_.base.h);
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t slot = begin + k;
            Quad<T>* const s = &slots[4 * k];
            const T cosine = turn[k], sine = turn[batch + k];
            rotation[4 * slot] = float(cosine);
            rotation[4 * slot + 1] = float(sine);
            Mat r = Mat::Identity();
            r(u, u) = r(v, v) = cosine;
            r(u, v) = -sine;
            r(v, u) = sine;
            if (plastic_) {
                flow(slot, moment_matrix(s), r);
                r = (r * rest_shape(slot)).eval();
            }
            const T weight = weight_[slot], inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
            Vec moved = inverse * s[0].template head<3>().matrix();
            for (std::size_t d = 1; d < 3; ++d) {
                const Vec column = h * r.col(regions.axes[d - 1]);
                moved -= (s[d][3] * inverse) * column;
                s[d] = Quad<T>(weight * column[0], weight * column[1], weight * column[2], T(0));
            }
            s[0] = Quad<T>(weight * moved[0], weight * moved[1], weight * moved[2], T(0));
            s[3].setZero();
        }
    }

    // A flat region has no extent along one axis: its normal, as long as its sides, stands in.
    void complete(Mat& m) const
    {
        const int n = body_.flat_axis;
        const Vec a = m.col((n + 1) % 3), b = m.col((n + 2) % 3);
        const Vec normal = a.cross(b);
        const T length = normal.norm();
        m.col(n) = length > 0 ? (normal * (std::sqrt(length) / length)).eval() : normal;
    }

    // S_r, which State::plastic keeps less I.
    Mat rest_shape(std::size_t slot) const
    {
        const float* const p = state_.plastic.data() + 6 * slot;
        Mat s;
        s << T(1 + p[0]), T(p[1]), T(p[2]), T(p[1]), T(1 + p[3]), T(p[4]), T(p[2]), T(p[4]),
            T(1 + p[5]);
        return s;
    }

    // The inverse of what the rest shape of each cell has flowed to: its corners' regions' mean.
    std::span<const float> membrane_rest()
    {
        if (!plastic_) return {};
        const LatticeRegions& regions = matched_->regions;
        const int u = body_.membrane.axes[0], v = body_.membrane.axes[1];
        std::vector<std::uint32_t> slot(n_);
        for (std::size_t s = 0; s < regions.slots(); ++s) {
            if (regions.particle[s] != none) slot[regions.particle[s]] = std::uint32_t(s);
        }
        const Membrane& membrane = body_.membrane;
        membrane_rest_.resize(3 * membrane.cells());
        const auto find_rest = [&](std::size_t c, const Membrane::Cell& cell) {
            Mat mean = Mat::Zero();
            for (const auto k : cell) mean += T(0.25) * rest_shape(slot[k]);
            const T det = mean(u, u) * mean(v, v) - mean(u, v) * mean(u, v);
            const T inverse = det > 0 ? 1 / det : T(0);
            membrane_rest_[3 * c] = float(mean(v, v) * inverse);
            membrane_rest_[3 * c + 1] = float(-mean(u, v) * inverse);
            membrane_rest_[3 * c + 2] = float(mean(u, u) * inverse);
        };
        geometry::parallel_for(membrane.strip.size(), strips_grain,
                               [&](std::size_t begin, std::size_t end) {
                                   membrane.for_each_cell(begin, end, find_rest);
                               });
        return membrane_rest_;
    }

    // Lets the rest shape of a region give way to its strain.
    void flow(std::size_t slot, const Mat& m, const Mat& r)
    {
        if (matched_->regions.particle[slot] == none) return;
        const PlasticOptions& options = options_.plastic;
        const float* const b = matched_->inverse_spread.data() + 6 * slot;
        Mat3 inverse_b;
        inverse_b << double(b[0]), double(b[1]), double(b[2]), double(b[1]), double(b[3]),
            double(b[4]), double(b[2]), double(b[4]), double(b[5]);
        const Mat3 s = rest_shape(slot).template cast<double>();
        const Mat3 turned = r.transpose().template cast<double>() * m.template cast<double>();
        Mat3 shape = turned * inverse_b / body_.base.h;
        // Along an axis that nothing in it lies along (of a plane, or where links have broken) it
        // is as it was.
        for (Eigen::Index d = 0; d < 3; ++d) {
            if (inverse_b(d, d) == 0) shape.col(d) = s.col(d);
        }
        Mat3 strain = shape * s.inverse();
        strain = (0.5 * (strain + strain.transpose())).eval();
        strain -= Mat3::Identity();
        const double size = strain.norm();
        if (!(size > options.yield) || !std::isfinite(size)) return;
        // Within a step it gives way by no more than a fifth, whatever the step.
        const double give = -std::expm1(-options.flow * dt_) * (1 - options.yield / size);
        const Mat3 grown =
            (Mat3::Identity() + std::min(1.0, 0.2 / (give * size)) * give * strain) * s;
        Mat3 next = 0.5 * (grown + grown.transpose());
        const double det = next.determinant();
        if (!flat_ && det > 0) next /= std::cbrt(det);  // flow keeps the volume
        Mat3 change = next - Mat3::Identity();
        const double total = change.norm();
        if (total > options.limit) change *= options.limit / total;
        float* const p = state_.plastic.data() + 6 * slot;
        const double packed[6] = {change(0, 0), change(0, 1), change(0, 2),
                                  change(1, 1), change(1, 2), change(2, 2)};
        for (std::size_t c = 0; c < 6; ++c) p[c] = float(packed[c]);
    }

    // The lattice's own impulses.
    void pull()
    {
        if (!membrane_share_.empty()) {
            stretched_.pull(body_.membrane, {torn_corners_, membrane_rest()}, membrane_share_,
                            state_.x);
        }
        const auto& goal = sums_.particles;
        float* const before = state_.rotation.data() + 4 * matched_->regions.slots();
        const double damping = has_before_ ? damping_ : 0;
        const auto momentum = geometry::ordered_sum<PullMomentum>(
            n_, grain, {}, [&](std::size_t begin, std::size_t end) {
                constexpr std::size_t at_once = 256;
                alignas(64) T stretch[4 * at_once];
                PullMomentum sum;
                for (std::size_t i = begin; i < end; i += at_once) {
                    const std::size_t count = std::min(at_once, end - i);
                    const bool stretches = !membrane_share_.empty();
                    if (stretches) stretched_.gather(body_.membrane, i, count, stretch);
                    const PulledParticles<T> particles{count,
                                                       state_.x[i].data(),
                                                       state_.v[i].data(),
                                                       before + 3 * i,
                                                       goal[i].data(),
                                                       held_weight_.data() + i,
                                                       matched_->held_by.data() + i,
                                                       body_.base.mass.data() + i,
                                                       stretches ? stretch : nullptr};
                    sum = sum + pull_particles(particles, origin_, stiffness_ / dt_, damping / dt_);
                }
                return sum;
            });
        has_before_ = true;
        if (!loads_.pins.corner.empty()) return;

        // Regions pull without force or torque; what rounding has left of them is taken out again.
        const Vec3 linear = momentum.linear(), centre = momentum.moment() / mass_;
        const Mat3 about = momentum.spread() - mass_ * centre * centre.transpose();
        const Mat3 inertia = about.trace() * Mat3::Identity() - about;
        const Vec3 torque = momentum.angular() - centre.cross(linear);
        const Eigen::LDLT<Mat3> solver(inertia);
        Vec3 spin = solver.solve(torque);
        const double least = solver.vectorD().minCoeff();
        if (!(least > 1e-9 * about.trace()) || !spin.allFinite())
            spin.setZero();  // a line, a point
        drift_ = linear / mass_;
        spin_ = spin;
        pivot_ = origin_ + centre;
    }

    void push_from_outside()
    {
        Aligned<double> force, drag;
        if (windy_) {
            force.assign(body_.base.numbers, 0);
            drag = force;
            Aligned<double> x(body_.base.numbers, 0), v(body_.base.numbers, 0);
            for (std::size_t i = 0; i < n_; ++i) {
                for (std::size_t d = 0; d < 3; ++d) {
                    x[4 * i + d] = state_.x[i][Eigen::Index(d)];
                    v[4 * i + d] = state_.v[i][Eigen::Index(d)];
                }
            }
            add_wind(body_.base, loads_.forces, x.data(), v.data(), force, drag);
        }
        const Vec3 steady = dt_ * gravity_ - drift_, spin = spin_, pivot = pivot_;
        if (!touches_ && !windy_ && !damped_ && !in_plane_ && steady_.empty()) {
            const CommonPush common{steady, spin, pivot, dt_};
            take_origin([&](std::size_t begin, std::size_t end) {
                return push_together(common, end - begin, state_.x[begin].data(),
                                     state_.v[begin].data());
            });
            return;
        }
        const auto push = [&](std::size_t i) {
            const double m = body_.base.mass[i];
            Vec3& v = state_.v[i];
            v += steady - spin.cross(Vec3(state_.x[i] - pivot));
            if (!steady_.empty()) v += dt_ / m * Eigen::Map<const Vec3>(steady_.data() + 4 * i);
            if (damped_) v *= std::exp(-body_.base.damping_of(i) / m * dt_);
            if (windy_) {
                // The drag is implicit, so that light bodies follow the wind and no more.
                v = (m * v + dt_ * Eigen::Map<const Vec3>(force.data() + 4 * i)) /
                    (m + dt_ * drag[4 * i]);
            }
            if (in_plane_) v[body_.flat_axis] = 0;
        };
        if (touches_) {
            geometry::parallel_for(n_, grain, [&](std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) push(i);
            });
        } else {
            take_origin_after([&](std::size_t i) {
                push(i);
                state_.x[i] += dt_ * state_.v[i];
            });
        }
    }

    void collide(double share)
    {
        if (!touches_) return;
        const bool pairs = body_.options.contact.on;
        for (BallState& ball : state_.balls) ball.v += dt_ * gravity_;
        std::vector<PosedCollider> colliders;
        for (const Collider& c : loads_.colliders) {
            colliders.push_back(pose_collider(c, share, frame_, body_.base.h));
        }
        const ContactScene scene{body_.base, state_,       inverse_mass_,
                                 dt_,        loads_.balls, torn_skin_ ? &*torn_skin_ : nullptr};
        pushes_.skin = find_skin_pushes(scene, colliders);
        pushes_.balls = find_ball_pushes(scene, colliders);
        if (pairs) {
            const double distance = options_.contact.distance;
            find_pair_pushes(scene, body_.side, body_.piece, distance > 0 ? distance : body_.base.h,
                             options_.contact.friction, pushes_.pairs);
        }
        solve_pushes(scene, pushes_, contact_rounds, state_.v, state_.balls);
        if (!in_plane_) return;
        for (Vec3& v : state_.v) v[body_.flat_axis] = 0;
    }

    void move(double share)
    {
        if (touches_) take_origin_after([&](std::size_t i) { state_.x[i] += dt_ * state_.v[i]; });
        const auto& pins = loads_.pins;
        for (std::size_t p = 0; p < pins.corner.size(); ++p) {
            const std::uint32_t k = pins.corner[p];
            state_.x[k] = share == 1 ? pins.target[p]
                                     : Vec3(start_[p] + share * (pins.target[p] - start_[p]));
            state_.v[k] = (pins.target[p] - start_[p]) / frame_;
        }
        for (BallState& ball : state_.balls) {
            ball.x += dt_ * ball.v;
            const double angle = dt_ * ball.spin.norm();
            if (!(angle > 0)) continue;
            const Eigen::Quaterniond turned =
                Eigen::Quaterniond(Eigen::AngleAxisd(angle, ball.spin.normalized())) *
                Eigen::Quaterniond(ball.turn[0], ball.turn[1], ball.turn[2], ball.turn[3]);
            ball.turn =
                Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z()).normalized();
        }
    }

    // Breaks links that are longer than they can bear.
    void tear()
    {
        const Lattice& lattice = body_.torn->lattice();
        const double longest_sq = std::pow((1 + options_.tear) * body_.base.h, 2);
        std::vector<std::uint32_t> fresh;
        for (std::uint32_t i = 0; i < n_; ++i) {
            for (std::uint32_t d = 0; d < 3; ++d) {
                const std::uint32_t j = lattice.next[i][d], link = 3 * i + d;
                if (j == none || (state_.x[i] - state_.x[j]).squaredNorm() <= longest_sq) continue;
                if (!std::binary_search(state_.broken.begin(), state_.broken.end(), link)) {
                    fresh.push_back(link);
                }
            }
        }
        if (fresh.empty()) return;
        std::vector<std::uint32_t> all;
        std::merge(state_.broken.begin(), state_.broken.end(), fresh.begin(), fresh.end(),
                   std::back_inserter(all));
        state_.broken = std::move(all);
        use_regions(state_.broken);
    }

    static constexpr std::size_t batch = 64;
    static constexpr int contact_rounds = 8;
    // The largest share of a particle, see membrane.hpp: with regions as stiff as they get steps
    // stay below the limit of 4, and leave room for damping.
    static constexpr double most_membrane = 2;
    // Of cells_crossed(). A single corner of a free sheet kicked at 2.5 cells a substep keeps its
    // energy for ten seconds; at 3 it doubles, at 6 and more it grows a hundredfold.
    static constexpr double most_crossed = 2.5;

    const LatticeBody& body_;
    State& state_;
    const Loads& loads_;
    const LatticeOptions& options_;
    double frame_, dt_;
    std::size_t n_;
    bool flat_, in_plane_, plastic_ = false;
    std::shared_ptr<const MatchedRegions> held_regions_;
    std::optional<TornSkin> torn_skin_;  // likewise, where it touches
    const MatchedRegions* matched_ = nullptr;
    RegionSums<T> sums_;
    Pushes pushes_;                           // of the last step
    std::vector<T> weight_;                   // slots, alpha of `stiffness_`
    std::vector<T> held_weight_;              // N, their sums over the regions of each
    std::vector<T> membrane_share_;           // C, kg of `stiffness_`; empty where there is none
    std::vector<std::uint8_t> torn_corners_;  // C, while links of a membrane are broken
    std::vector<float> membrane_rest_;        // 3 C, as MembraneState wants it; where plastic
    MembranePull<T> stretched_;
    const RegionTwist<T>* twist_ = nullptr;  // slots, of a plane in space
    std::vector<RegionTwist<T>> own_twist_;  // where it is not the body's
    std::vector<float> with_pins_;           // kg, M_i, as regions weigh it; where there are pins
    std::vector<double> inverse_mass_;       // 1/kg, 0 of pins; where there can be contact
    std::vector<Vec3> start_;                // of pins, at the start of the frame
    bool has_before_ = false;                // d of the step before is known
    Vec3 gravity_ = Vec3::Zero();
    Aligned<double> steady_;  // point forces, N, four numbers a corner; empty without
    bool windy_ = false, damped_ = false;
    bool touches_ = false;  // there is something to touch; if not, forces and motion are one pass
    double stiffness_ = 0, damping_ = 0;  // alpha with the membrane's share, beta
    double mass_ = 0;                     // kg, of all
    double resolved_ = 0;                 // s dt, at most 1 where steps can bear the stiffness
    Vec3 origin_ = Vec3::Zero();          // what single precision measures from
    // The rigid motion that pull() must take out again.
    Vec3 drift_ = Vec3::Zero(), spin_ = Vec3::Zero(), pivot_ = Vec3::Zero();
};

bool all_finite(const State& state)
{
    // Any NaN or infinity ends up in the sum.
    double sum = geometry::ordered_sum<double>(
        state.x.size(), grain, 0.0, [&](std::size_t begin, std::size_t end) {
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
        geometry::parallel_for(from.size(), grain, [&](std::size_t begin, std::size_t end) {
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
        throw std::invalid_argument(
            fmt::format("expected at least one substep and a rate, bend and damping of 0 or more, "
                        "found {}, {}, {} and {}",
                        options.substeps, options.rate, options.bend, options.damping));
    }
    if (!positive(options.plastic.yield) || !positive(options.plastic.flow) ||
        !(options.plastic.limit >= 0 && options.plastic.limit < 1) || !positive(options.tear)) {
        throw std::invalid_argument(fmt::format(
            "expected a yield strain, a flow and a tear of 0 or more and a limit of flow below 1, "
            "found {}, {}, {} and {}",
            options.plastic.yield, options.plastic.flow, options.tear, options.plastic.limit));
    }
    if (!positive(options.contact.distance) || !positive(options.contact.friction)) {
        throw std::invalid_argument(
            fmt::format("expected a distance and friction of contact of 0 or more, found {} and {}",
                        options.contact.distance, options.contact.friction));
    }
}

}  // namespace

State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const LatticeOptions& options)
{
    const std::size_t n = body.base.corners;
    if (state.x.size() != n || state.v.size() != n) {
        throw std::invalid_argument(fmt::format(
            "expected positions and velocities of {} corners, found {} and {}: is the state of "
            "other cubes?",
            n, state.x.size(), state.v.size()));
    }
    if (!all_finite(state)) throw std::invalid_argument("expected a finite state");
    if (!(dt > 0) || !std::isfinite(dt)) {
        throw std::invalid_argument(fmt::format("expected a step above 0 s, found {}", dt));
    }
    check(options);
    check_pins(loads.pins, n);
    check_forces(loads.forces);
    check_balls(loads.balls);
    State before = copied(state);
    if (options.precision == Precision::single) {
        Stepper<float>(body, state, loads, dt, options).run();
    } else {
        Stepper<double>(body, state, loads, dt, options).run();
    }
    if (all_finite(state)) return state;
    before.time += dt;
    before.report = {};
    before.report.converged = false;
    before.report.warnings.emplace_back(
        "the step went beyond all numbers; the state stays as it was. Is something pulled to "
        "infinity?");
    return before;
}

int least_substeps(const LatticeBody& body, double dt)
{
    LatticeOptions options = body.options;
    options.substeps = 1;
    State state = rest_state(body);
    const Loads loads;
    return Stepper<double>(body, state, loads, dt, options).least_substeps();
}

State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const StepOptions& step)
{
    LatticeOptions options = body.options;
    options.substeps = step.substeps;
    return advance(body, std::move(state), loads, dt, options);
}

}  // namespace physics
