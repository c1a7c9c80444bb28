#include "physics/bricks/direct_factor.hpp"

#include "physics/bricks/front_walk.hpp"
#include "physics/bricks/held_corners.hpp"
#include "physics/math/dense_front.hpp"

#include <algorithm>
#include <atomic>

namespace physics {
namespace {

using Eigen::Index;
using geometry::no_index;
using Columns = Eigen::Map<Eigen::MatrixXd>;
using Fixed = Eigen::Map<const Eigen::MatrixXd>;
using Numbers = Eigen::Map<Eigen::VectorXd>;

}  // namespace

// Eliminates front after front. Only the lower triangles of their matrices are read.
class DirectFactorizer {
public:
    DirectFactorizer(const std::vector<BrickMatrix>& cubes, std::span<const double> diagonal,
                     std::span<const std::uint8_t> held, DirectFactor& out)
        : cubes_(cubes), diagonal_(diagonal), held_(held), out_(out),
          schur_(out.tree_->fronts.size())
    {}

    bool run()
    {
        const Dissection& tree = *out_.tree_;
        for (const auto root : tree.roots) {
            children_first(tree.fronts, root, [&](std::uint32_t f) { eliminate(f); });
        }
        return sound_;
    }

private:
    void eliminate(std::uint32_t f)
    {
        if (!sound_) return;
        const Front& front = out_.tree_->fronts[f];
        auto& panel = out_.panels_[f];
        const Index p = panel.pivots, b = panel.border;
        panel.columns.assign(std::size_t((p + b) * p), 0);
        Columns columns(panel.columns.data(), p + b, p);
        Eigen::MatrixXd& rest = schur_[f];
        rest.setZero(b, b);
        assemble(front, columns, rest);
        if (p == 0) return;  // a cut between parts that lie apart
        if (!eliminate_front(std::size_t(p), std::size_t(b), columns.data(), rest.data())) {
            sound_ = false;
        }
    }

    void assemble(const Front& front, Columns& columns, Eigen::MatrixXd& rest) const
    {
        const Index p = columns.cols();
        const auto add = [&](std::uint32_t row, std::uint32_t column, const auto& block) {
            const Index i = 3 * Index{row}, j = 3 * Index{column};
            if (j < p) {
                columns.block<3, 3>(i, j) += block;
            } else {
                rest.block<3, 3>(i - p, j - p) += block;
            }
        };
        for (std::size_t i = 0; i < front.pivots.size(); ++i) {
            if (out_.is_inner(front.pivots[i])) continue;
            const double* from = &diagonal_[4 * std::size_t{out_.slot_[front.pivots[i]]}];
            for (std::size_t k = 0; k < 3; ++k) {
                columns(Index(3 * i + k), Index(3 * i + k)) += from[k];
            }
        }
        for (std::size_t i = 0; i < front.cubes.size(); ++i) {
            const BrickMatrix& k = cubes_[front.cubes[i]];
            const auto& at = front.corner_at[i];
            for (std::size_t a = 0; a < 8; ++a) {
                for (std::size_t b = 0; b < 8; ++b) {
                    if (at[a] == no_index || at[b] == no_index || at[a] < at[b]) continue;
                    const auto block = k.block<3, 3>(Index(3 * a), Index(3 * b));
                    if (held_.empty()) {
                        add(at[a], at[b], block);
                    } else {
                        add(at[a], at[b],
                            without_held(block, held_axes(corner_of(front, at[a])),
                                         held_axes(corner_of(front, at[b])), a == b));
                    }
                }
            }
        }
        for (const auto child : front.children) {
            // Corners of a border lie in the same order in the parent.
            const auto& to = out_.tree_->fronts[child].in_parent;
            Eigen::MatrixXd& s = schur_[child];
            for (std::size_t j = 0; j < to.size(); ++j) {
                for (std::size_t i = j; i < to.size(); ++i) {
                    add(to[i], to[j], s.block<3, 3>(Index(3 * i), Index(3 * j)));
                }
            }
            s.resize(0, 0);
        }
    }

    std::uint8_t held_axes(std::uint32_t corner) const
    {
        return out_.is_inner(corner) ? std::uint8_t{0} : held_[corner];
    }

    const std::vector<BrickMatrix>& cubes_;
    std::span<const double> diagonal_;
    std::span<const std::uint8_t> held_;
    DirectFactor& out_;
    mutable std::vector<Eigen::MatrixXd> schur_;
    std::atomic<bool> sound_ = true;
};

std::optional<DirectFactor> DirectFactor::make(std::shared_ptr<const Dissection> dissection,
                                               const std::vector<BrickMatrix>& cubes,
                                               std::span<const double> diagonal,
                                               std::span<const std::uint32_t> slot,
                                               std::span<const std::uint8_t> held)
{
    DirectFactor out;
    out.tree_ = std::move(dissection);
    out.slot_.assign(slot.begin(), slot.end());
    std::size_t work = 0;
    std::size_t inner = 0;
    for (const Front& front : out.tree_->fronts) {
        for (const auto k : front.pivots) {
            if (out.is_inner(k)) inner = std::max(inner, out.inner_at(k) + 3);
        }
        const std::size_t p = 3 * front.pivots.size(), all = p + 3 * front.border.size();
        out.panels_.push_back({Index(p), Index(all - p), work, {}});
        work += all;
    }
    out.work_.assign(work, 0);
    out.inner_.assign(inner, 0);
    if (!DirectFactorizer(cubes, diagonal, held, out).run()) return std::nullopt;
    return out;
}

void DirectFactor::solve(const double* b, double* x)
{
    const auto& fronts = tree_->fronts;
    for (const auto root : tree_->roots) {
        children_first(fronts, root, [&](std::uint32_t f) { forward(f, b); });
        parents_first(fronts, root, [&](std::uint32_t f) { back(f, x); });
    }
}

void DirectFactor::forward(std::uint32_t f, const double* b)
{
    const Front& front = tree_->fronts[f];
    const Panel& panel = panels_[f];
    double* own = work_.data() + panel.at;
    for (std::size_t i = 0; i < front.pivots.size(); ++i) {
        const std::uint32_t k = front.pivots[i];
        if (is_inner(k)) {
            std::fill(own + 3 * i, own + 3 * i + 3, 0.0);
            continue;
        }
        const double* from = b + 4 * std::size_t{slot_[k]};
        std::copy(from, from + 3, own + 3 * i);
    }
    std::fill(own + panel.pivots, own + panel.pivots + panel.border, 0.0);
    for (const auto child : front.children) {
        const auto& to = tree_->fronts[child].in_parent;
        const double* from = work_.data() + panels_[child].at + panels_[child].pivots;
        for (std::size_t i = 0; i < to.size(); ++i) {
            for (std::size_t k = 0; k < 3; ++k) own[3 * to[i] + k] += from[3 * i + k];
        }
    }
    const Fixed columns(panel.columns.data(), panel.pivots + panel.border, panel.pivots);
    Numbers pivots(own, panel.pivots), border(own + panel.pivots, panel.border);
    columns.topRows(panel.pivots).triangularView<Eigen::Lower>().solveInPlace(pivots);
    border.noalias() -= columns.bottomRows(panel.border) * pivots;
}

void DirectFactor::back(std::uint32_t f, double* x)
{
    const Front& front = tree_->fronts[f];
    const Panel& panel = panels_[f];
    double* own = work_.data() + panel.at;
    for (std::size_t i = 0; i < front.border.size(); ++i) {
        const std::uint32_t k = front.border[i];
        const double* from =
            is_inner(k) ? inner_.data() + inner_at(k) : x + 4 * std::size_t{slot_[k]};
        std::copy(from, from + 3, own + panel.pivots + 3 * i);
    }
    const Fixed columns(panel.columns.data(), panel.pivots + panel.border, panel.pivots);
    Numbers pivots(own, panel.pivots), border(own + panel.pivots, panel.border);
    pivots.noalias() -= columns.bottomRows(panel.border).transpose() * border;
    columns.topRows(panel.pivots).triangularView<Eigen::Lower>().transpose().solveInPlace(pivots);
    for (std::size_t i = 0; i < front.pivots.size(); ++i) {
        const std::uint32_t k = front.pivots[i];
        double* to = is_inner(k) ? inner_.data() + inner_at(k) : x + 4 * std::size_t{slot_[k]};
        std::copy(own + 3 * i, own + 3 * i + 3, to);
    }
}

void DirectFactor::solve(const EightColumns& b, EightColumns& x)
{
    const auto& fronts = tree_->fronts;
    eight_work_.resize(eight * work_.size());
    for (const auto root : tree_->roots) {
        children_first(fronts, root, [&](std::uint32_t f) { forward_eight(f, b.data()); });
        parents_first(fronts, root, [&](std::uint32_t f) { back_eight(f, x.data()); });
    }
}

void DirectFactor::forward_eight(std::uint32_t f, const double* b)
{
    const Front& front = tree_->fronts[f];
    const Panel& panel = panels_[f];
    const auto pivots = std::size_t(panel.pivots), border = std::size_t(panel.border);
    double* own = eight_work_.data() + eight * panel.at;
    for (std::size_t i = 0; i < front.pivots.size(); ++i) {
        const double* from = b + 3 * eight * slot_[front.pivots[i]];
        std::copy(from, from + 3 * eight, own + 3 * eight * i);
    }
    std::fill(own + eight * pivots, own + eight * (pivots + border), 0.0);
    for (const auto child : front.children) {
        const auto& to = tree_->fronts[child].in_parent;
        const auto& of = panels_[child];
        const double* from = eight_work_.data() + eight * (of.at + std::size_t(of.pivots));
        for (std::size_t i = 0; i < to.size(); ++i) {
            double* at = own + 3 * eight * to[i];
            for (std::size_t k = 0; k < 3 * eight; ++k) at[k] += from[3 * eight * i + k];
        }
    }
    solve_down(pivots, border, panel.columns.data(), own);
}

void DirectFactor::back_eight(std::uint32_t f, double* x)
{
    const Front& front = tree_->fronts[f];
    const Panel& panel = panels_[f];
    const auto pivots = std::size_t(panel.pivots), border = std::size_t(panel.border);
    double* own = eight_work_.data() + eight * panel.at;
    for (std::size_t i = 0; i < front.border.size(); ++i) {
        const double* from = x + 3 * eight * slot_[front.border[i]];
        std::copy(from, from + 3 * eight, own + eight * (pivots + 3 * i));
    }
    solve_up(pivots, border, panel.columns.data(), own);
    for (std::size_t i = 0; i < front.pivots.size(); ++i) {
        std::copy(own + 3 * eight * i, own + 3 * eight * (i + 1),
                  x + 3 * eight * slot_[front.pivots[i]]);
    }
}

}  // namespace physics
