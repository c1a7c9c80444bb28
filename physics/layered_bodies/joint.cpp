#include "physics/layered_bodies/joint.hpp"

#include <cmath>
#include <limits>

namespace physics {
namespace {

constexpr double endless = std::numeric_limits<double>::infinity();

// How far b has turned against a since drawn: a rotation vector in the world, rad.
Vec3 turned(const Joint& joint, const Transform& a, const Transform& b)
{
    const Mat3 by = b.linear() * joint.axes_b * (a.linear() * joint.axes_a).transpose();
    const Eigen::AngleAxisd turn(by);
    return turn.angle() * turn.axis();
}

void add_turns(const Vec3& turn, double bound, JointRows& rows)
{
    for (int axis = 0; axis < 3; ++axis) {
        JointRow& row = rows.add();
        row.along = Vec3::Unit(axis);
        row.angular = true;
        row.value = turn[axis];
        row.lowest = -bound;
        row.highest = bound;
    }
}

// b's point against a's along `along`, which a carries. A line that moves with a meets b's point,
// so that both arms reach there.
JointRow& add_offset(const Joint& joint, const Transform& a, const Transform& b, const Vec3& along,
                     const Vec3& meet, JointRows& rows)
{
    JointRow& row = rows.add();
    row.along = along;
    row.value = along.dot(b * joint.point_b - a * joint.point_a);
    row.arm_a = meet - a.translation();
    row.arm_b = b * joint.point_b - b.translation();
    return row;
}

void add_points(const Joint& joint, const Transform& a, const Transform& b, JointRows& rows)
{
    for (int axis = 0; axis < 3; ++axis) {
        add_offset(joint, a, b, Vec3::Unit(axis), a * joint.point_a, rows);
    }
}

}  // namespace

JointRows joint_rows(const Joint& joint, const Transform& a, const Transform& b)
{
    JointRows rows;
    const Mat3 axes = a.linear() * joint.axes_a;
    const Vec3 first = axes.col(0);
    switch (joint.kind) {
    case JointKind::slider:
        for (int axis = 1; axis < 3; ++axis) {
            add_offset(joint, a, b, axes.col(axis), b * joint.point_b, rows);
        }
        add_turns(turned(joint, a, b), 0, rows);
        if (joint.lowest > -1e8 || joint.highest < 1e8) {
            JointRow& row = add_offset(joint, a, b, first, b * joint.point_b, rows);
            row.lowest = joint.lowest;
            row.highest = joint.highest;
        }
        break;
    case JointKind::ball:
        add_points(joint, a, b, rows);
        if (joint.cone < 1e8) {
            const Vec3 other = b.linear() * joint.axes_b.col(0), across = first.cross(other);
            const double sine = across.norm();
            JointRow& row = rows.add();
            row.angular = true;
            row.along = sine > 1e-9 ? Vec3(across / sine) : Vec3(axes.col(1));
            row.value = std::atan2(sine, first.dot(other));
            row.lowest = -endless;
            row.highest = joint.cone;
        }
        break;
    case JointKind::two_axis: {
        add_points(joint, a, b, rows);
        // The angle between the two axes grows by (w_b - w_a) . along.
        const Vec3 second = b.linear() * joint.axes_b.col(1), across = first.cross(second);
        const double sine = across.norm();
        JointRow& row = rows.add();
        row.angular = true;
        row.along = sine > 1e-9 ? Vec3(across / sine) : Vec3(axes.col(2));
        row.value = std::atan2(sine, first.dot(second)) - std::atan2(1.0, 0.0);
        break;
    }
    }
    return rows;
}

JointRows free_rows(const Joint& joint, const Transform& a, const Transform& b)
{
    JointRows rows;
    if (joint.kind == JointKind::slider) {
        const Vec3 first = a.linear() * joint.axes_a.col(0);
        JointRow& row = add_offset(joint, a, b, first, b * joint.point_b, rows);
        row.lowest = -endless;
        row.highest = endless;
    } else {
        add_turns(turned(joint, a, b), endless, rows);
    }
    return rows;
}

}  // namespace physics
