#include "layered_fixtures.hpp"

#include <gtest/gtest.h>

namespace physics {

using namespace layered_fixtures;

// Keyed positions of skeletons move the layer of a still body inside its frame.
TEST(LayeredMotion, SkeletonsThatMoveInsideAStillFrameAreTold)
{
    const auto still_at = [](double x) {
        LayeredPart part;
        part.body = std::make_shared<const LayeredBody>(
            make_layered_body(soft_layer({point({x, 0, 0})}), BaseKind::still, 1, 0.05));
        return part;
    };
    const LayeredScene scene = start({still_at(0)});
    const LayeredScene same =
        advance(scene, {still_at(0)}, layered_fixtures::weightless, 1.0 / 24, 1);
    EXPECT_TRUE(same.states[0].report.warnings.empty());
    const LayeredScene other =
        advance(scene, {still_at(0.1)}, layered_fixtures::weightless, 1.0 / 24, 1);
    ASSERT_EQ(other.states[0].report.warnings.size(), 1u);
    EXPECT_NE(other.states[0].report.warnings[0].find("have no velocity"), std::string::npos);
}

}  // namespace physics
