#include "physics/modal/stiffness_matrix.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/bricks/dissection.hpp"
#include "physics/state/cube_mass.hpp"

#include <Eigen/SparseCholesky>
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

// K and M in those blocks.
struct Blocks {
    std::vector<geometry::Mat3> stiffness;
    std::vector<double> mass;
};

Blocks sum_blocks(const geometry::Cubes& cubes, const Unknowns& unknowns, const BlockPairs& of,
                  CubeStiffness& stiffness)
{
    const auto& [pairs, first] = of;
    const CubeMass usual = cube_mass_matrix();
    Blocks blocks{{pairs.size(), geometry::Mat3::Zero()}, std::vector<double>(pairs.size(), 0.0)};
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto [k, factor] = stiffness.of(c);
        const CubeMass mass = mass_of_cube(cubes, c, usual);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) {
                const std::uint64_t row = unknowns.at[cubes.corners[c][a]];
                const std::uint64_t column = unknowns.at[cubes.corners[c][b]];
                if (row == no_index || column == no_index || row < column) continue;
                const auto begin = pairs.begin() + std::ptrdiff_t(first[column]);
                const auto end = pairs.begin() + std::ptrdiff_t(first[column + 1]);
                const auto found = std::lower_bound(begin, end, column << 32 | row);
                const auto at = std::size_t(found - pairs.begin());
                blocks.stiffness[at] +=
                    factor * k.block<3, 3>(Eigen::Index(3 * a), Eigen::Index(3 * b));
                blocks.mass[at] += cubes.mass[c] * mass[a][b];
            }
        }
    }
    return blocks;
}

// x, y and z of each unknown.
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

Eigen::Map<const Rows> rows_of(const Eigen::VectorXd& v)
{
    return {v.data(), v.size() / 3, 3};
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
    const auto [begin, end] = std::equal_range(held_.begin(), held_.end(), c, ByCube{});
    if (begin == end) return material(c);
    const auto [k, factor] = material(c);
    sum_ = factor * k;
    for (auto held = begin; held != end; ++held) add_held(*held, 1, sum_);
    return {sum_, 1};
}

std::pair<const BrickMatrix&, double> CubeStiffness::material(std::size_t c)
{
    if (cubes_.is_own(c)) {
        own_ = stiffness_of(cubes_.elements[cubes_.own[c]]);
        return {own_, cubes_.young[c] * cubes_.size};
    }
    // K is linear in E: one matrix for each Poisson ratio.
    auto& k = by_poisson_[cubes_.poisson[c]];
    if (!k) {
        k = std::make_unique<BrickMatrix>(
            brick_stiffness(cubes_.size, lame(1, cubes_.poisson[c]), element_));
    }
    return {*k, cubes_.young[c] * stiffness_share(cubes_, c, weighting_)};
}

double StiffnessAndMass::largest_ratio() const
{
    double largest = 0;
    for (Eigen::Index i = 0; i < rows(); ++i) {
        largest = std::max(largest, stiffness.coeff(i, i) / mass.coeff(i / 3, i / 3));
    }
    return largest;
}

Eigen::SparseMatrix<double> StiffnessAndMass::shifted(double shift) const
{
    Eigen::SparseMatrix<double> out = stiffness;
    for (Eigen::Index column = 0; column < rows(); ++column) {
        Eigen::SparseMatrix<double>::InnerIterator own(mass, column / 3);
        for (Eigen::SparseMatrix<double>::InnerIterator it(out, column); it; ++it) {
            if (it.row() % 3 != column % 3) continue;
            while (own.row() < it.row() / 3) ++own;
            it.valueRef() -= shift * own.value();
        }
    }
    return out;
}

Eigen::VectorXd StiffnessAndMass::times_mass(const Eigen::VectorXd& v) const
{
    Rows out = mass.selfadjointView<Eigen::Lower>() * rows_of(v);
    return Eigen::Map<const Eigen::VectorXd>(out.data(), v.size());
}

Eigen::VectorXd StiffnessAndMass::times_root(const Eigen::VectorXd& v) const
{
    const Rows out = root * rows_of(v);
    return Eigen::Map<const Eigen::VectorXd>(out.data(), v.size());
}

Eigen::VectorXd StiffnessAndMass::times_root_transposed(const Eigen::VectorXd& v) const
{
    const Rows out = root.transpose() * rows_of(v);
    return Eigen::Map<const Eigen::VectorXd>(out.data(), v.size());
}

Eigen::VectorXd StiffnessAndMass::without_root(const Eigen::VectorXd& v) const
{
    const Rows out = root.triangularView<Eigen::Lower>().solve(rows_of(v));
    return Eigen::Map<const Eigen::VectorXd>(out.data(), v.size());
}

Eigen::VectorXd StiffnessAndMass::without_root_transposed(const Eigen::VectorXd& v) const
{
    const Rows out = root.transpose().triangularView<Eigen::Upper>().solve(rows_of(v));
    return Eigen::Map<const Eigen::VectorXd>(out.data(), v.size());
}

StiffnessAndMass sum_matrices(const geometry::Cubes& cubes, const Unknowns& unknowns,
                              CubeStiffness& stiffness)
{
    const auto n = unknowns.count();
    const BlockPairs of = pairs_that_share_cubes(cubes, unknowns);
    const auto& [pairs, first] = of;
    const Blocks blocks = sum_blocks(cubes, unknowns, of, stiffness);
    StiffnessAndMass out;
    out.stiffness.resize(Eigen::Index(3 * n), Eigen::Index(3 * n));
    out.mass.resize(Eigen::Index(n), Eigen::Index(n));
    std::vector<int> entries(3 * n), mass_entries(n);
    for (std::size_t column = 0; column < n; ++column) {
        mass_entries[column] = int(first[column + 1] - first[column]);
        for (std::size_t j = 0; j < 3; ++j) {
            entries[3 * column + j] = int(3 * (first[column + 1] - first[column]) - j);
        }
    }
    out.stiffness.reserve(entries);
    out.mass.reserve(mass_entries);
    for (std::size_t column = 0; column < n; ++column) {
        for (std::size_t p = first[column]; p < first[column + 1]; ++p) {
            out.mass.insert(Eigen::Index(pairs[p] & 0xffffffffu), Eigen::Index(column)) =
                blocks.mass[p];
        }
        for (Eigen::Index j = 0; j < 3; ++j) {
            const Eigen::Index to = Eigen::Index(3 * column) + j;
            for (std::size_t p = first[column]; p < first[column + 1]; ++p) {
                const auto row = pairs[p] & 0xffffffffu;
                for (Eigen::Index i = 0; i < 3; ++i) {
                    const Eigen::Index from = Eigen::Index(3 * row) + i;
                    if (from >= to) out.stiffness.insert(from, to) = blocks.stiffness[p](i, j);
                }
            }
        }
    }
    out.stiffness.makeCompressed();
    out.mass.makeCompressed();
    const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>, Eigen::Lower,
                               Eigen::NaturalOrdering<int>>
        factor(out.mass);
    if (factor.info() != Eigen::Success) {
        throw std::invalid_argument("expected cubes with masses that can be added up, found some "
                                    "that are too far apart");
    }
    out.root = factor.matrixL();
    return out;
}

}  // namespace physics
