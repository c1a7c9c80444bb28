// Contacts of surfaces that several frames carry.

#include "physics/layered_bodies/contact_rows.hpp"

#include "tests/physics/layered_bodies/layered_fixtures.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace physics::contact_rows_test {
namespace {

using namespace layered_fixtures;

constexpr double g = 9.81;

// Two balls on frames of their own, that blend.
LayeredBody blended(const Vec3& a, const Vec3& b, double stiffness)
{
    ImplicitLayer layer = soft_layer({point(a), point(b)}, true);
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    layer.blend.links = {{0, 1, 1}};
    LayeredBody body = make_layered_body(layer, BaseKind::rigid, 1000, 0.03);
    body.matter.stiffness = stiffness;
    return body;
}

// J, of motion and height of body 0.
double energy(const LayeredScene& scene)
{
    const Base& base = scene.parts[0].body->base;
    const LayeredState& state = scene.states[0];
    double sum = 0;
    for (std::size_t f = 0; f < base.mass.size(); ++f) {
        const geometry::Mat3 R = Eigen::Quaterniond(state.rotation[f]).toRotationMatrix();
        const Vec3 spin = R.transpose() * state.spin[f];
        sum += base.mass[f] * (0.5 * state.velocity[f].squaredNorm() + g * state.position[f].y()) +
               0.5 * spin.dot(base.inertia[f] * spin);
    }
    return sum;
}

}  // namespace

// A floor cuts the blend of a ball and one above it: both are pushed, the near one more; together
// by as much as one is.
TEST(ContactRows, AllThatBlendsAtAContactIsPushed)
{
    const LayeredScene scene = scene_of({blended({0, 0.08, 0}, {0.05, 0.2, 0}, 1e6), floor_at(0)});
    const LayeredMoment moment(scene);
    const LayeredSystem system = make_system(scene, moment, 0.01);
    ASSERT_FALSE(moment.contacts.contacts.empty());
    bool several = false;
    for (const LayerContact& contact : moment.contacts.contacts) {
        const ContactRows pushed = contact_rows(scene, moment, system, contact);
        Vec6 own = Vec6::Zero();  // about the world's origin
        for (const FrameRow& row : pushed.rows) {
            if (row.body != 0) continue;
            const Vec3 force = row.along.head<3>(), torque = row.along.tail<3>();
            own.head<3>() += force;
            own.tail<3>() += torque + scene.states[0].position[row.frame].cross(force);
        }
        Vec6 expected;
        expected << -contact.normal, -contact.position.cross(contact.normal);
        EXPECT_LT((own - expected).norm(), 1e-12);
        if (!pushed.blended) continue;
        several = true;
        ASSERT_EQ(pushed.rows.size(), 3u);
        EXPECT_GT(pushed.rows[0].along.y(), pushed.rows[1].along.y());
        EXPECT_GT(pushed.rows[1].along.y(), 0);
    }
    EXPECT_TRUE(several);
}

// The upper one presses the layer that both share while it falls. Pushed by none for that, it left
// the work to the lower one, which flew up to seven times as high as it began.
TEST(ContactRows, FramesThatBlendGainNoEnergy)
{
    for (const RigidBodies solver : {RigidBodies::implicit, RigidBodies::bullet}) {
        LayeredScene scene = scene_of({blended({0, 0.3, 0}, {0.15, 0.35, 0}, 1e7), floor_at(0)});
        const double began = energy(scene);
        double most = began;
        for (int frame = 0; frame < 72; ++frame) {
            scene = advance(scene, scene.parts, {.rigid_bodies = solver}, 1.0 / 24, 2);
            most = std::max(most, energy(scene));
        }
        EXPECT_LT(most, 1.05 * began) << (solver == RigidBodies::bullet);
    }
}

// Steps get shorter while a layer bounces. A joint that a long step left open is not closed in one
// of those: it would throw the limbs apart, with ten times their energy.
TEST(ContactRows, JointsDoNotThrowLimbsWhereStepsGetShort)
{
    LayeredBody body = blended({0, 0.3, 0}, {0.15, 0.35, 0}, 1e8);
    add_joint(body.base, JointKind::ball, 0, 1, {0.075, 0.325, 0}, Vec3::UnitY());
    LayeredScene scene = scene_of({body, floor_at(0)});
    const double began = energy(scene);
    double most = began;
    for (int frame = 0; frame < 72; ++frame) {
        scene = advance(scene, scene.parts, {}, 1.0 / 24, 2);
        most = std::max(most, energy(scene));
    }
    EXPECT_LT(most, 1.2 * began);
}

}  // namespace physics::contact_rows_test
