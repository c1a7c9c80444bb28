#include "graph/document/frame_path.hpp"

#include <gtest/gtest.h>

namespace {

TEST(FramePath, FillsTheFirstRunOfHashesWithTheFrame)
{
    EXPECT_EQ(graph::frame_path("frames/####.png", 7), "frames/0007.png");
    EXPECT_EQ(graph::frame_path("a.#.b.##.png", 12), "a.12.b.##.png");
    EXPECT_EQ(graph::frame_path("shot##.png", 12345), "shot12345.png");
    EXPECT_EQ(graph::frame_path("x####", -3), "x-0003");
    EXPECT_EQ(graph::frame_path("still.png", 7), "still.png");
}

TEST(FramePath, LeavesFoldersAlone)
{
    EXPECT_EQ(graph::frame_path("a##/b.png", 7), "a##/b.png");
}

TEST(FramePath, ShowsTheFrameInAnyText)
{
    EXPECT_EQ(graph::frame_text("frame ### of it", 5), "frame 005 of it");
    EXPECT_EQ(graph::frame_text("", 5), "");
}

}  // namespace
