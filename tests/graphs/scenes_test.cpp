// Every scene in graphs/ and graphs/shots/ loads, cooks and meets its own `expect` block. The
// assets in graphs/assets/ are parts of scenes and cook with them.

#include "nodes/registry.hpp"
#include "runtime/commands/command_line.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <sstream>

// Paths below graphs/, without ending.
static std::vector<std::string> scenes()
{
    const std::filesystem::path graphs = ASPIC_SOURCE_DIR "/graphs";
    std::vector<std::string> out;
    for (const auto& folder : {graphs, graphs / "shots"}) {
        for (const auto& entry : std::filesystem::directory_iterator(folder)) {
            if (entry.path().extension() != ".json") continue;
            out.push_back(entry.path().lexically_relative(graphs).replace_extension().string());
        }
    }
    std::sort(out.begin(), out.end());
    return out;
}

class Scene : public testing::TestWithParam<std::string> {};

TEST_P(Scene, MeetsItsExpectations)
{
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    const std::string file = ASPIC_SOURCE_DIR "/graphs/" + GetParam() + ".json";
    EXPECT_EQ(
        runtime::run_command_line({"check", file, "--no-disk-cache"}, nodes::registry(), console),
        runtime::exit_ok)
        << out.str() << err.str();
    // A scene without expectations could not fail.
    EXPECT_TRUE(
        std::regex_search(out.str() + err.str(), std::regex("all [0-9]+ expectations? met")))
        << out.str() << err.str();
}

INSTANTIATE_TEST_SUITE_P(Graphs, Scene, testing::ValuesIn(scenes()), [](const auto& scene) {
    std::string name = scene.param;
    std::replace(name.begin(), name.end(), '/', '_');
    return name;
});
