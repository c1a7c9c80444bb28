#include "physics/state/pins.hpp"

#include <gtest/gtest.h>

namespace {

using namespace physics;

std::shared_ptr<const Pins> pins_with(std::vector<std::uint32_t> corners, const Vec3& target)
{
    auto pins = std::make_shared<Pins>();
    pins->target.assign(corners.size(), target);
    pins->corner = std::move(corners);
    return pins;
}

TEST(Pins, TwoThatPullTheSameCornerApartAreNamed)
{
    const std::vector pins{pins_with({1, 4}, Vec3(0, 0, 0)), pins_with({2, 3}, Vec3(5, 0, 0)),
                           pins_with({0, 4, 9}, Vec3(0, 0.1, 0))};
    const auto warnings = conflicting_pins(pins, 1e-3);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0].rfind("Pins 1 and 3 of 3 pull the same corners", 0), 0u) << warnings[0];
    // What is warned of: the corner goes to the mean of both targets.
    const Pins merged = merge_pins(pins, 10);
    EXPECT_EQ(merged.corner, (std::vector<std::uint32_t>{0, 1, 2, 3, 4, 9}));
    EXPECT_EQ(merged.target[4], Vec3(0, 0.05, 0));
}

TEST(Pins, ThatAgreeWithinTheToleranceOrShareNoCornerAreFine)
{
    const std::vector pins{pins_with({1, 2}, Vec3(0, 0, 0)), pins_with({2, 3}, Vec3(0, 1e-4, 0)),
                           pins_with({7}, Vec3(1, 0, 0))};
    EXPECT_TRUE(conflicting_pins(pins, 1e-3).empty());
    EXPECT_TRUE(conflicting_pins({}, 1e-3).empty());
}

}  // namespace
