#include "geometry/fields/polygonize.hpp"

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>
#include <numbers>
#include <optional>

namespace geometry {
namespace {

const std::vector<Transform> unmoved{Transform::Identity()};

ImplicitLayer balls(std::span<const Vec3> centres, const Contribution& contribution)
{
    ImplicitLayer layer;
    for (const Vec3& c : centres) {
        layer.skeletons.push_back({.kind = SkeletonKind::point, .points = {c}});
        layer.contributions.push_back(contribution);
        layer.frame.push_back(0);
    }
    return layer;
}

TriMesh mesh_of(const ImplicitLayer& layer, double cell)
{
    const Field field = make_field(layer, unmoved);
    return polygonize(iso_field(field), cell);
}

// How often each directed edge is used: a closed oriented manifold has each once, and its opposite.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges(const TriMesh& mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
    for (const Triangle& t : mesh.triangles()) {
        for (std::size_t i = 0; i < 3; ++i) ++count[{t[i], t[(i + 1) % 3]}];
    }
    return count;
}

void expect_closed_manifold(const TriMesh& mesh)
{
    const auto count = edges(mesh);
    int doubled = 0, open = 0;
    for (const auto& [edge, times] : count) {
        doubled += times != 1;
        open += !count.contains({edge.second, edge.first});
    }
    EXPECT_EQ(doubled, 0);
    EXPECT_EQ(open, 0);
}

double volume(const TriMesh& mesh)
{
    double sum = 0;
    for (const Triangle& t : mesh.triangles()) {
        const Vec3 a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                   c = mesh.positions[t[2]].cast<double>();
        sum += a.dot(b.cross(c)) / 6;
    }
    return sum;
}

}  // namespace

TEST(Polygonize, ASphereHasItsRadiusNormalsVolumeAndTopology)
{
    const std::vector<Vec3> centre{{0.123, 0.456, -0.2}};
    const TriMesh mesh = mesh_of(balls(centre, {0.5, 2, 1.0, 0}), 0.05);
    ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const Vec3 d = mesh.positions[i].cast<double>() - centre[0];
        EXPECT_NEAR(d.norm(), 0.5, 1e-7);  // floats
        EXPECT_GT(mesh.normals[i].cast<double>().dot(d) / d.norm(), 1 - 1e-6);
    }
    expect_closed_manifold(mesh);
    const std::size_t e = edges(mesh).size() / 2, f = mesh.triangles().size();
    EXPECT_EQ(mesh.positions.size() + f - e, 2u);  // Euler
    // Inscribed: the volume falls short by about (h / r)^2 / 2, h the cell: 0.5 %.
    const double exact = 4.0 / 3 * std::numbers::pi * 0.125;
    EXPECT_LT(volume(mesh), exact);
    EXPECT_NEAR(volume(mesh), exact, 0.01 * exact);
}

TEST(Polygonize, TheVolumeErrorFallsWithTheSquareOfTheCell)
{
    const std::vector<Vec3> centre{{0, 0, 0}};
    const auto error = [&](double cell) {
        return 4.0 / 3 * std::numbers::pi * 0.125 -
               volume(mesh_of(balls(centre, {0.5, 2, 1.0, 0}), cell));
    };
    EXPECT_NEAR(error(0.04) / error(0.02), 4, 0.4);
}

TEST(Polygonize, BlendedBallsGiveOneClosedSurfaceOnTheIsovalue)
{
    const std::vector<Vec3> centres{{0, 0, 0}, {0.7, 0.1, 0}, {0.3, 0.6, 0.2}};
    const ImplicitLayer layer = balls(centres, {0.4, 2, 1.0, 0});
    const Field field = make_field(layer, unmoved);
    const TriMesh mesh = polygonize(iso_field(field), 0.03);
    expect_closed_manifold(mesh);
    for (const Vec3f& p : mesh.positions) {
        EXPECT_NEAR(value_at(field, p.cast<double>()).f, 1, 1e-6);
    }
}

// Any values at all, far rougher than a field: signs drawn at random give every pattern of corners,
// every ambiguous face beside every other.
TEST(Polygonize, IsAManifoldWhateverTheSigns)
{
    const Random random(1);
    for (const double share : {0.2, 0.5, 0.8}) {
        IsoField noise;
        noise.domain.add(Vec3::Constant(1.5));
        noise.domain.add(Vec3::Constant(30.5));
        noise.bounds = [](const Box&) { return Interval{-1, 1}; };
        noise.ask = [&](const FieldBlock& block, BlockValues& values) {
            for (std::size_t i = 0; i < block.count; ++i) {
                const Vec3 p = block.point(i);
                const bool edge = (p.array() < 2).any() || (p.array() > 30).any();
                const auto key = static_cast<std::uint64_t>(p.x() + 64 * (p.y() + 64 * p.z()));
                values.f[i] = !edge && random.unit(key) < share ? 1 : -1;
                values.gx[i] = values.gy[i] = values.gz[i] = 0;
            }
        };
        const TriMesh mesh = polygonize(noise, 1.0);
        EXPECT_GT(mesh.triangles().size(), 10000u);
        expect_closed_manifold(mesh);
    }
}

TEST(Polygonize, FacesLookOutward)
{
    const std::vector<Vec3> centres{{0, 0, 0}, {0.7, 0.1, 0}};
    const TriMesh mesh = mesh_of(balls(centres, {0.4, 2, 1.0, 0}), 0.05);
    for (const Triangle& t : mesh.triangles()) {
        const Vec3f face = (mesh.positions[t[1]] - mesh.positions[t[0]])
                               .cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
        EXPECT_GT(face.dot(mesh.normals[t[0]]), 0);
    }
}

TEST(Polygonize, TrianglesAreWellShaped)
{
    const Random random(1);
    std::vector<Vec3> centres;
    for (std::uint64_t i = 0; i < 12; ++i) {
        centres.push_back(Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)));
    }
    const TriMesh mesh = mesh_of(balls(centres, {0.2, 4, 0.5, 0}), 0.04);
    for (const Triangle& t : mesh.triangles()) {
        const Vec3f a = mesh.positions[t[0]], b = mesh.positions[t[1]], c = mesh.positions[t[2]];
        const float area = (b - a).cross(c - a).norm() / 2;
        const float edges_sq =
            (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
        EXPECT_GT(4 * std::sqrt(3.f) * area / edges_sq, 0.15f);  // 1: equal sides
    }
}

TEST(Polygonize, SparseBlocksMissNothingThatAFullGridFinds)
{
    const Random random(3);
    std::vector<Vec3> centres;
    for (std::uint64_t i = 0; i < 12; ++i) {
        centres.push_back(Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)));
    }
    ImplicitLayer layer = balls(centres, {0.12, 8, 0.3, 0});
    const Field field = make_field(layer, unmoved);
    const IsoField sparse = iso_field(field);
    IsoField full = sparse;
    full.bounds = [](const Box&) { return Interval{-1, 1}; };
    const TriMesh a = polygonize(sparse, 0.02), b = polygonize(full, 0.02);
    EXPECT_EQ(a.triangles(), b.triangles());
    EXPECT_EQ(a.positions, b.positions);
}

TEST(Polygonize, TheSameBitsForAnyNumberOfThreads)
{
    const std::vector<Vec3> centres{{0, 0, 0}, {0.7, 0.1, 0}, {0.3, 0.6, 0.2}};
    std::vector<TriMesh> meshes;
    for (const std::size_t threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        meshes.push_back(mesh_of(balls(centres, {0.4, 2, 1.0, 0}), 0.05));
    }
    EXPECT_EQ(meshes[0].positions, meshes[1].positions);
    EXPECT_EQ(meshes[0].positions, meshes[2].positions);
    EXPECT_EQ(meshes[0].triangles(), meshes[2].triangles());
}

TEST(Polygonize, NothingGivesAnEmptyMeshAndBadCellsAnError)
{
    EXPECT_TRUE(mesh_of({}, 0.1).triangles().empty());
    const std::vector<Vec3> centre{{0, 0, 0}};
    const ImplicitLayer layer = balls(centre, {0.5, 2, 1.0, 0});
    EXPECT_THROW(mesh_of(layer, 0), std::invalid_argument);
    EXPECT_THROW(mesh_of(layer, -1), std::invalid_argument);
    EXPECT_THROW(mesh_of(layer, std::nan("")), std::invalid_argument);
    EXPECT_THROW(mesh_of(layer, 1e-9), std::invalid_argument);
    expect_closed_manifold(mesh_of(layer, 0.9));  // cells wider than the ball
}

TEST(Polygonize, ASurfaceThatLeavesTheDomainIsCutOpenThere)
{
    const std::vector<Vec3> centre{{0, 0, 0}};
    const ImplicitLayer layer = balls(centre, {0.5, 2, 1.0, 0});
    const Field field = make_field(layer, unmoved);
    IsoField half = iso_field(field);
    half.domain.hi.y() = 0;
    const TriMesh mesh = polygonize(half, 0.05);
    EXPECT_FALSE(mesh.triangles().empty());
    for (const Vec3f& p : mesh.positions) EXPECT_LT(p.y(), 0.1f);
}

// It stops long before it has made what it refuses, and what it proposes does fit.
TEST(Polygonize, MoreTrianglesThanAllowedAreRefusedWithCellsThatFit)
{
    const std::vector<Vec3> centre{{0.01, 0, 0}};
    const ImplicitLayer layer = balls(centre, {0.5, 2, 1.0, 0});
    const Field field = make_field(layer, unmoved);
    const IsoField iso = iso_field(field);
    const std::size_t triangles = polygonize(iso, 0.02).triangles().size();
    EXPECT_EQ(polygonize(iso, 0.02, triangles + 10).triangles().size(), triangles);
    const auto proposed = [&](double cell, std::size_t most) {
        try {
            polygonize(iso, cell, most);
        } catch (const std::invalid_argument& error) {
            const std::string text = error.what();
            const auto at = text.find("Use cells of ");
            EXPECT_NE(text.find("max_triangles = " + std::to_string(most)), std::string::npos);
            EXPECT_NE(at, std::string::npos) << text;
            return std::stod(text.substr(at + 13));
        }
        ADD_FAILURE() << "not refused";
        return 0.0;
    };
    for (const double cell : {0.02, 0.002, 2e-5}) {
        const double fits = proposed(cell, triangles / 2);
        EXPECT_NEAR(fits, 0.02 * std::sqrt(2), 0.15 * fits);
        EXPECT_LE(polygonize(iso, fits, triangles / 2).triangles().size(), triangles / 2);
    }
}

}  // namespace geometry
