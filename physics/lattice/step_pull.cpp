#include "physics/lattice/step_pull.hpp"

#include "physics/lattice/lattice_pull.hpp"
#include "physics/lattice/plastic_flow.hpp"

#include <Eigen/Cholesky>

namespace physics {

namespace {

// Regions pull without force or torque; what rounding has left of them is taken out again.
void find_rigid_rest(FrameState& step, const PullMomentum& momentum)
{
    const Vec3 linear = momentum.linear(), centre = momentum.moment() / step.mass;
    const Mat3 about = momentum.spread() - step.mass * centre * centre.transpose();
    const Mat3 inertia = about.trace() * Mat3::Identity() - about;
    const Vec3 torque = momentum.angular() - centre.cross(linear);
    const Eigen::LDLT<Mat3> solver(inertia);
    Vec3 spin = solver.solve(torque);
    const double least = solver.vectorD().minCoeff();
    if (!(least > 1e-9 * about.trace()) || !spin.allFinite()) spin.setZero();  // a line, a point
    step.drift = linear / step.mass;
    step.spin = spin;
    step.pivot = step.origin + centre;
}

}  // namespace

template <class T> void pull(StepState<T>& step)
{
    if (!step.membrane_share.empty()) {
        step.stretched.pull(step.body.membrane, {step.torn_corners, find_membrane_rest(step)},
                            step.membrane_share, step.state.x);
    }
    const auto& goal = step.sums.particles;
    float* const before = step.state.rotation.data() + 4 * step.matched->regions.slots();
    const double damping = step.has_before ? step.damping : 0;
    const auto momentum = geometry::ordered_sum<PullMomentum>(
        step.n, particles_a_task, {}, [&](std::size_t begin, std::size_t end) {
            constexpr std::size_t at_once = 256;
            alignas(64) T stretch[4 * at_once];
            PullMomentum sum;
            for (std::size_t i = begin; i < end; i += at_once) {
                const std::size_t count = std::min(at_once, end - i);
                const bool stretches = !step.membrane_share.empty();
                if (stretches) step.stretched.gather(step.body.membrane, i, count, stretch);
                const PulledParticles<T> particles{count,
                                                   step.state.x[i].data(),
                                                   step.state.v[i].data(),
                                                   before + 3 * i,
                                                   goal[i].data(),
                                                   step.held_weight.data() + i,
                                                   step.matched->held_by.data() + i,
                                                   step.body.base.mass.data() + i,
                                                   stretches ? stretch : nullptr};
                sum = sum + pull_particles(particles, step.origin, step.stiffness / step.dt,
                                           damping / step.dt);
            }
            return sum;
        });
    step.has_before = true;
    if (step.loads.pins.corner.empty()) find_rigid_rest(step, momentum);
}

template void pull(StepState<float>&);
template void pull(StepState<double>&);

}  // namespace physics
