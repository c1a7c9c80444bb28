#include "physics/layered_bodies/figure_pose.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace physics {
namespace {

// Two frames that are joined, and b's frame in a's.
struct Link {
    std::uint32_t a, b;
    Transform b_in_a;
};

// b held by a at their points, turned by `turn` in a's frame since drawn, and moved by `way` there.
Transform across(const Base& base, std::uint32_t a, std::uint32_t b, const Vec3& point_a,
                 const Vec3& point_b, const Mat3& turn, const Vec3& way)
{
    const Mat3 drawn = base.frames[a].linear().transpose() * base.frames[b].linear();
    Transform t = Transform::Identity();
    t.translate(point_a + way).rotate(Mat3(turn * drawn)).translate(-point_b);
    return t;
}

Link link_of(const Base& base, const Hinge& h, double angle)
{
    const Mat3 turn = Eigen::AngleAxisd(angle, h.axis_a).toRotationMatrix();
    return {h.a, h.b, across(base, h.a, h.b, h.point_a, h.point_b, turn, Vec3::Zero())};
}

Link link_of(const Base& base, const Joint& j, const JointPose& pose)
{
    Mat3 turn = Mat3::Identity();
    Vec3 way = Vec3::Zero();
    const auto about = [](double angle, const Vec3& axis) {
        return Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    };
    switch (j.kind) {
    case JointKind::ball: {
        // In the axes of the drawing, which a's frame has turned since.
        const Mat3 in_a = base.frames[j.a].linear().transpose();
        const Mat3 drawn = about(pose.turn.z(), Vec3::UnitZ()) *
                           about(pose.turn.y(), Vec3::UnitY()) *
                           about(pose.turn.x(), Vec3::UnitX());
        turn = in_a * drawn * in_a.transpose();
        break;
    }
    case JointKind::slider:
        way = pose.first * j.axes_a.col(0);
        break;
    case JointKind::two_axis:
        turn = about(pose.first, j.axes_a.col(0)) * about(pose.second, j.axes_a.col(1));
        break;
    }
    return {j.a, j.b, across(base, j.a, j.b, j.point_a, j.point_b, turn, way)};
}

}  // namespace

std::vector<Transform> figure_pose(const Base& base, const Transform& root,
                                   std::span<const double> angle, std::span<const JointPose> pose)
{
    std::vector<Link> links;
    for (std::size_t h = 0; h < base.hinges.size(); ++h) {
        links.push_back(link_of(base, base.hinges[h], h < angle.size() ? angle[h] : 0));
    }
    for (std::size_t j = 0; j < base.joints.size(); ++j) {
        if (base.joints[j].a == Joint::world) continue;
        links.push_back(link_of(base, base.joints[j], j < pose.size() ? pose[j] : JointPose{}));
    }
    if (base.frames.empty()) return {};
    std::vector<Transform> frames(base.frames.size(), root * base.frames[0]);
    std::vector<char> placed(frames.size(), 0), used(links.size(), 0);
    std::vector<std::uint32_t> order{0};
    placed[0] = 1;
    for (std::size_t next = 0; next < order.size(); ++next) {
        const std::uint32_t f = order[next];
        for (std::size_t l = 0; l < links.size(); ++l) {
            const Link& link = links[l];
            if (used[l] != 0 || (link.a != f && link.b != f)) continue;
            used[l] = 1;
            const std::uint32_t other = link.a == f ? link.b : link.a;
            if (placed[other] != 0) {
                throw std::invalid_argument(fmt::format(
                    "a pose needs joints without loops; a hinge or joint closes one at frame {}",
                    other));
            }
            placed[other] = 1;
            frames[other] = frames[f] * (link.a == f ? link.b_in_a : link.b_in_a.inverse());
            order.push_back(other);
        }
    }
    for (std::size_t f = 0; f < placed.size(); ++f) {
        if (placed[f] != 0) continue;
        throw std::invalid_argument(fmt::format(
            "a pose needs every frame on a chain of hinges and joints to frame 0; frame {} is not",
            f));
    }
    return frames;
}

}  // namespace physics
