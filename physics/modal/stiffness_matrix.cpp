#include "physics/modal/stiffness_matrix.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/bricks/dissection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace physics {
namespace {

using geometry::no_index;

// Pairs of corners that share a cube, by unknowns: the matrix's 3 x 3 blocks.
struct BlockPairs {
    std::vector<std::uint64_t> pairs;  // sorted: column in the high half, row in the low
    std::vector<std::size_t> first;    // n + 1, of each column, into pairs
};

BlockPairs pairs_that_share_cubes(const geometry::Cubes& cubes, const Unknowns& unknowns)
{
    BlockPairs out;
    auto& pairs = out.pairs;
    pairs.reserve(36 * cubes.count());
    for (const auto& corners : cubes.corners) {
        for (const auto a : corners) {
            for (const auto b : corners) {
                const std::uint64_t row = unknowns.at[a], column = unknowns.at[b];
                if (row != no_index && column != no_index && row >= column) {
                    pairs.push_back(column << 32 | row);
                }
            }
        }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    auto& first = out.first;
    first.assign(unknowns.count() + 1, 0);
    for (const auto pair : pairs) ++first[(pair >> 32) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    return out;
}

// K in those blocks.
std::vector<geometry::Mat3> sum_blocks(const geometry::Cubes& cubes, const Unknowns& unknowns,
                                       const BlockPairs& of, CubeStiffness& stiffness)
{
    const auto& [pairs, first] = of;
    std::vector<geometry::Mat3> blocks(pairs.size(), geometry::Mat3::Zero());
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto [k, factor] = stiffness.of(c);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) {
                const std::uint64_t row = unknowns.at[cubes.corners[c][a]];
                const std::uint64_t column = unknowns.at[cubes.corners[c][b]];
                if (row == no_index || column == no_index || row < column) continue;
                const auto begin = pairs.begin() + std::ptrdiff_t(first[column]);
                const auto end = pairs.begin() + std::ptrdiff_t(first[column + 1]);
                const auto found = std::lower_bound(begin, end, column << 32 | row);
                blocks[std::size_t(found - pairs.begin())] +=
                    factor * k.block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b));
            }
        }
    }
    return blocks;
}

}  // namespace

Unknowns order_unknowns(const geometry::Cubes& cubes, const std::vector<std::uint32_t>& pinned)
{
    Unknowns u;
    u.at.assign(cubes.corner_count(), 0);
    for (const auto p : pinned) {
        if (p >= cubes.corner_count()) {
            throw std::invalid_argument(fmt::format(
                "expected pinned corners below {}, found {}. Were the pins made for other cubes?",
                cubes.corner_count(), p));
        }
        u.at[p] = no_index;
    }
    for (std::uint32_t i = 0; i < u.at.size(); ++i) {
        if (u.at[i] != no_index) u.corner.push_back(i);
    }
    order_for_elimination(cubes, u.corner);
    for (std::uint32_t i = 0; i < u.count(); ++i) u.at[u.corner[i]] = i;
    return u;
}

std::pair<const BrickMatrix&, double> CubeStiffness::of(std::size_t c)
{
    // K is linear in E: one matrix for each Poisson ratio.
    auto& k = by_poisson_[cubes_.poisson[c]];
    if (!k) {
        k = std::make_unique<BrickMatrix>(
            brick_stiffness(cubes_.size, lame(1, cubes_.poisson[c]), element_));
    }
    return {*k, cubes_.young[c] * stiffness_share(cubes_, c, weighting_)};
}

Eigen::SparseMatrix<double> stiffness_by_mass(const geometry::Cubes& cubes,
                                              const Unknowns& unknowns,
                                              const Eigen::VectorXd& root_mass,
                                              CubeStiffness& stiffness)
{
    const auto n = unknowns.count();
    const BlockPairs of = pairs_that_share_cubes(cubes, unknowns);
    const auto& [pairs, first] = of;
    const std::vector<geometry::Mat3> blocks = sum_blocks(cubes, unknowns, of, stiffness);
    Eigen::SparseMatrix<double> d(Eigen::Index(3 * n), Eigen::Index(3 * n));
    std::vector<int> entries(3 * n);
    for (std::size_t column = 0; column < n; ++column) {
        for (std::size_t j = 0; j < 3; ++j) {
            entries[3 * column + j] = int(3 * (first[column + 1] - first[column]) - j);
        }
    }
    d.reserve(entries);
    for (std::size_t column = 0; column < n; ++column) {
        for (Eigen::Index j = 0; j < 3; ++j) {
            const Eigen::Index to = Eigen::Index(3 * column) + j;
            for (std::size_t p = first[column]; p < first[column + 1]; ++p) {
                const auto row = pairs[p] & 0xffffffffu;
                for (Eigen::Index i = 0; i < 3; ++i) {
                    const Eigen::Index from = Eigen::Index(3 * row) + i;
                    if (from >= to) {
                        d.insert(from, to) = blocks[p](i, j) / (root_mass[from] * root_mass[to]);
                    }
                }
            }
        }
    }
    d.makeCompressed();
    return d;
}

}  // namespace physics
