// Boxes of few cubes that lie on each other off their middles, where corners alone hold neither.

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "physics/bricks/bricks.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace physics {
namespace {

constexpr double width = 0.1;  // m, of both boxes

struct BoxOnBox {
    geometry::Cubes lower, upper;
    geometry::TriMesh below, above;

    BoxOnBox(int cubes, double cube, const Vec3& at)
        : lower(fixtures::box(cubes, cubes, cubes, cube, {.density = 500, .young = 1e7})),
          upper(lower), below(geometry::box({width, width, width}, {1, 1, 1})), above(below)
    {
        // The mesh is about its middle, and so are the cubes.
        lower.origin = Vec3(0, width / 2, 0) - Vec3::Constant(cubes * cube / 2);
        upper.origin = lower.origin + at;
        const geometry::Vec3f up(0, float(width / 2), 0);
        for (auto& p : below.positions) p += up;
        for (auto& p : above.positions) p += up + at.cast<float>();
    }
    // m, how far the upper one's corners move in a second and a half.
    double moved(bool rigid) const
    {
        const std::vector<BodyModel> models = {{&lower, &below}, {&upper, &above}};
        const BricksBody body =
            make_bricks(BodyModels(models), {.contact = {.on = true},
                                             .rigid = std::vector<std::uint8_t>(2, rigid ? 1 : 0)});
        Loads loads;
        loads.forces.push_back({});
        loads.colliders.push_back({});
        State state = rest_state(body);
        const auto rest = state.x;
        for (int frame = 0; frame < 36; ++frame) {
            state = advance(body, std::move(state), loads, 1.0 / 24);
        }
        double most = 0;
        for (std::size_t k = lower.corner_count(); k < rest.size(); ++k) {
            most = std::max(most, (state.x[k] - rest[k]).norm());
        }
        return most;
    }
};

// The middle of the upper one is over the lower one by 1 cm and more each way. With points at
// corners alone the upper one rolled off over the line between the two that touch.
TEST(RestsAcross, ABoxOfOneCubeStaysWhereItsMiddleIsOverTheOther)
{
    for (const Vec3& at :
         {Vec3(0.03, width, 0.02), Vec3(0.02, width, 0.01), Vec3(0.04, width, 0.03)}) {
        for (const bool rigid : {true, false}) {
            EXPECT_LT(BoxOnBox(1, width, at).moved(rigid), 1e-3) << at.transpose() << rigid;
        }
        // Boxes half as wide as the cubes that hold them.
        EXPECT_LT(BoxOnBox(1, 2 * width, at).moved(true), 1e-3) << at.transpose();
    }
}

// As far outside it tips.
TEST(RestsAcross, ABoxFallsWhereItsMiddleIsBeyondTheOther)
{
    for (const bool rigid : {true, false}) {
        EXPECT_GT(BoxOnBox(1, width, {0.06, width, 0.02}).moved(rigid), width / 2) << rigid;
    }
}

}  // namespace
}  // namespace physics
