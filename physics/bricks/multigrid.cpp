#include "physics/bricks/multigrid.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/random.hpp"
#include "physics/math/dense_columns.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace physics {
namespace {

using Eigen::Index;
using geometry::Vec3i;

constexpr int first_ratio = 4, next_ratio = 2;
constexpr std::size_t nodes_to_invert = 130;
constexpr std::size_t most_to_invert = 400;
constexpr double smoothed_span = 8;  // on coarse grids, where cells double
constexpr int smoothed_degree = 2;

constexpr std::size_t rows_of(std::size_t n)
{
    return (n + 15) / 16 * 16;
}

constexpr std::size_t nodes_a_run = 128;

// y = A x of a node's near ones, and what each makes of it: each(n, y).
template <class Each>
void for_rows(const IndexLists& near, const std::vector<std::size_t>& rows,
              const Aligned<float>& matrix, const float* x, const Each& each)
{
    geometry::parallel_for(near.count(), nodes_a_run, [&](std::size_t begin, std::size_t end) {
        Aligned<float> room;
        for (std::size_t n = begin; n < end; ++n) {
            const auto list = near.of(n);
            const std::size_t length = rows_of(6 * list.size());
            room.assign(length, 0);
            for (std::size_t i = 0; i < list.size(); ++i) {
                std::memcpy(&room[6 * i], x + 6 * std::size_t{list[i]}, 6 * sizeof(float));
            }
            float y[6];
            column_dots(length, 6, &matrix[rows[n]], room.data(), y);
            each(n, y);
        }
    });
}

void block_times(const float* m, const float* r, float* out)
{
    for (std::size_t i = 0; i < 6; ++i) {
        float sum = 0;
        for (std::size_t j = 0; j < 6; ++j) sum += m[6 * i + j] * r[j];
        out[i] = sum;
    }
}

// The largest eigenvalue of D^-1 A, D the diagonal blocks: by powers, which stay a little below.
template <class Multiply> double largest_eigenvalue(std::size_t n, const Multiply& scaled_product)
{
    constexpr int rounds = 12;
    const geometry::Random random(22);
    Aligned<float> x(n), y(n);
    for (std::size_t i = 0; i < n; ++i) x[i] = static_cast<float>(random.unit(i) - 0.5);
    double value = 1;
    for (int round = 0; round < rounds; ++round) {
        scaled_product(x.data(), y.data());
        double before = 0, after = 0;
        for (std::size_t i = 0; i < n; ++i) {
            before += double(x[i]) * double(x[i]), after += double(y[i]) * double(y[i]);
        }
        value = std::sqrt(after / before);
        if (!(value > 0) || !std::isfinite(value)) return 1;
        const auto scale = static_cast<float>(1 / std::sqrt(after));
        for (std::size_t i = 0; i < n; ++i) x[i] = scale * y[i];
    }
    return 1.1 * value;
}

}  // namespace

std::vector<ChebyshevStep> chebyshev_steps(double largest, double span, int degree)
{
    const double middle = 0.5 * largest * (1 + 1 / span), half = 0.5 * largest * (1 - 1 / span);
    const double sigma = middle / half;
    double rho = 1 / sigma;
    std::vector<ChebyshevStep> steps{{0, static_cast<float>(1 / middle)}};
    for (int k = 1; k < degree; ++k) {
        const double next = 1 / (2 * sigma - rho);
        steps.push_back({static_cast<float>(next * rho), static_cast<float>(2 * next / half)});
        rho = next;
    }
    return steps;
}

// Fills near, rows and matrix from the cells' energies.
void Multigrid::assemble(const std::vector<CellMatrix>& energies, Level& level)
{
    const CoarseGrid& grid = level.grid;
    std::vector<std::uint32_t> list;
    std::size_t numbers = 0;
    for (std::size_t n = 0; n < grid.node.size(); ++n) {
        list.clear();
        for (const auto share : grid.shares.of(n)) {
            const Eight& eight = grid.nodes[share / 8];
            list.insert(list.end(), eight.begin(), eight.end());
        }
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
        level.near.index.insert(level.near.index.end(), list.begin(), list.end());
        level.near.first.push_back(static_cast<std::uint32_t>(level.near.index.size()));
        level.rows.push_back(numbers);
        numbers += 6 * rows_of(6 * list.size());
    }
    level.matrix.assign(numbers, 0);
    geometry::parallel_for(grid.node.size(), nodes_a_run, [&](std::size_t begin, std::size_t end) {
        std::vector<Eigen::Matrix<double, 6, 6>> sum;
        for (std::size_t n = begin; n < end; ++n) {
            const auto near = level.near.of(n);
            sum.assign(near.size(), Eigen::Matrix<double, 6, 6>::Zero());
            for (const auto share : grid.shares.of(n)) {
                for (std::size_t b = 0; b < 8; ++b) {
                    const auto at =
                        std::lower_bound(near.begin(), near.end(), grid.nodes[share / 8][b]) -
                        near.begin();
                    sum[std::size_t(at)] +=
                        energies[share / 8].block<6, 6>(6 * Index(b), 6 * Index(share % 8));
                }
            }
            const std::size_t length = rows_of(6 * near.size());
            for (std::size_t j = 0; j < 6; ++j) {
                for (std::size_t i = 0; i < 6 * near.size(); ++i) {
                    level.matrix[level.rows[n] + j * length + i] =
                        static_cast<float>(sum[i / 6](Index(i % 6), Index(j)));
                }
            }
        }
    });
}

// Fills what smooths, or the inverse.
void Multigrid::finish(bool coarsest, Level& level)
{
    const std::size_t count = level.grid.node.size();
    const auto entry = [&](std::size_t n, std::size_t near, std::size_t i, std::size_t j) {
        const std::size_t length = rows_of(6 * level.near.of(n).size());
        return double(level.matrix[level.rows[n] + j * length + 6 * near + i]);
    };
    constexpr double little =
        1e-6;  // of the diagonal, to keep blocks that move too little definite
    if (coarsest && count <= most_to_invert) {
        const auto n = Index(6 * count);
        Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n, n);
        for (std::size_t k = 0; k < count; ++k) {
            const auto near = level.near.of(k);
            for (std::size_t m = 0; m < near.size(); ++m) {
                for (std::size_t i = 0; i < 6; ++i) {
                    for (std::size_t j = 0; j < 6; ++j) {
                        whole(Index(6 * near[m] + i), Index(6 * k + j)) = entry(k, m, i, j);
                    }
                }
            }
        }
        for (Index i = 0; i < n; ++i)
            whole(i, i) = whole(i, i) > 0 ? (1 + little) * whole(i, i) : 1;
        const Eigen::MatrixXd inverse = whole.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
        level.inverse_rows = rows_of(6 * count);
        level.inverse.assign(level.inverse_rows * 6 * count, 0);
        for (Index j = 0; j < n; ++j) {
            for (Index i = 0; i < n; ++i) {
                level.inverse[std::size_t(j) * level.inverse_rows + std::size_t(i)] =
                    static_cast<float>(0.5 * (inverse(i, j) + inverse(j, i)));
            }
        }
        return;
    }
    level.block_inverse.resize(36 * count);
    for (std::size_t n = 0; n < count; ++n) {
        const auto near = level.near.of(n);
        const auto own = std::size_t(std::lower_bound(near.begin(), near.end(), n) - near.begin());
        Eigen::Matrix<double, 6, 6> block;
        for (std::size_t i = 0; i < 6; ++i) {
            for (std::size_t j = 0; j < 6; ++j) block(Index(i), Index(j)) = entry(n, own, i, j);
        }
        for (Index i = 0; i < 6; ++i)
            block(i, i) = block(i, i) > 0 ? (1 + little) * block(i, i) : 1;
        const Eigen::Matrix<double, 6, 6> inverse = block.ldlt().solve(block.Identity());
        for (std::size_t i = 0; i < 36; ++i) {
            level.block_inverse[36 * n + i] = static_cast<float>(
                0.5 * (inverse(Index(i / 6), Index(i % 6)) + inverse(Index(i % 6), Index(i / 6))));
        }
    }
    const double largest = largest_eigenvalue(6 * count, [&](const float* x, float* y) {
        for_rows(level.near, level.rows, level.matrix, x, [&](std::size_t n, const float* row) {
            block_times(&level.block_inverse[36 * n], row, y + 6 * n);
        });
    });
    level.smoother = chebyshev_steps(largest, smoothed_span, smoothed_degree);
}

Multigrid Multigrid::make(const geometry::Cubes& cubes, const CubeMatrices& matrices,
                          std::span<const double> diagonal, std::span<const std::uint8_t> held)
{
    Multigrid out;
    out.corner_ = cubes.corner;
    const GridView fine{cubes.cell, cubes.corners, cubes.corner};
    out.levels_.emplace_back();
    out.levels_[0].grid = coarsen(fine, first_ratio, held);
    std::vector<CellMatrix> energies(out.levels_[0].grid.cell.size(), CellMatrix::Zero());
    const CubeEnergies of_cubes(first_ratio, matrices);
    geometry::parallel_for(energies.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            of_cubes.add_cell(fine, out.levels_[0].grid, c, diagonal, held, energies[c]);
        }
    });
    while (true) {
        assemble(energies, out.levels_.back());
        const CoarseGrid& grid = out.levels_.back().grid;
        const std::size_t nodes = grid.node.size();
        CoarseGrid next;
        bool coarsest = nodes <= nodes_to_invert;
        if (!coarsest) next = coarsen(grid.view(), next_ratio);
        coarsest |= 10 * next.node.size() > 8 * nodes;
        finish(coarsest, out.levels_.back());
        if (coarsest) break;
        std::vector<CellMatrix> sums(next.cell.size(), CellMatrix::Zero());
        geometry::parallel_for(sums.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                for (const auto child : next.cells.of(c)) {
                    add_cell_of_cells(energies[child], grid.cell[child] - next_ratio * next.cell[c],
                                      next_ratio, sums[c]);
                }
            }
        });
        energies = std::move(sums);
        out.levels_.emplace_back();
        out.levels_.back().grid = std::move(next);
    }
    return out;
}

// r -= A d, d the last change of z.
void Multigrid::take_product(const Level& level, Work::Level& at)
{
    for_rows(level.near, level.rows, level.matrix, at.d.data(),
             [&](std::size_t node, const float* row) {
                 for (std::size_t i = 0; i < 6; ++i) at.r[6 * node + i] -= row[i];
             });
}

// z += S r, and r without what that answers but for its last change.
void Multigrid::smooth(const Level& level, Work::Level& at)
{
    for (const ChebyshevStep& step : level.smoother) {
        if (&step != level.smoother.data()) take_product(level, at);
        geometry::parallel_for(
            level.grid.node.size(), 1024, [&](std::size_t begin, std::size_t end) {
                for (std::size_t node = begin; node < end; ++node) {
                    float by_rest[6];
                    block_times(&level.block_inverse[36 * node], &at.r[6 * node], by_rest);
                    for (std::size_t i = 6 * node; i < 6 * node + 6; ++i) {
                        at.d[i] = step.by_last * at.d[i] + step.by_rest * by_rest[i - 6 * node];
                        at.z[i] += at.d[i];
                    }
                }
            });
    }
}

void Multigrid::apply_inverse(const Level& level, Work::Level& at)
{
    const std::size_t n = 6 * level.grid.node.size();
    at.y.assign(level.inverse_rows, 0);
    at.z.resize(n);
    std::copy(at.r.begin(), at.r.end(), at.y.begin());
    geometry::parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
        column_dots(level.inverse_rows, end - begin, &level.inverse[begin * level.inverse_rows],
                    at.y.data(), &at.z[begin]);
    });
}

// z = about A^-1 r of a level; r is used up.
void Multigrid::cycle(std::size_t l, Work& work) const
{
    const Level& level = levels_[l];
    Work::Level& at = work.levels[l];
    if (!level.inverse.empty()) {
        apply_inverse(level, at);
        return;
    }
    at.z.assign(at.r.size(), 0), at.d.assign(at.r.size(), 0);
    smooth(level, at);
    take_product(level, at);
    if (l + 1 < levels_.size()) {
        const CoarseGrid& grid = levels_[l + 1].grid;
        Work::Level& below = work.levels[l + 1];
        restrict_nodes(grid, level.grid.node, at.r.data(), below.by_cell, below.r);
        cycle(l + 1, work);
        prolong_nodes(grid, level.grid.node, below.z.data(), at.d.data(), at.z.data());
        take_product(level, at);
    }
    smooth(level, at);
}

void Multigrid::correct(const float* r, float* z, const std::uint32_t* slot, CornerTurns turns,
                        Work& work) const
{
    work.levels.resize(levels_.size());
    Work::Level& below = work.levels[0];
    const CoarseGrid& grid = levels_[0].grid;
    restrict_corners(grid, corner_, r, slot, turns, below.by_cell, below.r);
    cycle(0, work);
    prolong_corners(grid, corner_, below.z.data(), slot, turns, z);
}

std::size_t Multigrid::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    std::size_t sum = sizeof *this + of(corner_);
    for (const Level& l : levels_) {
        sum += sizeof l + of(l.grid.cell, l.grid.nodes, l.grid.node, l.grid.cells.index,
                             l.grid.corners.index, l.grid.shares.index, l.near.index, l.rows,
                             l.matrix, l.block_inverse, l.inverse);
    }
    return sum;
}

}  // namespace physics
