#include "geometry/mesh/sample_texture.hpp"

#include <gtest/gtest.h>

namespace {

using namespace geometry;

// Two by two pixels, by rows from the top: 0, 51 and 255, 102 in red; green is constant.
Picture checker()
{
    return {2, 2, {0, 255, 0, 255, 51, 255, 0, 255, 255, 255, 0, 255, 102, 255, 0, 255}};
}

double red(float u, float v, TextureUse::Wrap wrap = TextureUse::Wrap::repeat)
{
    return picture_at(checker(), {wrap, wrap}, {u, v})[0];
}

TEST(SampleTexture, IsThePixelInItsMiddleAndLinearBetween)
{
    // v runs up: the lower row is 1 and 0.4.
    EXPECT_DOUBLE_EQ(red(0.25f, 0.25f), 1);
    EXPECT_DOUBLE_EQ(red(0.75f, 0.25f), 0.4);
    EXPECT_DOUBLE_EQ(red(0.25f, 0.75f), 0);
    EXPECT_DOUBLE_EQ(red(0.75f, 0.75f), 0.2);
    EXPECT_DOUBLE_EQ(red(0.5f, 0.25f), 0.7);
    EXPECT_DOUBLE_EQ(red(0.5f, 0.5f), (1 + 0.4 + 0 + 0.2) / 4);
    EXPECT_DOUBLE_EQ(picture_at(checker(), {}, {0.3f, 0.9f})[1], 1);
}

TEST(SampleTexture, BeyondThePictureItIsAsTheUseSays)
{
    using Wrap = TextureUse::Wrap;
    // 1.25 is 0.25 again; the nearest edge, 0.4; or 0.75 seen in a mirror, 0.4.
    EXPECT_DOUBLE_EQ(red(1.25f, 0.25f), 1);
    EXPECT_DOUBLE_EQ(red(1.25f, 0.25f, Wrap::clamp), 0.4);
    EXPECT_DOUBLE_EQ(red(1.25f, 0.25f, Wrap::mirror), 0.4);
    EXPECT_DOUBLE_EQ(red(-0.75f, 0.25f), 1);
    EXPECT_DOUBLE_EQ(red(-0.75f, 0.25f, Wrap::clamp), 1);
    EXPECT_DOUBLE_EQ(red(-0.75f, 0.25f, Wrap::mirror), 0.4);
    // Half-way over the edge: of both neighbours.
    EXPECT_DOUBLE_EQ(red(1, 0.25f), 0.7);
    EXPECT_EQ(red(NAN, 0.25f), 0);
    EXPECT_EQ(picture_at({}, {}, {0, 0})[0], 0);
}

}  // namespace
