// Cubes whose stiffness is that of fine cubes within them: thin and tilted things.

#include "physics/modal/calibrate.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/brick_element.hpp"
#include "physics/modal/modes.hpp"
#include "physics/state/cube_mass.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace {

using namespace physics;
using geometry::Cubes;
using geometry::Vec3;
using geometry::Vec3i;

struct Made {
    geometry::TriMesh mesh;
    Eigen::Quaterniond turn;
    Cubes coarse, fine, calibrated;
    Report report;
};

// A turned box in cubes of `size`, with a corner of a cube at `origin`, and in fine ones.
Made made(const Vec3& box, const Eigen::Quaterniond& turn, double size, int ratio,
          const Vec3& origin)
{
    Made out;
    out.mesh = geometry::box(box, {1, 1, 1});
    out.turn = turn;
    for (auto& p : out.mesh.positions) p = (out.turn * p.cast<double>()).cast<float>();
    geometry::FaceMatter matter;
    matter.matters = {geometry::Matter{}};
    const auto cubes_of = [&](double edge) {
        return geometry::voxelize_solid(out.mesh, matter, geometry::Inside::winding, 0,
                                        {edge, origin, Vec3i::Zero()}, {});
    };
    out.coarse = cubes_of(size);
    out.fine = cubes_of(size / ratio);
    out.calibrated = calibrated(out.coarse, {out.fine, ratio}, {12}, out.report);
    return out;
}

// Turned about three axes.
Made made(const Vec3& box, double degrees, double size, int ratio)
{
    const double angle = degrees / 57.29577951308232;
    const Eigen::Quaterniond turn = Eigen::AngleAxisd(angle, Vec3::UnitZ()) *
                                    Eigen::AngleAxisd(angle, Vec3::UnitY()) *
                                    Eigen::AngleAxisd(angle, Vec3::UnitX());
    return made(box, turn, size, ratio, size * Vec3(0.37, 0.21, 0.11));
}

std::vector<double> frequencies(const Cubes& cubes, int count)
{
    ModeSettings settings;
    settings.count = count;
    std::vector<double> out;
    for (const double sq : lowest_modes(cubes, {}, settings).omega_sq) out.push_back(std::sqrt(sq));
    return out;
}

TEST(Calibrate, ATiltedPlateVibratesAsItsFineCubesDo)
{
    // Cubes as thick as the plate, and twice as thick: by fill 1.2 to 1.5 and up to 2.1 times too
    // fast. Six cubes by two have few modes.
    for (const auto& [ratio, within, modes] : {std::tuple{3, 0.03, 6}, std::tuple{6, 0.06, 3}}) {
        const Made m = made({2.4, 0.2, 0.8}, 20, 0.2 * ratio / 3, ratio);
        EXPECT_TRUE(m.report.converged);
        const auto fine = frequencies(m.fine, modes), coarse = frequencies(m.coarse, modes),
                   calibrated = frequencies(m.calibrated, modes);
        for (std::size_t k = 0; k < fine.size(); ++k) {
            EXPECT_NEAR(calibrated[k] / fine[k], 1, within) << ratio << " " << k;
        }
        EXPECT_GT(coarse[0] / fine[0], 1.25);
    }
}

TEST(Calibrate, ABeamAcrossCornersOfCubesIsNotSofterInOneDirection)
{
    // Along the diagonal of a layer of cubes. Without a share of K it bends 0.77 times as fast
    // within the layer and 1.06 times across it.
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(std::atan(1.0), Vec3::UnitZ()));
    const Made m = made({0.48, 0.03, 0.03}, turn, 0.03, 4, Vec3::Zero());
    const auto fine = frequencies(m.fine, 4), calibrated = frequencies(m.calibrated, 4);
    for (std::size_t k = 0; k < fine.size(); ++k) {
        EXPECT_NEAR(calibrated[k] / fine[k], 1, 0.06) << k;
    }
}

// A tilted stem, and soft leaves across it at its ends.
Made stem()
{
    Made out;
    geometry::FaceMatter matter;
    matter.matters = {geometry::Matter{}, geometry::Matter{}};
    matter.matters[1].young *= 1e-4;
    out.turn = Eigen::AngleAxisd(0.35, Vec3(1, 2, 3).normalized());
    std::vector<geometry::TriMesh> boxes;
    const auto add = [&](const Vec3& size, const Vec3& at, std::uint16_t of) {
        geometry::TriMesh& box = boxes.emplace_back(geometry::box(size, {1, 1, 1}));
        for (auto& p : box.positions) p = (out.turn * (p.cast<double>() + at)).cast<float>();
        matter.face.insert(matter.face.end(), box.triangles().size(), of);
    };
    add({2.4, 0.2, 0.2}, Vec3::Zero(), 0);
    for (int i = 0; i < 6; ++i) {
        add({0.1, i % 2 ? 0.05 : 1.2, i % 2 ? 1.2 : 0.05}, {-1.1 + 0.44 * i, 0, 0}, 1);
    }
    std::vector<const geometry::TriMesh*> parts;
    for (const auto& box : boxes) parts.push_back(&box);
    out.mesh = geometry::merge(parts);
    const auto cubes_of = [&](double edge) {
        return geometry::voxelize_solid(out.mesh, matter, geometry::Inside::winding, 0,
                                        {edge, Vec3::Zero(), Vec3i::Zero()}, {});
    };
    out.coarse = cubes_of(0.2);
    out.fine = cubes_of(0.05);
    out.calibrated = calibrated(out.coarse, {out.fine, 4}, {12}, out.report);
    return out;
}

// The lowest frequencies of the stem when its leaves weigh next to nothing.
std::vector<double> of_stem(Cubes cubes)
{
    const double young = *std::max_element(cubes.young.begin(), cubes.young.end());
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (cubes.young[c] < 0.1 * young) cubes.mass[c] *= 1e-6;
    }
    return frequencies(cubes, 4);
}

TEST(Calibrate, AStemIsAsStiffWhateverItsLeavesDo)
{
    // Its two lowest bends. Where every cube is made softer by what the leaves' vibrations are too
    // fast by, these are 0.78 and 0.84 times as fast.
    const Made m = stem();
    const auto fine = of_stem(m.fine), calibrated = of_stem(m.calibrated);
    for (std::size_t k = 0; k < 2; ++k) EXPECT_NEAR(calibrated[k] / fine[k], 1, 0.1) << k;
}

TEST(Calibrate, ElementsArePositiveAndResistNoRigidMotion)
{
    const Made m = made({1.6, 0.2, 0.8}, 20, 0.4, 6);
    ASSERT_FALSE(m.calibrated.elements.empty());
    Eigen::Matrix<double, 24, 6> rigid;
    for (unsigned a = 0; a < 8; ++a) {
        const Vec3 at(a & 1, a >> 1 & 1, a >> 2 & 1);
        for (int i = 0; i < 3; ++i) {
            rigid.block<3, 1>(3 * int(a), i) = Vec3::Unit(i);
            rigid.block<3, 1>(3 * int(a), 3 + i) = Vec3::Unit(i).cross(at);
        }
    }
    for (const auto& element : m.calibrated.elements) {
        const BrickMatrix k = stiffness_of(element);
        const Eigen::SelfAdjointEigenSolver<BrickMatrix> eigen(k);
        const double most = eigen.eigenvalues()[23];
        EXPECT_GT(eigen.eigenvalues()[0], -1e-6 * most);
        EXPECT_GT(eigen.eigenvalues()[6], 0);
        EXPECT_LT((k * rigid).cwiseAbs().maxCoeff(), 1e-13 * most);
    }
}

// The integral of the square of the distance from the box' middle plane, by its mass matrices.
double across(const Cubes& cubes, const Vec3& normal)
{
    const CubeMass usual = cube_mass_matrix();
    double sum = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const CubeMass mass = mass_of_cube(cubes, c, usual);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) {
                sum += cubes.mass[c] * mass[a][b] *
                       normal.dot(cubes.corner_position(cubes.corners[c][a])) *
                       normal.dot(cubes.corner_position(cubes.corners[c][b]));
            }
        }
    }
    return sum;
}

TEST(Calibrate, MassLiesWhereTheMaterialIs)
{
    // A plate of thickness t and mass m has m t^2 / 12 about its middle plane; cubes twice as thick
    // that are spread over all of themselves have several times that. Fine cubes of t / 3 still add
    // 2 / 3^2, as those of the two faces are partly filled.
    const Made m = made({1.6, 0.2, 0.8}, 20, 0.4, 6);
    const Vec3 normal = m.turn * Vec3::UnitY();
    const double mass = 1000 * 1.6 * 0.2 * 0.8, exact = mass * 0.2 * 0.2 / 12;
    EXPECT_NEAR(total_mass(m.calibrated), mass, 1e-4 * mass);
    EXPECT_NEAR(across(m.calibrated, normal), exact, 0.27 * exact);
    EXPECT_GT(across(m.coarse, normal), 3 * exact);
    const auto masses = corner_masses(m.calibrated);
    EXPECT_NEAR(std::accumulate(masses.begin(), masses.end(), 0.0), mass, 1e-4 * mass);
}

TEST(Calibrate, MassIsKeptWhereCubesAreLighterThanAnyMayBe)
{
    // A least share of 0.3 made slivers of the ball's cubes heavier, and full cubes lighter.
    const auto mesh = geometry::icosphere(0.5, 4);
    const auto cubes_of = [&](double edge, double min_fill) {
        return geometry::voxelize_solid(
            mesh, {{}, {{.density = 1000}}, {}}, geometry::Inside::winding, 0,
            {edge, Vec3::Constant(-0.6), Vec3i::Zero()}, {.min_fill = min_fill, .total_mass = 10});
    };
    const Cubes coarse = cubes_of(0.3, 0.3), fine = cubes_of(0.3 / 4, 1e-3);
    ASSERT_NEAR(total_mass(coarse), 10, 1e-9);
    Report report;
    const Cubes out = calibrated(coarse, {fine, 4}, {4}, report);
    EXPECT_FALSE(out.elements.empty());
    EXPECT_NEAR(total_mass(out), 10, 1e-9);
    // A cube all inside has the density of the ball.
    const double density = 10 / geometry::enclosed_volume(mesh);
    const std::size_t middle = geometry::nearest_cube(out, Vec3::Constant(-0.15)).cube;
    EXPECT_NEAR(out.mass[middle], density * 0.027, 0.01 * density * 0.027);
}

TEST(Calibrate, FullCubesKeepTheirStiffness)
{
    geometry::FaceMatter matter;
    matter.matters = {geometry::Matter{}};
    const auto mesh = geometry::box({0.4, 0.2, 0.2}, {1, 1, 1});
    const auto cubes_of = [&](double edge) {
        return geometry::voxelize_solid(
            mesh, matter, geometry::Inside::winding, 0,
            {edge, Vec3(-0.2, -0.1, -0.1), Vec3i(4, 2, 2) * int(0.1 / edge + 0.5)}, {});
    };
    Report report;
    const Cubes fine = cubes_of(0.05), coarse = cubes_of(0.1);
    const Cubes out = calibrated(coarse, {fine, 2}, {4}, report);
    EXPECT_EQ(coarse.count(), 16u);
    EXPECT_TRUE(out.own.empty());
    EXPECT_TRUE(out.elements.empty());
}

TEST(Calibrate, WhatHangsByAnEdgeHidesNothing)
{
    // A plate with a cube that hangs at its end by one edge, and turns there at no cost: the plate
    // gets the stiffness that it has without that.
    const Made m = made({1.6, 0.2, 0.8}, 20, 0.2, 3);
    const auto end = std::max_element(m.fine.cell.begin(), m.fine.cell.end(),
                                      [](auto& a, auto& b) { return a.y() < b.y(); });
    std::vector<Vec3i> cells = m.fine.cell;
    cells.push_back(*end + Vec3i(1, 1, 0));
    Cubes fine = geometry::solid_cubes(cells, m.fine.size, geometry::Matter{}, m.fine.origin);
    std::size_t next = 0;
    for (std::size_t f = 0; f < fine.count(); ++f) {  // both are in order
        if (next == m.fine.count() || fine.cell[f] != m.fine.cell[next]) continue;
        fine.fill[f] = m.fine.fill[next];
        fine.mass[f] = m.fine.mass[next++];
    }
    ASSERT_EQ(next, m.fine.count());
    Report report;
    const Cubes out = calibrated(m.coarse, {fine, 3}, {12}, report);
    EXPECT_TRUE(report.converged);
    const auto with = frequencies(out, 3), without = frequencies(m.calibrated, 3);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(with[k] / without[k], 1, 0.02);
}

TEST(Calibrate, CubesThatDoNotFitAreRefused)
{
    const Made m = made({0.8, 0.2, 0.4}, 0, 0.2, 2);
    const Cubes few = kept(m.coarse, [&] {
        std::vector<std::uint8_t> keep(m.coarse.count(), 1);
        std::fill_n(keep.begin(), keep.size() / 2, 0);
        return keep;
    }());
    Report report;
    EXPECT_THROW(calibrated(few, {m.fine, 2}, {4}, report), std::invalid_argument);
    Cubes broken = m.coarse;
    broken.own.assign(broken.count(), 1000);
    EXPECT_THROW(lowest_modes(broken, {}, {}), std::invalid_argument);
}

}  // namespace
