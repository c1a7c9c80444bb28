#pragma once

// How a body gives way where it is pushed: contacts for a preconditioner that knows nothing of
// them. With A = A_0 + sum W^T K W, W the weights of a contact and K its matrix, and M about
// A_0^-1,
//   K = G G^T,  U = W^T G of all contacts,  V = M U
//   A^-1 = about M - V (1 + U^T V)^-1 V^T      (Sherman and Morrison; Woodbury)
// Positive definite whenever M is. M W^T, three applications of M for each contact, stays from
// round to round as long as M does; without it, a contact costs some 25 iterations in every round.

#include "physics/bricks/contact_block.hpp"
#include "physics/math/aligned_memory.hpp"

#include <Eigen/Cholesky>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace physics {

struct StepResponses {
    using Apply = std::function<void(const float* r, float* z)>;
    using Weights = std::vector<std::pair<std::uint32_t, float>>;  // by slot

    // Forgets what is known of other stages: M is that of steps of `step` seconds, linear about a
    // place.
    void start(double step, const Aligned<double>& place);
    // How many applications of M it takes to know the contacts of a round.
    std::size_t missing(const std::vector<ContactBlock<float>>& contacts) const;
    // Forgets all but these.
    void keep(const std::vector<ContactBlock<float>>& contacts);
    // Makes those that are missing, and what take_contacts() needs of the contacts, which have to
    // stay until then. `inverse` is M, for vectors with `room`; `fixed` is not 0 of numbers that
    // are held.
    void make(const std::vector<ContactBlock<float>>& contacts, const Aligned<double>& fixed,
              std::size_t room, const Apply& inverse);
    // z = M r becomes what it is with the contacts that were made last.
    void take_contacts(float* z) const;

    std::map<Weights, std::array<Aligned<float>, 3>> known = {};  // M W^T by W
    Aligned<double> linear_at = {};                               // m, and s: what they are of
    double tau = 0;

private:
    struct Used {
        const ContactBlock<float>* contact = nullptr;
        const std::array<Aligned<float>, 3>* response = nullptr;
        Eigen::Matrix3d root;  // G
    };

    std::vector<Used> used_;
    Eigen::LLT<Eigen::MatrixXd> middle_;  // 1 + U^T V
};

}  // namespace physics
