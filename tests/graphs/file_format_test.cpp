// The examples in docs/file-format.md are documents that load.

#include "graph/document/document.hpp"
#include "nodes/registry.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace {

std::vector<std::string> examples_in(const std::filesystem::path& page)
{
    std::ifstream in(page);
    std::ostringstream all;
    all << in.rdbuf();
    const std::string text = all.str(), open = "```json\n", close = "```";
    std::vector<std::string> examples;
    for (std::size_t at = 0; (at = text.find(open, at)) != std::string::npos;) {
        const std::size_t begin = at + open.size(), end = text.find(close, begin);
        examples.push_back(text.substr(begin, end - begin));
        at = end;
    }
    return examples;
}

TEST(FileFormat, EveryExampleOfTheDocumentationLoads)
{
    const auto examples =
        examples_in(std::filesystem::path(ASPIC_SOURCE_DIR) / "docs/file-format.md");
    ASSERT_EQ(examples.size(), 6u);
    std::string name = (std::filesystem::temp_directory_path() / "format_XXXXXX").string();
    const std::filesystem::path folder = ::mkdtemp(name.data());
    std::filesystem::create_directories(folder / "assets");
    // The names by which the examples call one another.
    std::ofstream(folder / "ball.json") << examples[0];
    std::ofstream(folder / "assets/cubes_in.json") << examples[4];
    for (std::size_t i = 0; i < examples.size(); ++i) {
        if (i == 4) continue;  // a subgraph wants its inputs linked, as example 5 does
        const graph::Loaded loaded =
            graph::load_text(examples[i], folder / "example.json", nodes::registry());
        EXPECT_TRUE(loaded.problems.empty()) << "example " << i;
        for (const graph::Problem& p : loaded.problems) ADD_FAILURE() << describe(p);
    }
    std::filesystem::remove_all(folder);
}

}  // namespace
