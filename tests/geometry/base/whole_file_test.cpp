#include "geometry/base/whole_file.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using geometry::write_whole_file;

class WholeFile : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "aspic-XXXXXX").string();
        ASSERT_TRUE(mkdtemp(pattern.data()));
        folder = pattern;
    }
    void TearDown() override { fs::remove_all(folder); }

    std::string text(const fs::path& file) const
    {
        std::ifstream in(file, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    }
    std::size_t files() const
    {
        return static_cast<std::size_t>(
            std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
    }
    fs::path folder;
};

TEST_F(WholeFile, IsWhatWasWrittenLast)
{
    for (const char* bytes : {"one", "", "another"}) {
        write_whole_file(folder / "file", bytes);
        EXPECT_EQ(text(folder / "file"), bytes);
        EXPECT_EQ(files(), 1u);
    }
    write_whole_file(folder / "new" / "er" / "file", "x");
    EXPECT_EQ(text(folder / "new/er/file"), "x");
}

TEST_F(WholeFile, CannotStandWhereAFolderDoes)
{
    fs::create_directories(folder / "taken" / "by");
    EXPECT_THROW(write_whole_file(folder / "taken", "x"), std::runtime_error);
    EXPECT_EQ(files(), 1u) << "and nothing is left of the attempt";
}

// A process may write files of a megabyte and is killed in the middle of its second one.
TEST_F(WholeFile, AKilledWriterLeavesTheOldFileAndNothingElse)
{
    write_whole_file(folder / "file", "old");
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit megabyte{1 << 20, 1 << 20};
        ::setrlimit(RLIMIT_FSIZE, &megabyte);
        const rlimit none{0, 0};
        ::setrlimit(RLIMIT_CORE, &none);
        ::signal(SIGXFSZ, SIG_DFL);
        write_whole_file(folder / "file", std::string(4 << 20, 'x'));
        ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status));
    EXPECT_EQ(text(folder / "file"), "old");
    EXPECT_EQ(files(), 1u);
}

}  // namespace
