#include "physics/layered_bodies/layered_system.hpp"

#include "physics/layered_bodies/net_base.hpp"
#include "physics/math/cross_matrix.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using Jacobian = Eigen::Matrix<double, 3, 6>;

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

// kg, of what moves with carried frame f of a net at once.
double mass_of_span(const Base& base, std::size_t f)
{
    const std::span<const std::uint32_t> masses = masses_of(base, f);
    double easy = 0;
    for (const std::uint32_t m : masses) easy += 1 / base.mass[m];
    return static_cast<double>(masses.size() * masses.size()) / easy;
}

// Frames of a net that follow its masses.
void add_spans(const LayeredScene& scene, const LayeredMoment& moment, std::size_t b,
               LayeredSystem& system)
{
    const Base& base = scene.parts[b].body->base;
    for (std::size_t f = mass_count(base); f < base.frames.size(); ++f) {
        CarriedFrame carried{.frame = system.frame(b, f)};
        for (const std::uint32_t m : masses_of(base, f)) {
            carried.on.push_back(system.frame(b, m));
        }
        carried.by = net_hold(base, f, scene.states[b].position, moment.frames[b][f].linear()).by;
        system.kind[carried.frame] = BaseKind::carried;
        system.mass[carried.frame].topLeftCorner<3, 3>() = mass_of_span(base, f) * Mat3::Identity();
        system.diagonal[carried.frame].setZero();
        system.carried.push_back(std::move(carried));
    }
}

// Corners as unknowns, with the forces of body b's cubes on them.
void add_cubes(const LayeredScene& scene, std::size_t b, LayeredSystem& system)
{
    const LayeredPart& part = scene.parts[b];
    const State& state = scene.states[b].cubes;
    CubeCarrier carrier;
    carrier.base = part.body->base.cubes.get();
    carrier.first_frame = system.first_frame[b];
    carrier.first_corner = system.first_corner[b] = system.velocity.size();
    for (std::size_t f = 0; f < part.body->base.frames.size(); ++f) {
        CarriedFrame carried{.frame = carrier.first_frame + f};
        for (const std::uint32_t k : carrier.base->corners(f)) {
            carried.on.push_back(carrier.first_corner + k);
        }
        carried.by = carrier.base->hold(f, part.body->base.frames[f], state.x).by;
        system.carried.push_back(std::move(carried));
    }
    const CornerBody& body = carrier.corner_body();
    carrier.elasticity = elasticity_of(carrier.base->bricks(), state.rotation);
    Aligned<double> force(carrier.elasticity->room(), 0), pull = force, undamped = force;
    carrier.elasticity->forces(by_slot(body, state.x).data(), force.data());
    carrier.elasticity->weigh(system.dt * system.dt, system.dt);
    carrier.elasticity->multiply(by_slot(body, state.v).data(), pull.data());
    carrier.elasticity->excess(Lumped::damping, by_slot(body, state.v).data(), undamped.data());
    carrier.elasticity->couple(1, system.dt);  // for good: A has the mass of bricks
    carrier.diagonal.assign(body.numbers, 0);
    carrier.elasticity->add_diagonal(carrier.diagonal.data());
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::size_t slot = body.slot_of(k);
        system.drag.push_back(body.damping_of(slot));
        const double drag = system.dt * system.drag.back();
        Vec6 v = Vec6::Zero(), right = Vec6::Zero();
        for (std::size_t i = 0; i < 3; ++i) {
            const auto axis = static_cast<Eigen::Index>(i);
            v[axis] = state.v[k][axis];
            const double kept = system.dt * undamped[4 * slot + i];
            right[axis] =
                system.dt * force[4 * slot + i] - pull[4 * slot + i] - drag * v[axis] + kept;
        }
        system.velocity.push_back(v);
        system.right.push_back(right);
        system.held.push_back(false);
        system.kind.push_back(BaseKind::particles);
        system.mass.push_back(body.mass[slot] * Mat6::Identity());
        system.diagonal.push_back((body.mass[slot] + drag) * Mat6::Identity());
    }
    for (const std::uint32_t k : part.pins.corner) {
        system.kind[carrier.first_corner + k] = BaseKind::still;
    }
    carrier.in.assign(body.numbers, 0);
    carrier.out.assign(carrier.elasticity->room(), 0);
    system.carriers.push_back(std::move(carrier));
}

Jacobian point_jacobian(const LayeredSystem& system, std::size_t f, const Vec3& arm)
{
    Jacobian J = Jacobian::Zero();
    J.leftCols<3>().setIdentity();
    if (system.kind[f] != BaseKind::particles) J.rightCols<3>() = -cross_matrix(arm);
    return J;
}

void add_terms(LayeredSystem& system, std::size_t a, std::size_t b, const Jacobian& Ja,
               const Jacobian& Jb, const Mat3& C, const Mat3& K)
{
    if (system.kind[a] == BaseKind::still && system.kind[b] == BaseKind::still) {
        const double times = system.held[a] && system.held[b] ? 2 : 1;
        for (const auto& [f, J] : {std::pair(a, &Ja), std::pair(b, &Jb)}) {
            if (!system.held[f]) continue;
            system.held_stiffness[f] += times * J->transpose() * K * *J;
            system.held_damping[f] += times * J->transpose() * C * *J;
        }
        return;
    }
    const Mat3 D = system.dt * C + system.dt * system.dt * K;
    const Vec3 pull =
        system.dt * system.dt * (K * (Ja * system.velocity[a] - Jb * system.velocity[b]));
    system.right[a] -= Ja.transpose() * pull;
    system.right[b] += Jb.transpose() * pull;
    system.diagonal[a] += Ja.transpose() * D * Ja;
    system.diagonal[b] += Jb.transpose() * D * Jb;
    system.pairs.push_back({a, b, -Ja.transpose() * D * Jb});
    if (system.pairs.size() >= 4096 + 2 * system.merged) merge_pairs(system);
}

// The terms of one frame against the world.
void add_own_terms(LayeredSystem& system, std::size_t f, const Jacobian& J, const Mat3& C,
                   const Mat3& K)
{
    if (system.held[f]) {
        system.held_stiffness[f] += J.transpose() * K * J;
        system.held_damping[f] += J.transpose() * C * J;
    }
    if (system.kind[f] == BaseKind::still) return;
    const double dt = system.dt;
    system.right[f] -= dt * dt * J.transpose() * (K * (J * system.velocity[f]));
    system.diagonal[f] += J.transpose() * (dt * C + dt * dt * K) * J;
}

Jacobian angular_jacobian()
{
    Jacobian J = Jacobian::Zero();
    J.rightCols<3>().setIdentity();
    return J;
}

}  // namespace

LayeredSystem make_system(const LayeredScene& scene, const LayeredMoment& moment, double dt,
                          RigidBodies rigid_bodies)
{
    LayeredSystem system;
    system.dt = system.longest = dt;
    const bool bullet = rigid_bodies == RigidBodies::bullet;
    const double led_mass = led_weight * heaviest(scene);
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        system.first_frame.push_back(system.velocity.size());
        const LayeredBody& body = *scene.parts[b].body;
        for (std::size_t f = 0; f < body.base.frames.size(); ++f) {
            Vec6 v;
            v << moment.twists[b][f].linear, moment.twists[b][f].angular;
            system.velocity.push_back(v);
            const bool held = bullet && body.base.kind == BaseKind::rigid;
            system.held.push_back(held);
            system.kind.push_back(held                              ? BaseKind::still
                                  : body.base.kind == BaseKind::net ? BaseKind::particles
                                                                    : body.base.kind);
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
            system.mass.push_back(mass);
            system.diagonal.push_back(body.base.cubes ? Mat6::Zero() : mass);
        }
        add_spans(scene, moment, b, system);
        for (const HeldFrame& held : scene.parts[b].held) {
            system.kind[system.frame(b, held.frame)] = BaseKind::still;
        }
    }
    system.right.assign(system.velocity.size(), Vec6::Zero());
    system.drag.assign(system.velocity.size(), 0);
    if (bullet)
        system.held_damping = system.held_stiffness = {system.velocity.size(), Mat6::Zero()};
    system.first_corner.resize(scene.parts.size());
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.cubes) add_cubes(scene, b, system);
    }
    return system;
}

void add_force(LayeredSystem& system, std::size_t f, const Vec3& force, const Vec3& torque)
{
    system.right[f].head<3>() += system.dt * force;
    system.right[f].tail<3>() += system.dt * torque;
}

void add_drag(LayeredSystem& system, std::size_t f, double rate)
{
    system.drag[f] += rate * system.mass[f](0, 0);
    system.right[f] -= system.dt * rate * (system.mass[f] * system.velocity[f]);
    system.diagonal[f] += system.dt * rate * system.mass[f];
}

void add_pair(LayeredSystem& system, std::size_t a, std::size_t b, const Vec3& arm_a,
              const Vec3& arm_b, const Mat3& C, const Mat3& K)
{
    add_terms(system, a, b, point_jacobian(system, a, arm_a), point_jacobian(system, b, arm_b), C,
              K);
}

void add_angular_pair(LayeredSystem& system, std::size_t a, std::size_t b, const Mat3& C,
                      const Mat3& K)
{
    add_terms(system, a, b, angular_jacobian(), angular_jacobian(), C, K);
}

void add_along(LayeredSystem& system, std::span<const FrameRow> rows, double c, double k)
{
    double u = 0, held = 0;
    bool moves = false;
    for (const FrameRow& row : rows) {
        u += row.along.dot(system.velocity[row.frame]);
        held += system.held[row.frame] != 0 ? 1 : 0;
        moves |= system.kind[row.frame] != BaseKind::still;
    }
    const double left = system.dt * c + system.dt * system.dt * k;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::size_t f = rows[i].frame;
        const Mat6 own = rows[i].along * rows[i].along.transpose();
        if (system.held[f]) {
            system.held_stiffness[f] += held * k * own;
            system.held_damping[f] += held * c * own;
        }
        if (!moves) continue;
        system.right[f] -= system.dt * system.dt * k * u * rows[i].along;
        system.diagonal[f] += left * own;
        for (std::size_t j = i + 1; j < rows.size(); ++j) {
            const Mat6 off = left * rows[i].along * rows[j].along.transpose();
            if (rows[j].frame == f) {
                system.diagonal[f] += off + off.transpose();
            } else {
                system.pairs.push_back({f, rows[j].frame, off});
            }
        }
    }
    if (system.pairs.size() >= 4096 + 2 * system.merged) merge_pairs(system);
}

void add_hold(LayeredSystem& system, std::size_t f, const Vec3& arm, const Mat3& C, const Mat3& K)
{
    add_own_terms(system, f, point_jacobian(system, f, arm), C, K);
}

void add_angular_hold(LayeredSystem& system, std::size_t f, const Mat3& C, const Mat3& K)
{
    add_own_terms(system, f, angular_jacobian(), C, K);
}

void add_stop(LayeredSystem& system, std::size_t a, std::size_t b, const Vec3& arm_a,
              const Vec3& arm_b, const Vec3& normal, double gap)
{
    if (a == b || (system.kind[a] == BaseKind::still && system.kind[b] == BaseKind::still)) return;
    const double mass = system.kind[a] == BaseKind::still ? system.mass[b](0, 0)
                        : system.kind[b] == BaseKind::still
                            ? system.mass[a](0, 0)
                            : std::min(system.mass[a](0, 0), system.mass[b](0, 0));
    system.stops.push_back({a, b, point_jacobian(system, a, arm_a).transpose() * normal,
                            -point_jacobian(system, b, arm_b).transpose() * normal, gap / system.dt,
                            stop_stiffness * mass});
}

void merge_pairs(LayeredSystem& system)
{
    for (SystemPair& pair : system.pairs) {
        if (pair.a <= pair.b) continue;
        std::swap(pair.a, pair.b);
        pair.off.transposeInPlace();
    }
    std::stable_sort(system.pairs.begin(), system.pairs.end(),
                     [](const SystemPair& p, const SystemPair& q) {
                         return std::pair(p.a, p.b) < std::pair(q.a, q.b);
                     });
    system.merged = 0;
    for (const SystemPair& pair : system.pairs) {
        if (system.merged > 0 && system.pairs[system.merged - 1].a == pair.a &&
            system.pairs[system.merged - 1].b == pair.b) {
            system.pairs[system.merged - 1].off += pair.off;
        } else {
            system.pairs[system.merged++] = pair;
        }
    }
    system.pairs.resize(system.merged);
}

Vec6 held_force(const LayeredSystem& system, std::size_t f)
{
    return system.right[f] / system.dt;
}

// The largest eigenvalue of M^-1 A, of a symmetric A >= 0, is no more than sqrt(tr (M^-1 A)^2).
Rates held_rates(const LayeredSystem& system, std::size_t f)
{
    const Eigen::LDLT<Mat6> mass(system.mass[f]);
    const auto largest = [&](const Mat6& A) {
        const Mat6 ratio = mass.solve(A);
        return std::sqrt(std::max(0.0, ratio.cwiseProduct(ratio.transpose()).sum()));
    };
    return {std::sqrt(largest(system.held_stiffness[f])), largest(system.held_damping[f])};
}

std::vector<float> cube_rotations(const LayeredSystem& system, std::size_t body)
{
    for (const CubeCarrier& carrier : system.carriers) {
        if (carrier.first_frame == system.first_frame[body]) return carrier.elasticity->rotations();
    }
    return {};
}

}  // namespace physics
