#pragma once

// The linear equations of a stage between rigid parts and the elastic ones that they touch, solved
// at once. With E the elastic parts' own matrix, factored with their side of these contacts, R that
// of the rigid parts (rigid_blocks.hpp) and B = E's rows between both,
//   V = E^-1 B,   S = R - B^T V      (the Schur complement, six numbers a part)
//   u = S^-1 (P^T r - V^T r_e),   z = P u of rigid parts, E^-1 r_e - V u of elastic ones
// Without B, contacts as stiff as stop rigid parts take hundreds of iterations in every round.

#include "physics/bricks/direct_factor.hpp"
#include "physics/bricks/rigid_blocks.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/math/eight_columns.hpp"

#include <vector>

namespace physics {

class JoinedSystem {
public:
    // Takes V and S. `elastic` is E's factor, `fixed` is not 0 of numbers that are held. False, and
    // nothing is ready, where nothing rigid touches anything elastic, S is not positive, or V would
    // take too much room. `bodies` must outlive this.
    bool make(const RigidBodies& bodies, RigidBlocks blocks,
              const std::vector<ContactBlock<double>>& contacts, const Aligned<double>& fixed,
              DirectFactor& elastic);
    bool ready() const { return bodies_ != nullptr; }
    void forget() { bodies_ = nullptr; }
    // z, E^-1 r where it is elastic, becomes what it is with rigid parts.
    void join(const double* r, double* z) const;

private:
    const RigidBodies* bodies_ = nullptr;
    std::vector<std::uint32_t> touching_;  // of the rigid parts: six columns of V each
    std::vector<EightColumns> response_;   // V, three rows a slot
    RigidFactor factor_;                   // of S
};

}  // namespace physics
