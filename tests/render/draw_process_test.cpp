// Drawing in a process of its own: what happens when that process ends.

#include "geometry/base/sanitizers.hpp"
#include "geometry/mesh/primitive.hpp"
#include "pictures.hpp"
#include "render/draw.hpp"
#include "render/draw_process.hpp"
#include "render/fill_in.hpp"
#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>
#include <vector>

namespace {

using namespace tests;
using render::Image;
using render::Look;

// The variable as long as this lives.
class Variable {
public:
    Variable(const char* name, const std::string& value) : name_(name)
    {
        if (const char* before = std::getenv(name)) before_ = before;
        setenv(name, value.c_str(), 1);
    }
    Variable(const Variable&) = delete;
    ~Variable() { before_.empty() ? unsetenv(name_) : setenv(name_, before_.c_str(), 1); }

private:
    const char* name_;
    std::string before_;
};

// An opaque thing over a floor with a shadow, and a clear one before it.
Image picture(int rings = 24, const std::function<void()>& check = {})
{
    render::Scene scene;
    scene.surfaces = {surface(geometry::uv_sphere(1, 2 * rings, rings)),
                      surface(geometry::box({0.5, 0.5, 3}, {1, 1, 1}))};
    scene.surfaces[1].opacity = 0.5f;
    scene.ground = -1;
    Look look;
    look.width = 96;
    look.height = 54;
    return render::draw(scene, {{0, 2, 6}, {0, 0, 0}, {0, 1, 0}, 0.6}, look, nullptr, check);
}

bool runs(int pid)
{
    std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
    std::string id, name, state;
    return (file >> id >> name >> state) && state != "Z" && state != "X";
}

// The process that draws the next picture.
int next_process()
{
    picture();
    const auto idle = render::idle_draw_processes();
    return idle.empty() ? -1 : idle.back();
}

TEST(DrawProcess, GivesThePixelsOfThisProcess)
{
    ASSERT_FALSE(render::draw_program().empty()) << "aspic-draw is not built";
    const Image theirs = picture();
    const Variable here("ASPIC_DRAW", "none");
    EXPECT_TRUE(render::draw_program().empty());
    EXPECT_EQ(picture().rgba, theirs.rgba);
}

TEST(DrawProcess, AnotherOneDrawsThePictureOfOneThatWasKilled)
{
    const Image expected = picture();
    std::vector<int> signals{SIGKILL};
#ifndef ASPIC_ADDRESS_SANITIZER  // it answers the others itself
    signals.insert(signals.end(), {SIGSEGV, SIGABRT});
#endif
    for (const int signal : signals) {
        const int pid = next_process();
        ASSERT_GT(pid, 0);
        ASSERT_EQ(kill(pid, SIGSTOP), 0);  // so that it gets no further than being asked
        Image image;
        std::thread drawing([&] { image = picture(); });
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        EXPECT_TRUE(image.rgba.empty());
        ASSERT_EQ(kill(pid, signal), 0);
        kill(pid, SIGCONT);
        drawing.join();
        EXPECT_EQ(image.rgba, expected.rgba) << signal;
        EXPECT_FALSE(runs(pid));
        EXPECT_NE(next_process(), pid);
    }
}

TEST(DrawProcess, OneThatEndedWhileItWaitedIsReplaced)
{
    const Image expected = picture();
    const int pid = next_process();
    ASSERT_EQ(kill(pid, SIGKILL), 0);
    EXPECT_EQ(picture().rgba, expected.rgba);
    EXPECT_NE(kill(pid, 0), 0) << "it was not waited for";
}

TEST(DrawProcess, OneThatAlwaysEndsIsAnErrorThatSaysHow)
{
    const files::Folder folder;
    const auto program = folder.write("fake", "#!/bin/sh\necho run >> \"$0.runs\"\n"
                                              "echo 'no such luck' >&2\nkill -SEGV $$\n");
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    const Variable fake("ASPIC_DRAW", program);
    try {
        picture();
        FAIL();
    } catch (const std::runtime_error& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("Segmentation fault: no such luck"), std::string::npos) << text;
        EXPECT_NE(text.find(program.string()), std::string::npos) << text;
    }
    EXPECT_EQ(files::bytes_of(program.string() + ".runs"), "run\nrun\nrun\n");
    const Variable nowhere("ASPIC_DRAW", "/nowhere/aspic-draw");
    EXPECT_THROW(picture(), std::runtime_error);
}

TEST(DrawProcess, WaitingForItCanBeEnded)
{
    const int pid = next_process();
    ASSERT_EQ(kill(pid, SIGSTOP), 0);
    struct Enough {};
    EXPECT_THROW(picture(24, [] { throw Enough(); }), Enough);
    EXPECT_FALSE(runs(pid));
    EXPECT_FALSE(picture().rgba.empty());
}

TEST(DrawProcess, ReportsTheErrorsOfOpenGL)
{
    render::DrawProcess process(render::draw_program());
    render::DrawJob job;
    job.numbers.width = 1 << 20;  // no texture is that wide
    job.numbers.height = 1;
    std::vector<std::uint8_t> rgba(std::size_t{4} << 20);
    try {
        process.draw(job, {rgba}, {});
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("OpenGL reports error"), std::string::npos);
    }
}

// This program once more, which draws, says which process drew, and is killed.
TEST(DrawProcess, EndsWithTheProgramThatStartedIt)
{
    if (const char* path = std::getenv("ASPIC_TEST_PROCESS_TO")) {
        std::ofstream(path) << next_process() << std::endl;
        raise(SIGKILL);
    }
    const files::Folder folder;
    const auto path = folder.path / "process";
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
    const std::string command = "ASPIC_TEST_PROCESS_TO='" + path.string() + "' '" + program +
                                "' --gtest_filter=DrawProcess.EndsWith* >/dev/null 2>&1";
    EXPECT_NE(std::system(command.c_str()), 0);
    int pid = -1;
    std::ifstream(path) >> pid;
    ASSERT_GT(pid, 0);
    for (int i = 0; i < 1000 && runs(pid); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    EXPECT_FALSE(runs(pid));
}

// Several contexts at once in one process crashed one cook in twenty (fill_in.cpp says why).
TEST(DrawProcess, ManyThreadsDrawAtOnceAndGetTheSamePixels)
{
    const Image expected = picture(60);
    for (const char* where : {"", "none"}) {
        const Variable variable("ASPIC_DRAW", where);
        std::atomic<int> differ = 0;
        std::vector<std::thread> threads;
        for (int t = 0; t < 6; ++t) {
            threads.emplace_back([&] {
                for (int i = 0; i < 6; ++i) differ += picture(60).rgba != expected.rgba;
            });
        }
        for (auto& thread : threads) thread.join();
        EXPECT_EQ(differ, 0) << where;
    }
}

}  // namespace
