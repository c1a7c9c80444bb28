#include "graph/tools/reference.hpp"

#include "nodes/registry.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

TEST(Reference, ThePageMatchesTheDescriptions)
{
    std::ifstream in(ASPIC_SOURCE_DIR "/docs/nodes.md");
    std::ostringstream page;
    page << in.rdbuf();
    EXPECT_TRUE(page.str() == graph::reference_page(nodes::registry()))
        << "docs/nodes.md is out of date: ./aspic nodes --markdown > docs/nodes.md";
}
