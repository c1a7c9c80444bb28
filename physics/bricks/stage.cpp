#include "physics/bricks/stage.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/same_triangles.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/math/for_numbers.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

StepFrame::StepFrame(const CornerBody& its_body, const Loads& its_loads, double its_seconds,
                     const StepOptions& its_options)
    : body(its_body), loads(its_loads), seconds(its_seconds), options(its_options),
      n(its_body.numbers)
{
    for (Aligned<double>* v : {&mass, &damping, &fixed}) fill_numbers(*v, n, 0.0);
    part_mass.assign(std::max<std::size_t>(body.parts, 1), 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        part_mass[body.part_of(k)] += body.mass[k];
        for (std::size_t i = 0; i < 3; ++i) {
            mass[4 * k + i] = body.mass[k];
            damping[4 * k + i] = body.damping_of(k);
        }
    }
    held = held_by(loads.pins);
    for_held_axes(*this, [&](std::size_t pin, std::size_t, std::size_t number) {
        fixed[number] = 1;
        if (held_axes(loads.pins, pin) == all_axes) return;
        held_along.push_back(static_cast<std::uint32_t>(number));
    });
    forces = loads.forces;
    use_forces();
}

void StepFrame::use_forces()
{
    fill_numbers(steady, n, 0.0);
    add_steady_forces(body, forces, steady);
    following = following_forces(body, forces);
    windy = !following.empty();
    windy |= std::any_of(forces.begin(), forces.end(), varies_by_place);
}

void StepFrame::start_at(const Aligned<double>& x)
{
    start = x;
    const Pins& pins = loads.pins;
    std::vector<Vec3> from;
    std::vector<std::uint32_t> group;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const std::size_t slot = body.slot_of(pins.corner[p]);
        from.emplace_back(Eigen::Map<const Vec3>(&x[4 * slot]));
        const bool whole = held_axes(pins, p) == all_axes;
        group.push_back(whole ? body.part_of(slot) : geometry::no_index);
    }
    pin_paths = PinPaths(std::move(from), pins.target, group, pins.pivot, body.h);
}

void StepFrame::take_forces(double share)
{
    if (share == forces_at || !any_change(loads.forces)) return;
    forces_at = share;
    for (std::size_t i = 0; i < forces.size(); ++i) forces[i] = loads.forces[i].at(share);
    use_forces();
}

Stage::Stage(const StepFrame& its_frame, Elasticity& its_elasticity)
    : frame(its_frame), elasticity(its_elasticity), rigid(its_frame.body)
{
    for (Aligned<double>* v : {&w, &x, &wind, &drag, &r, &delta, &jump}) v->resize(frame.n);
    fill_numbers(force, elasticity.room(), 0.0);
    fill_numbers(product, elasticity.room(), 0.0);
}

namespace {

bool are_equal(const geometry::TriMesh& a, const geometry::TriMesh& b)
{
    return &a == &b || (a.positions == b.positions && geometry::same_triangles(a, b));
}

}  // namespace

bool colliders_stay(const StepFrame& frame)
{
    const auto& colliders = frame.loads.colliders;
    return std::all_of(colliders.begin(), colliders.end(), [](const Collider& c) {
        return c.pose.isApprox(c.before, 1e-12) && c.size_before.value_or(c.size()) == c.size() &&
               (!c.mesh_before || are_equal(*c.mesh_before, *c.mesh));
    });
}

bool pins_stay(const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    bool stay = !stage.elasticity.targets_move();
    for_held_axes(frame, [&](std::size_t pin, std::size_t axis, std::size_t number) {
        const double to = frame.loads.pins.target[pin][static_cast<Eigen::Index>(axis)];
        stay = stay && to == frame.start[number];
    });
    return stay;
}

void times_mass(const Stage& stage, const Aligned<double>& v, Aligned<double>& out)
{
    const std::size_t n = stage.frame.n;
    out.resize(std::max(n, stage.elasticity.room()), 0);
    const bool less = stage.elasticity.excess(Lumped::mass, v.data(), out.data());
    for_numbers(n,
                [&](std::size_t i) { out[i] = stage.frame.mass[i] * v[i] - (less ? out[i] : 0); });
}

void times_damping(const Stage& stage, const Aligned<double>& v, Aligned<double>& out)
{
    const std::size_t n = stage.frame.n;
    out.resize(std::max(n, stage.elasticity.room()), 0);
    const bool less = stage.elasticity.excess(Lumped::damping, v.data(), out.data());
    for_numbers(
        n, [&](std::size_t i) { out[i] = stage.frame.damping[i] * v[i] - (less ? out[i] : 0); });
}

void place(Stage& stage)
{
    for_numbers(stage.frame.n,
                [&](std::size_t i) { stage.x[i] = stage.x0[i] + stage.tau * stage.w[i]; });
}

// Whether there are no elastic forces: all parts keep their shape, and no springs hold them.
static bool nothing_bends(const Stage& stage)
{
    return stage.rigid.all() && stage.frame.loads.pins.matter.cubes.empty();
}

void linearise(Stage& stage, const Aligned<double>& x)
{
    if (nothing_bends(stage) && !stage.linear_at.empty()) return;  // stage.force is 0
    // Pins are put where they belong between stages, by a rounding error.
    constexpr double rounding = 1e-15;
    bool same = stage.linear_at.size() == x.size();
    for (std::size_t i = 0; same && i < x.size(); ++i) {
        same = std::abs(x[i] - stage.linear_at[i]) <= rounding * std::abs(x[i]);
    }
    if (same) return;
    stage.elasticity.forces(x.data(), stage.force.data());
    stage.linear_at = x;
}

AtWork at_work(const Stage& stage)
{
    const StepFrame& frame = stage.frame;
    AtWork out;
    for (Aligned<double>* v : {&out.outside, &out.elastic}) v->resize(frame.n);
    fill_numbers(out.inertia, frame.n, 0.0);
    Aligned<double> jump(frame.n);
    for_numbers(frame.n, [&](std::size_t i) {
        out.outside[i] = stage.tau * (frame.steady[i] + stage.wind[i]);
        out.elastic[i] = stage.tau * stage.force[i];
        jump[i] = stage.w[i] - stage.v0[i];
    });
    times_mass(stage, jump, out.inertia);
    for (Aligned<double>* v : {&out.outside, &out.elastic, &out.inertia}) {
        stage.rigid.even_out(v->data());
    }
    return out;
}

void find_residual(Stage& stage)
{
    const StepFrame& frame = stage.frame;
    const double tau = stage.tau;
    stage.elasticity.weigh(stage.at_start ? tau * tau : 0, tau);
    if (nothing_bends(stage)) {
        fill_numbers(stage.product, stage.product.size(), 0.0);
    } else if (stage.base.empty()) {
        stage.elasticity.multiply(stage.w.data(), stage.product.data());
    } else {
        for_numbers(frame.n, [&](std::size_t i) { stage.r[i] = stage.w[i] - stage.base[i]; });
        stage.elasticity.multiply(stage.r.data(), stage.product.data());
    }
    for_numbers(frame.n, [&](std::size_t i) { stage.jump[i] = stage.v0[i] - stage.w[i]; });
    times_mass(stage, stage.jump, stage.momentum);
    for_numbers(frame.n, [&](std::size_t i) {
        stage.r[i] =
            stage.momentum[i] +
            tau * (stage.force[i] + frame.steady[i] + stage.wind[i] - stage.drag[i] * stage.w[i]) -
            stage.product[i];
    });
    if (!frame.body.mass_damping.empty()) {
        times_damping(stage, stage.w, stage.momentum);
        for_numbers(frame.n, [&](std::size_t i) { stage.r[i] -= tau * stage.momentum[i]; });
    }
    stage.elasticity.weigh(tau * tau, tau);
    for (const PointContact& c : stage.contacts) {
        for (std::size_t a = 0; a < c.count; ++a) {
            for (std::size_t i = 0; i < 3; ++i) {
                stage.r[4 * std::size_t{c.corners[a]} + i] +=
                    tau * double(c.weight[a]) * c.force[static_cast<Eigen::Index>(i)];
            }
        }
    }
    stage.rigid.even_out(stage.r.data());
}

double dot(const Aligned<double>& a, const Aligned<double>& b)
{
    return sum_over(b.size(), [&](std::size_t k) { return a[k] * b[k]; });
}

bool all_finite(const Aligned<double>& v)
{
    // Any NaN or infinity ends up in the sum.
    return sum_over(v.size(), [&](std::size_t i) { return v[i] * 0; }) == 0;
}

}  // namespace physics
