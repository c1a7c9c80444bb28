#include "geometry/fields/field_grid.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace geometry {
namespace {

// Far away, rounding leaves a box without a width: all of it is one cell. Boxes that are wider than
// numbers go have no grid.
TEST(FieldGrid, TakesBoxesFarAway)
{
    const Vec3 far = Vec3::Constant(1e17), near = Vec3::Zero();
    const FieldGrid point = make_field_grid(std::vector<Box>{{far, far}});
    EXPECT_EQ(point.dims, Vec3i(1, 1, 1));
    EXPECT_EQ(point.skeleton.size(), 1u);
    const FieldGrid two = make_field_grid(std::vector<Box>{{near, near}, {far, far}});
    EXPECT_GE(two.dims.minCoeff(), 1);
    EXPECT_EQ(two.skeleton.size(), 2u);
    const FieldGrid wide =
        make_field_grid(std::vector<Box>{{Vec3::Constant(-1.5e308), Vec3::Constant(1.5e308)}});
    EXPECT_TRUE(wide.skeleton.empty());
}

}  // namespace
}  // namespace geometry
