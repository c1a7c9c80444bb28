#include "physics/shell/slope_factor.hpp"

#include "physics/bricks/front_walk.hpp"
#include "physics/math/dense_front.hpp"
#include "physics/math/eight_columns.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <stdexcept>

namespace physics {
namespace {

using Eigen::Index;
using geometry::no_index;

constexpr std::size_t row = 4;

// The triangles join their sides as cubes do their corners.
Dissection dissect_sides(const TriangleShell& shell, const double* rest)
{
    ElementCorners elements;
    for (const ShellTriangle& t : shell.triangle) {
        const auto [a, b, c] = t.side;
        elements.push_back({a, b, c, a, a, a, a, a});
    }
    return dissect(elements, middles_of_sides(shell, rest), {},
                   std::numeric_limits<double>::infinity());
}

}  // namespace

SlopeFactor::SlopeFactor(const TriangleShell& shell, const double* rest,
                         std::span<const double> weight)
    : tree_(dissect_sides(shell, rest))
{
    std::size_t numbers = 0;
    for (const Front& front : tree_.fronts) {
        const std::size_t pivots = front.pivots.size(), border = front.border.size();
        panels_.push_back({pivots, border, numbers, rows_});
        numbers += pivots * (pivots + border);
        rows_ += pivots + border;
    }
    numbers_.assign(numbers, 0);
    std::vector<Dense> rests(tree_.fronts.size());
    std::atomic<bool> sound = true;
    for (const auto root : tree_.roots) {
        children_first(tree_.fronts, root, [&](std::uint32_t f) {
            if (sound && !eliminate(f, shell, weight, rests)) sound = false;
        });
    }
    if (!sound) {
        throw std::invalid_argument("method shell: the triangles are too thin to bend: expected "
                                    "sides that are more alike. Remesh the surface");
    }
    for (Front& front : tree_.fronts) front.cubes = {}, front.corner_at = {};
}

// Only the lower triangles of matrices are read.
bool SlopeFactor::eliminate(std::uint32_t f, const TriangleShell& shell,
                            std::span<const double> weight, std::vector<Dense>& rests)
{
    const Front& front = tree_.fronts[f];
    const std::size_t p = panels_[f].pivots, b = panels_[f].border;
    double* columns = numbers_.data() + panels_[f].columns;
    rests[f].assign(b * b, 0);
    double* rest = rests[f].data();
    const auto add = [&](std::size_t i, std::size_t j, double value) {
        if (j < p) {
            columns[j * (p + b) + i] += value;
        } else {
            rest[(j - p) * b + (i - p)] += value;
        }
    };
    for (std::size_t e = 0; e < front.cubes.size(); ++e) {
        const ShellTriangle& own = shell.triangle[front.cubes[e]];
        const Eigen::Matrix3d k =
            weight[front.cubes[e]] * own.by_slope.transpose() * own.plate * own.by_slope;
        const auto& where = front.corner_at[e];
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                if (where[i] >= where[j]) add(where[i], where[j], k(Index(i), Index(j)));
            }
        }
    }
    for (const auto child : front.children) {
        // Those of a border lie in the same order in the parent.
        const auto& to = tree_.fronts[child].in_parent;
        Dense& from = rests[child];
        for (std::size_t j = 0; j < to.size(); ++j) {
            for (std::size_t i = j; i < to.size(); ++i) {
                add(to[i], to[j], from[j * to.size() + i]);
            }
        }
        from = {};
    }
    return p == 0 || eliminate_front(p, b, columns, rest);
}

void SlopeFactor::solve(SideVectors& sides, Aligned<double>& work) const
{
    work.resize(row * rows_);
    for (const auto root : tree_.roots) {
        children_first(tree_.fronts, root, [&](std::uint32_t f) { down(f, sides, work.data()); });
        parents_first(tree_.fronts, root, [&](std::uint32_t f) { up(f, sides, work.data()); });
    }
}

void SlopeFactor::down(std::uint32_t f, const SideVectors& sides, double* work) const
{
    const Front& front = tree_.fronts[f];
    const Panel& panel = panels_[f];
    double* own = work + row * panel.at;
    for (std::size_t i = 0; i < panel.pivots; ++i) {
        const double* from = sides.data() + 3 * std::size_t{front.pivots[i]};
        std::copy(from, from + 3, own + row * i);
        own[row * i + 3] = 0;
    }
    std::fill(own + row * panel.pivots, own + row * (panel.pivots + panel.border), 0.0);
    for (const auto child : front.children) {
        const auto& to = tree_.fronts[child].in_parent;
        const double* from = work + row * (panels_[child].at + panels_[child].pivots);
        for (std::size_t i = 0; i < to.size(); ++i) {
            double* at = own + row * to[i];
            for (std::size_t k = 0; k < row; ++k) at[k] += from[row * i + k];
        }
    }
    solve_four_down(panel.pivots, panel.border, numbers_.data() + panel.columns, own);
}

void SlopeFactor::up(std::uint32_t f, SideVectors& sides, double* work) const
{
    const Front& front = tree_.fronts[f];
    const Panel& panel = panels_[f];
    double* own = work + row * panel.at;
    for (std::size_t i = 0; i < panel.border; ++i) {
        const double* from = sides.data() + 3 * std::size_t{front.border[i]};
        std::copy(from, from + 3, own + row * (panel.pivots + i));
    }
    solve_four_up(panel.pivots, panel.border, numbers_.data() + panel.columns, own);
    for (std::size_t i = 0; i < panel.pivots; ++i) {
        std::copy(own + row * i, own + row * i + 3,
                  sides.data() + 3 * std::size_t{front.pivots[i]});
    }
}

}  // namespace physics
