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

TEST_F(OutputFolder, IsNamedAsItWasGiven)
{
    const WorkingFolder here(folder_.path / "p");
    const std::string said = cook("out/a").out;
    EXPECT_TRUE(has(said, "write: out/a/#number.txt (3 files)")) << said;
}
