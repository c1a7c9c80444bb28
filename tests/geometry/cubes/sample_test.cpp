#include "geometry/cubes/sample_volume.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <numbers>
#include <numeric>

namespace {

using geometry::FaceMatter;
using geometry::Inside;
using geometry::SampleMass;
using geometry::Samples;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;

FaceMatter of_density(double density = 1000)
{
    return {{}, {{.density = density}}, {}};
}

double total(const Samples& samples)
{
    return std::accumulate(samples.mass.begin(), samples.mass.end(), 0.0);
}

// The largest distance of a sample from the triangle that it says it is on, out of its plane and
// beyond its sides.
double worst_off(const TriMesh& mesh, const Samples& samples)
{
    double worst = 0;
    for (std::size_t i = 0; i < samples.positions.size(); ++i) {
        const auto& t = mesh.triangles()[samples.triangle[i]];
        const Vec3 a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                   c = mesh.positions[t[2]].cast<double>(), p = samples.positions[i].cast<double>();
        const Vec3 n = (b - a).cross(c - a).normalized();
        worst = std::max(worst, std::abs(n.dot(p - a)));
        for (const auto& [u, v] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
            worst = std::max(worst, -n.cross(v - u).normalized().dot(p - u));
        }
    }
    return worst;
}

TEST(SampleSurface, EveryFaceGetsItsShareAndNoMore)
{
    const TriMesh mesh = test_meshes::bumpy_sphere(2);
    constexpr std::size_t n = 20000;
    const Samples samples = sample_surface(mesh, of_density(), n, 5);
    ASSERT_EQ(samples.positions.size(), n);
    EXPECT_LT(worst_off(mesh, samples), 3e-7);  // single precision at size 1
    std::vector<std::size_t> count(mesh.triangles().size(), 0);
    for (const auto t : samples.triangle) ++count[t];
    const double area = sampled_area(mesh);
    for (std::size_t t = 0; t < count.size(); ++t) {
        const auto& [a, b, c] = mesh.triangles()[t];
        const double share = 0.5 *
                             (mesh.positions[b] - mesh.positions[a])
                                 .cross(mesh.positions[c] - mesh.positions[a])
                                 .norm() /
                             area;
        // Strips: a face holds all but two of its own wholly, and those two in part.
        EXPECT_NEAR(static_cast<double>(count[t]), share * n, 2.01);
    }
}

TEST(SampleSurface, IsEvenInsideAFaceToo)
{
    // A square of two triangles, 4096 points, 8 x 8 boxes of 64 expected each. Independent points
    // would scatter by 8; strips along and the golden ratio across leave far less.
    const TriMesh mesh =
        test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}});
    const Samples samples = sample_surface(mesh, of_density(), 4096, 1);
    std::array<double, 64> boxes{};
    for (const Vec3f& p : samples.positions) {
        const int x = std::min(static_cast<int>(p.x() * 8), 7),
                  y = std::min(static_cast<int>(p.y() * 8), 7);
        boxes[static_cast<std::size_t>(8 * y + x)] += 1;
    }
    double squares = 0;
    for (const double b : boxes) squares += (b - 64) * (b - 64);
    EXPECT_LT(std::sqrt(squares / 64), 4);
}

TEST(SampleSurface, MassIsAsAsked)
{
    TriMesh mesh = test_meshes::box({0, 0, 0}, {1, 1, 1});
    FaceMatter two{{}, {{.density = 1000}, {.density = 3000}}, {}};
    two.face.assign(12, 0);
    std::fill(two.face.begin() + 6, two.face.end(), std::uint16_t{1});
    SampleMass mass{SampleMass::By::density, 0, 0.01, 0};
    // Half of 6 m^2, a centimetre thick, of each; floats add up to 1e-7 of it.
    EXPECT_NEAR(total(sample_surface(mesh, two, 12000, 1, mass)), 30 + 90, 1e-3);
    // Without one, as thick as samples lie apart: sqrt(6 / 12000) m.
    mass.thickness = 0;
    EXPECT_NEAR(total(sample_surface(mesh, two, 12000, 1, mass)), 12000 * std::sqrt(6.0 / 12000),
                1e-2);
    mass = {SampleMass::By::surface_density, 0, 0, 2.5};
    EXPECT_NEAR(total(sample_surface(mesh, two, 12000, 1, mass)), 15, 1e-4);
    mass = {SampleMass::By::total, 7, 0.01, 0};
    const Samples shared = sample_surface(mesh, two, 12000, 1, mass);
    EXPECT_NEAR(total(shared), 7, 1e-4);
    for (std::size_t i = 0; i < shared.mass.size(); ++i) {
        EXPECT_NEAR(shared.mass[i], 7 * (shared.matter[i] ? 3 : 1) / 4.0 / 6000, 1e-8);
    }
}

TEST(SampleSurface, BlueNoiseKeepsItsDistance)
{
    const TriMesh mesh = test_meshes::icosphere(3);
    constexpr std::size_t n = 3000;
    const Samples samples = sample_surface_blue(mesh, of_density(), n, 3);
    ASSERT_EQ(samples.positions.size(), n);
    EXPECT_LT(worst_off(mesh, samples), 3e-7);
    double nearest = 10;
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            nearest =
                std::min(nearest, double((samples.positions[i] - samples.positions[j]).norm()));
        }
    }
    // Hexagons: area 2 / sqrt(3) r^2 ... of a packing: r_max = sqrt(2 A / (sqrt(3) n)).
    const double packing = std::sqrt(2 * 4 * std::numbers::pi / (std::sqrt(3.0) * n));
    EXPECT_GT(nearest, 0.66 * packing);
}

TEST(SampleVolume, FillsTheInsideEvenly)
{
    const TriMesh ball = test_meshes::icosphere(3);
    constexpr std::size_t n = 20000;
    const Samples samples = sample_volume(ball, of_density(500), Inside::winding, n, 2);
    ASSERT_EQ(samples.positions.size(), n);
    EXPECT_TRUE(samples.triangle.empty());
    std::array<double, 8> octants{};
    double inner = 0;
    for (const Vec3f& p : samples.positions) {
        EXPECT_LT(p.norm(), 1.02);
        inner += p.norm() < 0.5f;
        octants[static_cast<std::size_t>((p.x() > 0) + 2 * (p.y() > 0) + 4 * (p.z() > 0))] += 1;
    }
    // Independent points: sigma = sqrt(n / 8 * 7 / 8) = 47; strata do better.
    for (const double o : octants) EXPECT_NEAR(o, n / 8.0, 5 * 47);
    const double volume = volume_inside(ball, Inside::winding);
    EXPECT_NEAR(inner, n * (std::numbers::pi / 6) / volume, 5 * 47);
    EXPECT_NEAR(volume, 4 * std::numbers::pi / 3, 0.05);  // the polyhedron lacks 1 %
    EXPECT_NEAR(total(samples), 500 * volume, 1e-2);

    // A box's centre is that of its samples, but for the 2,800 or so of each 10,000 at its faces,
    // there or not by chance: sqrt(2,800) / 2 of them, half a box away, over twenty times 10,000
    // are 3e-4. Whichever are too many to be left at last are not those of one end.
    Vec3 centre = Vec3::Zero();
    for (std::size_t i = 0; i < 20; ++i) {
        const std::size_t count = 10'000 + 137 * i;
        const Samples many = sample_volume(test_meshes::box({0, 0, 0}, {1, 1, 1}), of_density(),
                                           Inside::winding, count, i);
        for (const Vec3f& p : many.positions) {
            centre += p.cast<double>() / (20 * static_cast<double>(count));
        }
    }
    EXPECT_LT((centre - Vec3::Constant(0.5)).cwiseAbs().maxCoeff(), 5 * 3e-4) << centre;
}

TEST(Sample, ASampleCubeIsACubeThatATriangleCrosses)
{
    const TriMesh mesh = test_meshes::bumpy_sphere(3);
    const auto grid = fit_grid(triangle_bounds(mesh), 0.1);
    const auto samples =
        sample_surface(mesh, of_density(), geometry::count_for_spacing(sampled_area(mesh), 0.1 / 6),
                       1, {.thickness = 0.01});
    const auto by_samples = voxelize_samples(samples, grid, {});
    const auto exact = voxelize_surface(mesh, of_density(), 0, grid, {});
    const geometry::CellIndex index(exact.cell);
    std::size_t outside = 0;
    for (const auto& c : by_samples.cell) outside += !index.find(c);
    EXPECT_EQ(outside, 0u);
    // 36 samples a cube's face on average: only cubes that hold a corner of it are missed.
    EXPECT_GT(static_cast<double>(by_samples.count()), 0.93 * static_cast<double>(exact.count()));
    EXPECT_NEAR(total(samples),
                std::accumulate(by_samples.mass.begin(), by_samples.mass.end(), 0.0),
                1e-6 * total(samples));
}

TEST(Sample, SaysWhatIsWrongAndTakesTheRest)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THROW(sample_surface({}, of_density(), 10, 1), std::invalid_argument);
    EXPECT_THROW(sample_surface_blue({}, of_density(), 10, 1), std::invalid_argument);
    EXPECT_THROW(sample_volume({}, of_density(), Inside::winding, 10, 1), std::invalid_argument);
    const TriMesh flat = test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
    EXPECT_THROW(sample_surface(flat, of_density(), 10, 1), std::invalid_argument);
    const TriMesh some =
        test_meshes::mesh_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}},
                             {{0, 0, 1}, {0, 1, 3}, {0, 1, 2}, {0, 1, 9}, {1, 1, 1}});
    for (const auto t : sample_surface(some, of_density(), 1000, 1).triangle) EXPECT_EQ(t, 2u);
    EXPECT_EQ(sample_surface_blue(some, of_density(), 1, 1).positions.size(), 1u);
    EXPECT_THROW(sample_volume(some, of_density(), Inside::winding, 10, 1), std::invalid_argument);
    TriMesh huge = test_meshes::icosphere(2);
    for (Vec3f& p : huge.positions) p *= 1e9f;
    EXPECT_EQ(sample_surface_blue(huge, of_density(), 100, 1).positions.size(), 100u);
    EXPECT_EQ(sample_volume(huge, of_density(), Inside::parity, 100, 1).positions.size(), 100u);
    EXPECT_THROW(geometry::count_for_spacing(1e9, 1e-6), std::invalid_argument);
}

// A prism over a pentagon whose caps are turned inside out: almost nothing is inside by winding,
// and samples as near as its volume asks took 7 minutes and 21 GB.
TEST(Sample, RefusesAVolumeThatIsTooSmallForItsSurface)
{
    std::vector<Vec3f> corners;
    std::vector<geometry::Triangle> faces;
    for (std::uint32_t i = 0; i < 5; ++i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / 5;
        for (const float z : {-1.0f, 1.0f}) {
            corners.emplace_back(std::cos(angle), std::sin(angle), z);
        }
        const std::uint32_t low = 2 * i, next = 2 * ((i + 1) % 5);
        faces.push_back({low, next, next + 1});
        faces.push_back({low, next + 1, low + 1});
    }
    for (std::uint32_t i = 1; i < 4; ++i) {
        faces.push_back({0, 2 * i, 2 * i + 2});
        faces.push_back({1, 2 * i + 3, 2 * i + 1});
    }
    for (std::uint32_t i = 0; i < 5; ++i) {  // fins, so that the caps are not turned back
        for (std::uint32_t end = 0; end < 2; ++end) {
            const std::uint32_t at = 2 * i + end, next = 2 * ((i + 1) % 5) + end;
            faces.push_back({at, next, static_cast<std::uint32_t>(corners.size())});
            corners.push_back(0.5f * (corners[at] + corners[next]) +
                              Vec3f(0, 0, end == 0 ? -0.01f : 0.01f));
        }
    }
    const TriMesh prism = test_meshes::mesh_of(corners, faces);
    const auto sample = [&](Inside rule) {
        return sample_volume(prism, of_density(), rule, 20000, 1).positions.size();
    };
    EXPECT_EQ(sample(Inside::parity), 20000u);
    try {
        sample(Inside::winding);
        FAIL() << "sampled a volume of " << volume_inside(prism, Inside::winding);
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("set inside = parity"), std::string::npos) << e.what();
    }
}

TEST(Sample, SameSeedSamePointsOnAnyNumberOfThreads)
{
    const TriMesh mesh = test_meshes::bumpy_sphere(4);
    std::vector<Vec3f> reference;
    for (const unsigned threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        auto now = sample_surface(mesh, of_density(), 50000, 9).positions;
        for (const auto& more :
             {sample_surface_blue(mesh, of_density(), 500, 9).positions,
              sample_volume(mesh, of_density(), Inside::winding, 500, 9).positions}) {
            now.insert(now.end(), more.begin(), more.end());
        }
        if (reference.empty()) reference = now;
        EXPECT_EQ(now, reference);
    }
    EXPECT_NE(sample_surface(mesh, of_density(), 100, 1).positions,
              sample_surface(mesh, of_density(), 100, 2).positions);
}

}  // namespace
