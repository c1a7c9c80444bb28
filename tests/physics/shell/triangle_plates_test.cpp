// Plates and strips of triangles against closed forms, on regular meshes and on irregular ones.

#include "geometry/mesh/primitive.hpp"
#include "physics/shell/triangle_elasticity.hpp"
#include "tests/physics/shell/triangle_fixtures.hpp"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace physics;
using namespace fixtures;

namespace {

constexpr double plate_thickness = 0.01, plate_young = 1e6, plate_density = 1000;
constexpr Cut all_cuts[] = {Cut::alike, Cut::in_turns, Cut::random};

double stiffness_of_plate(double nu)
{
    return plate_young * std::pow(plate_thickness, 3) / (12 * (1 - nu * nu));
}

double lowest_sag(const Cubes& cubes, const State& state)
{
    double most = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        most = std::max(most, cubes.corner_position(k).y() - state.x[k].y());
    }
    return most;
}

// w D / (q a^4) of a unit square plate of n squares a side under its weight, hinged at its border
// or clamped by a rim of squares around it.
double sag_of_triangles(int n, Cut cut, bool clamped, double nu = 0.3)
{
    const double acceleration = 1e-4;
    const Cubes cubes =
        sheet_of(squares({n, n, 1.0 / n, cut, 0.3, clamped ? 1 : 0}), plate_thickness, nu);
    const ShellBody body = make_shell(cubes);
    Loads loads;
    loads.pins = held_at(cubes, [](const Vec3& p) {
        return std::min({p.x(), p.z(), 1 - p.x(), 1 - p.z()}) < 1e-6;
    });
    loads.forces = {weight({0, -acceleration, 0})};
    const State state = settled(body, loads);
    EXPECT_TRUE(state.report.converged) << state.report.residual;
    return lowest_sag(cubes, state) * stiffness_of_plate(nu) /
           (plate_density * plate_thickness * acceleration);
}

}  // namespace

// Timoshenko, Woinowsky-Krieger. Theory of plates and shells. 1959, tables 8 and 35.
TEST(TrianglePlates, SagUnderEvenPressureOnAnyMesh)
{
    for (const Cut cut : all_cuts) {
        EXPECT_NEAR(sag_of_triangles(16, cut, false), 0.004062, 0.03 * 0.004062) << int(cut);
        EXPECT_NEAR(sag_of_triangles(32, cut, true), 0.0012653, 0.03 * 0.0012653) << int(cut);
    }
}

TEST(TrianglePlates, TwistAsTheirStiffnessSaysOnAnyMesh)
{
    // Three corners held and a force at the fourth: an even twist, w = P L^2 / (2 (1 - nu) D).
    for (const Cut cut : all_cuts) {
        const double nu = 0.3, force = 1e-5;
        const Cubes cubes = sheet_of(squares({8, 8, 0.125, cut}), plate_thickness, nu);
        const ShellBody body = make_shell(cubes);
        Loads loads;
        const auto at_end = [](double v) { return std::abs(v) < 1e-6 || std::abs(v - 1) < 1e-6; };
        loads.pins = held_at(cubes, [&](const Vec3& p) {
            return at_end(p.x()) && at_end(p.z()) && p.x() + p.z() < 1.5;
        });
        Force pull;
        pull.kind = Force::Kind::point;
        pull.position = {1, 0, 1};
        pull.radius = 1e-3;
        pull.force = {0, -force, 0};
        loads.forces = {pull};
        const State state = settled(body, loads);
        EXPECT_NEAR(lowest_sag(cubes, state) * 2 * (1 - nu) * stiffness_of_plate(nu) / force, 1,
                    1e-3)
            << int(cut);
    }
}

TEST(TrianglePlates, AStripHangsAsTheHeavyElasticaDoes)
{
    // As in ShellPlates: q b L^3 / E I = 10.
    constexpr int n = 20;
    for (const Cut cut : all_cuts) {
        const Cubes cubes =
            sheet_of(squares({n - 1, 0, 1.0 / n, cut, 0.25, 1}), plate_thickness, 0);
        const ShellBody body = make_shell(cubes);
        Loads loads;
        loads.pins = held_at(cubes, [](const Vec3& p) { return p.x() < 1e-6; });
        const double stiffness = plate_young * std::pow(plate_thickness, 3) / 12;
        loads.forces = {weight({0, -10 * stiffness / (plate_density * plate_thickness), 0})};
        const State state = settled(body, loads);
        EXPECT_TRUE(state.report.converged) << state.report.residual;
        Vec3 end = Vec3::Zero();
        int count = 0;
        for (std::size_t k = 0; k < state.x.size(); ++k) {
            if (cubes.corner_position(k).x() < 1 - 1e-6) continue;
            end += state.x[k];
            ++count;
        }
        EXPECT_NEAR(end.x() / count, 0.65635, 0.007) << int(cut);
        EXPECT_NEAR(end.y() / count, -0.70020, 0.007) << int(cut);
    }
}

TEST(TrianglePlates, AQuarterOfARingBendsAsACurvedBeamDoes)
{
    // Clamped at one end, a force F along the tangent there at the other: pi F R^3 / (4 E I).
    constexpr int n = 16;
    constexpr double force = 1e-7;
    for (const Cut cut : all_cuts) {
        const double a = std::numbers::pi / 2 / n;
        const Squares s{n - 1, 2, a, cut, 0.25, 1};
        const Cubes cubes =
            sheet_of(squares(s, [](double along,
                                   double z) { return Vec3(std::cos(along), std::sin(along), z); }),
                     plate_thickness, 0);
        const ShellBody body = make_shell(cubes);
        Loads loads;
        loads.pins = held_at(cubes, [](const Vec3& p) { return p.y() < 1e-6; });
        const auto end = held_at(cubes, [](const Vec3& p) { return p.x() < 1e-6; });
        for (const auto k : end.corner) {
            Force& pull = loads.forces.emplace_back();
            pull.kind = Force::Kind::point;
            pull.position = cubes.corner_position(k);
            pull.radius = 1e-3 * a;
            pull.force = {0, -force / double(end.corner.size()), 0};
        }
        const State state = settled(body, loads);
        double down = 0;
        for (const auto k : end.corner) down += cubes.corner_position(k).y() - state.x[k].y();
        const double width = a * (s.nj + 2);
        const double stiffness = plate_young * width * std::pow(plate_thickness, 3) / 12;
        EXPECT_NEAR(down / double(end.corner.size()) * 4 * stiffness / (std::numbers::pi * force),
                    1, 0.02)
            << int(cut);
    }
}

TEST(TrianglePlates, ATubeIsAsStiffBetweenTwoForcesAsARing)
{
    // Two forces F against each other across it: it gives way by (pi / 4 - 2 / pi) F R^3 / (E I).
    constexpr int around = 80, along = 8;
    geometry::TriMesh mesh = geometry::cylinder(1, 0.6, around, along);
    const Cubes cubes = [&] {
        auto open = std::make_shared<geometry::MeshTopology>();
        for (const auto& t : mesh.triangles()) {
            const auto high = [&](std::size_t i) { return std::abs(mesh.positions[t[i]].y()); };
            const bool cap = std::min({high(0), high(1), high(2)}) > 0.29f;
            if (!cap) open->triangles.push_back(t);
        }
        mesh.topology = open;
        mesh.normals.clear();
        return sheet_of(mesh, plate_thickness, 0);
    }();
    const ShellBody body = make_shell(cubes);
    constexpr double force = 1e-7;
    Loads loads;
    for (const double side : {-1.0, 1.0}) {
        const auto line = held_at(cubes, [&](const Vec3& p) { return side * p.x() > 1 - 1e-6; });
        ASSERT_EQ(line.corner.size(), std::size_t(along + 1));
        for (std::size_t i = 0; i < line.corner.size(); ++i) {
            Force& push = loads.forces.emplace_back();
            push.kind = Force::Kind::point;
            push.position = cubes.corner_position(line.corner[i]);
            push.radius = 1e-3;
            push.force = {-side * force / (along + 1), 0, 0};
        }
    }
    // Held as a whole alone.
    loads.pins = held_at(cubes, [](const Vec3& p) {
        return p.norm() < 1.01 && p.z() > 1 - 1e-6 && std::abs(p.y()) < 1e-6;
    });
    ASSERT_EQ(loads.pins.corner.size(), 1u);
    const State state = settled(body, loads);
    double wide = 0;
    int count = 0;
    for (std::size_t k = 0; k < state.x.size(); ++k) {
        const double x = cubes.corner_position(k).x();
        if (std::abs(x) < 1 - 1e-6) continue;
        wide += std::copysign(1.0, x) * (x - state.x[k].x());
        ++count;
    }
    const double stiffness = plate_young * 0.6 * std::pow(plate_thickness, 3) / 12;
    EXPECT_NEAR(2 * wide / count * stiffness / force, std::numbers::pi / 4 - 2 / std::numbers::pi,
                0.02 * 0.149);
}

TEST(TrianglePlates, AStripBucklesAtEulersLoad)
{
    // As in ShellPlates: hinged at both ends, P = pi^2 E I / L^2, pressed evenly by a strain.
    constexpr int n = 20;
    constexpr double nu = 0.3;
    const double euler = std::pow(std::numbers::pi * plate_thickness, 2) / 12;
    for (const Cut cut : all_cuts) {
        const Cubes cubes = sheet_of(squares({n, 2, 1.0 / n, cut, 0.25}), plate_thickness, nu);
        const ShellBody body = make_shell(cubes);
        const Pins pins =
            held_at(cubes, [](const Vec3& p) { return p.x() < 1e-6 || p.x() > 1 - 1e-6; });
        std::vector<std::size_t> free;
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (!std::binary_search(pins.corner.begin(), pins.corner.end(), k)) free.push_back(k);
        }
        double low = 0, high = 3 * euler;
        for (int i = 0; i < 12; ++i) {
            const double strain = (low + high) / 2;
            TriangleElasticity elasticity(body, pins);
            elasticity.use_hessian(true);
            Aligned<double> x = body.base.rest, f(body.base.numbers), p(body.base.numbers, 0), y(p);
            for (std::size_t k = 0; k < body.base.corners; ++k) {
                x[4 * k] *= 1 - strain;
                x[4 * k + 2] *= 1 + nu * strain;
            }
            elasticity.forces(x.data(), f.data());
            Eigen::MatrixXd across(free.size(), free.size());
            for (std::size_t a = 0; a < free.size(); ++a) {
                p[4 * free[a] + 1] = 1;
                elasticity.multiply(p.data(), y.data());
                p[4 * free[a] + 1] = 0;
                for (std::size_t b = 0; b < free.size(); ++b) {
                    across(Eigen::Index(b), Eigen::Index(a)) = y[4 * free[b] + 1];
                }
            }
            const Eigen::LLT<Eigen::MatrixXd> factor(across);
            (factor.info() == Eigen::Success ? low : high) = strain;
        }
        EXPECT_NEAR(low / euler, 1, 0.03) << int(cut);
    }
}
