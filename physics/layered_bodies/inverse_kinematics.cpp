#include "physics/layered_bodies/inverse_kinematics.hpp"
#include "geometry/base/no_index.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace physics {
namespace {

constexpr std::uint32_t no_frame = geometry::no_index;

// The hinges as a tree below frame 0, from the root outward.
struct Tree {
    std::vector<std::uint32_t> order;   // hinges
    std::vector<std::uint32_t> hinge;   // B, the hinge that carries each frame; no_frame: the root
    std::vector<std::uint32_t> parent;  // B
};

Tree make_tree(const Base& base)
{
    const std::size_t n = base.frames.size();
    Tree tree;
    tree.hinge.assign(n, no_frame);
    tree.parent.assign(n, no_frame);
    std::vector<std::uint32_t> reached{0};
    for (std::size_t k = 0; k < reached.size(); ++k) {
        const std::uint32_t f = reached[k];
        for (std::uint32_t h = 0; h < base.hinges.size(); ++h) {
            const Hinge& hinge = base.hinges[h];
            if (h == tree.hinge[f] || (hinge.a != f && hinge.b != f)) continue;
            const std::uint32_t other = hinge.a == f ? hinge.b : hinge.a;
            if (other == 0 || tree.parent[other] != no_frame) {
                throw std::invalid_argument(fmt::format("inverse kinematics needs hinges without "
                                                        "loops; hinge {} closes a loop at frame {}",
                                                        h, other));
            }
            tree.parent[other] = f;
            tree.hinge[other] = h;
            tree.order.push_back(h);
            reached.push_back(other);
        }
    }
    for (std::uint32_t f = 1; f < n; ++f) {
        if (tree.parent[f] == no_frame) {
            throw std::invalid_argument(
                fmt::format("inverse kinematics needs every frame on a chain of hinges to frame 0; "
                            "frame {} is on none",
                            f));
        }
    }
    return tree;
}

// Frame b as hinge h holds it at its angle, in a's frame, and the other way round.
Transform across(const Base& base, const Hinge& h, double angle)
{
    const geometry::Mat3 drawn = base.frames[h.a].linear().transpose() * base.frames[h.b].linear();
    Transform t = Transform::Identity();
    t.translate(h.point_a)
        .rotate(Eigen::AngleAxisd(angle, h.axis_a))
        .rotate(drawn)
        .translate(-h.point_b);
    return t;
}

void place(const Base& base, const Tree& tree, std::span<const double> angle,
           std::vector<Transform>& frames)
{
    for (const std::uint32_t h : tree.order) {
        const Hinge& hinge = base.hinges[h];
        const Transform t = across(base, hinge, angle[h]);
        if (tree.hinge[hinge.b] == h) {
            frames[hinge.b] = frames[hinge.a] * t;
        } else {
            frames[hinge.a] = frames[hinge.b] * t.inverse();
        }
    }
}

struct Figure {
    const Base& base;
    const Tree& tree;
    std::span<const PoseGoal> goals;
    std::span<const Vec3> local;  // the goals' points, in their frames
};

double within(const Hinge& hinge, double angle)
{
    return has_limits(hinge) ? std::clamp(angle, hinge.lowest, hinge.highest) : angle;
}

// Places the frames; returns e, three rows a goal, and leaves the longest in `miss`.
Eigen::VectorXd misses(const Figure& figure, SolvedPose& at)
{
    place(figure.base, figure.tree, at.angle, at.frames);
    Eigen::VectorXd e(static_cast<Eigen::Index>(3 * figure.goals.size()));
    at.miss = 0;
    for (std::size_t g = 0; g < figure.goals.size(); ++g) {
        const PoseGoal& goal = figure.goals[g];
        const Vec3 miss = goal.target - at.frames[goal.frame] * figure.local[g];
        e.segment<3>(static_cast<Eigen::Index>(3 * g)) = miss;
        at.miss = std::max(at.miss, miss.norm());
    }
    return e;
}

Eigen::MatrixXd jacobian(const Figure& figure, std::span<const Transform> frames)
{
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(3 * figure.goals.size()),
                                              static_cast<Eigen::Index>(figure.base.hinges.size()));
    for (std::size_t g = 0; g < figure.goals.size(); ++g) {
        const Vec3 p = frames[figure.goals[g].frame] * figure.local[g];
        for (std::uint32_t f = figure.goals[g].frame; figure.tree.parent[f] != no_frame;
             f = figure.tree.parent[f]) {
            const std::uint32_t h = figure.tree.hinge[f];
            const Hinge& hinge = figure.base.hinges[h];
            const Vec3 axis = frames[hinge.a].linear() * hinge.axis_a;
            const Vec3 o = frames[hinge.a] * hinge.point_a;
            // The angle turns b; a hinge that carries a turns it the other way.
            const double way = hinge.b == f ? 1 : -1;
            J.block<3, 1>(static_cast<Eigen::Index>(3 * g), h) = way * axis.cross(p - o);
        }
    }
    return J;
}

// Turns the hinges by dtheta, half a radian each at most.
void turn_hinges(const Figure& figure, Eigen::MatrixXd J, const Eigen::VectorXd& e, double lambda,
                 std::vector<double>& angle)
{
    const Eigen::MatrixXd damping = lambda * lambda * Eigen::MatrixXd::Identity(e.size(), e.size());
    Eigen::VectorXd turn;
    for (std::size_t round = 0; round <= angle.size(); ++round) {
        turn = J.transpose() * (J * J.transpose() + damping).ldlt().solve(e);
        bool stopped = false;
        for (std::size_t h = 0; h < angle.size(); ++h) {
            const Hinge& hinge = figure.base.hinges[h];
            const auto k = static_cast<Eigen::Index>(h);
            const bool ends = (angle[h] >= hinge.highest && turn[k] > 0) ||
                              (angle[h] <= hinge.lowest && turn[k] < 0);
            if (!ends || !has_limits(hinge)) continue;
            J.col(k).setZero();
            stopped = true;
        }
        if (!stopped) break;
    }
    for (std::size_t h = 0; h < angle.size(); ++h) {
        const double by = std::clamp(turn[static_cast<Eigen::Index>(h)], -0.5, 0.5);
        angle[h] = within(figure.base.hinges[h], angle[h] + by);
    }
}

void check_goals(const Base& base, std::span<const PoseGoal> goals)
{
    if (base.frames.empty())
        throw std::invalid_argument("inverse kinematics needs a figure with frames, got none");
    for (std::size_t g = 0; g < goals.size(); ++g) {
        if (goals[g].frame >= base.frames.size() || !goals[g].point.allFinite() ||
            !goals[g].target.allFinite()) {
            throw std::invalid_argument(fmt::format(
                "goal {} names frame {} of {} (counted from 0), or its point or target is not "
                "finite",
                g, goals[g].frame, base.frames.size()));
        }
    }
}

// Levenberg and Marquardt's steps from where the figure is.
void descend(const Figure& figure, double size, const PoseOptions& options, SolvedPose& at)
{
    const std::size_t hinges = figure.base.hinges.size();
    Eigen::VectorXd e = misses(figure, at);
    double lambda = options.damping * size;
    bool nudged = false;
    while (at.miss > options.tolerance * size && lambda < 1e3 * size &&
           at.iterations < options.most_iterations && hinges > 0) {
        const Eigen::MatrixXd J = jacobian(figure, at.frames);
        if (!nudged && (J.transpose() * e).norm() < 1e-6 * size * e.norm()) {
            // Stretched out along the line to its goal, no hinge helps at first order: bend them.
            for (std::size_t h = 0; h < hinges; ++h) {
                at.angle[h] =
                    within(figure.base.hinges[h], at.angle[h] + (h % 2 == 0 ? 0.02 : -0.03));
            }
            e = misses(figure, at);
            nudged = true;
            continue;
        }
        ++at.iterations;
        SolvedPose next = at;
        turn_hinges(figure, J, e, lambda, next.angle);
        const Eigen::VectorXd next_e = misses(figure, next);
        const bool better = next_e.squaredNorm() < e.squaredNorm();
        lambda *= better ? 0.3 : 2;
        if (!better) continue;
        next.iterations = at.iterations;
        at = std::move(next);
        e = next_e;
    }
}

}  // namespace

double figure_size(const Base& base, std::span<const PoseGoal> goals)
{
    geometry::Box box;
    for (const Transform& frame : base.frames) box.add(frame.translation());
    if (!(box.diagonal() > 0)) {
        for (const Hinge& hinge : base.hinges) box.add(base.frames[hinge.a] * hinge.point_a);
    }
    for (const PoseGoal& goal : goals) box.add(goal.point);
    return std::max(box.diagonal(), 1e-12);
}

SolvedPose inverse_kinematics(const Base& base, const Transform& root,
                              std::span<const PoseGoal> goals, std::span<const double> start,
                              const PoseOptions& options)
{
    check_goals(base, goals);
    const Tree tree = make_tree(base);
    SolvedPose at;
    at.frames.assign(base.frames.size(), root * base.frames[0]);
    at.angle.assign(base.hinges.size(), 0);
    for (std::size_t h = 0; h < base.hinges.size(); ++h) {
        const double angle = h < start.size() ? start[h] : 0;
        at.angle[h] = within(base.hinges[h], angle);
    }
    std::vector<Vec3> local;
    for (const PoseGoal& goal : goals) {
        local.push_back(base.frames[goal.frame].inverse() * goal.point);
    }
    descend({base, tree, goals, local}, figure_size(base, goals), options, at);
    place(base, tree, at.angle, at.frames);
    return at;
}

}  // namespace physics
