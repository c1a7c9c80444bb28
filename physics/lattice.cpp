#include "physics/lattice.hpp"

#include "geometry/parallel.hpp"
#include "physics/contact.hpp"
#include "physics/outside_forces.hpp"
#include "physics/pins.hpp"
#include "physics/rotation.hpp"

#include <fmt/format.h>

#include <numeric>

namespace physics {

namespace {

constexpr std::size_t grain = 2048;

// Which axis all particles are one layer across; -1 for none.
int flat_axis(const Lattice& lattice)
{
    for (int d = 0; d < 3; ++d) {
        bool linked = false;
        for (const auto& next : lattice.next) linked |= next[std::size_t(d)] != none;
        if (!linked) return d;
    }
    return -1;
}

}  // namespace

Lattice corner_lattice(const geometry::Cubes& cubes)
{
    Lattice lattice;
    lattice.at = cubes.corner;
    lattice.next.assign(cubes.corner_count(), {none, none, none});
    for (const auto& corners : cubes.corners) {
        for (unsigned a = 0; a < 8; ++a) {
            for (unsigned d = 0; d < 3; ++d) {
                if (!(a >> d & 1)) lattice.next[corners[a]][d] = corners[a | 1u << d];
            }
        }
    }
    return lattice;
}

std::size_t LatticeBody::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    std::size_t sum = sizeof *this - sizeof base + base.bytes() +
                      of(mass, held_by, rate_sq, regions.particle, regions.held_by);
    for (const LatticeLines* along : {&regions.x, &regions.y, &regions.z}) {
        sum += of(along->lines, along->items, along->dead);
    }
    const LatticeExceptions& e = regions.exceptions;
    return sum + of(e.region, e.at, e.child_at, e.child, e.parent_at, e.parent, e.particle,
                    e.bar_at, e.bar);
}

LatticeBody make_lattice(const geometry::Cubes& cubes, const LatticeOptions& options,
                         const geometry::TriMesh* surface)
{
    std::vector<std::uint32_t> slot(cubes.corner_count());
    std::iota(slot.begin(), slot.end(), 0u);
    LatticeBody body;
    body.options = options;
    body.base = make_corner_body(cubes, std::move(slot), surface);
    const Lattice lattice = corner_lattice(cubes);
    body.regions = find_regions(lattice, options.half_width);
    body.flat_axis = flat_axis(lattice);
    const std::size_t n = lattice.count();
    for (std::size_t i = 0; i < n; ++i) {
        const auto holders = double(body.regions.held_by[i]);
        body.mass.push_back(float(body.base.mass[i] / holders));
        body.held_by.push_back(float(1 / holders));
    }

    // s^2 = 3 E / (rho h^2 w (w + 1)), with E V and m summed over the region.
    std::vector<double> elasticity(n, 0);  // Pa m^3
    const double volume = std::pow(cubes.size, 3);
    double whole = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const auto k : cubes.corners[c]) {
            elasticity[k] +=
                cubes.young[c] * stiffness_share(cubes, c, options.weighting) * volume / 8;
        }
        const double part = cubes.young[c] * stiffness_share(cubes, c, options.weighting);
        body.damping += part * cubes.stiffness_damping[c];
        whole += part;
    }
    body.damping /= whole;
    RegionSums<double> sums(body.regions);
    for (std::size_t i = 0; i < n; ++i) {
        sums.particles(body.regions)[i] = {elasticity[i], body.base.mass[i], 0, 0};
    }
    collect(body.regions, sums);
    const double w = options.half_width, h = cubes.size;
    for (std::size_t s = 0; s < body.regions.slots(); ++s) {
        const auto total = sums.slots(body.regions)[4 * s];
        const bool real = body.regions.particle[s] != none;
        body.rate_sq.push_back(real ? float(3 * total[0] / (total[1] * h * h * w * (w + 1)))
                                    : 0.0f);
    }
    return body;
}

State rest_state(const LatticeBody& body)
{
    State state;
    for (std::size_t i = 0; i < body.base.corners; ++i) {
        state.x.emplace_back(Eigen::Map<const Vec3>(body.base.rest.data() + 4 * i));
    }
    state.v.assign(body.base.corners, Vec3::Zero());
    return state;
}

namespace {

// A point of the skin that is about to be inside a collider at the end of a step.
struct Push {
    std::array<std::uint32_t, 8> corners;
    std::array<double, 8> weight;
    Vec3 normal, surface_velocity;
    double gap;       // m, at the end of the step if nothing else happens, less what may remain
    double approach;  // m/s, of the point along the normal when the gap was looked at
    double inverse;   // 1/kg, of the point
    double friction;
    double impulse = 0;  // N s, along the normal
    Vec3 drag = Vec3::Zero();
};

template <class T> class Stepper {
public:
    Stepper(const LatticeBody& body, State& state, const Loads& loads, double frame,
            const LatticeOptions& options)
        : body_(body), state_(state), loads_(loads), options_(options), frame_(frame),
          dt_(frame / options.substeps), n_(body.base.corners), sums_(body.regions)
    {
        pinned_.assign(loads.pins.corner.empty() ? 0 : n_, 0);
        for (const auto k : loads.pins.corner) {
            pinned_[k] = 1;
            start_.push_back(state.x[k]);
        }
        const std::size_t kept = 4 * body.regions.slots() + 3 * n_;
        has_before_ = state.rotation.size() == kept;
        if (!has_before_) state.rotation.assign(kept, 0.0f);

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
        for (std::size_t i = 0; i < n_; ++i) {
            damped_ |= body.base.mass_damping[i] > 0;
            mass_ += body.base.mass[i];
        }

        // Weights of regions, relative to the largest.
        const double rate_sq = options.rate * options.rate;
        double largest = 0;
        if (options.stiffness == Stiffness::material) {
            for (const float r : body.rate_sq) largest = std::max(largest, double(r));
        } else {
            largest = rate_sq;
        }
        stiffness_ = -std::expm1(-largest * dt_ * dt_);
        const double tau = body.damping + options.damping;
        damping_ = tau > 0 ? -std::expm1(-tau * largest * dt_) : 0;
        resolved_ = std::sqrt(largest) * dt_;
    }

    void run()
    {
        for (int i = 1; i <= options_.substeps; ++i) step(double(i) / options_.substeps);
        state_.time += frame_;
        state_.report = {};
        state_.report.steps = options_.substeps;
        if (options_.stiffness == Stiffness::material && resolved_ > 1.5) {
            state_.report.converged = false;
            state_.report.warnings.push_back(fmt::format(
                "the lattice is softer than its material: regions of half width {} can be that "
                "stiff only at {} substeps or more; widen the regions, take more substeps or set "
                "a rate",
                body_.regions.half_width, int(std::ceil(options_.substeps * resolved_))));
        }
    }

private:
    void step(double share)
    {
        find_goals();
        pull();
        push_from_outside();
        if (!loads_.colliders.empty()) collide(share);
        move(share);
    }

    // d_i into the particles' quads: x, y, z, and the sum of weights.
    void find_goals()
    {
        const auto f = sums_.particles(body_.regions);
        origin_ = geometry::ordered_sum<Vec3>(n_, grain, Vec3::Zero(),
                                              [&](std::size_t begin, std::size_t end) {
                                                  Vec3 sum = Vec3::Zero();
                                                  for (std::size_t i = begin; i < end; ++i) {
                                                      sum += state_.x[i];
                                                  }
                                                  return sum;
                                              }) /
                  double(n_);
        geometry::parallel_for(n_, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const T m = T(body_.mass[i]);
                const Vec3 p = state_.x[i] - origin_;
                f[i] = Quad<T>(m * T(p[0]), m * T(p[1]), m * T(p[2]), m);
            }
        });
        collect(body_.regions, sums_);
        geometry::parallel_for(
            (body_.regions.slots() + batch - 1) / batch, 16,
            [&](std::size_t begin, std::size_t end) {
                for (std::size_t b = begin; b < end; ++b) {
                    match_shapes(b * batch, std::min(body_.regions.slots(), (b + 1) * batch));
                }
            });
        spread(body_.regions, sums_);
    }

    // From sums over regions to their rigid motions, with weights.
    void match_shapes(std::size_t begin, std::size_t end)
    {
        const auto slots = sums_.slots(body_.regions);
        const std::size_t count = end - begin;
        alignas(64) T a[9 * batch], q[4 * batch];
        float* const rotation = state_.rotation.data();
        for (std::size_t k = 0; k < count; ++k) {
            const Quad<T>* const s = slots.data() + 4 * (begin + k);
            const T inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
            Eigen::Matrix<T, 3, 3> m;
            for (int d = 0; d < 3; ++d) {
                m.col(d) = (s[1 + d] - (s[1 + d][3] * inverse) * s[0]).template head<3>();
            }
            if (body_.flat_axis >= 0) complete(m);
            for (int i = 0; i < 9; ++i) a[std::size_t(i) * batch + k] = m(i / 3, i % 3);
            for (std::size_t c = 0; c < 4; ++c) q[c * batch + k] = T(rotation[4 * (begin + k) + c]);
        }
        extract_rotations(count, a, batch, q, batch);
        const T h = T(body_.base.h);
        for (std::size_t k = 0; k < count; ++k) {
            Quad<T>* const s = slots.data() + 4 * (begin + k);
            const T weight =
                body_.regions.particle[begin + k] == none ? T(0) : weight_of(begin + k);
            const Eigen::Quaternion<T> turn(q[k], q[batch + k], q[2 * batch + k], q[3 * batch + k]);
            for (std::size_t c = 0; c < 4; ++c) {
                rotation[4 * (begin + k) + c] = float(q[c * batch + k]);
            }
            const Eigen::Matrix<T, 3, 3> r = (weight * h) * turn.toRotationMatrix();
            const T inverse = s[0][3] > 0 ? 1 / s[0][3] : T(0);
            const Eigen::Matrix<T, 3, 1> centre(s[1][3] * inverse, s[2][3] * inverse,
                                                s[3][3] * inverse);  // C_r - X_r, lattice steps
            const Eigen::Matrix<T, 3, 1> moved =
                (weight * inverse) * s[0].template head<3>().matrix() - r * centre;
            s[0] = Quad<T>(moved[0], moved[1], moved[2], weight);
            for (int d = 0; d < 3; ++d) s[1 + d] = Quad<T>(r(0, d), r(1, d), r(2, d), T(0));
        }
    }

    // A flat region has no extent along one axis: its normal, as long as its sides, stands in.
    void complete(Eigen::Matrix<T, 3, 3>& m) const
    {
        const int n = body_.flat_axis;
        const Eigen::Matrix<T, 3, 1> u = m.col((n + 1) % 3), v = m.col((n + 2) % 3);
        const Eigen::Matrix<T, 3, 1> normal = u.cross(v);
        const T length = normal.norm();
        m.col(n) = length > 0 ? (normal * (std::sqrt(length) / length)).eval() : normal;
    }

    T weight_of(std::size_t slot) const
    {
        if (options_.stiffness == Stiffness::rate) return T(1);
        return T(-std::expm1(-double(body_.rate_sq[slot]) * dt_ * dt_) / stiffness_);
    }

    // The lattice's own impulses.
    void pull()
    {
        const auto g = sums_.particles(body_.regions);
        float* const before = state_.rotation.data() + 4 * body_.regions.slots();
        const double damping = has_before_ ? damping_ : 0;
        struct Momentum {
            Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
            Mat3 spread = Mat3::Zero();  // sum of m x x^T
            Vec3 moment = Vec3::Zero();
            Momentum operator+(const Momentum& o) const
            {
                return {linear + o.linear, angular + o.angular, spread + o.spread,
                        moment + o.moment};
            }
        };
        const bool free = loads_.pins.corner.empty();
        const auto momentum =
            geometry::ordered_sum<Momentum>(n_, grain, {}, [&](std::size_t begin, std::size_t end) {
                Momentum sum;
                for (std::size_t i = begin; i < end; ++i) {
                    const Vec3 x = state_.x[i] - origin_;
                    const T held_by = T(body_.held_by[i]);
                    Vec3 impulse;
                    for (int d = 0; d < 3; ++d) {
                        const T away = held_by * (g[i][d] - g[i][3] * T(x[d]));
                        const double change = double(away) - double(before[3 * i + std::size_t(d)]);
                        before[3 * i + std::size_t(d)] = float(away);
                        impulse[d] = (stiffness_ * double(away) + damping * change) / dt_;
                    }
                    state_.v[i] += impulse;
                    if (!free) continue;
                    const double m = body_.base.mass[i];
                    sum.linear += m * impulse;
                    sum.angular += m * x.cross(impulse);
                    sum.spread += m * x * x.transpose();
                    sum.moment += m * x;
                }
                return sum;
            });
        has_before_ = true;
        if (!free) return;

        // Regions pull without force or torque; what rounding has left of them is taken out again.
        const Vec3 centre = momentum.moment / mass_;
        const Mat3 about = momentum.spread - mass_ * centre * centre.transpose();
        const Mat3 inertia = about.trace() * Mat3::Identity() - about;
        const Vec3 torque = momentum.angular - centre.cross(momentum.linear);
        const Eigen::LDLT<Mat3> solver(inertia);
        Vec3 spin = solver.solve(torque);
        const double least = solver.vectorD().minCoeff();
        if (!(least > 1e-9 * about.trace()) || !spin.allFinite())
            spin.setZero();  // a line, a point
        const Vec3 drift = momentum.linear / mass_;
        geometry::parallel_for(n_, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                state_.v[i] -= drift + spin.cross(Vec3(state_.x[i] - origin_ - centre));
            }
        });
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
        geometry::parallel_for(n_, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const double m = body_.base.mass[i];
                Vec3& v = state_.v[i];
                v += dt_ * gravity_;
                if (!steady_.empty()) v += dt_ / m * Eigen::Map<const Vec3>(steady_.data() + 4 * i);
                if (damped_) v *= std::exp(-body_.base.mass_damping[i] / m * dt_);
                if (windy_) {
                    // The drag is implicit, so that light bodies follow the wind and no more.
                    v = (m * v + dt_ * Eigen::Map<const Vec3>(force.data() + 4 * i)) /
                        (m + dt_ * drag[4 * i]);
                }
            }
        });
    }

    double inverse_mass(std::uint32_t i) const
    {
        return !pinned_.empty() && pinned_[i] ? 0 : 1 / body_.base.mass[i];
    }

    // Impulses that keep the skin out of colliders and rub it along them, one point after another.
    void collide(double share)
    {
        std::vector<PosedCollider> colliders;
        for (const Collider& c : loads_.colliders) {
            colliders.push_back(pose_collider(c, share, frame_, body_.base.h));
        }
        std::vector<Push> pushes = find_pushes(colliders);
        for (int round = 0; round < contact_rounds; ++round) {
            for (Push& p : pushes) {
                Vec3 v = Vec3::Zero();
                for (std::size_t a = 0; a < 8; ++a) v += p.weight[a] * state_.v[p.corners[a]];
                const double ahead = p.gap + dt_ * (v.dot(p.normal) - p.approach);
                const double before = p.impulse;
                p.impulse = std::max(0.0, before - ahead / (dt_ * p.inverse));
                Vec3 change = (p.impulse - before) * p.normal;
                v += p.inverse * change;
                const Vec3 slip = v - p.surface_velocity;
                const Vec3 wanted = p.drag - (slip - slip.dot(p.normal) * p.normal) / p.inverse;
                const double most = p.friction * p.impulse, size = wanted.norm();
                const Vec3 drag = size > most ? Vec3(most / size * wanted) : wanted;
                change += drag - p.drag;
                p.drag = drag;
                for (std::size_t a = 0; a < 8; ++a) {
                    state_.v[p.corners[a]] += p.weight[a] * inverse_mass(p.corners[a]) * change;
                }
            }
        }
    }

    std::vector<Push> find_pushes(const std::vector<PosedCollider>& colliders) const
    {
        const Skin& skin = body_.base.skin;
        constexpr std::size_t piece = 256;
        std::vector<std::vector<Push>> found((skin.corners.size() + piece - 1) / piece);
        geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t g = begin; g < end; ++g) {
                const std::size_t last = std::min(skin.corners.size(), (g + 1) * piece);
                for (std::size_t c = g * piece; c < last; ++c) look(colliders, c, found[g]);
            }
        });
        std::vector<Push> all;
        for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
        return all;
    }

    void look(const std::vector<PosedCollider>& colliders, std::size_t c,
              std::vector<Push>& out) const
    {
        const Skin& skin = body_.base.skin;
        const auto& corners = skin.corners[c];
        const auto next = [&](std::uint32_t i) -> Vec3 { return state_.x[i] + dt_ * state_.v[i]; };
        Vec3 centre = Vec3::Zero();
        for (const auto k : corners) centre += next(k) / 8;
        double radius = 0;
        for (const auto k : corners) radius = std::max(radius, (next(k) - centre).norm());
        for (const PosedCollider& collider : colliders) {
            // Points may lie outside their cube; a distance changes no faster than a place.
            const bool mesh = collider.kind == Collider::Kind::mesh;
            if (!mesh && touch(collider, centre).gap > skin.reach[c] * radius) continue;
            for (std::uint32_t i = skin.point_at[c]; i < skin.point_at[c + 1]; ++i) {
                Push push{};
                push.corners = corners;
                for (std::size_t a = 0; a < 8; ++a) push.weight[a] = skin.point[i][a];
                Vec3 now = Vec3::Zero(), v = now;
                for (std::size_t a = 0; a < 8; ++a) {
                    now += push.weight[a] * state_.x[corners[a]];
                    v += push.weight[a] * state_.v[corners[a]];
                    push.inverse += push.weight[a] * push.weight[a] * inverse_mass(corners[a]);
                }
                const Touch t = touch(collider, now + dt_ * v);
                if (!(t.gap < 0) || !(push.inverse > 0)) continue;
                push.normal = t.normal;
                push.surface_velocity = t.velocity;
                push.approach = v.dot(t.normal);
                push.friction = collider.friction;
                // What was inside already comes out by a fifth a step, not with a jump.
                const double inside = t.gap - dt_ * (push.approach - t.velocity.dot(t.normal));
                push.gap = t.gap - 0.8 * std::min(0.0, inside);
                out.push_back(push);
            }
        }
    }

    void move(double share)
    {
        geometry::parallel_for(n_, grain, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) state_.x[i] += dt_ * state_.v[i];
        });
        const auto& pins = loads_.pins;
        for (std::size_t p = 0; p < pins.corner.size(); ++p) {
            const std::uint32_t k = pins.corner[p];
            state_.x[k] = share == 1 ? pins.target[p]
                                     : Vec3(start_[p] + share * (pins.target[p] - start_[p]));
            state_.v[k] = (pins.target[p] - start_[p]) / frame_;
        }
    }

    static constexpr std::size_t batch = 64;
    static constexpr int contact_rounds = 8;

    const LatticeBody& body_;
    State& state_;
    const Loads& loads_;
    const LatticeOptions& options_;
    double frame_, dt_;
    std::size_t n_;
    RegionSums<T> sums_;
    std::vector<std::uint8_t> pinned_;  // by corner; empty without pins
    std::vector<Vec3> start_;           // of pins, at the start of the frame
    bool has_before_ = false;           // d of the step before is known
    Vec3 gravity_ = Vec3::Zero();
    Aligned<double> steady_;  // point forces, N, four numbers a corner; empty without
    bool windy_ = false, damped_ = false;
    double stiffness_ = 0, damping_ = 0;  // alpha, beta
    double mass_ = 0;                     // kg, of all
    double resolved_ = 0;                 // s dt
    Vec3 origin_ = Vec3::Zero();          // what single precision measures from
};

bool all_finite(const State& state)
{
    double sum = 0;  // any NaN or infinity ends up in it
    for (const Vec3& x : state.x) sum += (0 * x).sum();
    for (const Vec3& v : state.v) sum += (0 * v).sum();
    return sum == 0;
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
    if (options.substeps < 1 || !(options.rate >= 0) || !(options.damping >= 0)) {
        throw std::invalid_argument(
            fmt::format("expected at least one substep and a rate and damping of 0 or more, found "
                        "{}, {} and {}",
                        options.substeps, options.rate, options.damping));
    }
    check_pins(loads.pins, n);
    check_forces(loads.forces);
    State before = state;
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

State advance(const LatticeBody& body, State state, const Loads& loads, double dt,
              const StepOptions& step)
{
    LatticeOptions options = body.options;
    options.substeps = step.substeps;
    return advance(body, std::move(state), loads, dt, options);
}

}  // namespace physics
