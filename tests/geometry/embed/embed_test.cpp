#include "geometry/embed/embed.hpp"

#include "geometry/cubes/components.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/embed/carried_numbers.hpp"
#include "tests/geometry/meshes.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace {

using geometry::bind;
using geometry::Binding;
using geometry::Cubes;
using geometry::embed;
using geometry::Mat3;
using geometry::Random;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;

// A ball with a normal at each vertex, and cubes around it.
struct Scene {
    TriMesh mesh = test_meshes::icosphere(3);
    Cubes cubes;
    Scene()
    {
        mesh.normals = mesh.positions;
        cubes =
            voxelize_surface(mesh, {{}, {{}}, {}}, 0, fit_grid(triangle_bounds(mesh), 0.17), {});
    }
};

std::vector<Vec3> moved(const Cubes& cubes, const Mat3& m, const Vec3& t)
{
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p = m * p + t;
    return x;
}

Vec3 random_vector(const Random& random, std::uint64_t i)
{
    return 2 * Vec3(random.unit(3 * i), random.unit(3 * i + 1), random.unit(3 * i + 2)) -
           Vec3::Ones();
}

TEST(Embed, AffineMotionOfTheCubesIsThatOfTheMesh)
{
    Scene s;
    // Strays too: vertices outside, one of the ball's own and a piece with none inside.
    s.mesh.positions[5] *= 1.8f;
    const TriMesh mesh = [&] {
        TriMesh far = test_meshes::box({3, 3, 3}, {3.5, 3.2, 3.1});
        TriMesh out = test_meshes::both(s.mesh, far);
        for (std::size_t v = 0; v < out.positions.size(); ++v) {
            out.normals.push_back(v < s.mesh.normals.size() ? s.mesh.normals[v] : Vec3f(0, 1, 0));
        }
        return out;
    }();
    Mat3 m;
    m << 0.9, 0.4, -0.2, -0.3, 1.1, 0.25, 0.3, -0.1, 0.8;
    const Vec3 t(3, -2, 1);
    const Binding binding = bind(mesh, s.cubes);
    EXPECT_EQ(binding.strays.size(), 9u);
    const TriMesh out = embed(binding, mesh, s.cubes, moved(s.cubes, m, t));
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const Vec3 p = m * mesh.positions[v].cast<double>() + t;
        // Floats of size 5, of sums of eight terms; a far stray's weights are some 20.
        EXPECT_NEAR((out.positions[v].cast<double>() - p).norm(), 0,
                    v < 642 && v != 5 ? 3e-6 : 5e-5);
        const Vec3 n = (m.inverse().transpose() * mesh.normals[v].cast<double>()).normalized();
        EXPECT_NEAR((out.normals[v].cast<double>() - n).norm(), 0, 2e-5);
    }
}

TEST(Embed, NormalsOfACloudOfPointsTurnAsThoseOfAMesh)
{
    Scene s;
    const std::vector<Vec3> x = moved(s.cubes, Vec3(1, 2, 0.5).asDiagonal(), Vec3::Zero());
    const TriMesh mesh = embed(bind(s.mesh, s.cubes), s.mesh, s.cubes, x);
    s.mesh.topology = std::make_shared<const geometry::MeshTopology>();
    EXPECT_EQ(embed(bind(s.mesh, s.cubes), s.mesh, s.cubes, x).normals, mesh.normals);
    EXPECT_NE(mesh.normals, s.mesh.normals);
}

TEST(Embed, AtRestNothingMoves)
{
    const Scene s;
    const TriMesh out = embed(bind(s.mesh, s.cubes), s.mesh, s.cubes, corner_positions(s.cubes));
    EXPECT_EQ(out.positions, s.mesh.positions);
    EXPECT_EQ(out.topology, s.mesh.topology);
    for (std::size_t n = 0; n < out.normals.size(); ++n) {
        EXPECT_NEAR((out.normals[n] - s.mesh.normals[n]).norm(), 0, 1e-6);
    }
}

TEST(Embed, VerticesMoveByTheTrilinearWeightsOfTheirCube)
{
    const Scene s;
    const Random random(4);
    std::vector<Vec3> x = corner_positions(s.cubes), u;
    for (std::uint64_t k = 0; k < x.size(); ++k) {
        u.push_back(0.05 * random_vector(random, k));
        x[k] += u[k];
    }
    const Binding binding = bind(s.mesh, s.cubes);
    const TriMesh out = embed(binding, s.mesh, s.cubes, x);
    for (std::size_t v = 0; v < s.mesh.positions.size(); ++v) {
        const Vec3 p = s.mesh.positions[v].cast<double>();
        const Vec3 at = (p - s.cubes.origin) / s.cubes.size;
        const std::size_t c = binding.used[binding.cube[v]];
        const Vec3 local = at - s.cubes.cell[c].cast<double>();
        EXPECT_TRUE((local.array() >= -2e-3).all() && (local.array() <= 1 + 2e-3).all());
        Vec3 expected = p;
        for (int a = 0; a < 8; ++a) {
            double w = 1;
            for (int d = 0; d < 3; ++d) w *= (a >> d & 1) ? local[d] : 1 - local[d];
            expected += w * u[s.cubes.corners[c][static_cast<std::size_t>(a)]];
        }
        EXPECT_NEAR((out.positions[v].cast<double>() - expected).norm(), 0, 1e-6);
    }
}

TEST(Embed, NormalsStayAcrossTheirSurface)
{
    // Two tangents at a vertex, moved as nearby points are: the normal is their cross product.
    const Scene s;
    std::vector<Vec3> x = corner_positions(s.cubes);
    for (Vec3& p : x) {
        p += Vec3(0.3 * p.y() * p.z(), -0.2 * p.x() * p.y(), 0.25 * p.x() * p.z());
    }
    const Binding binding = bind(s.mesh, s.cubes);
    const TriMesh out = embed(binding, s.mesh, s.cubes, x);
    constexpr float step = 1e-3f;
    for (std::size_t v = 0; v < s.mesh.positions.size(); v += 7) {
        // Away from cube faces, where the gradient jumps.
        if ((binding.local[v].array() < 0.02f).any() || (binding.local[v].array() > 0.98f).any()) {
            continue;
        }
        const Vec3f n = s.mesh.normals[v];
        const Vec3f a = n.unitOrthogonal(), b = n.cross(a), p = s.mesh.positions[v];
        const TriMesh probe =
            test_meshes::mesh_of({p - step * a, p + step * a, p - step * b, p + step * b}, {});
        const auto q = embed(bind(probe, s.cubes), probe, s.cubes, x).positions;
        const Vec3f expected = (q[1] - q[0]).cross(q[3] - q[2]).normalized();
        // Floats of size 1 differenced over 2e-3: 1e-7 / 2e-3, a few times over.
        EXPECT_NEAR((out.normals[v] - expected).norm(), 0, 5e-4);
    }
}

// Vertices are carried two at a time where the machine can, with their normals where each has its
// own: whatever their number, to the bit the same as positions and normals by themselves.
TEST(Embed, PositionsAndNormalsAtOnceAreThoseOfEachByItself)
{
    const Scene s;
    const Random random(4);
    std::vector<Vec3> x = corner_positions(s.cubes);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += 0.02 * random_vector(random, i);
    const TriMesh whole = embed(bind(s.mesh, s.cubes), s.mesh, s.cubes, x);
    for (std::size_t n = 0; n < 8; ++n) {
        TriMesh few = test_meshes::mesh_of({}, {});
        few.positions.assign(s.mesh.positions.begin(), s.mesh.positions.begin() + long(n));
        few.normals.assign(s.mesh.normals.begin(), s.mesh.normals.begin() + long(n));
        Binding binding = bind(few, s.cubes);
        EXPECT_TRUE(binding.one_normal_each);
        const TriMesh together = embed(binding, few, s.cubes, x);
        binding.one_normal_each = false;
        const TriMesh apart = embed(binding, few, s.cubes, x);
        for (std::size_t v = 0; v < n; ++v) {
            EXPECT_EQ(together.positions[v], whole.positions[v]);
            EXPECT_EQ(together.normals[v], whole.normals[v]);
        }
        EXPECT_EQ(together.positions, apart.positions);
        EXPECT_EQ(together.normals, apart.normals);
    }
}

TEST(Embed, TheTransposeIsTheAdjoint)
{
    Scene s;
    s.mesh.positions[7] *= 2;  // a stray
    const Binding binding = bind(s.mesh, s.cubes);
    const Random random(9);
    std::vector<Vec3> x = corner_positions(s.cubes), u, f;
    for (std::uint64_t k = 0; k < x.size(); ++k) {
        u.push_back(random_vector(random, k));
        x[k] += u[k];
    }
    for (std::uint64_t v = 0; v < s.mesh.positions.size(); ++v) {
        f.push_back(random_vector(random, 5000 + v));
    }
    const TriMesh out = embed(binding, s.mesh, s.cubes, x);
    const std::vector<Vec3> back = transpose(binding, s.cubes, f);
    double forward = 0, backward = 0;
    for (std::size_t v = 0; v < f.size(); ++v) {
        forward += f[v].dot((out.positions[v] - s.mesh.positions[v]).cast<double>());
    }
    for (std::size_t k = 0; k < u.size(); ++k) backward += u[k].dot(back[k]);
    EXPECT_NEAR(forward, backward, 642 * 1e-6);  // embed() works in single precision

    // Sum and torque are kept, to the local coordinates' single precision.
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t v = 0; v < f.size(); ++v) {
        force += f[v];
        torque += s.mesh.positions[v].cast<double>().cross(f[v]);
    }
    for (std::size_t k = 0; k < back.size(); ++k) {
        force -= back[k];
        torque -= s.cubes.corner_position(k).cross(back[k]);
    }
    EXPECT_NEAR(force.norm(), 0, 1e-10);
    EXPECT_NEAR(torque.norm(), 0, 642 * 1e-7);
}

TEST(Embed, APieceOutsideAllCubesStaysInOnePiece)
{
    // Pulled apart cubes at both ends of a bar between them that is in no cube.
    const Cubes cubes = geometry::solid_cubes({{0, 0, 0}, {10, 0, 0}}, 1);
    TriMesh bar = test_meshes::box({2, 0.4, 0.4}, {8.5, 0.6, 0.6});
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p.x() += p.x() > 5 ? 3 : 0;
    const Binding binding = bind(bar, cubes);
    EXPECT_EQ(binding.strays.size(), 8u);
    EXPECT_NEAR(binding.farthest, 7.5, 1e-5);  // from x = 8.5 to the first cube's side at 1
    const TriMesh out = embed(binding, bar, cubes, x);
    for (std::size_t v = 0; v < 8; ++v) {
        // 1.0 from the first cube, 1.5 from the second: all go with the first, which stays.
        EXPECT_NEAR((out.positions[v] - bar.positions[v]).norm(), 0, 1e-6);
    }
}

TEST(Embed, VerticesOnTheFarFacesAreInside)
{
    const TriMesh box = test_meshes::box({0, 0, 0}, {1, 0.3, 0.2});
    const Cubes cubes = voxelize_solid(box, {{}, {{}}, {}}, geometry::Inside::winding, 0,
                                       fit_grid(triangle_bounds(box), 0.1), {});
    EXPECT_TRUE(bind(box, cubes).strays.empty());
}

TEST(Embed, TakesWhateverComes)
{
    const Scene s;
    TriMesh mesh = s.mesh;
    mesh.positions[3].x() = std::numeric_limits<float>::quiet_NaN();
    mesh.positions[4].x() = std::numeric_limits<float>::infinity();
    mesh.positions[5].x() = 1e30f;
    mesh.normals.push_back({0, 0, 1});  // of no vertex
    const TriMesh out = embed(bind(mesh, s.cubes), mesh, s.cubes, corner_positions(s.cubes));
    EXPECT_EQ(out.normals.back(), mesh.normals.back());
    EXPECT_EQ(out.positions[0], mesh.positions[0]);
    EXPECT_THROW(bind(mesh, {}), std::invalid_argument);
    EXPECT_TRUE(embed(bind({}, {}), {}, {}, {}).positions.empty());
    const Binding binding = bind(s.mesh, s.cubes);
    EXPECT_THROW(embed(binding, s.mesh, s.cubes, {}), std::invalid_argument);
    EXPECT_THROW(embed(binding, {}, s.cubes, corner_positions(s.cubes)), std::invalid_argument);
    EXPECT_THROW(transpose(binding, s.cubes, {}), std::invalid_argument);
    // Crushed to a point: positions collapse, normals stay what they can.
    const TriMesh flat =
        embed(binding, s.mesh, s.cubes, std::vector<Vec3>(s.cubes.corner_count(), Vec3::Zero()));
    for (const Vec3f& n : flat.normals) EXPECT_NEAR(n.norm(), 1, 1e-5);
}

TEST(Embed, CornerValuesAreInterpolatedAndCubeValuesAveraged)
{
    const Scene s;
    const Binding binding = bind(s.mesh, s.cubes);
    std::vector<double> height;
    for (std::size_t k = 0; k < s.cubes.corner_count(); ++k) {
        height.push_back(s.cubes.corner_position(k).y());
    }
    const auto at = interpolate(binding, s.cubes, height);
    for (std::size_t v = 0; v < at.size(); ++v) {
        EXPECT_NEAR(at[v], s.mesh.positions[v].y(), 2e-4 * s.cubes.size + 1e-6);
    }
    const std::vector<float> same(s.cubes.count(), 3.5f);
    for (const double value : at_corners(s.cubes, same)) EXPECT_NEAR(value, 3.5, 1e-12);
}

TEST(Embed, SpeedIsThatOfTheVertexAlsoOutsideOfTheCubes)
{
    // A cube that spins about its middle at 2 rad/s: each vertex moves at 2 rad/s times its
    // distance.
    const Cubes cubes = geometry::solid_cubes({{0, 0, 0}}, 1);
    const Vec3 middle(0.5, 0.5, 0.5);
    std::vector<Vec3> v;
    for (const Vec3& p : corner_positions(cubes)) v.push_back(Vec3(0, 0, 2).cross(p - middle));
    const TriMesh mesh = test_meshes::mesh_of(
        {{0.5f, 0.5f, 0.5f}, {0.75f, 0.5f, 0.5f}, {0.5f, 3.5f, 0.5f}}, {{0, 1, 2}});
    TriMesh out = mesh;
    geometry::add_carried_numbers(out, {}, mesh, bind(mesh, cubes), cubes, {v, {}, {}});
    ASSERT_EQ(out.attributes.size(), 2u);
    ASSERT_EQ(out.attributes[1].name, "speed");
    const std::vector<float>& speed = out.attributes[1].values;
    EXPECT_NEAR(speed[0], 0, 1e-6);
    EXPECT_NEAR(speed[1], 0.5, 1e-6);
    EXPECT_NEAR(speed[2], 6, 1e-5);
}

TEST(Embed, GivesTheSameBytesOnAnyNumberOfThreads)
{
    TriMesh mesh = test_meshes::bumpy_sphere(5);
    mesh.normals = mesh.positions;
    const Cubes cubes =
        voxelize_surface(mesh, {{}, {{}}, {}}, 0, fit_grid(triangle_bounds(mesh), 0.1), {});
    std::vector<Vec3> x = corner_positions(cubes);
    for (Vec3& p : x) p += Vec3(p.y() * p.y(), 0, p.x());
    std::vector<Vec3f> reference;
    for (const unsigned threads : {1u, 2u, 8u}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const TriMesh out = embed(bind(mesh, cubes), mesh, cubes, x);
        auto now = out.positions;
        now.insert(now.end(), out.normals.begin(), out.normals.end());
        if (reference.empty()) reference = now;
        EXPECT_EQ(now, reference);
    }
}

// Two blocks half a cube apart, whose cubes overlap where the gap lies within a cell.
TEST(Embed, VerticesGoWithThePieceThatTheyBelongTo)
{
    for (const double x0 : {2.0, 2.2, 2.5, 2.75}) {
        SCOPED_TRACE(x0);
        // In slabs, so that many vertices lie on faces of cells and quarters.
        const TriMesh left =
            meshes::moved(geometry::box({1.5, 2, 2}, {6, 8, 7}), {x0 - 0.75, 1, 1});
        const TriMesh right =
            meshes::moved(geometry::box({1.5, 2, 2}, {5, 9, 8}), {x0 + 0.5 + 0.75, 1, 1});
        const std::array<const TriMesh*, 2> both{&left, &right};
        const TriMesh mesh = geometry::merge(both);
        const geometry::VoxelGrid grid{1, Vec3::Zero(), geometry::Vec3i::Zero()};
        const Cubes cubes = voxelize_solid(mesh, {{}, {{}}, {}}, geometry::Inside::winding, 0, grid,
                                           {.pieces = geometry::NearPieces::apart});
        const Binding binding = bind(mesh, cubes);
        EXPECT_TRUE(binding.strays.empty());
        std::vector<Vec3> x = corner_positions(cubes);
        const TriMesh rest = embed(binding, mesh, cubes, x);
        EXPECT_EQ(rest.positions, mesh.positions);

        // The piece with the first cube is the left one: it moves up, the other down.
        const auto found = find_components(cubes, geometry::Connectivity::face);
        ASSERT_EQ(found.count(), 2u);
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            const double up = found.label[c] == found.label[0] ? 1 : -1;
            for (const auto k : cubes.corners[c]) {
                x[k] = cubes.corner_position(k) + Vec3(0, up, 0);
            }
        }
        const TriMesh moved = embed(binding, mesh, cubes, x);
        for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
            const float up = v < left.positions.size() ? 1.0f : -1.0f;
            EXPECT_LT((moved.positions[v] - mesh.positions[v] - Vec3f(0, up, 0)).norm(), 1e-6f)
                << v;
        }
    }
}

}  // namespace
