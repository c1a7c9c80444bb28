#include "physics/bricks/joined_system.hpp"

#include <algorithm>
#include <map>

namespace physics {
namespace {

using Eigen::Index;
using Pulls = std::map<std::uint32_t, RigidRows>;  // B of one part, by slot

std::vector<Pulls> pulls_of(const RigidBodies& bodies,
                            const std::vector<ContactBlock<double>>& contacts,
                            const Aligned<double>& fixed)
{
    std::vector<Pulls> out(bodies.count());
    for (const auto& contact : contacts) {
        const RigidSides sides = sides_of(bodies, contact);
        for (std::size_t s = 0; s < sides.count; ++s) {
            const RigidRows pushed = matrix_of(contact) * sides.side[s].rows();
            for (std::size_t a = 0; a < contact.count; ++a) {
                const std::uint32_t slot = contact.corners[a];
                if (bodies.of_corner(slot) != RigidBodies::not_rigid) continue;
                const double* const held = &fixed[4 * std::size_t{slot}];
                if (held[0] + held[1] + held[2] == 3) continue;
                Pulls& pulls = out[sides.side[s].body];
                RigidRows& rows = pulls.try_emplace(slot, RigidRows::Zero()).first->second;
                for (Index i = 0; i < 3; ++i) {
                    if (held[i] == 0) rows.row(i) += contact.weight[a] * pushed.row(i);
                }
            }
        }
    }
    return out;
}

// x = E^-1 of eight columns.
void solve_eight(DirectFactor& elastic, std::size_t slots, const EightColumns& b, EightColumns& x)
{
    if (!elastic.has_inner()) return elastic.solve(b, x);
    Aligned<double> from(4 * slots, 0), to(4 * slots, 0);
    for (std::size_t c = 0; c < eight; ++c) {
        for (std::size_t k = 0; k < slots; ++k) {
            for (std::size_t i = 0; i < 3; ++i) from[4 * k + i] = b[eight * (3 * k + i) + c];
        }
        std::fill(to.begin(), to.end(), 0);
        elastic.solve(from.data(), to.data());
        for (std::size_t k = 0; k < slots; ++k) {
            for (std::size_t i = 0; i < 3; ++i) x[eight * (3 * k + i) + c] = to[4 * k + i];
        }
    }
}

}  // namespace

bool JoinedSystem::make(const RigidBodies& bodies, RigidBlocks blocks,
                        const std::vector<ContactBlock<double>>& contacts,
                        const Aligned<double>& fixed, DirectFactor& elastic)
{
    constexpr std::size_t most_numbers = 30'000'000;  // of V, 240 MB
    forget();
    const std::size_t slots = fixed.size() / 4, rows = 3 * slots;
    const std::vector<Pulls> pulls = pulls_of(bodies, contacts, fixed);
    touching_.clear();
    for (std::uint32_t i = 0; i < pulls.size(); ++i) {
        if (!pulls[i].empty()) touching_.push_back(i);
    }
    const std::size_t columns = 6 * touching_.size();
    if (columns == 0 || columns * rows > most_numbers) return false;
    response_.resize((columns + eight - 1) / eight);
    EightColumns pushed;
    for (std::size_t e = 0; e < response_.size(); ++e) {
        pushed.assign(eight * rows, 0);
        for (std::size_t c = eight * e; c < std::min(columns, eight * (e + 1)); ++c) {
            for (const auto& [slot, of] : pulls[touching_[c / 6]]) {
                for (std::size_t i = 0; i < 3; ++i) {
                    pushed[eight * (3 * std::size_t{slot} + i) + c % eight] =
                        of(Index(i), Index(c % 6));
                }
            }
        }
        response_[e].assign(eight * rows, 0);
        solve_eight(elastic, slots, pushed, response_[e]);
    }
    for (std::size_t a = 0; a < touching_.size(); ++a) {
        Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(6, Index(eight * response_.size()));
        for (const auto& [slot, of] : pulls[touching_[a]]) {
            for (std::size_t e = 0; e < response_.size(); ++e) {
                using Three = Eigen::Matrix<double, 3, 8, Eigen::RowMajor>;
                const double* const at = &response_[e][3 * eight * std::size_t{slot}];
                moved.middleCols<8>(Index(eight * e)) +=
                    of.transpose() * Eigen::Map<const Three>(at);
            }
        }
        blocks.own[touching_[a]] -= moved.middleCols<6>(Index(6 * a));
        for (std::size_t b = a + 1; b < touching_.size(); ++b) {
            const Matrix6 block = moved.middleCols<6>(Index(6 * b));
            if (!block.isZero(0)) blocks.add_between(touching_[a], touching_[b], -block);
        }
    }
    if (!factor_.make(blocks)) return false;
    bodies_ = &bodies;
    return true;
}

void JoinedSystem::join(const double* r, double* z) const
{
    const std::size_t bodies = bodies_->count(), rows = response_[0].size() / eight;
    Eigen::VectorXd u(Index(6 * bodies));
    for (std::size_t i = 0; i < bodies; ++i) {
        Vec3 force, torque;
        bodies_->gather(i, r, force, torque);
        u.segment<6>(Index(6 * i)) << force, torque;
    }
    using Eight = Eigen::Array<double, 8, 1>;
    const auto unknown = [&](std::size_t column) {  // of u, 6 * bodies beyond the last column
        const std::size_t t = column / 6;
        return t < touching_.size() ? 6 * touching_[t] + column % 6 : 6 * bodies;
    };
    for (std::size_t e = 0; e < response_.size(); ++e) {
        Eight sum = Eight::Zero();
        for (std::size_t row = 0; row < rows; ++row) {
            const double at = r[4 * (row / 3) + row % 3];
            if (at != 0) sum += at * Eigen::Map<const Eight>(&response_[e][eight * row]);
        }
        for (std::size_t c = 0; c < eight; ++c) {
            const std::size_t to = unknown(eight * e + c);
            if (to < 6 * bodies) u[Index(to)] -= sum[Index(c)];
        }
    }
    factor_.solve(u);
    for (std::size_t e = 0; e < response_.size(); ++e) {
        Eight by = Eight::Zero();
        for (std::size_t c = 0; c < eight; ++c) {
            const std::size_t from = unknown(eight * e + c);
            if (from < 6 * bodies) by[Index(c)] = u[Index(from)];
        }
        for (std::size_t row = 0; row < rows; ++row) {
            const Eigen::Map<const Eight> at(&response_[e][eight * row]);
            z[4 * (row / 3) + row % 3] -= (by * at).sum();
        }
    }
    for (std::size_t i = 0; i < bodies; ++i) {
        const auto own = u.segment<6>(Index(6 * i));
        bodies_->spread(i, Vec3(own.head<3>()), Vec3(own.tail<3>()), z);
    }
}

}  // namespace physics
