// From a mesh of two matters to what it does under a load.

#include "geometry/cubes/voxelize.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/geometry/test_meshes.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;
using geometry::Cubes;

TEST(TwoMatters, HalvesOf1To1e6StretchAsOneOfThem)
{
    // F L / (E A) of the soft half alone, on either side; the interface lies on a face of cubes.
    const geometry::TriMesh mesh = test_meshes::both(test_meshes::box({0, 0, 0}, {0.5, 0.2, 0.2}),
                                                     test_meshes::box({0.5, 0, 0}, {1, 0.2, 0.2}));
    geometry::FaceMatter matter;
    matter.face.assign(24, 0);
    std::fill(matter.face.begin() + 12, matter.face.end(), std::uint16_t{1});
    const geometry::Matter soft{.young = 1e4, .poisson = 0}, stiff{.young = 1e10, .poisson = 0};
    for (const auto& [size, soft_first] : {std::pair(0.1, true), std::pair(0.1, false),
                                           std::pair(0.05, true), std::pair(0.05, false)}) {
        matter.matters = soft_first ? std::vector{soft, stiff} : std::vector{stiff, soft};
        const Cubes cubes =
            voxelize_solid(mesh, matter, geometry::Inside::winding, 0,
                           geometry::fit_grid(geometry::triangle_bounds(mesh), size), {});
        const BricksBody body = make_bricks(cubes);
        Loads loads;
        std::vector<std::uint32_t> tip;
        int length = 0;
        for (const auto& c : cubes.corner) length = std::max(length, c.x());
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k].x() == length) tip.push_back(k);
            if (cubes.corner[k].x() != 0) continue;
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner_position(k));
        }
        // Pulled evenly: by the faces of the last cubes that each corner is of.
        const double force = 1;
        std::vector<double> faces(cubes.corner_count(), 0);
        double all = 0;
        for (const auto& corners : cubes.corners) {
            for (const auto k : corners) {
                if (cubes.corner[k].x() != length) continue;
                faces[k] += 1;
                all += 1;
            }
        }
        for (const auto k : tip) {
            Force f;
            f.kind = Force::Kind::point;
            f.position = cubes.corner_position(k);
            f.radius = 0;
            f.force = Vec3(force * faces[k] / all, 0, 0);
            loads.forces.push_back(f);
        }
        const State state = advance(body, rest_state(body), loads, 1e4,
                                    {.newton_iterations = 30, .tolerance = 1e-8});
        double moved = 0;
        for (const auto k : tip) {
            moved += (state.x[k].x() - cubes.corner_position(k).x()) / double(tip.size());
        }
        const double expected = force * 0.5 / (1e4 * 0.04);
        EXPECT_NEAR(moved, expected, 0.03 * expected) << size;
    }
}

}  // namespace
