#pragma once

// The linear equations of a stage between its rigid parts alone, P^T A P with six unknowns each
// (rigid_bodies.hpp), factored with the contacts between them: a preconditioner that solves a scene
// of rigid parts at once. It knows nothing of elastic parts that they touch.

#include "physics/bricks/rigid_blocks.hpp"
#include "physics/math/aligned_memory.hpp"

#include <functional>
#include <vector>

namespace physics {

class RigidSystem {
public:
    // Takes each part alone, unless its arms are those that it was taken with last. `multiply` is
    // y = K p with vectors of `room` numbers, `diagonal` what A has besides K and the contacts.
    // `bodies` must outlive this.
    void look(const RigidBodies& bodies,
              const std::function<void(const double* p, double* y)>& multiply, std::size_t room,
              const Aligned<double>& diagonal);
    // Factors all of them with contacts.
    void make(const std::vector<ContactBlock<double>>& contacts);
    // z = P (P^T A P)^-1 P^T r at their corners; others stay as they are.
    template <class T> void solve(const T* r, T* z) const;

    // As make() took them, with contacts.
    const RigidBlocks& blocks() const { return blocks_; }

private:
    const RigidBodies* bodies_ = nullptr;
    std::vector<Matrix6> own_;  // of each part alone, without contacts
    std::uint64_t looks_ = 0;   // of the arms that these are of
    RigidBlocks blocks_;
    RigidFactor factor_;
    std::vector<Matrix6> inverse_;  // of each part's block, where all of them have no factor
};

extern template void RigidSystem::solve(const float*, float*) const;
extern template void RigidSystem::solve(const double*, double*) const;

}  // namespace physics
