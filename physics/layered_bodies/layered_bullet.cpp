#include "physics/layered_bodies/layered_bullet.hpp"

#include "physics/layered_bodies/layered_forces.hpp"
#include "physics/layered_bodies/layered_loads.hpp"

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/ConstraintSolver/btContactSolverInfo.h>
#include <BulletDynamics/ConstraintSolver/btHingeConstraint.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

btVector3 to_bullet(const Vec3& v)
{
    return {v.x(), v.y(), v.z()};
}

btQuaternion to_bullet(const Eigen::Quaterniond& q)
{
    return {q.x(), q.y(), q.z(), q.w()};
}

Vec3 from_bullet(const btVector3& v)
{
    return {v.x(), v.y(), v.z()};
}

Eigen::Quaterniond from_bullet(const btQuaternion& q)
{
    return {q.w(), q.x(), q.y(), q.z()};
}

// A frame of the scene.
struct Limb {
    std::size_t part, frame;
    Eigen::Quaterniond axes;  // of inertia, in the frame: Bullet's local axes
    btVector3 inertia;        // about those, kg m^2
    std::unique_ptr<btRigidBody> body;
};

Limb make_limb(const LayeredScene& scene, std::size_t part, std::size_t frame,
               const LayeredWorld& world)
{
    const Base& base = scene.parts[part].body->base;
    const LayeredState& state = scene.states[part];
    const Eigen::SelfAdjointEigenSolver<Mat3> own(base.inertia[frame]);
    Mat3 axes = own.eigenvectors();
    if (axes.determinant() < 0) axes.col(0) *= -1;
    Limb limb{part, frame, Eigen::Quaterniond(axes), to_bullet(own.eigenvalues()), nullptr};
    limb.body = std::make_unique<btRigidBody>(base.mass[frame], nullptr, nullptr, limb.inertia);
    btRigidBody& body = *limb.body;
    body.setCenterOfMassTransform(
        btTransform(to_bullet(Eigen::Quaterniond(state.rotation[frame]) * limb.axes),
                    to_bullet(state.position[frame])));
    body.setLinearVelocity(to_bullet(state.velocity[frame]));
    body.setAngularVelocity(to_bullet(state.spin[frame]));
    body.setFlags(0);  // of its own on turning
    body.setGravity(to_bullet(world.gravity));
    const double lost = -std::expm1(-world.drag);  // of the speed, in a second
    body.setDamping(lost, lost);
    return limb;
}

// The frame whose z is a hinge's axis and whose x is at angle 0, in a limb's axes.
btTransform hinge_frame(const Limb& limb, const Vec3& point, const Vec3& axis, const Vec3& zero)
{
    Mat3 turn;
    turn << zero, axis.cross(zero), axis;
    const Eigen::Quaterniond back = limb.axes.conjugate();
    return btTransform(to_bullet(back * Eigen::Quaterniond(turn)), to_bullet(Vec3(back * point)));
}

// Bullet's hinge, which lets its limits be passed and throws the limbs back, with limits of ours:
// in no step does the angle come nearer to one than it is, so that the limbs stop there, without a
// bounce. Where it has limits, two more rows J v = e with impulses of one sign, v the rate
// -(w_b - w_a) . axis:
//   -rate >= -(highest - angle) / h,   -rate <= (angle - lowest) / h
class LimitedHinge : public btHingeConstraint {
public:
    LimitedHinge(const Hinge& hinge, const Limb& a, const Limb& b)
        : btHingeConstraint(*a.body, *b.body,
                            hinge_frame(a, hinge.point_a, hinge.axis_a, hinge.zero_a),
                            hinge_frame(b, hinge.point_b, hinge.axis_b, hinge.zero_b), true),
          hinge_(hinge)
    {
        setLimit(1, -1);  // none of its own
    }

    void getInfo1(btConstraintInfo1* info) override
    {
        btHingeConstraint::getInfo1(info);
        if (has_limits(hinge_)) info->m_numConstraintRows += 2;
    }

    void getInfo2(btConstraintInfo2* info) override
    {
        btHingeConstraint::getInfo2(info);
        if (!has_limits(hinge_)) return;
        const btScalar angle = unwound(hinge_, getHingeAngle());
        const btVector3 axis =
            m_rbA.getCenterOfMassTransform().getBasis() * getAFrame().getBasis().getColumn(2);
        const auto limit = [&](int row, btScalar error, btScalar least, btScalar most) {
            const int at = row * info->rowskip;
            for (int k = 0; k < 3; ++k) {
                info->m_J1angularAxis[at + k] = axis[k];
                info->m_J2angularAxis[at + k] = -axis[k];
            }
            info->m_constraintError[at] = error * info->fps;
            info->m_lowerLimit[at] = least;
            info->m_upperLimit[at] = most;
        };
        // What is beyond comes back by a fifth a step, as joints do.
        const auto room = [](btScalar free) { return free > 0 ? free : 0.2 * free; };
        limit(5, -room(hinge_.highest - angle), 0, SIMD_INFINITY);
        limit(6, room(angle - hinge_.lowest), -SIMD_INFINITY, 0);
    }

private:
    Hinge hinge_;
};

// A joint by its rows (joint.hpp), found anew in each step: Jacobians and errors as they are then.
class RowJoint : public btTypedConstraint {
public:
    // `drawn`: where the body started, which is where its joints with the world are.
    RowJoint(const Joint& joint, const Limb* a, const Limb& b, btRigidBody& world,
             const Transform& drawn)
        : btTypedConstraint(D6_CONSTRAINT_TYPE, a ? *a->body : world, *b.body), joint_(joint),
          axes_a_(a ? a->axes : Eigen::Quaterniond::Identity()), axes_b_(b.axes), to_world_(!a),
          drawn_(drawn)
    {}

    void getInfo1(btConstraintInfo1* info) override
    {
        info->m_numConstraintRows = info->nub = 0;
        const JointRows now = rows();
        for (const JointRow& row : now.all()) {
            info->m_numConstraintRows += row.lowest < row.highest ? limits(row) : 1;
        }
    }

    // Rows J v = e, v the velocities of a less those of b.
    void getInfo2(btConstraintInfo2* info) override
    {
        int at = 0;
        const auto put = [&](const JointRow& row, btScalar error, btScalar least, btScalar most) {
            const Vec3 turn_a = row.angular ? row.along : Vec3(row.arm_a.cross(row.along));
            const Vec3 turn_b = row.angular ? row.along : Vec3(row.arm_b.cross(row.along));
            for (int k = 0; k < 3; ++k) {
                if (!row.angular) {
                    info->m_J1linearAxis[at + k] = row.along[k];
                    info->m_J2linearAxis[at + k] = -row.along[k];
                }
                info->m_J1angularAxis[at + k] = turn_a[k];
                info->m_J2angularAxis[at + k] = -turn_b[k];
            }
            const int row_number = at / info->rowskip;
            info->m_constraintError[at] = error * info->fps;
            info->m_lowerLimit[at] = least;
            info->m_upperLimit[at] = most;
            at = (row_number + 1) * info->rowskip;
        };
        // What is beyond comes back by a fifth a step, as hinges do.
        const auto room = [&](btScalar free) { return free > 0 ? free : info->erp * free; };
        const JointRows all = rows();
        for (const JointRow& row : all.all()) {
            if (!(row.lowest < row.highest)) {
                put(row, info->erp * row.value, -SIMD_INFINITY, SIMD_INFINITY);
                continue;
            }
            if (row.highest < unbounded) put(row, -room(row.highest - row.value), 0, SIMD_INFINITY);
            if (row.lowest > -unbounded) put(row, room(row.value - row.lowest), -SIMD_INFINITY, 0);
        }
    }

    void setParam(int, btScalar, int) override {}
    btScalar getParam(int, int) const override { return 0; }

private:
    static constexpr double unbounded = 1e8;

    static int limits(const JointRow& row)
    {
        return int(row.highest < unbounded) + int(row.lowest > -unbounded);
    }
    static Transform frame(const btRigidBody& body, const Eigen::Quaterniond& axes)
    {
        Transform at = Transform::Identity();
        at.translate(from_bullet(body.getCenterOfMassPosition()));
        at.rotate(from_bullet(body.getOrientation()) * axes.conjugate());
        return at;
    }
    JointRows rows() const
    {
        return joint_rows(joint_, to_world_ ? drawn_ : frame(m_rbA, axes_a_),
                          frame(m_rbB, axes_b_));
    }

    Joint joint_;
    Eigen::Quaterniond axes_a_, axes_b_;
    bool to_world_;
    Transform drawn_;
};

// One turn of dt seconds that keeps the angular momentum, by the spin in its middle.
void turn(const Limb& limb, double dt)
{
    btRigidBody& body = *limb.body;
    const btTransform start = body.getCenterOfMassTransform();
    const btVector3 own = body.getAngularVelocity() * start.getBasis();  // in the body's axes
    const btVector3 momentum = start.getBasis() * (own * limb.inertia);
    const btVector3 v = body.getLinearVelocity();
    btVector3 spin = body.getAngularVelocity();
    for (const double share : {0.5, 1.0}) {
        btTransform at;
        btTransformUtil::integrateTransform(start, v, spin, share * dt, at);
        body.setCenterOfMassTransform(at);
        spin = body.getInvInertiaTensorWorld() * momentum;
    }
    body.setAngularVelocity(spin);
}

}  // namespace

struct BulletBodies::World {
    std::vector<Limb> limbs;
    std::vector<std::size_t> first;  // limb of each part's first frame
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    btRigidBody told{0, nullptr, nullptr};  // stands for all frames that are no limbs
    Vec3 gravity = Vec3::Zero();            // m/s^2, with that of fields
    btSequentialImpulseConstraintSolver solver;
    std::vector<btCollisionObject*> objects;
    std::vector<btTypedConstraint*> constraints;

    bool moves(std::size_t part) const { return first[part] < first[part + 1]; }
    btRigidBody* body(std::size_t part, std::size_t frame)
    {
        return moves(part) ? limbs[first[part] + frame].body.get() : &told;
    }
};

BulletBodies::BulletBodies(const LayeredScene& scene, const LayeredWorld& world)
    : world_(std::make_unique<World>())
{
    world_->gravity = free_fall(world);
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const std::size_t first = world_->limbs.size();
        world_->first.push_back(first);
        const Base& base = scene.parts[b].body->base;
        if (base.kind != BaseKind::rigid) continue;
        for (std::size_t f = 0; f < base.frames.size(); ++f) {
            world_->limbs.push_back(make_limb(scene, b, f, world));
        }
        for (const Hinge& hinge : base.hinges) {
            world_->joints.push_back(std::make_unique<LimitedHinge>(
                hinge, world_->limbs[first + hinge.a], world_->limbs[first + hinge.b]));
        }
        for (const Joint& joint : base.joints) {
            const Limb* a = joint.a == Joint::world ? nullptr : &world_->limbs[first + joint.a];
            world_->joints.push_back(std::make_unique<RowJoint>(
                joint, a, world_->limbs[first + joint.b], world_->told, scene.parts[b].pose));
        }
    }
    world_->first.push_back(world_->limbs.size());
    for (const Limb& limb : world_->limbs) world_->objects.push_back(limb.body.get());
    for (const auto& joint : world_->joints) world_->constraints.push_back(joint.get());
}

BulletBodies::~BulletBodies() = default;

void BulletBodies::drift(LayeredScene& scene, double dt)
{
    for (const Limb& limb : world_->limbs) {
        turn(limb, dt);
        const btTransform& at = limb.body->getCenterOfMassTransform();
        LayeredState& state = scene.states[limb.part];
        state.position[limb.frame] = from_bullet(at.getOrigin());
        state.rotation[limb.frame] =
            (from_bullet(at.getRotation()) * limb.axes.conjugate()).normalized().coeffs();
        state.spin[limb.frame] = from_bullet(limb.body->getAngularVelocity());
    }
}

void BulletBodies::push(LayeredScene& scene, const LayeredMoment& moment,
                        const LayeredSystem& system, double share, double dt)
{
    if (world_->limbs.empty()) return;
    for (const Limb& limb : world_->limbs) {
        const Vec6 force = share * held_force(system, system.frame(limb.part, limb.frame));
        limb.body->clearForces();
        limb.body->applyDamping(0.5 * dt);
        limb.body->applyGravity();
        limb.body->applyCentralForce(to_bullet(force.head<3>()));
        limb.body->applyTorque(to_bullet(force.tail<3>()));
    }

    const std::vector<double> lag(scene.parts.size(), dt);

    // Each stop as a touching point of its own, without friction or bounce.
    std::vector<std::unique_ptr<btPersistentManifold>> stops;
    std::vector<btPersistentManifold*> manifolds;
    for (const LayerStop& stop : moment.contacts.stops) {
        if (!world_->moves(stop.body) && !world_->moves(stop.other)) continue;
        const std::uint32_t fa = scene.parts[stop.body].body->layer.frame[stop.skeleton];
        const std::uint32_t fb = scene.parts[stop.other].body->layer.frame[stop.other_skeleton];
        btRigidBody* a = world_->body(stop.body, fa);
        btRigidBody* b = world_->body(stop.other, fb);
        if (a == b) continue;
        // Frames that are told where to be come on, or leave.
        double room =
            stop_room(moment, stop, falls_together(scene, stop, world_->gravity, lag), dt);
        const auto closing = [&](std::size_t part, std::uint32_t f) {
            if (world_->moves(part)) return 0.0;
            const Twist& twist = moment.twists[part][f];
            const Vec3 arm = stop.position - moment.frames[part][f].translation();
            return dt * stop.normal.dot(twist.linear + twist.angular.cross(arm));
        };
        room += closing(stop.body, fa) - closing(stop.other, fb);
        btManifoldPoint point({}, {}, to_bullet(stop.normal), room);
        point.m_positionWorldOnA = point.m_positionWorldOnB = to_bullet(stop.position);
        constexpr double any = 1e30;  // how near they must be to count
        stops.push_back(std::make_unique<btPersistentManifold>(a, b, 0, any, any));
        stops.back()->addManifoldPoint(point);
        manifolds.push_back(stops.back().get());
    }

    btContactSolverInfo info;
    info.m_timeStep = dt;
    info.m_numIterations = 50;
    info.m_splitImpulse = 0;
    info.m_erp2 = 1;  // stop_room() has made its choice
    world_->solver.solveGroup(world_->objects.data(), static_cast<int>(world_->objects.size()),
                              manifolds.data(), static_cast<int>(manifolds.size()),
                              world_->constraints.data(),
                              static_cast<int>(world_->constraints.size()), info, nullptr, nullptr);
    for (const Limb& limb : world_->limbs) {
        limb.body->applyDamping(0.5 * dt);
        scene.states[limb.part].velocity[limb.frame] = from_bullet(limb.body->getLinearVelocity());
        scene.states[limb.part].spin[limb.frame] = from_bullet(limb.body->getAngularVelocity());
    }
}

}  // namespace physics
