#include "physics/layered_system.hpp"

#include "physics/cross_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// Of the mass that it stops: it gives way by a thousandth of what the step would do without it.
constexpr double stop_stiffness = 1000;
// Led frames are so much heavier than all others: those hardly push them.
constexpr double led_weight = 1e6;

double heaviest(const LayeredScene& scene)
{
    double most = 0;
    for (const LayeredPart& part : scene.parts) {
        if (is_told(part.body->base.kind)) continue;
        for (const double mass : part.body->base.mass) most = std::max(most, mass);
    }
    return most > 0 ? most : 1;
}

}  // namespace

LayeredSystem::LayeredSystem(const LayeredScene& scene, const LayeredMoment& moment, double dt,
                             RigidBodies rigid_bodies)
    : dt_(dt)
{
    const bool bullet = rigid_bodies == RigidBodies::bullet;
    const double led_mass = led_weight * heaviest(scene);
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        first_.push_back(velocity_.size());
        const LayeredBody& body = *scene.parts[b].body;
        for (std::size_t f = 0; f < body.base.frames.size(); ++f) {
            Vec6 v;
            v << moment.twists[b][f].linear, moment.twists[b][f].angular;
            velocity_.push_back(v);
            const bool held = bullet && body.base.kind == BaseKind::rigid;
            held_.push_back(held);
            kind_.push_back(held ? BaseKind::still : body.base.kind);
            Mat6 mass = Mat6::Identity();
            if (body.base.kind != BaseKind::still) {
                mass.topLeftCorner<3, 3>() *= body.base.kind == BaseKind::led ? led_mass
                                              : body.base.cubes ? body.base.cubes->mass(f)
                                                                : body.base.mass[f];
            }
            if (body.base.kind == BaseKind::rigid) {
                const Mat3 turn = moment.frames[b][f].linear();
                mass.bottomRightCorner<3, 3>() = turn * body.base.inertia[f] * turn.transpose();
            }
            mass_.push_back(mass);
            diagonal_.push_back(body.base.cubes ? Mat6::Zero() : mass);
        }
    }
    right_.assign(velocity_.size(), Vec6::Zero());
    if (bullet) held_damping_ = held_stiffness_ = {velocity_.size(), Mat6::Zero()};
    first_corner_.resize(scene.parts.size());
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.cubes) add_cubes(scene, b);
    }
}

std::vector<float> LayeredSystem::rotations(std::size_t body) const
{
    for (const Carrier& carrier : carriers_) {
        if (carrier.first_frame == first_[body]) return carrier.elasticity->rotations();
    }
    return {};
}

// The largest eigenvalue of M^-1 A, of a symmetric A >= 0, is no more than sqrt(tr (M^-1 A)^2).
LayeredSystem::Rates LayeredSystem::rates(std::size_t f) const
{
    const Eigen::LDLT<Mat6> mass(mass_[f]);
    const auto largest = [&](const Mat6& A) {
        const Mat6 ratio = mass.solve(A);
        return std::sqrt(std::max(0.0, ratio.cwiseProduct(ratio.transpose()).sum()));
    };
    return {std::sqrt(largest(held_stiffness_[f])), largest(held_damping_[f])};
}

void LayeredSystem::add_force(std::size_t f, const Vec3& force, const Vec3& torque)
{
    right_[f].head<3>() += dt_ * force;
    right_[f].tail<3>() += dt_ * torque;
}

void LayeredSystem::add_drag(std::size_t f, double rate)
{
    right_[f] -= dt_ * rate * (mass_[f] * velocity_[f]);
    diagonal_[f] += dt_ * rate * mass_[f];
}

void LayeredSystem::add_pair(std::size_t a, std::size_t b, const Vec3& arm_a, const Vec3& arm_b,
                             const Mat3& C, const Mat3& K)
{
    add_terms(a, b, point_jacobian(a, arm_a), point_jacobian(b, arm_b), C, K);
}

void LayeredSystem::add_angular_pair(std::size_t a, std::size_t b, const Mat3& C, const Mat3& K)
{
    Jacobian J = Jacobian::Zero();
    J.rightCols<3>().setIdentity();
    add_terms(a, b, J, J, C, K);
}

void LayeredSystem::add_stop(std::size_t a, std::size_t b, const Vec3& arm_a, const Vec3& arm_b,
                             const Vec3& normal, double gap)
{
    if (a == b || (kind_[a] == BaseKind::still && kind_[b] == BaseKind::still)) return;
    const double mass = kind_[a] == BaseKind::still   ? mass_[b](0, 0)
                        : kind_[b] == BaseKind::still ? mass_[a](0, 0)
                                                      : std::min(mass_[a](0, 0), mass_[b](0, 0));
    stops_.push_back({a, b, point_jacobian(a, arm_a).transpose() * normal,
                      -point_jacobian(b, arm_b).transpose() * normal, gap / dt_,
                      stop_stiffness * mass});
}

std::vector<Vec6> LayeredSystem::solve(Report& report)
{
    merge_pairs();
    hand_to_corners(right_);
    for (std::size_t f = 0; f < velocity_.size(); ++f) {
        right_[f] = free(f, right_[f]);
        if (kind_[f] == BaseKind::particles) right_[f].tail<3>().setZero();
    }
    std::vector<Vec6> dv = solve_held(report);
    constexpr int most_rounds = 30;
    double now = potential(dv);
    for (int round = 0; round < most_rounds && hold_passed(dv); ++round) {
        const std::vector<Vec6> end = solve_held(report);
        std::vector<Vec6> next = end;
        double after = potential(next);
        for (double share = 0.5; after > now && share > 1e-3; share *= 0.5) {
            for (std::size_t f = 0; f < dv.size(); ++f) {
                next[f] = dv[f] + share * (end[f] - dv[f]);
            }
            after = potential(next);
        }
        dv = std::move(next);
        now = after;
    }
    return dv;
}

double LayeredSystem::beyond(const Stop& stop, const std::vector<Vec6>& dv) const
{
    return stop.speed(velocity_) + stop.speed(dv) + stop.room;
}

bool LayeredSystem::hold_passed(const std::vector<Vec6>& dv)
{
    bool changed = false;
    for (Stop& stop : stops_) {
        const bool passed = beyond(stop, dv) < 0;
        changed |= passed != stop.held;
        stop.held = passed;
    }
    return changed;
}

double LayeredSystem::potential(const std::vector<Vec6>& dv) const
{
    if (stops_.empty()) return 0;
    double sum = 0;
    for (std::size_t f = 0; f < dv.size(); ++f) {
        sum += dv[f].dot(0.5 * diagonal_[f] * dv[f] - right_[f]);
    }
    for (const Pair& pair : pairs_) sum += dv[pair.a].dot(pair.off * dv[pair.b]);
    if (!carriers_.empty()) {
        std::vector<Vec6> pull(dv.size(), Vec6::Zero());
        add_elastic(dv, pull);
        for (std::size_t f = 0; f < dv.size(); ++f) sum += 0.5 * dv[f].dot(pull[f]);
    }
    for (const Stop& stop : stops_) {
        const double miss = std::min(0.0, beyond(stop, dv));
        sum += 0.5 * stop.stiffness * miss * miss;
    }
    return sum;
}

std::vector<Vec6> LayeredSystem::solve_held(Report& report) const
{
    const std::size_t n = velocity_.size();
    std::vector<Mat6> blocks = diagonal_;
    std::vector<Vec6> right = right_;
    for (const Stop& stop : stops_) {
        if (!stop.held) continue;
        const double miss = stop.stiffness * (stop.speed(velocity_) + stop.room);
        blocks[stop.a] += stop.stiffness * stop.along_a * stop.along_a.transpose();
        blocks[stop.b] += stop.stiffness * stop.along_b * stop.along_b.transpose();
        right[stop.a] -= miss * stop.along_a;
        right[stop.b] -= miss * stop.along_b;
    }
    hand_to_corners(right);
    add_to_corner_blocks(blocks);
    std::vector<Eigen::LDLT<Mat6>> own;
    for (std::size_t f = 0; f < n; ++f) {
        if (kind_[f] == BaseKind::led) {  // turns as told
            blocks[f].topRightCorner<3, 3>().setZero();
            blocks[f].bottomLeftCorner<3, 3>().setZero();
            blocks[f].bottomRightCorner<3, 3>().setIdentity();
        }
        if (kind_[f] == BaseKind::cubes) blocks[f].setIdentity();
        own.emplace_back(blocks[f]);
        right[f] = free(f, right[f]);
    }
    std::vector<Vec6> x(n, Vec6::Zero()), r = right, z(n), p(n), Ap(n);
    const auto dot = [&](const std::vector<Vec6>& u, const std::vector<Vec6>& v) {
        double sum = 0;
        for (std::size_t f = 0; f < n; ++f) sum += u[f].dot(v[f]);
        return sum;
    };
    for (std::size_t f = 0; f < n; ++f) p[f] = z[f] = free(f, own[f].solve(r[f]));
    double rz = dot(r, z);
    const double goal = 1e-20 * rz;
    int iteration = 0;
    for (; rz > goal && rz > 1e-290 && iteration < 1000; ++iteration) {
        multiply(p, Ap);
        const double alpha = rz / dot(p, Ap);
        for (std::size_t f = 0; f < n; ++f) {
            x[f] += alpha * p[f];
            r[f] -= alpha * Ap[f];
            z[f] = free(f, own[f].solve(r[f]));
        }
        const double next = dot(r, z);
        for (std::size_t f = 0; f < n; ++f) p[f] = z[f] + next / rz * p[f];
        rz = next;
    }
    report.iterations += iteration;
    if (rz > 1e-12 * std::abs(goal) * 1e20) report.converged = false;
    return x;
}

Vec6 LayeredSystem::free(std::size_t f, Vec6 v) const
{
    if (kind_[f] == BaseKind::still) v.setZero();
    if (kind_[f] == BaseKind::led) v.tail<3>().setZero();
    return v;
}

LayeredSystem::Jacobian LayeredSystem::point_jacobian(std::size_t f, const Vec3& arm) const
{
    Jacobian J = Jacobian::Zero();
    J.leftCols<3>().setIdentity();
    if (kind_[f] != BaseKind::particles) J.rightCols<3>() = -cross_matrix(arm);
    return J;
}

void LayeredSystem::add_terms(std::size_t a, std::size_t b, const Jacobian& Ja, const Jacobian& Jb,
                              const Mat3& C, const Mat3& K)
{
    if (kind_[a] == BaseKind::still && kind_[b] == BaseKind::still) {
        const double times = held_[a] && held_[b] ? 2 : 1;
        for (const auto& [f, J] : {std::pair(a, &Ja), std::pair(b, &Jb)}) {
            if (!held_[f]) continue;
            held_stiffness_[f] += times * J->transpose() * K * *J;
            held_damping_[f] += times * J->transpose() * C * *J;
        }
        return;
    }
    const Mat3 D = dt_ * C + dt_ * dt_ * K;
    const Vec3 pull = dt_ * dt_ * (K * (Ja * velocity_[a] - Jb * velocity_[b]));
    right_[a] -= Ja.transpose() * pull;
    right_[b] += Jb.transpose() * pull;
    diagonal_[a] += Ja.transpose() * D * Ja;
    diagonal_[b] += Jb.transpose() * D * Jb;
    pairs_.push_back({a, b, -Ja.transpose() * D * Jb});
    if (pairs_.size() >= 4096 + 2 * merged_) merge_pairs();
}

void LayeredSystem::merge_pairs()
{
    for (Pair& pair : pairs_) {
        if (pair.a <= pair.b) continue;
        std::swap(pair.a, pair.b);
        pair.off.transposeInPlace();
    }
    std::stable_sort(pairs_.begin(), pairs_.end(), [](const Pair& p, const Pair& q) {
        return std::pair(p.a, p.b) < std::pair(q.a, q.b);
    });
    merged_ = 0;
    for (const Pair& pair : pairs_) {
        if (merged_ > 0 && pairs_[merged_ - 1].a == pair.a && pairs_[merged_ - 1].b == pair.b) {
            pairs_[merged_ - 1].off += pair.off;
        } else {
            pairs_[merged_++] = pair;
        }
    }
    pairs_.resize(merged_);
}

void LayeredSystem::multiply(std::vector<Vec6>& x, std::vector<Vec6>& y) const
{
    take_along(x);
    for (std::size_t f = 0; f < x.size(); ++f) y[f] = diagonal_[f] * x[f];
    for (const Pair& pair : pairs_) {
        y[pair.a] += pair.off * x[pair.b];
        y[pair.b] += pair.off.transpose() * x[pair.a];
    }
    for (const Stop& stop : stops_) {
        if (!stop.held) continue;
        const double pull = stop.stiffness * stop.speed(x);
        y[stop.a] += pull * stop.along_a;
        y[stop.b] += pull * stop.along_b;
    }
    hand_to_corners(y);
    add_elastic(x, y);
    for (std::size_t f = 0; f < x.size(); ++f) y[f] = free(f, y[f]);
}

void LayeredSystem::add_cubes(const LayeredScene& scene, std::size_t b)
{
    const LayeredPart& part = scene.parts[b];
    const State& state = scene.states[b].cubes;
    Carrier carrier;
    carrier.base = part.body->base.cubes.get();
    carrier.first_frame = first_[b];
    carrier.first_corner = first_corner_[b] = velocity_.size();
    for (std::size_t f = 0; f < part.body->base.frames.size(); ++f) {
        carrier.holds.push_back(carrier.base->hold(f, part.body->base.frames[f], state.x));
    }
    const CornerBody& body = carrier.corner_body();
    carrier.elasticity = elasticity_of(carrier.base->bricks(), state.rotation);
    Aligned<double> force(carrier.elasticity->room(), 0), pull = force;
    carrier.elasticity->forces(by_slot(body, state.x).data(), force.data());
    carrier.elasticity->weigh(dt_ * dt_, dt_);
    carrier.elasticity->multiply(by_slot(body, state.v).data(), pull.data());
    carrier.diagonal.assign(body.numbers, 0);
    carrier.elasticity->add_diagonal(carrier.diagonal.data());
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t slot = body.slot_of(k);
        const double drag = dt_ * body.damping_of(slot);
        Vec6 v = Vec6::Zero(), right = Vec6::Zero();
        for (std::size_t i = 0; i < 3; ++i) {
            const auto axis = static_cast<Eigen::Index>(i);
            v[axis] = state.v[k][axis];
            right[axis] = dt_ * force[4 * slot + i] - pull[4 * slot + i] - drag * v[axis];
        }
        velocity_.push_back(v);
        right_.push_back(right);
        held_.push_back(false);
        kind_.push_back(BaseKind::particles);
        mass_.push_back(body.mass[slot] * Mat6::Identity());
        diagonal_.push_back((body.mass[slot] + drag) * Mat6::Identity());
    }
    for (const std::uint32_t k : part.pins.corner) {
        kind_[carrier.first_corner + k] = BaseKind::still;
    }
    carrier.in.assign(body.numbers, 0);
    carrier.out.assign(carrier.elasticity->room(), 0);
    carriers_.push_back(std::move(carrier));
}

void LayeredSystem::take_along(std::vector<Vec6>& x) const
{
    for (const Carrier& carrier : carriers_) {
        for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
            Vec6& twist = x[carrier.first_frame + f];
            twist.setZero();
            const auto corners = carrier.base->corners(f);
            for (std::size_t a = 0; a < corners.size(); ++a) {
                twist += carrier.holds[f].by[a] * x[carrier.first_corner + corners[a]].head<3>();
            }
        }
    }
}

void LayeredSystem::hand_to_corners(std::vector<Vec6>& y) const
{
    for (const Carrier& carrier : carriers_) {
        for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
            Vec6& wrench = y[carrier.first_frame + f];
            const auto corners = carrier.base->corners(f);
            for (std::size_t a = 0; a < corners.size(); ++a) {
                y[carrier.first_corner + corners[a]].head<3>() +=
                    carrier.holds[f].by[a].transpose() * wrench;
            }
            wrench.setZero();
        }
    }
}

void LayeredSystem::add_to_corner_blocks(std::vector<Mat6>& blocks) const
{
    for (const Carrier& carrier : carriers_) {
        for (std::size_t f = 0; f < carrier.holds.size(); ++f) {
            const auto corners = carrier.base->corners(f);
            for (std::size_t a = 0; a < corners.size(); ++a) {
                const auto& by = carrier.holds[f].by[a];
                blocks[carrier.first_corner + corners[a]].topLeftCorner<3, 3>() +=
                    by.transpose() * blocks[carrier.first_frame + f] * by;
            }
        }
        const CornerBody& body = carrier.corner_body();
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (int i = 0; i < 3; ++i) {
                blocks[carrier.first_corner + k](i, i) +=
                    carrier.diagonal[4 * body.slot_of(k) + std::size_t(i)];
            }
        }
    }
}

void LayeredSystem::add_elastic(const std::vector<Vec6>& x, std::vector<Vec6>& y) const
{
    for (const Carrier& carrier : carriers_) {
        const CornerBody& body = carrier.corner_body();
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                carrier.in[4 * body.slot_of(k) + i] =
                    x[carrier.first_corner + k][static_cast<Eigen::Index>(i)];
            }
        }
        carrier.elasticity->multiply(carrier.in.data(), carrier.out.data());
        for (std::size_t k = 0; k < body.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) {
                y[carrier.first_corner + k][static_cast<Eigen::Index>(i)] +=
                    carrier.out[4 * body.slot_of(k) + i];
            }
        }
    }
}

}  // namespace physics
