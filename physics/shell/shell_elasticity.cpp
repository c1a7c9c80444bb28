#include "physics/shell/shell_elasticity.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/shell/contact_weights.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

using geometry::no_index;

constexpr std::size_t cells_a_task = 256, points_a_task = 2048;

Vec3 place_at(const double* field, std::uint32_t k)
{
    return Eigen::Map<const Vec3>(field + 4 * std::size_t{k});
}

ShellVector cell_at(const ShellBody& body, std::size_t c, const double* x)
{
    ShellVector out = ShellVector::Zero();
    const auto& corners = body.cell[c];
    // From its first corner: what is far away is told as exactly as what is near.
    const Vec3 first = place_at(x, corners[0]);
    const double h = body.base.edge_at(corners[0]);
    for (std::size_t i = 1; i < 4; ++i) {
        const Vec3 away = (place_at(x, corners[i]) - first) / h;
        for (std::size_t p = 0; p < 3; ++p) {
            out.segment<3>(static_cast<Eigen::Index>(3 * p)) += shell_shares[i][p] * away;
        }
    }
    return out;
}

// x[i-1] - 2 x[i] + x[i+1] along u or v.
Vec3 bend_along(const ShellPoint& point, std::uint32_t k, std::size_t low, const double* x)
{
    const Vec3 here = place_at(x, k);
    return (place_at(x, point.beside[low]) - here) + (place_at(x, point.beside[low + 1]) - here);
}

// su and sv of a point; 0 where it has none.
std::array<Vec3, 2> bends_of(const ShellPoint& point, std::uint32_t k, const double* x)
{
    return {point.along_u ? bend_along(point, k, ShellPoint::low_u, x) : Vec3(Vec3::Zero()),
            point.along_v ? bend_along(point, k, ShellPoint::low_v, x) : Vec3(Vec3::Zero())};
}

// Whether the point is the edge of what is pinned along an axis.
bool clamps(const ShellPoint& point, std::size_t low, const std::vector<char>& pinned)
{
    return pinned[point.beside[low]] != pinned[point.beside[low + 1]];
}

// Each corner of a point's curvatures and what they have of it, over u and v.
struct PointShare {
    std::uint32_t corner;
    double u, v;
};
struct PointShares {
    std::array<PointShare, 5> share;
    std::size_t count = 0;
};
PointShares shares_of(const ShellPoint& point, std::uint32_t k)
{
    PointShares out;
    out.share[out.count++] = {k, point.along_u ? -2.0 : 0.0, point.along_v ? -2.0 : 0.0};
    for (std::size_t i = 0; i < 4; ++i) {
        const bool is_u = i < 2;
        if (!(is_u ? point.along_u : point.along_v)) continue;
        out.share[out.count++] = {point.beside[i], is_u ? 1.0 : 0.0, is_u ? 0.0 : 1.0};
    }
    return out;
}

double entry_of_bend(const ShellPoint& point, const PointShare& a, const PointShare& b,
                     double stiffness, double damping)
{
    const double uu = stiffness * point.uu + damping * point.uu_damping;
    const double uv = stiffness * point.uv + damping * point.uv_damping;
    const double vv = stiffness * point.vv + damping * point.vv_damping;
    return uu * a.u * b.u + uv * (a.u * b.v + a.v * b.u) + vv * a.v * b.v;
}

}  // namespace

ShellElasticity::ShellElasticity(const ShellBody& body, const Pins& pins)
    : body_(body), point_(body.point), pull_(body.cell.size()), blocks_(body.cell.size()),
      moment_(body.point.size()), matrix_(9 * body.column.size()),
      matrix_low_(9 * body.column.size())
{
    const auto& tau = body.damping;
    even_ = std::all_of(tau.begin(), tau.end(), [&](double t) { return t == tau[0]; });
    std::vector<char> pinned(body.base.corners, 0);
    for (const auto k : pins.corner) pinned[k] = 1;
    for (const auto k : pins.corner) {
        ShellPoint& point = point_[k];
        const bool clamped = (point.along_u && clamps(point, ShellPoint::low_u, pinned)) ||
                             (point.along_v && clamps(point, ShellPoint::low_v, pinned));
        if (!clamped) continue;
        for (double* s : {&point.uu, &point.uv, &point.vv, &point.uu_damping, &point.uv_damping,
                          &point.vv_damping}) {
            *s *= 2;
        }
    }
}

// The pull of a cell on its corners, and the blocks of its derivative.
void ShellElasticity::evaluate_cell(std::size_t c)
{
    const double h = body_.base.edge_at(body_.cell[c][0]);
    const ShellVector way = came_.empty() ? ShellVector::Zero() : cell_at(body_, c, came_.data());
    const CellEnergy cell = cell_energy(body_.matter[c], cell_at(body_, c, at_.data()),
                                        hessian_ ? Curvature::whole : Curvature::positive,
                                        came_.empty() ? nullptr : &way);
    for (std::size_t i = 0; i < 4; ++i) {
        Vec3& pull = pull_[c][i];
        pull.setZero();
        Eigen::Matrix<double, 3, 9> row = Eigen::Matrix<double, 3, 9>::Zero();
        for (std::size_t p = 0; p < 3; ++p) {
            const double share = shell_shares[i][p] / h;
            const auto at = static_cast<Eigen::Index>(3 * p);
            pull -= share * cell.slope.segment<3>(at);
            row += share * cell.curvature.middleRows<3>(at);
        }
        for (std::size_t j = 0; j < 4; ++j) {
            const auto& share = shell_shares[j];
            blocks_[c][4 * i + j] =
                (share[0] * row.leftCols<3>() + share[1] * row.middleCols<3>(3) +
                 share[2] * row.rightCols<3>()) /
                h;
        }
    }
}

// The force on a point, of its cells and of the moments at it and its neighbours.
Vec3 ShellElasticity::force_on(std::size_t k) const
{
    Vec3 sum = 2 * (moment_[k][0] + moment_[k][1]);
    for (const auto at : body_.cells_of[k]) {
        if (at != no_index) sum += pull_[at / 4][at % 4];
    }
    for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t other = point_[k].beside[i];
        if (other == no_index) continue;
        const ShellPoint& p = point_[other];
        if (i < 2 ? p.along_u : p.along_v) sum -= moment_[other][i / 2];
    }
    return sum;
}

void ShellElasticity::evaluate_cells()
{
    geometry::parallel_for(body_.cell.size(), cells_a_task,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t c = begin; c < end; ++c) evaluate_cell(c);
                           });
}

void ShellElasticity::forces(const double* x, double* f)
{
    at_.assign(x, x + body_.base.numbers);
    came_.clear();
    evaluate_cells();
    geometry::parallel_for(point_.size(), points_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const ShellPoint& p = point_[k];
            const auto [u, v] = bends_of(p, static_cast<std::uint32_t>(k), x);
            moment_[k] = {Vec3(p.uu * u + p.uv * v), Vec3(p.uv * u + p.vv * v)};
        }
    });
    geometry::parallel_for(point_.size(), points_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            Eigen::Map<Vec3>(f + 4 * k) = force_on(k);
        }
    });
    assemble();
}

AcrossStiffness ShellElasticity::across(std::size_t c, const double* came, double tau) const
{
    constexpr double steepest = 0.5;  // of f1 and f2, in edges: shell_shares
    const double h = body_.base.edge_at(body_.cell[c][0]);
    double least = std::numeric_limits<double>::infinity();  // kg
    for (const auto k : body_.cell[c]) least = std::min(least, body_.base.mass[k]);
    const ShellVector change = cell_at(body_, c, came);
    return across_stiffness(body_.matter[c], cell_at(body_, c, at_.data()), &change)
        .times(steepest * tau * tau / (h * h * least));
}

bool ShellElasticity::look_back(const double* came, double tau)
{
    bool far_off = false;
    for (std::size_t c = 0; c < body_.cell.size() && !far_off; ++c) {
        far_off = across(c, came, tau).far_off();
    }
    if (!far_off) return false;
    came_.assign(came, came + body_.base.numbers);
    evaluate_cells();
    assemble();
    return true;
}

double ShellElasticity::energy(const double* x)
{
    const auto of_cells = geometry::ordered_sum(
        body_.cell.size(), cells_a_task, 0.0, [&](std::size_t begin, std::size_t end) {
            double sum = 0;
            for (std::size_t c = begin; c < end; ++c) {
                sum += cell_energy(body_.matter[c], cell_at(body_, c, x), Curvature::none).energy;
            }
            return sum;
        });
    const auto of_points = geometry::ordered_sum(
        point_.size(), points_a_task, 0.0, [&](std::size_t begin, std::size_t end) {
            double sum = 0;
            for (std::size_t k = begin; k < end; ++k) {
                sum += bend_energy(static_cast<std::uint32_t>(k), x);
            }
            return sum;
        });
    return of_cells + of_points;
}

double ShellElasticity::bend_energy(std::uint32_t k, const double* x) const
{
    const ShellPoint& p = point_[k];
    const auto [u, v] = bends_of(p, k, x);
    return 0.5 * (p.uu * u.squaredNorm() + 2 * p.uv * u.dot(v) + p.vv * v.squaredNorm());
}

double ShellElasticity::largest_rate(const double* w) const
{
    double most = 0;
    for (const auto& k : body_.cell) {
        const Vec3 at[4] = {place_at(w, k[0]), place_at(w, k[1]), place_at(w, k[2]),
                            place_at(w, k[3])};
        const double most_sq =
            std::max({(at[1] - at[0]).squaredNorm(), (at[2] - at[0]).squaredNorm(),
                      (at[3] - at[1]).squaredNorm(), (at[3] - at[2]).squaredNorm()});
        most = std::max(most, std::sqrt(most_sq) / body_.base.edge_at(k[0]));
    }
    return most;
}

void ShellElasticity::weigh(double stiffness, double damping)
{
    const bool same = stiffness == stiffness_weight_ && damping == damping_weight_;
    stiffness_weight_ = stiffness;
    damping_weight_ = damping;
    if (even_) {
        scale_ = stiffness + damping * body_.damping[0];
    } else if (!same) {
        assemble();
    }
}

bool ShellElasticity::use_hessian(bool on)
{
    if (on == hessian_) return true;
    hessian_ = on;
    if (at_.empty()) return true;
    evaluate_cells();
    assemble();
    return true;
}

// Of the matrices of cells and points; 1 where the damping is even, and the weight is scale_.
double ShellElasticity::weight_of_cell(std::size_t c) const
{
    return even_ ? 1 : stiffness_weight_ + damping_weight_ * body_.damping[c];
}

void ShellElasticity::assemble()
{
    const double stiffness = even_ ? 1 : stiffness_weight_, damping = even_ ? 0 : damping_weight_;
    geometry::parallel_for(point_.size(), points_a_task, [&](std::size_t begin, std::size_t end) {
        const std::size_t first = 9 * std::size_t{body_.row[begin]};
        const std::size_t last = 9 * std::size_t{body_.row[end]};
        std::fill(matrix_.begin() + std::ptrdiff_t(first), matrix_.begin() + std::ptrdiff_t(last),
                  0.0);
        for (std::size_t k = begin; k < end; ++k) {
            for (const auto at : body_.cells_of[k]) {
                if (at == no_index) continue;
                const std::size_t c = at / 4, i = at % 4;
                const double weight = weight_of_cell(c);
                for (std::size_t j = 0; j < 4; ++j) {
                    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> to(
                        matrix_.data() + 9 * std::size_t{body_.cell_at[c][4 * i + j]});
                    to += weight * blocks_[c][4 * i + j];
                }
            }
            add_bends(static_cast<std::uint32_t>(k), stiffness, damping);
        }
        for (std::size_t i = first; i < last; ++i) matrix_low_[i] = static_cast<float>(matrix_[i]);
    });
}

// To the row of a point, those of it and its neighbours.
void ShellElasticity::add_bends(std::uint32_t k, double stiffness, double damping)
{
    const auto add_of = [&](std::uint32_t centre) {
        const PointShares all = shares_of(point_[centre], centre);
        const auto own = std::find_if(all.share.begin(), all.share.begin() + all.count,
                                      [&](const PointShare& s) { return s.corner == k; });
        if (own == all.share.begin() + all.count) return;
        for (std::size_t i = 0; i < all.count; ++i) {
            const PointShare& other = all.share[i];
            const double value = entry_of_bend(point_[centre], *own, other, stiffness, damping);
            double* to = matrix_.data() + 9 * std::size_t{entry_of(body_, k, other.corner)};
            for (std::size_t d = 0; d < 3; ++d) to[4 * d] += value;
        }
    };
    add_of(k);
    for (const auto other : point_[k].beside) {
        if (other != no_index) add_of(other);
    }
}

template <class T>
void ShellElasticity::multiply_any(const Aligned<T>& matrix, const T* p, T* y) const
{
    const T scale = static_cast<T>(scale_);
    geometry::parallel_for(point_.size(), points_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            T sum[3] = {0, 0, 0};
            for (std::size_t e = body_.row[k]; e < body_.row[k + 1]; ++e) {
                const T* m = matrix.data() + 9 * e;
                const T* from = p + 4 * std::size_t{body_.column[e]};
                for (std::size_t i = 0; i < 3; ++i) {
                    sum[i] += m[3 * i] * from[0] + m[3 * i + 1] * from[1] + m[3 * i + 2] * from[2];
                }
            }
            for (std::size_t i = 0; i < 3; ++i) y[4 * k + i] = scale * sum[i];
        }
    });
}

void ShellElasticity::multiply(const float* p, float* y) const
{
    multiply_any(matrix_low_, p, y);
}

void ShellElasticity::multiply(const double* p, double* y) const
{
    multiply_any(matrix_, p, y);
}

void ShellElasticity::add_diagonal(double* d) const
{
    for (std::uint32_t k = 0; k < point_.size(); ++k) {
        const double* m = matrix_.data() + 9 * std::size_t{entry_of(body_, k, k)};
        for (std::size_t i = 0; i < 3; ++i) d[4 * std::size_t{k} + i] += scale_ * m[4 * i];
    }
}

void ShellElasticity::element_matrix(std::size_t e, BrickMatrix& to) const
{
    const auto [c, k] = body_.element[e];
    to.setZero();
    if (c != no_index) {
        const double weight = stiffness_weight_ + damping_weight_ * body_.damping[c];
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = 0; j < 4; ++j) {
                to.block<3, 3>(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) =
                    weight * blocks_[c][4 * i + j];
            }
        }
    }
    const PointShares all = shares_of(point_[k], k);
    const auto& corners = body_.elements.corners[e];
    const auto at = [&](std::size_t i) {
        const auto found = std::find(corners.begin(), corners.end(), all.share[i].corner);
        return static_cast<Eigen::Index>(3 * (found - corners.begin()));
    };
    for (std::size_t i = 0; i < all.count; ++i) {
        for (std::size_t j = 0; j < all.count; ++j) {
            const double value = entry_of_bend(point_[k], all.share[i], all.share[j],
                                               stiffness_weight_, damping_weight_);
            to.block<3, 3>(at(i), at(j)).diagonal().array() += value;
        }
    }
}

bool ShellElasticity::cube_matrices(std::vector<BrickMatrix>& out) const
{
    out.resize(body_.element.size());
    geometry::parallel_for(out.size(), cells_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) element_matrix(e, out[e]);
    });
    return true;
}

void ShellElasticity::add_contact(const PointContact& contact, const geometry::Mat3& block,
                                  std::span<BrickMatrix> to) const
{
    if (contact.count != 8) return;
    // What touches a collider is a point or a side of one cell. Its upper corners are its lower
    // ones.
    for (const std::uint32_t at : body_.cells_of[contact.corners[0]]) {
        if (at == no_index) continue;
        const auto weight = weights_in(body_.cell[at / 4], contact);
        if (weight) return add_between(*weight, block, to[at / 4]);
    }
}

std::shared_ptr<const Dissection>
ShellElasticity::dissection(const std::vector<std::uint32_t>& held) const
{
    // Solves with more than these take longer than any other way.
    constexpr double most_entries_a_corner = 1500;
    constexpr std::size_t uncut = 8;
    return body_.dissections->find({0, 0, {}, {held, {}}}, [&]() -> DissectionCache::Factor {
        std::vector<char> left_out(body_.base.corners, 0);
        for (const auto k : held) left_out[k] = 1;
        const double most = most_entries_a_corner * static_cast<double>(body_.base.corners);
        Dissection tree = dissect(body_.elements, left_out, most, uncut);
        if (tree.fronts.empty()) return nullptr;
        return std::make_shared<const Dissection>(std::move(tree));
    });
}

std::shared_ptr<const Dissection>
ShellElasticity::dissection_with(const std::vector<std::uint32_t>& held,
                                 const std::vector<std::array<std::uint32_t, 8>>& more,
                                 const double* x) const
{
    constexpr double most_entries_a_corner = 3000;
    std::vector<char> left_out(body_.base.corners, 0);
    for (const auto k : held) left_out[k] = 1;
    std::vector<Vec3> places;
    for (std::uint32_t k = 0; k < body_.base.corners; ++k) places.push_back(place_at(x, k));
    ElementCorners elements = body_.elements.corners;
    elements.insert(elements.end(), more.begin(), more.end());
    Dissection tree = dissect(elements, places, left_out,
                              most_entries_a_corner * static_cast<double>(body_.base.corners));
    if (tree.fronts.empty()) return nullptr;
    return std::make_shared<const Dissection>(std::move(tree));
}

}  // namespace physics
