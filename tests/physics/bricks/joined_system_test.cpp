// Rigid and elastic parts that touch, solved at once, against the products of their whole matrix.

#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/joined_system.hpp"
#include "physics/bricks/rigid_system.hpp"
#include "physics/state/state.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <random>

namespace physics {
namespace {

using geometry::Cubes;

constexpr double tau = 1.0 / 24;

Cubes box_at(const Vec3& origin, int nx, int ny, int nz, double h, double young)
{
    Cubes out = fixtures::box(nx, ny, nz, h, {.young = young});
    out.origin = origin;
    return out;
}

// An elastic board on which two rigid boxes lie, and a third that touches nothing.
struct Scene {
    Scene()
        : board(box_at(Vec3::Zero(), 6, 1, 2, 0.1, 1e6)),
          one(box_at({0, 0.1, 0}, 1, 2, 2, 0.1, 1e8)),
          other(box_at({0.4, 0.1, 0}, 2, 1, 1, 0.1, 1e8)),
          apart(box_at({0, 1, 0}, 1, 1, 1, 0.1, 1e8)),
          body(make_bricks(BodyModels(std::vector<BodyModel>{{&board}, {&one}, {&other}, {&apart}}),
                           {.contact = {}, .rigid = {0, 1, 1, 1}})),
          elasticity(body), rigid(body.base), n(4 * body.base.corners), fixed(n, 0), mass(n, 0)
    {
        for (std::size_t k = 0; k < body.base.corners; ++k) {
            for (std::size_t i = 0; i < 3; ++i) mass[4 * k + i] = body.base.mass[k];
        }
        Aligned<double> f(elasticity.room(), 0);
        elasticity.forces(body.base.rest.data(), f.data());
        elasticity.weigh(tau * tau, 0);
        rigid.look_at(body.base.rest.data());
    }

    std::uint32_t slot(std::uint32_t corner) const
    {
        return static_cast<std::uint32_t>(body.base.slot_of(corner));
    }

    // Between the middles of two cubes.
    void touch(std::uint32_t cube, std::uint32_t cube_of_rigid, double stiffness)
    {
        PointContact contact;
        contact.count = 16;
        for (std::size_t a = 0; a < 8; ++a) {
            contact.corners[a] = slot(body.rest->corners[cube][a]);
            contact.corners[8 + a] = slot(body.rest->corners[cube_of_rigid][a]);
            contact.weight[a] = 0.125f, contact.weight[8 + a] = -0.125f;
        }
        contact.stiffness = {0.1 * stiffness, 0, 0, stiffness, 0, 0.1 * stiffness};
        points.push_back(contact);
        ContactBlock<double> block{};
        block.count = 16;
        for (std::size_t a = 0; a < 16; ++a) {
            block.corners[a] = contact.corners[a], block.weight[a] = double(contact.weight[a]);
        }
        for (std::size_t i = 0; i < 6; ++i) block.matrix[i] = tau * tau * contact.stiffness[i];
        contacts.push_back(block);
    }

    // The factor of what is elastic, with its side of the contacts where `whole`.
    DirectFactor factor(bool whole) const
    {
        std::vector<BrickMatrix> cubes;
        EXPECT_TRUE(elasticity.cube_matrices(cubes));
        for (const PointContact& contact : points) {
            PointContact side = contact;
            side.count = 8;
            geometry::Mat3 block = geometry::Mat3::Zero();
            for (int i = 0; i < 3; ++i) {
                block(i, i) = tau * tau * contact.stiffness[std::array{0u, 3u, 5u}[std::size_t(i)]];
            }
            if (whole) elasticity.add_contact(side, block, cubes);
        }
        std::vector<std::uint32_t> out;
        for (std::uint32_t k = 0; k < body.base.corners; ++k) {
            if (rigid.of_corner(slot(k)) != RigidBodies::not_rigid) out.push_back(k);
        }
        std::vector<std::uint8_t> held(body.base.corners, 0);
        for (std::uint32_t k = 0; k < body.base.corners; ++k) {
            for (std::uint32_t i = 0; i < 3; ++i) {
                if (fixed[4 * slot(k) + i] != 0) held[k] = std::uint8_t(held[k] | 1u << i);
            }
        }
        auto made =
            DirectFactor::make(elasticity.dissection(out), cubes, mass, body.base.slot, held);
        EXPECT_TRUE(made);
        return std::move(*made);
    }

    RigidSystem alone() const
    {
        RigidSystem out;
        const auto multiply = [&](const double* p, double* y) { elasticity.multiply(p, y); };
        out.look(rigid, multiply, elasticity.room(), mass);
        out.make(contacts);
        return out;
    }

    // A z, of rigid parts as it counts there.
    Aligned<double> times(const Aligned<double>& z) const
    {
        Aligned<double> y(elasticity.room(), 0);
        elasticity.multiply(z.data(), y.data());
        y.resize(n);
        for (const auto& contact : contacts) contact.add_times(z.data(), y.data());
        for (std::size_t i = 0; i < n; ++i) y[i] += mass[i] * z[i];
        rigid.even_out(y.data());
        return y;
    }

    Cubes board, one, other, apart;
    BricksBody body;
    BrickElasticity elasticity;
    RigidBodies rigid;
    std::size_t n;
    Aligned<double> fixed, mass;
    std::vector<PointContact> points;
    std::vector<ContactBlock<double>> contacts;
};

TEST(JoinedSystem, SolvesRigidPartsAndWhatTheyTouchAtOnce)
{
    Scene scene;
    scene.fixed[4 * scene.slot(3) + 1] = 1;
    const auto first = static_cast<std::uint32_t>(scene.board.cell.size());
    for (const std::uint32_t cube : {0u, 6u}) scene.touch(cube, first, 1e7);
    const auto of_other = static_cast<std::uint32_t>(first + scene.one.cell.size());
    for (const std::uint32_t cube : {4u, 5u}) scene.touch(cube, of_other, 1e7);
    const RigidSystem alone = scene.alone();
    DirectFactor factor = scene.factor(true);
    JoinedSystem joined;
    ASSERT_TRUE(joined.make(scene.rigid, alone.blocks(), scene.contacts, scene.fixed, factor));
    std::mt19937 random(3);
    std::normal_distribution<double> any;
    Aligned<double> r(scene.n, 0), z(scene.n, 0);
    for (std::size_t i = 0; i < scene.n; ++i) {
        if (i % 4 < 3 && scene.fixed[i] == 0) r[i] = any(random);
    }
    scene.rigid.even_out(r.data());
    factor.solve(r.data(), z.data());
    for (std::size_t i = 0; i < scene.n; ++i) z[i] *= 1 - scene.fixed[i];
    joined.join(r.data(), z.data());
    const Aligned<double> again = scene.times(z);
    for (std::size_t i = 0; i < scene.n; ++i) {
        if (scene.fixed[i] != 0) continue;
        EXPECT_NEAR(again[i], r[i], 1e-8) << i;
    }
}

TEST(JoinedSystem, IsNotReadyWhereNothingElasticTouchesOrItWouldNotBePositive)
{
    Scene scene;
    JoinedSystem joined;
    DirectFactor factor = scene.factor(true);
    EXPECT_FALSE(
        joined.make(scene.rigid, scene.alone().blocks(), scene.contacts, scene.fixed, factor));
    scene.touch(0, static_cast<std::uint32_t>(scene.board.cell.size()), 1e9);
    DirectFactor without = scene.factor(false);
    EXPECT_FALSE(
        joined.make(scene.rigid, scene.alone().blocks(), scene.contacts, scene.fixed, without));
    EXPECT_FALSE(joined.ready());
    DirectFactor with = scene.factor(true);
    EXPECT_TRUE(
        joined.make(scene.rigid, scene.alone().blocks(), scene.contacts, scene.fixed, with));
    EXPECT_TRUE(joined.ready());
}

}  // namespace
}  // namespace physics
