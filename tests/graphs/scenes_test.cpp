// Every scene in graphs/ loads, cooks and keeps the promises of its own `expect` block.

#include "nodes/registry.hpp"
#include "runtime/command_line.hpp"

#include <regex>
#include <sstream>

static std::vector<std::string> scenes()
{
    std::vector<std::string> out;
    for (const auto& entry : std::filesystem::directory_iterator(ASPIC_SOURCE_DIR "/graphs")) {
        if (entry.path().extension() == ".json") out.push_back(entry.path().stem().string());
    }
    std::sort(out.begin(), out.end());
    return out;
}

class Scene : public testing::TestWithParam<std::string> {};

TEST_P(Scene, KeepsItsPromises)
{
    std::ostringstream out, err;
    runtime::Console console{out, err, false, {}, {}, "test"};
    const std::string file = ASPIC_SOURCE_DIR "/graphs/" + GetParam() + ".json";
    EXPECT_EQ(
        runtime::run_command_line({"check", file, "--no-disk-cache"}, nodes::registry(), console),
        runtime::exit_ok)
        << out.str() << err.str();
    // A scene that promises nothing could not fail.
    EXPECT_TRUE(
        std::regex_search(out.str() + err.str(), std::regex("all [0-9]+ expectations? met")))
        << out.str() << err.str();
}

INSTANTIATE_TEST_SUITE_P(Graphs, Scene, testing::ValuesIn(scenes()),
                         [](const auto& scene) { return scene.param; });
