#include "physics/lattice/step_pull.hpp"

#include "physics/lattice/lattice_pull.hpp"
#include "physics/lattice/plastic_flow.hpp"

#include <Eigen/Cholesky>

#include <algorithm>

namespace physics {

namespace {

constexpr std::size_t pulled_at_once = 256;

// Regions pull a piece without force or torque; what rounding has left of them.
RigidRest find_rigid_rest(const PullMomentum& momentum, double mass, const Vec3& origin)
{
    const Vec3 linear = momentum.linear(), centre = momentum.moment() / mass;
    const Mat3 about = momentum.spread() - mass * centre * centre.transpose();
    const Mat3 inertia = about.trace() * Mat3::Identity() - about;
    const Vec3 torque = momentum.angular() - centre.cross(linear);
    const Eigen::LDLT<Mat3> solver(inertia);
    Vec3 spin = solver.solve(torque);
    const double least = solver.vectorD().minCoeff();
    if (!(least > 1e-9 * about.trace()) || !spin.allFinite()) spin.setZero();  // a line, a point
    return {linear / mass, spin, origin + centre};
}

// Momentum of some pieces, each once.
struct PieceMomentum {
    std::vector<std::uint32_t> piece;
    std::vector<PullMomentum> momentum;

    void add(std::uint32_t of, const PullMomentum& more)
    {
        std::size_t k = piece.size();
        while (k > 0 && piece[k - 1] != of) --k;
        if (k == 0) {
            piece.push_back(of);
            momentum.emplace_back();
            k = piece.size();
        }
        momentum[k - 1] = momentum[k - 1] + more;
    }
};

// Calls pull(begin, count), which returns the momentum that it gave, for runs of particles of one
// piece, at most pulled_at_once each; into step.rest.
template <class Pull> void pull_pieces(FrameState& step, const Pull& pull)
{
    const std::vector<std::uint32_t>& piece = step.pieces->of;
    std::vector<PieceMomentum> parts((step.n + particles_a_task - 1) / particles_a_task);
    geometry::parallel_for(parts.size(), 1, [&](std::size_t first, std::size_t last) {
        for (std::size_t part = first; part < last; ++part) {
            const std::size_t end = std::min(step.n, (part + 1) * particles_a_task);
            for (std::size_t i = part * particles_a_task; i < end;) {
                const std::size_t most = std::min(pulled_at_once, end - i);
                std::size_t count = 1;
                while (count < most && piece[i + count] == piece[i]) ++count;
                parts[part].add(piece[i], pull(i, count));
                i += count;
            }
        }
    });
    std::vector<PullMomentum> sums(step.pieces->count);
    for (const PieceMomentum& part : parts) {
        for (std::size_t k = 0; k < part.piece.size(); ++k) {
            PullMomentum& sum = sums[part.piece[k]];
            sum = sum + part.momentum[k];
        }
    }
    for (std::size_t p = 0; p < sums.size(); ++p) {
        if (!step.is_pinned[p])
            step.rest[p] = find_rigid_rest(sums[p], step.piece_mass[p], step.origin);
    }
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
    pull_pieces(step, [&](std::size_t i, std::size_t count) {
        alignas(64) T stretch[4 * pulled_at_once];
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
        return pull_particles(particles, step.origin, step.stiffness / step.dt, damping / step.dt);
    });
    step.has_before = true;
}

template void pull(StepState<float>&);
template void pull(StepState<double>&);

}  // namespace physics
