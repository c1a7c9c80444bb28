#include "physics/modal/stiffness_matrix.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/stop.hpp"
#include "physics/bricks/dissection.hpp"
#include "physics/state/cube_mass.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

namespace physics {
namespace {

using Eigen::Index;
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
    geometry::stop_if_asked();
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

// The lower triangle of K, column by column.
void put_together(const BlockPairs& of, const std::vector<geometry::Mat3>& blocks,
                  Eigen::SparseMatrix<double>& out)
{
    const auto n = Index(of.first.size() - 1);
    out.resize(3 * n, 3 * n);
    out.resizeNonZeros(Index(9 * of.pairs.size()) - 3 * n);
    int* row = out.innerIndexPtr();
    double* value = out.valuePtr();
    for (Index column = 0; column < 3 * n; ++column) {
        out.outerIndexPtr()[column] = int(row - out.innerIndexPtr());
        for (std::size_t p = of.first[std::size_t(column / 3)];
             p < of.first[std::size_t(column / 3) + 1]; ++p) {
            const Index from = 3 * Index(of.pairs[p] & 0xffffffffu);
            for (Index i = std::max(from, column); i < from + 3; ++i) {
                *row++ = int(i);
                *value++ = blocks[p](i - from, column % 3);
            }
        }
    }
    out.outerIndexPtr()[3 * n] = int(row - out.innerIndexPtr());
}

// The whole of M.
void put_together(const BlockPairs& of, const std::vector<double>& numbers,
                  Eigen::SparseMatrix<double, Eigen::RowMajor>& out)
{
    const auto n = Index(of.first.size() - 1);
    Eigen::SparseMatrix<double> lower(n, n);
    lower.resizeNonZeros(Index(of.pairs.size()));
    for (std::size_t p = 0; p < of.pairs.size(); ++p) {
        lower.innerIndexPtr()[p] = int(of.pairs[p] & 0xffffffffu);
        lower.valuePtr()[p] = numbers[p];
    }
    for (std::size_t k = 0; k < of.first.size(); ++k) lower.outerIndexPtr()[k] = int(of.first[k]);
    out = lower.selfadjointView<Eigen::Lower>();
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
    for (Index i = 0; i < rows(); ++i) {
        largest = std::max(largest, stiffness.coeff(i, i) / mass.coeff(i / 3, i / 3));
    }
    return largest;
}

Eigen::SparseMatrix<double> StiffnessAndMass::shifted(double shift) const
{
    Eigen::SparseMatrix<double> out = stiffness;
    for (Index column = 0; column < rows(); ++column) {
        Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator own(mass, column / 3);
        for (Eigen::SparseMatrix<double>::InnerIterator it(out, column); it; ++it) {
            if (it.row() % 3 != column % 3) continue;
            while (own.col() < it.row() / 3) ++own;
            it.valueRef() -= shift * own.value();
        }
    }
    return out;
}

Eigen::MatrixXd StiffnessAndMass::times_mass(const Eigen::MatrixXd& v) const
{
    Eigen::MatrixXd out(v.rows(), v.cols());
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    for (Index j = 0; j < v.cols(); ++j) {
        const Eigen::Map<const Rows> from(v.col(j).data(), v.rows() / 3, 3);
        Eigen::Map<Rows>(out.col(j).data(), v.rows() / 3, 3) = mass * from;
    }
    return out;
}

void StiffnessAndMass::times_mass(const EightColumns& v, EightColumns& to) const
{
    times_in_threes(std::size_t(mass.rows()),
                    {mass.outerIndexPtr(), mass.innerIndexPtr(), mass.valuePtr()}, v, to);
}

StiffnessAndMass sum_matrices(const geometry::Cubes& cubes, const Unknowns& unknowns,
                              CubeStiffness& stiffness)
{
    const BlockPairs of = pairs_that_share_cubes(cubes, unknowns);
    geometry::stop_if_asked();
    const Blocks blocks = sum_blocks(cubes, unknowns, of, stiffness);
    StiffnessAndMass out;
    geometry::stop_if_asked();
    put_together(of, blocks.stiffness, out.stiffness);
    put_together(of, blocks.mass, out.mass);
    const Eigen::VectorXd diagonal = out.mass.diagonal();
    if (!(diagonal.minCoeff() > 1e-15 * diagonal.maxCoeff())) {
        throw std::invalid_argument("expected cubes with masses that can be added up, found some "
                                    "that are too far apart");
    }
    return out;
}

}  // namespace physics
