// One output folder under several spellings, from several working folders.

#include "runtime/commands/manifest.hpp"
#include "tests/runtime/said.hpp"

#include <gtest/gtest.h>

using namespace runtime;
using toys::has;
using toys::run;
using toys::Said;

namespace {

namespace fs = std::filesystem;

class WorkingFolder {
public:
    explicit WorkingFolder(const fs::path& folder) : before_(fs::current_path())
    {
        fs::create_directories(folder);
        fs::current_path(folder);
    }
    ~WorkingFolder() { fs::current_path(before_); }
    WorkingFolder(const WorkingFolder&) = delete;

private:
    fs::path before_;
};

class OutputFolder : public testing::Test {
protected:
    void SetUp() override { file_ = folder_.write("three.json", toys::three_frames).string(); }
    Said cook(const fs::path& out)
    {
        const Said said =
            run({"cook", file_, "--out", out, "--cache", (folder_.path / "cache").string()});
        EXPECT_EQ(said.exit, exit_ok) << said.err;
        return said;
    }

    toys::Folder folder_;
    std::string file_;
};

}  // namespace

TEST_F(OutputFolder, FilesThatAreGoneAreMadeAgainFromAnyWorkingFolder)
{
    const fs::path first = folder_.path / "p1", second = folder_.path / "p2";
    for (const fs::path& place : {first, second}) {
        const WorkingFolder here(place);
        cook("out/a");
    }
    fs::remove_all(first / "out");
    const WorkingFolder here(second);
    cook(first / "out/a");
    EXPECT_TRUE(fs::exists(first / "out/a/2number.txt"));
}

TEST_F(OutputFolder, IsTheSameUnderEverySpelling)
{
    const WorkingFolder here(folder_.path / "p");
    fs::create_directory("real");
    fs::create_directory_symlink("real", "link");
    cook("real/out");
    for (const fs::path& again :
         {fs::current_path() / "real/out/", fs::path("./link/../real/out"), fs::path("link/out")}) {
        toys::take_runs("WriteNumber");
        cook(again);
        EXPECT_EQ(toys::take_runs("WriteNumber"), 0) << again;
        for (const Manifest::Output& o : read_manifest("real/out/manifest.json").outputs) {
            EXPECT_EQ(o.file.path, std::to_string(o.frame) + "number.txt") << again;
        }
        EXPECT_EQ(run({"verify", "real/out"}).exit, exit_ok) << again;
    }
}

TEST_F(OutputFolder, HoldsNoFileThatTheCookReads)
{
    folder_.write("in/number.txt", "7");
    folder_.write("in/n.0001.txt", "8");
    folder_.write("in/n.0002.txt", "9");
    fs::create_directory_symlink(folder_.path / "in", folder_.path / "link");
    const auto said = [&](const std::string& reads, const std::string& writes,
                          const std::string& out, std::vector<std::string> more = {}) {
        const std::string file =
            folder_
                .write("in/g.json", R"({ "aspic": 1, "frames": { "last": 2 }, "nodes": {
                "read": { "type": "ReadNumber@1", "params": { "path": ")" +
                                        reads + R"(" } },
                "other": { "type": "Clock@1" },
                "alone": { "type": "WriteRow@1", "inputs": { "value": "other.value" },
                           "params": { "path": "alone.txt" } },
                "write": { "type": "WriteRow@1", "inputs": { "value": "read.value" },
                           "params": { "path": ")" +
                                        writes + R"(" } } } })")
                .string();
        std::vector<std::string> args{"cook", file, "--out", (folder_.path / out).string()};
        args.insert(args.end(), more.begin(), more.end());
        return run(args);
    };
    for (const char* const out : {"in", "link", "in/../in/"}) {
        const Said same = said("number.txt", "number.txt", out);
        EXPECT_EQ(same.exit, exit_usage) << out;
        EXPECT_TRUE(has(same.err, "'write' would write over ")) << same.err;
        EXPECT_TRUE(has(same.err, "number.txt, which 'read' reads: give it another path, or use "
                                  "--out DIR"))
            << same.err;
    }
    EXPECT_EQ(toys::bytes_of(folder_.path / "in/number.txt"), "7");
    EXPECT_FALSE(fs::exists(folder_.path / "in/manifest.json"));
    EXPECT_TRUE(has(said("n.####.txt", "n.0002.txt", "in").err, "which 'read' reads"));
    EXPECT_TRUE(has(said("number.txt", "g.json", "in").err, "which is a document of this graph"));

    EXPECT_EQ(said("n.####.txt", "n.0002.txt", "in", {"--frames", "1"}).exit, exit_ok);
    EXPECT_EQ(said("number.txt", "number.txt", "out").exit, exit_ok);
    EXPECT_EQ(said("number.txt", "number.txt", "in", {"--node", "alone"}).exit, exit_ok);
}

TEST_F(OutputFolder, IsNamedAsItWasGiven)
{
    const WorkingFolder here(folder_.path / "p");
    const std::string said = cook("out/a").out;
    EXPECT_TRUE(has(said, "write: out/a/#number.txt (3 files)")) << said;
}
