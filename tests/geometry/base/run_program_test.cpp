#include "geometry/base/run_program.hpp"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <csignal>
#include <stdexcept>
#include <sys/wait.h>
#include <unistd.h>

namespace {

using geometry::ProgramCall;
using geometry::run_program;

ProgramCall shell(const std::string& script)
{
    ProgramCall call;
    call.words = {"sh", "-c", script};
    return call;
}

double seconds_since(std::chrono::steady_clock::time_point begin)
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

TEST(RunProgram, TellsWhatItSaidAndHowItEnded)
{
    const auto run = run_program(shell("echo one; echo two >&2; exit 7"), [] {});
    EXPECT_TRUE(run.found);
    EXPECT_TRUE(run.in_time);
    EXPECT_EQ(run.said, "one\ntwo\n");
    ASSERT_TRUE(WIFEXITED(run.status));
    EXPECT_EQ(WEXITSTATUS(run.status), 7);
    const auto killed = run_program(shell("kill -ABRT $$"), [] {});
    ASSERT_TRUE(WIFSIGNALED(killed.status));
    EXPECT_EQ(WTERMSIG(killed.status), SIGABRT);
}

TEST(RunProgram, KeepsTheEndOfWhatItSaid)
{
    const auto run = run_program(shell("yes | head -c 100000; echo end"), [] {});
    EXPECT_LE(run.said.size(), 4000u);
    EXPECT_EQ(run.said.substr(run.said.size() - 4), "end\n");
}

TEST(RunProgram, GivesNoInputAndOnlyTheEnvironmentAskedFor)
{
    // Whatever this process could read from its own.
    std::array<int, 2> ends{};
    ASSERT_EQ(pipe(ends.data()), 0);
    ASSERT_EQ(write(ends[1], "ours\n", 5), 5);
    close(ends[1]);
    const int kept = dup(0);
    dup2(ends[0], 0);
    const std::string said = run_program(shell("cat; echo done"), [] {}).said;
    dup2(kept, 0);
    close(kept);
    close(ends[0]);
    EXPECT_EQ(said, "done\n");
    ProgramCall call = shell("echo $GIVEN$HOME");
    call.environment = {"GIVEN=yes"};
    EXPECT_EQ(run_program(call, [] {}).said, "yes\n");
}

TEST(RunProgram, SaysWhenThereIsNoSuchProgram)
{
    ProgramCall call;
    call.words = {"/nowhere/no-such-program"};
    EXPECT_FALSE(run_program(call, [] {}).found);
    call.words = {"/"};
    EXPECT_THROW(run_program(call, [] {}), std::runtime_error);
}

TEST(RunProgram, EndsItAfterItsTimeAndWhenTheCheckThrows)
{
    const auto begin = std::chrono::steady_clock::now();
    ProgramCall call = shell("exec sleep 60");
    call.seconds = 0.2;
    EXPECT_FALSE(run_program(call, [] {}).in_time);
    call.seconds = 60;
    struct Stop {};
    EXPECT_THROW(run_program(call, [] { throw Stop(); }), Stop);
    EXPECT_LT(seconds_since(begin), 30);
}

}  // namespace
