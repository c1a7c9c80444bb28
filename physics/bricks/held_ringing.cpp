#include "physics/bricks/held_ringing.hpp"

#include "physics/bricks/holding_elasticity.hpp"
#include "physics/math/conjugate_gradients.hpp"
#include "physics/state/hold_matter.hpp"
#include "physics/state/measure.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

// Of each of HeldMatter::corner.
using Velocities = std::vector<Vec3>;

std::size_t number_of(const FrameStep& step, std::size_t held)
{
    const StepFrame& frame = step.frame;
    return 4 * frame.body.slot_of(frame.loads.pins.matter.corner[held]);
}

// m/s, of targets against corners that move at v.
Velocities ahead(const FrameStep& step, const HoldingElasticity& holding, const double* v,
                 double share)
{
    Velocities out = holding.target_velocities(share);
    for (std::size_t i = 0; i < out.size(); ++i) {
        out[i] = out[i] / step.frame.seconds - Eigen::Map<const Vec3>(v + number_of(step, i));
    }
    return out;
}

// The springs of cubes whose points turned round within the step. Rigid parts do not ring.
HeldMatter turning_round(const FrameStep& step, const Velocities& before, const Velocities& after)
{
    HeldMatter out = step.frame.loads.pins.matter;
    std::erase_if(out.cubes, [&](const HeldCube& cube) {
        const auto first = static_cast<std::uint32_t>(number_of(step, cube.corner[0]) / 4);
        if (step.stage.rigid.of_corner(first) != RigidBodies::not_rigid) return true;
        double sum = 0;
        for (const auto at : cube.corner) {
            for (Eigen::Index i = 0; i < 3; ++i) {
                if ((cube.axes >> i & 1) != 0) sum += before[at][i] * after[at][i];
            }
        }
        return !(sum < 0);
    });
    return out;
}

// y += factor * A of what is held, with `of` its corners' vectors.
void add_springs(const FrameStep& step, const HeldMatter& matter, const Velocities& of,
                 double factor, double* y)
{
    const std::vector<Vec3> forces = forces_of(matter, of);
    for (std::size_t i = 0; i < forces.size(); ++i) {
        Eigen::Map<Vec3>(y + number_of(step, i)) += factor * forces[i];
    }
}

// M + dt^2 A, without what pins hold.
LinearSystem<double> system_of(FrameStep& step, const HeldMatter& matter, double dt)
{
    const StepFrame& frame = step.frame;
    Stage& stage = step.stage;
    LinearSystem<double> out;
    out.numbers = frame.n, out.room = std::max(frame.n, stage.elasticity.room());
    out.diagonal = frame.mass;
    out.inverse = frame.mass;
    for (const HeldCube& cube : matter.cubes) {
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t i = 0; i < 3; ++i) {
                if ((cube.axes >> i & 1) == 0) continue;
                const std::size_t at = number_of(step, cube.corner[a]) + i;
                out.inverse[at] += dt * dt * stiffness_at(cube, a, a);
            }
        }
    }
    for (std::size_t i = 0; i < frame.n; ++i) {
        const bool moves = frame.fixed[i] == 0 && out.inverse[i] > 0;
        out.inverse[i] = moves ? 1 / out.inverse[i] : 0;
    }
    out.multiply = [&step, &stage, &matter, dt, room = out.room](const double* p, double* y) {
        if (!stage.elasticity.excess(Lumped::mass, p, y)) std::fill_n(y, room, 0);
        for (std::size_t i = 0; i < step.frame.n; ++i) y[i] = -y[i];
        Velocities held(matter.corner.size());
        for (std::size_t i = 0; i < held.size(); ++i) {
            held[i] = Eigen::Map<const Vec3>(p + number_of(step, i));
        }
        add_springs(step, matter, held, dt * dt, y);
    };
    return out;
}

}  // namespace

void stop_ringing(FrameStep& step, const HoldingElasticity& holding, const Aligned<double>& v0,
                  double begin, double end)
{
    constexpr double tolerance = 1e-8;
    constexpr int most = 200;
    const StepFrame& frame = step.frame;
    Aligned<double>& v = step.now.v;
    const Velocities after = ahead(step, holding, v.data(), end);
    const HeldMatter matter = turning_round(step, ahead(step, holding, v0.data(), begin), after);
    if (matter.cubes.empty()) return;
    const double dt = (end - begin) * frame.seconds;
    const LinearSystem<double> system = system_of(step, matter, dt);
    ConjugateVectors<double> work;
    work.r.assign(frame.n, 0);
    add_springs(step, matter, after, dt * dt, work.r.data());
    double size_sq = 0;
    for (std::size_t i = 0; i < frame.n; ++i) size_sq += work.r[i] * work.r[i] * system.inverse[i];
    conjugate_gradients(system, tolerance * std::sqrt(size_sq), most, work);
    Aligned<double> momentum;
    times_mass(step.stage, work.x, momentum);
    for (std::size_t i = 0; i < frame.n; ++i) {
        if (step.account.known) step.account.due += momentum[i] * (v[i] + 0.5 * work.x[i]);
        v[i] += work.x[i];
    }
    MeanForces more;
    more.held = forces_of(matter, ahead(step, holding, v.data(), end));
    for (Vec3& force : more.held) force *= dt;
    more.held = holding.at_end(std::move(more.held), end);
    add_share(step.forces, more, 1);
}

}  // namespace physics
