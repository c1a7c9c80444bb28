#include "physics/bricks/corner_factor.hpp"

#include "physics/bricks/front_walk.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/math/dense_columns.hpp"

#include <algorithm>
#include <atomic>

namespace physics {
namespace {

constexpr std::size_t up_to_16(std::size_t n)
{
    return (n + 15) / 16 * 16;
}

}  // namespace

// Eliminates front after front in double precision.
class Factorizer {
public:
    Factorizer(const CubeMatrices& cubes, const std::vector<double>& diagonal,
               std::span<const std::uint8_t> held, CornerFactor& out)
        : cubes_(cubes), diagonal_(diagonal), held_(held), out_(out),
          schur_(out.tree_.fronts.size())
    {}

    bool run()
    {
        for (const auto root : out_.tree_.roots) {
            children_first(out_.tree_.fronts, root, [&](std::uint32_t f) { eliminate(f); });
        }
        return sound_;
    }

private:
    void eliminate(std::uint32_t f)
    {
        const Front& front = out_.tree_.fronts[f];
        Eigen::MatrixXd matrix = assemble(front);
        const auto p = static_cast<Eigen::Index>(3 * front.pivots.size());
        const auto b = static_cast<Eigen::Index>(3 * front.border.size());
        const Eigen::LLT<Eigen::MatrixXd> pivots(matrix.topLeftCorner(p, p));
        if (pivots.info() != Eigen::Success) {
            sound_ = false;
            schur_[f] = Eigen::MatrixXd::Zero(b, b);
            return;
        }
        const CornerFactor::Block& block = out_.blocks_[f];
        const Eigen::MatrixXd inverse = pivots.solve(Eigen::MatrixXd::Identity(p, p));
        const Eigen::MatrixXd across = matrix.bottomLeftCorner(b, p) * inverse;  // W
        schur_[f] = matrix.bottomRightCorner(b, b);
        schur_[f].noalias() -= across * matrix.bottomLeftCorner(b, p).transpose();
        for (Eigen::Index j = 0; j < p; ++j) {
            float* to = &out_.numbers_[block.inverse + static_cast<std::size_t>(j) * block.rows];
            for (Eigen::Index i = 0; i < p; ++i) to[i] = static_cast<float>(inverse(i, j));
        }
        for (Eigen::Index j = 0; j < p && b > 0; ++j) {
            float* to = &out_.numbers_[block.across + static_cast<std::size_t>(j) * block.border];
            for (Eigen::Index i = 0; i < b; ++i) to[i] = static_cast<float>(-across(i, j));
        }
    }

    // Pivots, then border.
    Eigen::MatrixXd assemble(const Front& front)
    {
        const std::size_t pivots = front.pivots.size(), all = pivots + front.border.size();
        const auto n = static_cast<Eigen::Index>(3 * all);
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
        for (std::size_t i = 0; i < pivots; ++i) {
            matrix.diagonal().segment<3>(static_cast<Eigen::Index>(3 * i)).array() +=
                diagonal_[front.pivots[i]];
        }
        for (std::size_t i = 0; i < front.cubes.size(); ++i) {
            const BrickMatrix k = cubes_.of(front.cubes[i]);
            const auto& at = front.corner_at[i];
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) {
                    if (at[a] == geometry::no_index || at[b] == geometry::no_index) continue;
                    const auto block = k.block<3, 3>(static_cast<Eigen::Index>(3 * a),
                                                     static_cast<Eigen::Index>(3 * b));
                    auto to = matrix.block<3, 3>(3 * Eigen::Index{at[a]}, 3 * Eigen::Index{at[b]});
                    if (held_.empty()) {
                        to += block;
                    } else {
                        to += without_held(block, held_[corner_of(front, at[a])],
                                           held_[corner_of(front, at[b])], a == b);
                    }
                }
            }
        }
        for (const auto child : front.children) {
            const auto& to = out_.tree_.fronts[child].in_parent;
            const Eigen::MatrixXd& s = schur_[child];
            for (std::size_t j = 0; j < to.size(); ++j) {
                for (std::size_t i = 0; i < to.size(); ++i) {
                    matrix.block<3, 3>(3 * Eigen::Index{to[i]}, 3 * Eigen::Index{to[j]}) +=
                        s.block<3, 3>(static_cast<Eigen::Index>(3 * i),
                                      static_cast<Eigen::Index>(3 * j));
                }
            }
            schur_[child].resize(0, 0);
        }
        return matrix;
    }

    const CubeMatrices& cubes_;
    const std::vector<double>& diagonal_;
    std::span<const std::uint8_t> held_;
    CornerFactor& out_;
    std::vector<Eigen::MatrixXd> schur_;
    std::atomic<bool> sound_ = true;
};

std::optional<CornerFactor> CornerFactor::make(Dissection dissection, const CubeMatrices& cubes,
                                               const std::vector<double>& diagonal,
                                               std::span<const std::uint8_t> held)
{
    CornerFactor out;
    out.tree_ = std::move(dissection);
    std::size_t numbers = 0;
    for (const Front& front : out.tree_.fronts) {
        Block block;
        block.pivots = 3 * front.pivots.size();
        block.rows = up_to_16(block.pivots);
        block.border = up_to_16(3 * front.border.size());
        block.inverse = numbers;
        numbers += block.rows * block.pivots;
        block.across = numbers;
        numbers += block.border * block.pivots;
        block.at = out.work_;
        out.work_ += block.rows + block.border;
        out.blocks_.push_back(block);
    }
    out.numbers_.assign(numbers, 0);
    if (!Factorizer(cubes, diagonal, held, out).run()) return std::nullopt;
    for (Front& front : out.tree_.fronts) front.cubes = {}, front.corner_at = {};
    return out;
}

void CornerFactor::solve(const float* b, float* x, const std::uint32_t* slot,
                         Aligned<float>& work) const
{
    work.resize(work_);
    const auto& fronts = tree_.fronts;
    for (const auto root : tree_.roots) {
        children_first(fronts, root, [&](std::uint32_t f) { forward(f, b, slot, work.data()); });
        parents_first(fronts, root, [&](std::uint32_t f) { back(f, x, slot, work.data()); });
    }
}

void CornerFactor::forward(std::uint32_t f, const float* b, const std::uint32_t* slot,
                           float* work) const
{
    const Front& front = tree_.fronts[f];
    const Block& block = blocks_[f];
    float *pivots = work + block.at, *border = pivots + block.rows;
    for (std::size_t i = 0; i < front.pivots.size(); ++i) {
        const float* from = b + 4 * std::size_t{slot[front.pivots[i]]};
        std::copy(from, from + 3, pivots + 3 * i);
    }
    std::fill(border, border + block.border, 0.0f);
    for (const auto child : front.children) {
        const auto& to = tree_.fronts[child].in_parent;
        const float* from = work + blocks_[child].at + blocks_[child].rows;
        for (std::size_t i = 0; i < to.size(); ++i) {
            float* at = to[i] < front.pivots.size() ? pivots + 3 * std::size_t{to[i]}
                                                    : border + 3 * (to[i] - front.pivots.size());
            for (std::size_t k = 0; k < 3; ++k) at[k] += from[3 * i + k];
        }
    }
    add_columns(block.border, block.pivots, numbers_.data() + block.across, pivots, border);
}

void CornerFactor::back(std::uint32_t f, float* x, const std::uint32_t* slot, float* work) const
{
    const Front& front = tree_.fronts[f];
    const Block& block = blocks_[f];
    float *pivots = work + block.at, *border = pivots + block.rows;
    std::fill(border, border + block.border, 0.0f);
    for (std::size_t i = 0; i < front.border.size(); ++i) {
        const float* from = x + 4 * std::size_t{slot[front.border[i]]};
        std::copy(from, from + 3, border + 3 * i);
    }
    constexpr std::size_t small = 128;
    float room[small];
    std::vector<float> large(block.rows > small ? block.rows : 0);
    float* result = block.rows > small ? large.data() : room;
    std::fill(result, result + block.rows, 0.0f);
    column_dots(block.border, block.pivots, numbers_.data() + block.across, border, result);
    add_columns(block.rows, block.pivots, numbers_.data() + block.inverse, pivots, result);
    for (std::size_t i = 0; i < front.pivots.size(); ++i) {
        std::copy(result + 3 * i, result + 3 * i + 3, x + 4 * std::size_t{slot[front.pivots[i]]});
    }
}

std::size_t CornerFactor::bytes() const
{
    std::size_t sum = sizeof *this + numbers_.size() * sizeof(float);
    for (const Front& front : tree_.fronts) {
        sum +=
            sizeof front + sizeof(std::uint32_t) * (front.pivots.size() + 2 * front.border.size());
    }
    return sum;
}

}  // namespace physics
