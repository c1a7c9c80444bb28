#include "physics/shell/triangle_elasticity.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/shell/contact_weights.hpp"

#include <algorithm>
#include <cmath>

// Map: what a triangle is stretched and bent by; slopes; forces and blocks; the matrix.

namespace physics {
namespace {

using Eigen::Index;
using geometry::no_index;

constexpr std::size_t triangles_a_task = 256, corners_a_task = 1024;

template <class T> Vec3 corner_at(const T* field, std::uint32_t k)
{
    return Eigen::Map<const Eigen::Matrix<T, 3, 1>>(field + 4 * std::size_t{k})
        .template cast<double>();
}

}  // namespace

TriangleElasticity::TriangleElasticity(const ShellBody& body, const Pins& pins)
    : body_(body), shell_(*body.triangles), clamp_(shell_.triangle.size(), 1.0),
      pull_(shell_.triangle.size()), blocks_(shell_.triangle.size()),
      matrix_(9 * shell_.column.size()), matrix_low_(9 * shell_.column.size())
{
    constexpr double stiffer = 1e4;
    load_plastic({});
    std::vector<char> pinned(body.base.corners, 0);
    for (const auto k : pins.corner) pinned[k] = 1;
    for (std::uint32_t t = 0; t < clamp_.size(); ++t) {
        const auto& k = shell_.triangle[t].corner;
        if (!pinned[k[0]] || !pinned[k[1]] || !pinned[k[2]]) continue;
        const std::uint32_t fourth = shell_.triangle[t].fourth;
        if (fourth != no_index && !pinned[fourth]) continue;
        clamp_[t] = stiffer;
        clamps_.push_back(t);
    }
    at_rest_ = factor_for(1, 0);
    weighed_ = at_rest_;
}

std::shared_ptr<const SlopeFactor> TriangleElasticity::factor_for(double stiffness,
                                                                  double damping) const
{
    return shell_.slopes->find({stiffness, damping, {}, {clamps_, {}}}, [&] {
        std::vector<double> weight = clamp_;
        for (std::size_t t = 0; t < weight.size(); ++t) {
            weight[t] *= stiffness + damping * damping_of(t);
        }
        return std::make_shared<const SlopeFactor>(shell_, body_.base.rest.data(), weight);
    });
}

TriangleElasticity::Pose TriangleElasticity::pose_without_slopes(std::size_t t,
                                                                 const double* x) const
{
    const ShellTriangle& own = shell_.triangle[t];
    const Vec3 first = corner_at(x, own.corner[0]);
    const Vec3 a = corner_at(x, own.corner[1]) - first, b = corner_at(x, own.corner[2]) - first;
    Pose out{Vec3::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
    out.bends = a * own.by_place.col(1).transpose() + b * own.by_place.col(2).transpose();
    const Eigen::Vector3d& curved = rest_[t].curved;
    if (curved.isZero(0)) return out;
    // The normal moves by minus sum_i turn_i (normal . dx_i).
    constexpr double least = 1e-12;
    const Vec3 area = a.cross(b);
    const double size_sq = std::max(area.squaredNorm(), least * a.squaredNorm() * b.squaredNorm());
    if (!(size_sq > 0)) return out;
    out.normal = area / std::sqrt(size_sq);
    out.turn.col(1) = b.cross(area) / size_sq;
    out.turn.col(2) = area.cross(a) / size_sq;
    out.turn.col(0) = -out.turn.col(1) - out.turn.col(2);
    out.bends -= out.normal * curved.transpose();
    return out;
}

void TriangleElasticity::add_slopes(std::size_t t, const SideVectors& slopes, Pose& pose) const
{
    const ShellTriangle& own = shell_.triangle[t];
    for (std::size_t i = 0; i < 3; ++i) {
        pose.bends +=
            slopes.row(Index(own.side[i])).transpose() * own.by_slope.col(Index(i)).transpose();
    }
}

// What the places pull at the slopes with.
SideVectors TriangleElasticity::pulls_at(const std::vector<Pose>& poses) const
{
    SideVectors out(Index(shell_.side.size()), 3);
    geometry::parallel_for(shell_.side.size(), corners_a_task,
                           [&](std::size_t begin, std::size_t end) {
                               for (std::size_t s = begin; s < end; ++s) {
                                   Vec3 pull = Vec3::Zero();
                                   for (const auto use : shell_.side[s]) {
                                       if (use == no_index) continue;
                                       const ShellTriangle& t = shell_.triangle[use / 3];
                                       pull -= clamp_[use / 3] * poses[use / 3].bends *
                                               (t.plate * t.by_slope.col(Index(use % 3)));
                                   }
                                   out.row(Index(s)) = pull.transpose();
                               }
                           });
    return out;
}

// With the slopes that make the energy of bending least.
std::vector<TriangleElasticity::Pose> TriangleElasticity::poses_at(const double* x) const
{
    std::vector<Pose> poses(shell_.triangle.size());
    const auto for_all = [&](const auto& with) {
        geometry::parallel_for(poses.size(), triangles_a_task,
                               [&](std::size_t begin, std::size_t end) {
                                   for (std::size_t t = begin; t < end; ++t) with(t);
                               });
    };
    for_all([&](std::size_t t) { poses[t] = pose_without_slopes(t, x); });
    SideVectors slopes = pulls_at(poses);
    at_rest_->solve(slopes, slope_work_);
    for_all([&](std::size_t t) { add_slopes(t, slopes, poses[t]); });
    return poses;
}

// The pull of a triangle on its corners, and the blocks of its derivative between them.
void TriangleElasticity::evaluate_triangle(std::size_t t, const Pose& pose)
{
    const ShellTriangle& own = shell_.triangle[t];
    const TriangleRest& rest = rest_[t];
    const ShellVector way =
        came_.empty() ? ShellVector::Zero() : stretch_at(own, rest, came_.data());
    const CellEnergy cell = cell_energy(own.stretch, stretch_at(own, rest, at_.data()),
                                        hessian_ ? Curvature::whole : Curvature::positive,
                                        came_.empty() ? nullptr : &way);
    const Eigen::Matrix3d plate = clamp_[t] * own.plate;
    const Eigen::Matrix3d moment = pose.bends * plate;  // a column each
    const Eigen::Matrix3d places = own.by_place.transpose() * plate * own.by_place;
    const Eigen::Vector3d pulled = plate * rest.curved;
    const Eigen::Vector3d across = own.by_place.transpose() * pulled;
    const double own_turn = rest.curved.dot(pulled);
    const bool curved = !rest.curved.isZero(0);
    const Vec3 turned = moment * rest.curved;
    for (Index i = 0; i < 3; ++i) {
        const double gu = rest.gradient(0, i), gv = rest.gradient(1, i);
        Vec3& pull = pull_[t][std::size_t(i)];
        pull = -gu * cell.slope.head<3>() - gv * cell.slope.segment<3>(3) -
               moment * own.by_place.col(i);
        if (curved) pull -= pose.turn.col(i).dot(turned) * pose.normal;
        const Eigen::Matrix<double, 3, 6> row =
            gu * cell.curvature.topLeftCorner<3, 6>() + gv * cell.curvature.block<3, 6>(3, 0);
        for (Index j = 0; j < 3; ++j) {
            Eigen::Matrix3d& block = blocks_[t][std::size_t(3 * i + j)];
            block =
                rest.gradient(0, j) * row.leftCols<3>() + rest.gradient(1, j) * row.rightCols<3>();
            block.diagonal().array() += places(i, j);
            if (!curved) continue;
            const auto &ci = pose.turn.col(i), &cj = pose.turn.col(j);
            block += across[i] * cj * pose.normal.transpose() +
                     across[j] * pose.normal * ci.transpose() +
                     own_turn * ci.dot(cj) * pose.normal * pose.normal.transpose();
        }
    }
}

void TriangleElasticity::evaluate()
{
    geometry::parallel_for(pose_.size(), triangles_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) evaluate_triangle(t, pose_[t]);
    });
}

void TriangleElasticity::forces(const double* x, double* f)
{
    at_.assign(x, x + body_.base.numbers);
    came_.clear();
    pose_ = poses_at(x);
    evaluate();
    const std::size_t corners = body_.base.corners;
    geometry::parallel_for(corners, corners_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            Vec3 sum = Vec3::Zero();
            for (auto at = shell_.of_corner[k]; at < shell_.of_corner[k + 1]; ++at) {
                sum += pull_[shell_.around[at] / 3][shell_.around[at] % 3];
            }
            Eigen::Map<Vec3>(f + 4 * k) = sum;
        }
    });
    assemble();
}

double TriangleElasticity::energy(const double* x)
{
    const std::vector<Pose> poses = poses_at(x);
    return geometry::ordered_sum(
        poses.size(), triangles_a_task, 0.0, [&](std::size_t begin, std::size_t end) {
            double sum = 0;
            for (std::size_t t = begin; t < end; ++t) {
                const ShellTriangle& own = shell_.triangle[t];
                const Eigen::Matrix3d& e = poses[t].bends;
                sum +=
                    cell_energy(own.stretch, stretch_at(own, rest_[t], x), Curvature::none).energy;
                sum += 0.5 * clamp_[t] * (e * own.plate).cwiseProduct(e).sum();
            }
            return sum;
        });
}

double TriangleElasticity::largest_rate(const double* w) const
{
    const double* rest = body_.base.rest.data();
    double most_sq = 0;
    for (const ShellTriangle& t : shell_.triangle) {
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = t.corner[i], b = t.corner[(i + 1) % 3];
            const double side_sq = (corner_at(rest, b) - corner_at(rest, a)).squaredNorm();
            most_sq =
                std::max(most_sq, (corner_at(w, b) - corner_at(w, a)).squaredNorm() / side_sq);
        }
    }
    return std::sqrt(most_sq);
}

void TriangleElasticity::weigh(double stiffness, double damping)
{
    const bool same = stiffness == stiffness_weight_ && damping == damping_weight_;
    stiffness_weight_ = stiffness;
    damping_weight_ = damping;
    if (shell_.even) {
        scale_ = stiffness + damping * shell_.most_damping;
    } else if (!same) {
        weighed_ = factor_for(stiffness, damping);
        assemble();
    }
}

bool TriangleElasticity::use_hessian(bool on)
{
    if (on == hessian_) return true;
    hessian_ = on;
    if (at_.empty()) return true;
    evaluate();
    assemble();
    return true;
}

double TriangleElasticity::damping_of(std::size_t t) const
{
    // Where some have none, their slopes go with those that have.
    constexpr double least = 1e-6;
    return std::max(shell_.triangle[t].damping, least * shell_.most_damping);
}

double TriangleElasticity::weight_of(std::size_t t) const
{
    return shell_.even ? 1 : stiffness_weight_ + damping_weight_ * damping_of(t);
}

void TriangleElasticity::assemble()
{
    const std::size_t corners = body_.base.corners;
    geometry::parallel_for(corners, corners_a_task, [&](std::size_t begin, std::size_t end) {
        const std::size_t first = 9 * std::size_t{shell_.row[begin]};
        const std::size_t last = 9 * std::size_t{shell_.row[end]};
        std::fill(matrix_.begin() + std::ptrdiff_t(first), matrix_.begin() + std::ptrdiff_t(last),
                  0.0);
        for (std::size_t k = begin; k < end; ++k) {
            for (auto at = shell_.of_corner[k]; at < shell_.of_corner[k + 1]; ++at) {
                const std::size_t t = shell_.around[at] / 3, i = shell_.around[at] % 3;
                const double weight = weight_of(t);
                for (std::size_t j = 0; j < 3; ++j) {
                    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> to(
                        matrix_.data() + 9 * std::size_t{shell_.block_at[t][3 * i + j]});
                    to += weight * blocks_[t][3 * i + j];
                }
            }
        }
        for (std::size_t i = first; i < last; ++i) matrix_low_[i] = static_cast<float>(matrix_[i]);
    });
}

// Kgg^-1 Kgx p.
template <class T> SideVectors TriangleElasticity::slopes_that_answer(const T* p) const
{
    SideVectors out(Index(shell_.side.size()), 3);
    geometry::parallel_for(
        shell_.side.size(), corners_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                Vec3 sum = Vec3::Zero();
                for (const auto use : shell_.side[s]) {
                    if (use == no_index) continue;
                    const std::size_t t = use / 3;
                    const ShellTriangle& own = shell_.triangle[t];
                    const auto side = Index(use % 3);
                    Vec3 pulled = Vec3::Zero();
                    for (Index i = 0; i < 3; ++i) {
                        const Vec3 way = corner_at(p, own.corner[std::size_t(i)]);
                        pulled += own.joined(i, side) * way;
                        if (rest_[t].turned[side] == 0) continue;
                        pulled +=
                            rest_[t].turned[side] * pose_[t].normal.dot(way) * pose_[t].turn.col(i);
                    }
                    sum += clamp_[t] * weight_of(t) * pulled;
                }
                out.row(Index(s)) = sum.transpose();
            }
        });
    (shell_.even ? at_rest_ : weighed_)->solve(out, slope_work_);
    return out;
}

template <class T>
void TriangleElasticity::multiply_any(const Aligned<T>& matrix, const T* p, T* y) const
{
    const SideVectors slopes = slopes_that_answer(p);
    const std::size_t corners = body_.base.corners;
    geometry::parallel_for(corners, corners_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            Vec3 sum = Vec3::Zero();
            for (std::size_t e = shell_.row[k]; e < shell_.row[k + 1]; ++e) {
                using Block = Eigen::Matrix<T, 3, 3, Eigen::RowMajor>;
                const Eigen::Map<const Block> m(matrix.data() + 9 * e);
                sum += m.template cast<double>() * corner_at(p, shell_.column[e]);
            }
            for (auto at = shell_.of_corner[k]; at < shell_.of_corner[k + 1]; ++at) {
                const std::size_t t = shell_.around[at] / 3;
                const auto i = Index(shell_.around[at] % 3);
                const ShellTriangle& own = shell_.triangle[t];
                Vec3 pull = Vec3::Zero();
                double along = 0;
                for (Index j = 0; j < 3; ++j) {
                    const Vec3 slope = slopes.row(Index(own.side[std::size_t(j)])).transpose();
                    pull += own.joined(i, j) * slope;
                    if (rest_[t].turned[j] != 0)
                        along += rest_[t].turned[j] * pose_[t].turn.col(i).dot(slope);
                }
                if (along != 0) pull += along * pose_[t].normal;
                sum -= clamp_[t] * weight_of(t) * pull;
            }
            for (std::size_t i = 0; i < 3; ++i) {
                y[4 * k + i] = static_cast<T>(scale_ * sum[Index(i)]);
            }
        }
    });
}

void TriangleElasticity::multiply(const float* p, float* y) const
{
    multiply_any(matrix_low_, p, y);
}

void TriangleElasticity::multiply(const double* p, double* y) const
{
    multiply_any(matrix_, p, y);
}

void TriangleElasticity::add_diagonal(double* d) const
{
    for (std::uint32_t k = 0; k < body_.base.corners; ++k) {
        const auto first = shell_.column.begin() + shell_.row[k];
        const auto last = shell_.column.begin() + shell_.row[k + 1];
        const auto at = std::lower_bound(first, last, k) - shell_.column.begin();
        const double* m = matrix_.data() + 9 * at;
        for (std::size_t i = 0; i < 3; ++i) d[4 * std::size_t{k} + i] += scale_ * m[4 * i];
    }
}

// Of its corners, then its sides.
void TriangleElasticity::element_matrix(std::size_t t, BrickMatrix& to) const
{
    const ShellTriangle& own = shell_.triangle[t];
    const double weight = stiffness_weight_ + damping_weight_ * damping_of(t);
    to.setZero();
    for (Index i = 0; i < 3; ++i) {
        for (Index j = 0; j < 3; ++j) {
            to.block<3, 3>(3 * i, 3 * j) = weight * blocks_[t][std::size_t(3 * i + j)];
        }
    }
    const double bend = weight * clamp_[t];
    const Eigen::Matrix3d slopes = bend * own.by_slope.transpose() * own.plate * own.by_slope;
    const Eigen::Matrix3d across = bend * own.joined;
    const Vec3 turn = bend * rest_[t].turned;
    for (Index i = 0; i < 3; ++i) {
        for (Index j = 0; j < 3; ++j) {
            to.block<3, 3>(9 + 3 * i, 9 + 3 * j).diagonal().array() += slopes(i, j);
            Eigen::Matrix3d block = across(i, j) * Eigen::Matrix3d::Identity();
            if (turn[j] != 0) {
                block += turn[j] * pose_[t].normal * pose_[t].turn.col(i).transpose();
            }
            to.block<3, 3>(3 * i, 9 + 3 * j) = block;
            to.block<3, 3>(9 + 3 * j, 3 * i) = block.transpose();
        }
    }
}

bool TriangleElasticity::cube_matrices(std::vector<BrickMatrix>& out) const
{
    out.resize(shell_.triangle.size());
    geometry::parallel_for(out.size(), triangles_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) element_matrix(t, out[t]);
    });
    return true;
}

void TriangleElasticity::add_contact(const PointContact& contact, const geometry::Mat3& block,
                                     std::span<BrickMatrix> to) const
{
    if (contact.count != 8) return;
    // What touches a collider is a point of one triangle.
    const std::uint32_t first = contact.corners[0];
    for (auto at = shell_.of_corner[first]; at < shell_.of_corner[first + 1]; ++at) {
        const std::size_t t = shell_.around[at] / 3;
        const auto weight = weights_in(shell_.triangle[t].corner, contact);
        if (weight) return add_between(*weight, block, to[t]);
    }
}

// Corners, then sides.
ElementsOfMethod TriangleElasticity::elements(const double* x) const
{
    const auto corners = static_cast<std::uint32_t>(body_.base.corners);
    ElementsOfMethod out;
    for (const ShellTriangle& t : shell_.triangle) {
        out.corners.push_back({t.corner[0], t.corner[1], t.corner[2], corners + t.side[0],
                               corners + t.side[1], corners + t.side[2], t.corner[0], t.corner[0]});
    }
    out.inner = middles_of_sides(shell_, x);
    return out;
}

// Its elements, then `more`, by where corners are at x.
std::shared_ptr<const Dissection>
TriangleElasticity::dissected(const std::vector<std::uint32_t>& held, const ElementCorners& more,
                              const double* x) const
{
    // Solves with more than these take longer than any other way.
    constexpr double most_entries_a_corner = 1500;
    constexpr std::size_t uncut = 24;
    ElementsOfMethod own = elements(x);
    std::vector<Vec3> places;
    for (std::uint32_t k = 0; k < body_.base.corners; ++k) places.push_back(corner_at(x, k));
    places.insert(places.end(), own.inner.begin(), own.inner.end());
    std::vector<char> left_out(places.size(), 0);
    for (const auto k : held) left_out[k] = 1;
    own.corners.insert(own.corners.end(), more.begin(), more.end());
    Dissection tree = dissect(own.corners, places, left_out,
                              most_entries_a_corner * static_cast<double>(places.size()), uncut);
    if (tree.fronts.empty()) return nullptr;
    return std::make_shared<const Dissection>(std::move(tree));
}

std::shared_ptr<const Dissection>
TriangleElasticity::dissection(const std::vector<std::uint32_t>& held) const
{
    return body_.dissections->find({0, 0, {}, {held, {}}}, [&]() -> DissectionCache::Factor {
        return dissected(held, {}, body_.base.rest.data());
    });
}

std::shared_ptr<const Dissection>
TriangleElasticity::dissection_with(const std::vector<std::uint32_t>& held,
                                    const ElementCorners& more, const double* x) const
{
    return dissected(held, more, x);
}

}  // namespace physics
