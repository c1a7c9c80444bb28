#include "geometry/mesh/mesh.hpp"
#include "physics/body/contact_surface.hpp"

#include "geometry/base/random.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/merge.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

using namespace physics;

namespace {

ContactSurface skin_of(const geometry::Cubes& cubes)
{
    return make_contact_surface(cubes, {}, nullptr);
}

}  // namespace

TEST(ContactSurface, CubesThatHoldTheSameShareAPatch)
{
    // Cells take those of their corners that no cell before them has, and corners have an area by
    // the number of cells around. Both are the same for all cells of a row but its first and last,
    // and so are rows but the first and last: 3 x 3 kinds, whatever the size. But the ends of rows
    // and the cells of the last row hold the same, one corner with two cells around: 8 kinds.
    const auto sheet =
        geometry::plane_cubes(geometry::rectangle_cells(20, 31), {1, 0.1, {0, 0, 0}}, 0.02);
    const ContactSurface skin = skin_of(sheet);
    EXPECT_EQ(skin.corners.size(), 20u * 31u);
    EXPECT_EQ(skin.patch.size(), 8u);
    // Of a solid alike, with three axes; cubes within hold nothing.
    const ContactSurface solid = skin_of(fixtures::box(6, 7, 8, 0.1));
    EXPECT_EQ(solid.corners.size(), 6u * 7u * 8u - 4u * 5u * 6u);
    EXPECT_EQ(solid.patch.size(), 26u);
}

TEST(ContactSurface, CornersAreReadAsTheyWereGivenInWhateverRuns)
{
    // Runs of one to five cubes: some go on, some start anew, one in seven changes a single corner.
    const geometry::Random random(3);
    std::vector<CornerRuns::Corners> given;
    CornerRuns runs;
    for (std::uint64_t run = 0; run < 60; ++run) {
        CornerRuns::Corners at;
        for (std::size_t a = 0; a < 8; ++a) {
            at[a] = std::uint32_t(1000 * random.unit(16 * run + a));
        }
        if (run % 7 == 6) {
            at = given.back();
            for (auto& k : at) ++k;
            ++at[run % 8];
        }
        const auto count = 1 + std::uint32_t(5 * random.unit(16 * run + 8));
        for (std::uint32_t k = 0; k < count; ++k) {
            given.push_back(at);
            runs.push_back(at);
            for (auto& corner : at) ++corner;
        }
    }
    ASSERT_EQ(runs.size(), given.size());
    for (std::size_t c = 0; c < given.size(); ++c) EXPECT_EQ(runs[c], given[c]) << c;
    for (std::size_t begin = 0; begin <= given.size(); ++begin) {
        for (const std::size_t end : {begin, std::min(begin + 9, given.size()), given.size()}) {
            std::size_t next = begin;
            runs.for_each(begin, end, [&](std::size_t c, const auto& corners) {
                ASSERT_EQ(c, next++);
                ASSERT_EQ(corners, given[c]) << c;
            });
            EXPECT_EQ(next, end);
        }
    }
    // A sheet's rows are one run each: its number here, and eight corners.
    const auto sheet =
        geometry::plane_cubes(geometry::rectangle_cells(20, 31), {1, 0.1, {0, 0, 0}}, 0.02);
    EXPECT_EQ(skin_of(sheet).corners.bytes(), 31u * 36u);
}

TEST(ContactSurface, HoldsEveryCornerOnceAndAllOfTheArea)
{
    const geometry::Cubes cubes = fixtures::box(4, 5, 3, 0.1);
    const ContactSurface skin = skin_of(cubes);
    std::vector<int> times(cubes.corner_count(), 0);
    double at_points = 0, of_faces = 0;
    for (std::size_t c = 0; c < skin.corners.size(); ++c) {
        const SurfacePatch& patch = skin.on(c);
        for (auto i = patch.point; i < patch.points_end; ++i) {
            at_points += double(skin.point_area[i]);
            for (std::size_t a = 0; a < 8; ++a) {
                if (skin.point[i][a] != 0) ++times[skin.corners[c][a]];
            }
        }
        for (auto i = patch.area; i < patch.areas_end; ++i) of_faces += double(skin.area[i].norm());
    }
    for (std::size_t k = 0; k < times.size(); ++k) {
        const auto& at = cubes.corner[k];
        const bool outside = at[0] % 4 == 0 || at[1] % 5 == 0 || at[2] % 3 == 0;
        EXPECT_EQ(times[k], outside ? 1 : 0) << k;
    }
    // 2 (4 x 5 + 5 x 3 + 3 x 4) faces of 0.01 m^2, in single precision.
    EXPECT_NEAR(at_points, 0.94, 1e-6);
    EXPECT_NEAR(of_faces, 0.94, 1e-6);
}

TEST(ContactSurface, WideFacesAreTouchedAllOver)
{
    // A box of 12 triangles around 8 x 5 x 6 cubes, just inside them, as it is and finer: each cube
    // on the outside has a point of its own, and points share out the area.
    const geometry::Cubes cubes = fixtures::box(8, 5, 6, 0.1);
    for (const int divisions : {1, 2, 3, 40}) {
        auto surface = geometry::box(Vec3(0.79, 0.49, 0.59), geometry::Vec3i::Constant(divisions));
        for (Vec3f& p : surface.positions) p += Vec3f(0.4f, 0.25f, 0.3f);
        const ContactSurface skin = make_contact_surface(cubes, {}, &surface);
        double area = 0;
        std::size_t touched = 0, most = 0;
        for (std::size_t c = 0; c < skin.corners.size(); ++c) {
            const SurfacePatch& patch = skin.on(c);
            EXPECT_EQ(patch.within, patch.points_end);
            const std::size_t points = patch.points_end - patch.point;
            touched += points > 0;
            most = std::max(most, points);
            for (auto i = patch.point; i < patch.points_end; ++i) {
                area += double(skin.point_area[i]);
                Vec3 local = Vec3::Zero();
                for (std::size_t a = 0; a < 8; ++a) {
                    const Vec3 corner(double(a & 1), double(a >> 1 & 1), double(a >> 2 & 1));
                    local += double(skin.point[i][a]) * corner;
                }
                const Vec3 at = 0.1 * (cubes.corner[skin.corners[c][0]].cast<double>() + local);
                const Vec3 away =
                    (at - Vec3(0.4, 0.25, 0.3)).cwiseAbs() - Vec3(0.395, 0.245, 0.295);
                EXPECT_NEAR(away.maxCoeff(), 0, 1e-6);  // on the box
            }
        }
        EXPECT_EQ(touched, 8u * 5u * 6u - 6u * 3u * 4u) << divisions;
        EXPECT_LE(most, 64u);
        EXPECT_NEAR(area, 2 * (0.79 * 0.49 + 0.49 * 0.59 + 0.59 * 0.79), 1e-5) << divisions;
    }
}

TEST(ContactSurface, OfCrowdedPointsTheCornersStay)
{
    // A box of 60 x 60 x 60 faces, wherever its corners lie in the cubes that hold them: each is a
    // point, also where it looks towards the middle of its cube, and wound inwards beside a larger
    // piece that is not.
    const geometry::Cubes cubes = fixtures::box(13, 6, 6, 0.1);
    for (const float shift : {0.0f, 0.035f, 0.08f}) {
        for (const bool inward : {false, true}) {
            auto surface = geometry::box(Vec3(0.42, 0.42, 0.42), geometry::Vec3i::Constant(60));
            for (Vec3f& p : surface.positions) p += Vec3f::Constant(0.25f + shift);
            if (inward) {
                auto turned = std::make_shared<geometry::MeshTopology>(*surface.topology);
                for (auto& t : turned->triangles) std::swap(t[1], t[2]);
                surface.topology = turned;
                auto larger = geometry::box(Vec3(0.5, 0.5, 0.5), geometry::Vec3i::Ones());
                for (Vec3f& p : larger.positions) p += Vec3f(0.95f, 0.3f, 0.3f);
                surface = geometry::merge(std::vector{&surface, &larger});
            }
            const ContactSurface skin = make_contact_surface(cubes, {}, &surface);
            std::array<double, 8> nearest;
            nearest.fill(1);
            for (std::size_t c = 0; c < skin.corners.size(); ++c) {
                const SurfacePatch& patch = skin.on(c);
                for (auto i = patch.point; i < patch.points_end; ++i) {
                    Vec3 at = Vec3::Zero();
                    for (std::size_t a = 0; a < 8; ++a) {
                        at += double(skin.point[i][a]) * cubes.corner_position(skin.corners[c][a]);
                    }
                    for (std::size_t k = 0; k < 8; ++k) {
                        const Vec3 corner =
                            Vec3::Constant(0.04 + double(shift)) +
                            0.42 * Vec3(double(k & 1), double(k >> 1 & 1), double(k >> 2 & 1));
                        nearest[k] = std::min(nearest[k], (at - corner).norm());
                    }
                }
            }
            for (const double far : nearest) EXPECT_LT(far, 1e-6) << shift << inward;
        }
    }
}

TEST(ContactSurface, AMeshInAPlaneHangsOnTheCornersThatMove)
{
    // A plane's cells have one layer of corners: what a point has of the upper four, they take.
    const geometry::Cubes sheet =
        geometry::plane_cubes(geometry::rectangle_cells(6, 4), {1, 0.1, {0, 0, 0}}, 0.02);
    const int flat = geometry::flat_axis(sheet);
    ASSERT_GE(flat, 0);
    auto surface = geometry::box(Vec3(0.5, 0.01, 0.3), geometry::Vec3i::Constant(5));
    Vec3f middle = Vec3f::Zero(), centre = Vec3f::Zero();
    for (const Vec3f& p : surface.positions) middle += p / float(surface.positions.size());
    for (std::size_t k = 0; k < sheet.corner_count(); ++k) {
        centre += sheet.corner_position(k).cast<float>() / float(sheet.corner_count());
    }
    for (Vec3f& p : surface.positions) p += centre - middle;
    const ContactSurface skin = make_contact_surface(sheet, {}, &surface);
    std::size_t points = 0;
    for (std::size_t c = 0; c < skin.corners.size(); ++c) {
        const SurfacePatch& patch = skin.on(c);
        for (auto i = patch.point; i < patch.points_end; ++i, ++points) {
            float sum = 0;
            for (std::size_t a = 0; a < 8; ++a) {
                sum += skin.point[i][a];
                EXPECT_EQ(a >> flat & 1 ? skin.point[i][a] : 0.0f, 0.0f);
            }
            EXPECT_NEAR(sum, 1, 1e-6);
        }
    }
    EXPECT_GT(points, 24u);
}

TEST(ContactSurface, ABodyThatTearsHasPointsAtItsInnerCornersToo)
{
    // Corners that no point of the surface goes with, each once.
    const geometry::Cubes cubes = fixtures::box(5, 4, 4, 0.1);
    auto surface = geometry::icosphere(0.12, 3);
    for (Vec3f& p : surface.positions) p += Vec3f(0.2f, 0.2f, 0.2f);
    for (const geometry::TriMesh* mesh : {&surface, static_cast<geometry::TriMesh*>(nullptr)}) {
        const ContactSurface skin = make_contact_surface(cubes, {}, mesh, true);
        std::vector<int> outer(cubes.corner_count(), 0), within = outer;
        for (std::size_t c = 0; c < skin.corners.size(); ++c) {
            const SurfacePatch& patch = skin.on(c);
            for (auto i = patch.point; i < patch.points_end; ++i) {
                for (std::size_t a = 0; a < 8; ++a) {
                    auto& times = i < patch.within ? outer : within;
                    if (skin.point[i][a] > 0) ++times[skin.corners[c][a]];
                }
            }
        }
        std::size_t inner = 0;
        for (std::size_t k = 0; k < outer.size(); ++k) {
            EXPECT_EQ(within[k], outer[k] > 0 ? 0 : 1) << k;
            inner += std::size_t(within[k]);
        }
        EXPECT_GT(inner, 10u);
    }
}

TEST(ContactSurface, PiecesThatStayApartHaveTheirOwnFaces)
{
    // Two blocks of 2 x 2 x 2 cells, half a cube apart: 24 faces each. Merged, the cells on both
    // sides of the gap cover each other: 40 faces.
    const auto block = [](double x) {
        geometry::TriMesh mesh = geometry::box({1.5, 2, 2}, {1, 1, 1});
        move(mesh, geometry::placement({x, 1, 1}, {0, 0, 0}, {1, 1, 1}, {0, 0, 0}));
        return mesh;
    };
    const geometry::TriMesh left = block(1.25), right = block(3.25);
    const std::array<const geometry::TriMesh*, 2> both{&left, &right};
    const geometry::TriMesh mesh = geometry::merge(both);
    const auto cubes = [&](geometry::NearPieces pieces) {
        return voxelize_solid(mesh, {{}, {{}}, {}}, geometry::Inside::winding, 0,
                              {1, Vec3::Zero(), geometry::Vec3i::Zero()}, {.pieces = pieces});
    };
    const auto area = [](const ContactSurface& skin) {
        double sum = 0;
        for (const std::uint32_t p : skin.patch_of) {
            const SurfacePatch& patch = skin.patch[p];
            for (auto i = patch.area; i < patch.areas_end; ++i) {
                sum += double(skin.area[i].norm());
            }
        }
        return sum;
    };
    const auto apart = cubes(geometry::NearPieces::apart);
    EXPECT_NEAR(area(skin_of(apart)), 48, 1e-4);
    EXPECT_NEAR(area(skin_of(cubes(geometry::NearPieces::merge))), 40, 1e-4);
    // The blocks' own faces: 2 (4 + 3 + 3) each, none left out.
    EXPECT_NEAR(area(make_contact_surface(apart, {}, &mesh)), 40, 1e-4);
}

// Wind blows on both sides of a plane, whether its own mesh is linked or not: 2 x 1 m^2 twice. A
// surface that is closed has both already.
TEST(ContactSurface, TheSurfaceOfAPlaneHasTwoSides)
{
    const auto cubes =
        geometry::plane_cubes(geometry::rectangle_cells(20, 10), {1, 0.1, {0, 0, 0}}, 0.02);
    const auto area_of = [&](const geometry::TriMesh* mesh) {
        double area = 0;
        const ContactSurface skin = make_contact_surface(cubes, {}, mesh);
        skin.corners.for_each(0, skin.corners.size(), [&](std::size_t c, const auto&) {
            for (auto i = skin.on(c).area; i < skin.on(c).areas_end; ++i) {
                area += double(skin.area[i].norm());
            }
        });
        return area;
    };
    geometry::TriMesh one_side = geometry::grid(2, 1, 20, 10);
    geometry::TriMesh both_sides = geometry::box({2, 1e-6, 1}, {20, 1, 10});
    for (geometry::TriMesh* mesh : {&one_side, &both_sides}) {
        for (auto& p : mesh->positions) p += geometry::Vec3f(1, 0, 0.5f);
    }
    EXPECT_NEAR(area_of(nullptr), 4, 1e-4);
    EXPECT_NEAR(area_of(&one_side), 4, 1e-4);
    EXPECT_NEAR(area_of(&both_sides), 4, 1e-4);
}
