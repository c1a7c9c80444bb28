#include "physics/bricks/step_energy.hpp"

#include "physics/bricks/free_parts.hpp"

#include <cmath>

namespace physics {
namespace {

// Elastic energy; what is left of it is lost of the stage's linearisation.
double elastic(Stage& stage, const Aligned<double>& x)
{
    stage.linear_at.clear();
    return stage.elasticity.energy(x.data());
}

// Of motion and of the forces that do not change.
double kinetic(const Stage& stage, const Aligned<double>& v)
{
    Aligned<double> momentum;
    times_mass(stage, v, momentum);
    return 0.5 * dot(momentum, v);
}
double others(const Stage& stage, const Aligned<double>& x, const Aligned<double>& v)
{
    const StepFrame& frame = stage.frame;
    double sum = kinetic(stage, v);
    for (std::size_t i = 0; i < frame.n; ++i) sum -= frame.steady[i] * (x[i] - frame.start[i]);
    return sum;
}

bool is_known(const StepFrame& frame)
{
    if (frame.windy || !frame.loads.colliders.empty()) return false;
    for (std::size_t i = 0; i < frame.loads.pins.corner.size(); ++i) {
        for (std::size_t a = 0; a < 3; ++a) {
            if (pin_target(frame, i, a, 0) != pin_target(frame, i, a, 1)) return false;
        }
    }
    return true;
}

}  // namespace

EnergyAccount open_account(Stage& stage, const Aligned<double>& x, const Aligned<double>& v)
{
    if (!is_known(stage.frame)) return {};
    return {true, elastic(stage, x) + others(stage, x, v)};
}

void charge_damping(EnergyAccount& account, Stage& stage, double seconds)
{
    if (!account.known) return;
    const StepFrame& frame = stage.frame;
    Aligned<double> u = stage.w;
    for (std::size_t i = 0; i < stage.base.size(); ++i) u[i] -= stage.base[i];
    stage.elasticity.weigh(0, 1);
    stage.elasticity.multiply(u.data(), stage.product.data());
    double power = 0;
    for (std::size_t i = 0; i < frame.n; ++i) power += u[i] * stage.product[i];
    if (!frame.body.mass_damping.empty()) {
        times_damping(stage, stage.w, stage.momentum);
        power += dot(stage.momentum, stage.w);
    }
    account.due -= seconds * power;
}

bool settle(const EnergyAccount& account, Stage& stage, const Aligned<double>& x,
            Aligned<double>& v)
{
    if (!account.known) return true;
    const StepFrame& frame = stage.frame;
    const double stored = elastic(stage, x);
    const double excess = stored + others(stage, x, v) - account.due;
    const Aligned<double> u = deforming(stage, x, v);
    const double moving = kinetic(stage, u);
    const double share_sq = 1 - excess / moving;
    if (share_sq >= 0.5 && share_sq <= 2) {
        const double change = std::sqrt(share_sq) - 1;
        for (std::size_t i = 0; i < frame.n; ++i) v[i] += change * u[i];
        return true;
    }
    const double whole = kinetic(stage, v);
    return !(excess > 0.1 * (stored + moving) + 1e-4 * whole);
}

}  // namespace physics
