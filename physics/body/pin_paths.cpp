#include "physics/body/pin_paths.hpp"

#include "geometry/base/no_index.hpp"
#include "physics/state/loads.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace physics {
namespace {

using geometry::Mat3;
using geometry::no_index;

// The turn that takes arms nearest to others; none where they lie on a line, which leaves it open.
std::optional<Eigen::AngleAxisd> nearest_turn(const std::vector<Vec3>& from,
                                              const std::vector<Vec3>& to, double edge)
{
    constexpr double least = 1e-3;  // cubes, of arms beside a line
    Mat3 sum = Mat3::Zero();
    for (std::size_t i = 0; i < from.size(); ++i) sum += to[i] * from[i].transpose();
    const Eigen::JacobiSVD<Mat3> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const auto count = static_cast<double>(from.size());
    if (!(svd.singularValues()[1] > count * least * least * edge * edge)) return std::nullopt;
    Mat3 u = svd.matrixU();
    if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
    return Eigen::AngleAxisd(Mat3(u * svd.matrixV().transpose()));
}

Vec3 middle_of_points(const std::vector<Vec3>& all, const std::vector<std::size_t>& points)
{
    Vec3 sum = Vec3::Zero();
    for (const auto i : points) sum += all[i];
    return sum / static_cast<double>(points.size());
}

// Where pins take points.
struct Moves {
    const std::vector<Vec3>&from, &to;
    double edge;  // m, of a cube
};

// A motion as one rigid body, of those that are at the mean places.
struct RigidMove {
    Vec3 from, to;
    Eigen::AngleAxisd by;

    bool takes(const Moves& moves, std::size_t point) const
    {
        constexpr double nearly = 1e-3;  // cubes, that what moves as a rigid body may be off
        const Vec3 there = to + by * Vec3(moves.from[point] - from);
        return (moves.to[point] - there).norm() < nearly * moves.edge;
    }
};

// That of some points, if they move so.
std::optional<RigidMove> rigid_move(const Moves& moves, const std::vector<std::size_t>& points)
{
    RigidMove out{middle_of_points(moves.from, points), middle_of_points(moves.to, points), {}};
    std::vector<Vec3> before, now;
    for (const auto i : points) {
        before.emplace_back(moves.from[i] - out.from);
        now.emplace_back(moves.to[i] - out.to);
    }
    const auto by = nearest_turn(before, now, moves.edge);
    if (!by) return std::nullopt;
    out.by = *by;
    const auto taken = [&](std::size_t point) { return out.takes(moves, point); };
    return std::all_of(points.begin(), points.end(), taken) ? std::optional(out) : std::nullopt;
}

// Those of some points that are nearest to one of them, and itself.
std::vector<std::size_t> beside(const Moves& moves, const std::vector<std::size_t>& points,
                                std::size_t one)
{
    constexpr double reach = 1.8;    // of the way to the nearest: over the diagonal of a cube
    constexpr double apart = 0.001;  // cubes: two pins may hold one point
    const auto way = [&](std::size_t i) { return (moves.from[i] - moves.from[one]).norm(); };
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto i : points) {
        if (way(i) > apart * moves.edge) nearest = std::min(nearest, way(i));
    }
    std::vector<std::size_t> out;
    std::copy_if(points.begin(), points.end(), std::back_inserter(out),
                 [&](std::size_t i) { return way(i) < reach * nearest; });
    return out;
}

struct RigidGroup {
    RigidMove move;
    std::vector<std::size_t> points;
};

// The points of a part by how they move: all as one, or else as those beside each other do, which
// one pin holds. Points that move otherwise are in no group.
std::vector<RigidGroup> rigid_groups(const Moves& moves, std::vector<std::size_t> points)
{
    constexpr int most_tries = 16;  // lest a pin that bends thousands of them takes long
    if (const auto all = rigid_move(moves, points)) return {{*all, std::move(points)}};
    std::vector<RigidGroup> out;
    std::vector<std::size_t> left = points;
    int tries = 0;
    for (const auto seed : points) {
        if (!std::binary_search(left.begin(), left.end(), seed)) continue;  // they stay sorted
        if (tries == most_tries) break;
        const auto move = rigid_move(moves, beside(moves, left, seed));
        if (!move) {
            ++tries;
            continue;
        }
        const auto others = std::stable_partition(
            left.begin(), left.end(), [&](std::size_t i) { return move->takes(moves, i); });
        std::vector<std::size_t> group(left.begin(), others);
        left.erase(left.begin(), others);
        if (const auto whole = rigid_move(moves, group)) out.push_back({*whole, std::move(group)});
    }
    return out;
}

struct TurnCentre {
    Vec3 from, to;  // m
};

// What a group turns about: of its pins' pivots and its mean place what goes least far. A pin takes
// its own pivot no further than it moves it; what it holds anew was turned elsewhere.
TurnCentre stillest(const RigidMove& move, const std::vector<std::size_t>& points,
                    const std::vector<Vec3>& pivots)
{
    TurnCentre out{move.from, move.to};
    for (const auto i : points) {
        const Vec3 to = pivot_of(pivots, i);
        const Vec3 from = move.from + move.by.inverse() * Vec3(to - move.to);
        if ((to - from).norm() < (out.to - out.from).norm()) out = {from, to};
    }
    return out;
}

}  // namespace

PinPaths::PinPaths(std::vector<Vec3> from, std::vector<Vec3> to,
                   const std::vector<std::uint32_t>& group, const std::vector<Vec3>& pivots,
                   double edge)
    : from_(std::move(from)), to_(std::move(to))
{
    constexpr double least = 1e-6;  // rad
    if (!move()) return;
    std::map<std::uint32_t, std::vector<std::size_t>> parts;
    for (std::size_t i = 0; i < group.size(); ++i) {
        if (group[i] != no_index) parts[group[i]].push_back(i);
    }
    for (auto& part : parts) {
        for (const auto& [move, points] :
             rigid_groups({from_, to_, edge}, std::move(part.second))) {
            if (!(move.by.angle() > least)) continue;
            turn_.resize(from_.size(), no_index);
            for (const auto i : points) turn_[i] = static_cast<std::uint32_t>(turns_.size());
            const TurnCentre centre = stillest(move, points, pivots);
            turns_.push_back({centre.from, centre.to, move.by.axis(), move.by.angle()});
        }
    }
}

Vec3 PinPaths::arm(const Turn& turn, std::size_t point, double share) const
{
    return Eigen::AngleAxisd(share * turn.angle, turn.axis) * Vec3(from_[point] - turn.from);
}

Vec3 PinPaths::at(std::size_t point, double share) const
{
    const Vec3 &from = from_[point], &to = to_[point];
    if (share == 1) return to;
    if (turn_.empty() || turn_[point] == no_index) return from + share * (to - from);
    const Turn& turn = turns_[turn_[point]];
    const Vec3 left = to - turn.to - arm(turn, point, 1);
    return turn.from + share * (turn.to - turn.from) + arm(turn, point, share) + share * left;
}

Vec3 PinPaths::velocity(std::size_t point, double share) const
{
    const Vec3 &from = from_[point], &to = to_[point];
    if (turn_.empty() || turn_[point] == no_index) return to - from;
    const Turn& turn = turns_[turn_[point]];
    const Vec3 left = to - turn.to - arm(turn, point, 1);
    const Vec3 turning = turn.angle * turn.axis.cross(arm(turn, point, share));
    return turn.to - turn.from + turning + left;
}

std::vector<Vec3> PinPaths::at_end(std::vector<Vec3> forces, double share) const
{
    if (turns_.empty() || share == 1) return forces;
    std::vector<Vec3> mean(turns_.size(), Vec3::Zero());
    std::vector<double> count(turns_.size(), 0);
    for (std::size_t i = 0; i < forces.size(); ++i) {
        if (turn_[i] == no_index) continue;
        mean[turn_[i]] += forces[i];
        count[turn_[i]] += 1;
    }
    for (std::size_t t = 0; t < turns_.size(); ++t) mean[t] /= count[t];
    std::vector<Vec3> off(turns_.size(), Vec3::Zero());  // N m, moments that the turn took away
    for (std::size_t i = 0; i < forces.size(); ++i) {
        if (turn_[i] == no_index) continue;
        const Turn& turn = turns_[turn_[i]];
        const Vec3 own = forces[i] - mean[turn_[i]];
        const Vec3 turned = Eigen::AngleAxisd((1 - share) * turn.angle, turn.axis) * own;
        off[turn_[i]] += arm(turn, i, share).cross(own) - arm(turn, i, 1).cross(turned);
        forces[i] = mean[turn_[i]] + turned;
    }
    add_moments(off, forces);
    return forces;
}

void PinPaths::add_moments(const std::vector<Vec3>& more, std::vector<Vec3>& forces) const
{
    // By forces w x arm, whose sum is 0:  M = J w,  J = sum |arm|^2 I - arm arm^T. Points of a
    // group that turns lie on no line, so that J has an inverse.
    std::vector<Vec3> middle(turns_.size(), Vec3::Zero());
    std::vector<double> count(turns_.size(), 0);
    for (std::size_t i = 0; i < forces.size(); ++i) {
        if (turn_[i] == no_index) continue;
        middle[turn_[i]] += arm(turns_[turn_[i]], i, 1);
        count[turn_[i]] += 1;
    }
    for (std::size_t t = 0; t < turns_.size(); ++t) middle[t] /= count[t];
    std::vector<Mat3> spread(turns_.size(), Mat3::Zero());
    for (std::size_t i = 0; i < forces.size(); ++i) {
        if (turn_[i] == no_index) continue;
        const Vec3 from = arm(turns_[turn_[i]], i, 1) - middle[turn_[i]];
        spread[turn_[i]] += from.squaredNorm() * Mat3::Identity() - from * from.transpose();
    }
    std::vector<Vec3> w;
    for (std::size_t t = 0; t < turns_.size(); ++t) w.emplace_back(spread[t].ldlt().solve(more[t]));
    for (std::size_t i = 0; i < forces.size(); ++i) {
        if (turn_[i] == no_index) continue;
        forces[i] += w[turn_[i]].cross(arm(turns_[turn_[i]], i, 1) - middle[turn_[i]]);
    }
}

}  // namespace physics
