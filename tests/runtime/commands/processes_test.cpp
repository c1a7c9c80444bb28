// The program itself: killed, several at once, on disks that are full or not to be written.

#include "geometry/base/sanitizers.hpp"
#include "runtime/cache/disk_cache.hpp"
#include "tests/runtime/toys.hpp"

#include <csignal>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <random>
#include <spawn.h>
#include <sys/mount.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using std::chrono::duration;
using std::chrono::steady_clock;
using toys::bytes_of;

const std::string falling = toys::falling_block(20, 0.125);

// A ball with a soft layer that keeps its volume falls on a stone and rolls off.
const char* const layered = R"({ "aspic": 1, "frames": { "first": 1, "last": 20, "fps": 24 },
  "nodes": {
    "skeleton": { "type": "Skeletons@1", "params": { "skeletons": [
      { "kind": "point", "position": [0.02, 0.3, 0],
        "contribution": { "thickness": 0.1, "stiffness": 10, "radius": 0.25 } } ] } },
    "ball": { "type": "ImplicitLayer@3", "inputs": { "layer": "skeleton.layer" },
      "params": { "seed_spacing": 0.015, "volume": { "proportional": 10 } } },
    "stone": { "type": "Primitive@1", "params": { "shape": "sphere", "sphere": { "radius": 0.1 } } },
    "hard": { "type": "Collider@1", "inputs": { "mesh": "stone.mesh" },
      "params": { "kind": "mesh" } },
    "motion": { "type": "Layered@1",
      "inputs": { "parts": ["ball.part"], "colliders": ["hard.collider"] } },
    "surface": { "type": "Polygonize@2", "inputs": { "scene": "motion.scene" },
      "params": { "surface": "seeds" } },
    "files": { "type": "WriteMesh@1", "inputs": { "mesh": "surface.mesh" },
      "params": { "path": "ball.####.ply" } } } })";

// Runs a program with no output but what goes to `log`.
pid_t start_program(std::vector<std::string> words, const fs::path& log)
{
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, 2, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    pid_t child = 0;
    const int error = posix_spawn(&child, argv[0], &files, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    if (error != 0) throw std::runtime_error(argv[0] + std::string(" can't be run"));
    return child;
}
pid_t start(std::vector<std::string> words, const fs::path& log)
{
    words.insert(words.begin(), ASPIC_PROGRAM);
    return start_program(std::move(words), log);
}
int wait_for(pid_t child)
{
    int status = 0;
    ::waitpid(child, &status, 0);
    return status;
}

// All files of a folder by name, but for the manifest, which tells of times, and what a killed
// writer had not finished.
std::map<std::string, std::string> files_of(const fs::path& folder)
{
    std::map<std::string, std::string> all;
    for (const auto& f : fs::directory_iterator(folder)) {
        const fs::path name = f.path().filename();
        if (name == "manifest.json" || name.extension() == ".part" || f.is_directory()) continue;
        all[name] = bytes_of(f.path());
    }
    return all;
}

class Processes : public testing::Test {
protected:
    void SetUp() override { folder_.write("falling.json", falling); }

    pid_t begin(const fs::path& cache, const fs::path& out)
    {
        return start({"cook", (folder_.path / "falling.json").string(), "--cache", cache.string(),
                      "--out", out.string(), "--quiet"},
                     log());
    }
    std::map<std::string, std::string> cook(const fs::path& cache, const fs::path& out)
    {
        EXPECT_EQ(wait_for(begin(cache, out)), 0) << bytes_of(log());
        return files_of(out);
    }
    // Kills cooks of `document` at moments from first to last, and looks at what those that come
    // after leave. ASPIC_KILLS=50 for the whole proof.
    void survive_kills(const std::string& document)
    {
        folder_.write("falling.json", document);
        const auto begun = steady_clock::now();
        const auto expected = cook(folder_.path / "whole", folder_.path / "out");
        const double seconds = duration<double>(steady_clock::now() - begun).count();
        ASSERT_EQ(expected.size(), 20u);

        const char* const wanted = std::getenv("ASPIC_KILLS");
        const int kills = wanted ? std::atoi(wanted) : 3;
        std::mt19937 random(11);
        for (int k = 0; k < kills; ++k) {
            const fs::path here = folder_.path / std::to_string(k);
            const double moment = seconds * 0x1p-32 * static_cast<double>(random());
            const pid_t child = begin(here / "cache", here / "out");
            std::this_thread::sleep_for(duration<double>(moment));
            ::kill(child, SIGKILL);
            wait_for(child);
            EXPECT_EQ(cook(here / "cache", here / "out"), expected)
                << "killed after " << moment << " s";
            EXPECT_EQ(said(), std::vector<std::string>{});
            runtime::DiskCache cache(here / "cache", std::uintmax_t{1} << 30, nullptr);
            EXPECT_EQ(cache.verify().bad, 0u);
            fs::remove_all(here);
        }
    }
    fs::path log() const { return folder_.path / "log"; }
    // What the last one said of its cache.
    std::vector<std::string> said() const
    {
        std::vector<std::string> lines;
        std::ifstream in(log());
        for (std::string line; std::getline(in, line);) {
            if (line.find("cache") != std::string::npos) lines.push_back(line);
        }
        return lines;
    }

    toys::Folder folder_;
};

// A file system of this many bytes in memory; not for everyone.
class SmallDisk {
public:
    SmallDisk(const fs::path& folder, const char* size) : folder_(folder)
    {
        fs::create_directories(folder);
        const std::string options = std::string("size=") + size;
        there_ = ::mount("tmpfs", folder.c_str(), "tmpfs", 0, options.c_str()) == 0;
    }
    ~SmallDisk()
    {
        if (there_) ::umount2(folder_.c_str(), MNT_DETACH);
    }
    bool there() const { return there_; }
    bool make_read_only() const
    {
        return ::mount(nullptr, folder_.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) == 0;
    }

private:
    fs::path folder_;
    bool there_ = false;
};

}  // namespace

TEST_F(Processes, AFarmOnThisMachineWritesTheBytesOfACook)
{
    const auto plain = cook(folder_.path / "cache", folder_.path / "plain");
    const pid_t farm =
        start({"farm", (folder_.path / "falling.json").string(), "--engine", "local", "--at-once",
               "2", "--threads", "1", "--task-seconds", "10", "--cache",
               (folder_.path / "shared").string(), "--out", (folder_.path / "farmed").string()},
              log());
    ASSERT_EQ(wait_for(farm), 0) << bytes_of(log());
    EXPECT_TRUE(bytes_of(log()).find("4 of 4") != std::string::npos) << bytes_of(log());
    const auto farmed = files_of(folder_.path / "farmed");
    EXPECT_EQ(farmed, plain);
    EXPECT_EQ(farmed.size(), 20u);
}

TEST_F(Processes, AKilledCookGoesOnAndLeavesTheSameBytes)
{
    survive_kills(falling);
}

TEST_F(Processes, AKilledCookOfLayersGoesOnAndLeavesTheSameBytes)
{
    survive_kills(layered);
}

TEST_F(Processes, FourOnOneCacheLeaveTheSameBytesAsOne)
{
    const auto expected = cook(folder_.path / "alone", folder_.path / "out");
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) {
        children.push_back(
            begin(folder_.path / "shared", folder_.path / ("out" + std::to_string(i))));
    }
    for (const pid_t child : children) EXPECT_EQ(wait_for(child), 0) << bytes_of(log());
    for (int i = 0; i < 4; ++i) {
        EXPECT_EQ(files_of(folder_.path / ("out" + std::to_string(i))), expected);
    }
    runtime::DiskCache cache(folder_.path / "shared", std::uintmax_t{1} << 30, nullptr);
    EXPECT_EQ(cache.verify().bad, 0u);
    const runtime::DiskUse use = cache.use();
    EXPECT_EQ(use.aside, 0u);
}

// As two machines see a shared folder: each by a mount of its own, and nothing else of the other.
TEST_F(Processes, CooksInTwoMountNamespacesAreJoinedByTheStoreAlone)
{
    const fs::path store = folder_.path / "store";
    fs::create_directories(store);
    const auto on_machine = [&](const std::string& name, const std::string& frames) {
        const std::string here = (folder_.path / name).string();
        // A folder that nobody else sees, in it the store by another path and what is written.
        const std::string script = "set -e; mkdir -p " + here + "; mount -t tmpfs tmpfs " + here +
                                   " || exit 77; mkdir " + here + "/store; mount --bind " +
                                   store.string() + " " + here +
                                   "/store || exit 77; exec " ASPIC_PROGRAM " cook " +
                                   (folder_.path / "falling.json").string() + " --cache " + here +
                                   "/store --out " + here + "/out --frames " + frames + " --quiet";
        return start_program(
            {"/usr/bin/unshare", "--mount", "--propagation", "private", "sh", "-c", script},
            folder_.path / (name + ".log"));
    };
    if (wait_for(start_program({"/usr/bin/unshare", "--mount", "true"},
                               folder_.path / "probe.log")) != 0) {
        GTEST_SKIP() << "needs to be allowed to unshare mounts";
    }
    const pid_t first = on_machine("n0", "1-14"), second = on_machine("n1", "1-20");
    const int status = wait_for(first), other = wait_for(second);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 77) {
        GTEST_SKIP() << "needs to be allowed to mount: " << bytes_of(folder_.path / "n0.log");
    }
    ASSERT_EQ(status, 0) << bytes_of(folder_.path / "n0.log");
    ASSERT_EQ(other, 0) << bytes_of(folder_.path / "n1.log");
    EXPECT_TRUE(fs::is_empty(folder_.path / "n0")) << "what it wrote was its own";
    // What both left in the store is whole, and what a third one makes of it is right.
    runtime::DiskCache cache(store, std::uintmax_t{1} << 30, nullptr);
    EXPECT_EQ(cache.verify().bad, 0u);
    EXPECT_EQ(cache.use().aside, 0u);
    EXPECT_EQ(cook(store, folder_.path / "out"),
              cook(folder_.path / "alone", folder_.path / "out2"));
    EXPECT_GT(cache.use().records, 20u) << "they did store something";
}

TEST_F(Processes, AFullDiskWarnsAndTheCookGoesOn)
{
    const auto expected = cook(folder_.path / "roomy", folder_.path / "out");
    const fs::path full = folder_.path / "full";
    const SmallDisk disk(full, "64k");
    if (!disk.there()) GTEST_SKIP() << "needs to be allowed to mount";
    EXPECT_EQ(cook(full, folder_.path / "out2"), expected);
    ASSERT_EQ(said().size(), 1u) << bytes_of(log());
    EXPECT_NE(said()[0].find("No space left"), std::string::npos) << said()[0];
    // What did fit is good.
    EXPECT_EQ(cook(full, folder_.path / "out3"), expected);
    runtime::DiskCache cache(full, std::uintmax_t{1} << 30, nullptr);
    EXPECT_EQ(cache.verify().bad, 0u);
}

TEST_F(Processes, AReadOnlyCacheIsReadAndWarnsAtMostOnce)
{
    const fs::path stored = folder_.path / "stored";
    const SmallDisk disk(stored, "64m");
    if (!disk.there()) GTEST_SKIP() << "needs to be allowed to mount";
    const auto expected = cook(stored, folder_.path / "out");
    ASSERT_TRUE(disk.make_read_only());
    EXPECT_EQ(cook(stored, folder_.path / "out"), expected);
    EXPECT_EQ(said(), std::vector<std::string>{}) << "nothing to write: nothing to warn of";
    EXPECT_EQ(cook(stored, folder_.path / "out2"), expected);
    ASSERT_EQ(said().size(), 1u) << bytes_of(log());
    EXPECT_NE(said()[0].find("Read-only file system"), std::string::npos) << said()[0];
}

// What a stranger's graph may ask for: each is refused by the node, in words, whatever the machine
// has. The last two do not pass the node's own limits but that of memory.
TEST_F(Processes, AGraphThatNeedsTooMuchMemoryFailsWithAMessage)
{
    const std::string ball = R"("a": { "type": "Primitive@1", "params": { "shape": "sphere" } }, )";
    const auto behind_ball = [&](const char* node) { return ball + node; };
    const std::vector<std::pair<std::string, const char*>> graphs{
        {R"("a": { "type": "Primitive@1", "params": { "shape": "grid",
             "grid": { "divisions_x": 100000, "divisions_z": 100000 } } })",
         "20000000000 faces, the limit is 50 million"},
        {behind_ball(R"("b": { "type": "Copies@1", "inputs": { "mesh": "a.mesh" }, "params": {
             "count_x": 100000, "count_y": 100000, "count_z": 100000 } })"),
         "1000000000000000 copies"},
        {behind_ball(R"("b": { "type": "Voxelize@1", "inputs": { "mesh": "a.mesh" },
             "params": { "method": "solid", "size": 1e-6 } })"),
         "would fit"},
        {behind_ball(R"("b": { "type": "Sample@2", "inputs": { "mesh": "a.mesh" },
             "params": { "spacing": 1e-9 } })"),
         "use a larger spacing"},
        {behind_ball(R"("b": { "type": "Render@2", "inputs": { "mesh": "a.mesh" },
             "params": { "width": 1000000, "height": 1000000 } })"),
         "from 1 to 8192 px"},
#ifndef ASPIC_ADDRESS_SANITIZER
#ifndef ASPIC_THREAD_SANITIZER
        {behind_ball(R"("b": { "type": "Sample@2", "inputs": { "mesh": "a.mesh" },
             "params": { "count": 100000000 } })"),
         "out of memory (limit 400 MB)"},
        {behind_ball(R"("b": { "type": "Sample@2", "inputs": { "mesh": "a.mesh" },
             "params": { "count": 100000000, "where": "volume" } })"),
         "out of memory (limit 400 MB)"},
#endif
#endif
    };
    for (const auto& [nodes, words] : graphs) {
        const fs::path file =
            folder_.write("big.json", R"({ "aspic": 1, "nodes": { )" + nodes + " } }");
        const int status =
            wait_for(start({"cook", file.string(), "--no-disk-cache", "--out",
                            (folder_.path / "out").string(), "--memory-limit", "400M", "--quiet"},
                           log()));
        ASSERT_TRUE(WIFEXITED(status)) << nodes << bytes_of(log());
        EXPECT_TRUE(WEXITSTATUS(status) == 1 || WEXITSTATUS(status) == 2) << bytes_of(log());
        EXPECT_NE(bytes_of(log()).find(words), std::string::npos) << bytes_of(log());
    }
}

#ifndef ASPIC_ADDRESS_SANITIZER
#ifndef ASPIC_THREAD_SANITIZER
TEST_F(Processes, ADocumentLargerThanMemoryIsNamed)
{
    std::string text = R"({ "aspic": 1, "nodes": { "n": { "type": "Primitive@1" })";
    for (int i = 0; i < 100'000; ++i) {
        text += ", \"n" + std::to_string(i) + "\": { \"type\": \"Primitive@1\" }";
    }
    const fs::path file = folder_.write("large.json", text + " } }");
    const int status =
        wait_for(start({"cook", file.string(), "--no-disk-cache", "--out",
                        (folder_.path / "out").string(), "--memory-limit", "60M", "--quiet"},
                       log()));
    ASSERT_TRUE(WIFEXITED(status)) << bytes_of(log());
    EXPECT_EQ(WEXITSTATUS(status), 1);
    EXPECT_NE(bytes_of(log()).find("large.json: out of memory"), std::string::npos)
        << bytes_of(log());
}

// Wherever memory runs out: before OpenGL has begun, which would crash, or never.
TEST_F(Processes, APictureLargerThanMemoryIsRefused)
{
    const fs::path file = folder_.write("picture.json", R"({ "aspic": 1, "nodes": {
        "a": { "type": "Primitive@1", "params": { "shape": "sphere" } },
        "b": { "type": "Render@2", "inputs": { "mesh": "a.mesh" },
               "params": { "width": 800, "height": 600 } } } })");
    std::set<int> exits;
    for (const int megabytes : {40, 60, 80, 100, 120, 140, 160, 200, 300, 500}) {
        const int status = wait_for(start({"cook", file.string(), "--no-disk-cache", "--out",
                                           (folder_.path / "out").string(), "--memory-limit",
                                           std::to_string(megabytes) + "M", "--quiet"},
                                          log()));
        ASSERT_TRUE(WIFEXITED(status)) << megabytes << " MB: " << bytes_of(log());
        exits.insert(WEXITSTATUS(status));
    }
    EXPECT_EQ(exits, (std::set{0, 1}));
}
#endif
#endif

// What the end of a terminal sends, more than once.
TEST_F(Processes, ASignalThatTheTerminalIsGoneLeavesAManifest)
{
    folder_.write("falling.json", toys::falling_block(2000, 0.125));
    struct sigaction now = {};
    ::sigaction(SIGHUP, nullptr, &now);
    if (now.sa_handler == SIG_IGN) GTEST_SKIP() << "runs under nohup, which hides the signal";
    for (const int signal : {SIGHUP, SIGTERM}) {
        const fs::path out = folder_.path / "out";
        fs::remove_all(out);
        const pid_t child = begin(folder_.path / "cache", out);
        const auto begun = steady_clock::now();
        while (!fs::exists(out / "block.0005.ply") &&
               steady_clock::now() - begun < std::chrono::seconds(60)) {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        ::kill(child, signal);
        if (signal == SIGHUP) ::kill(child, signal);
        const int status = wait_for(child);
        EXPECT_TRUE(WIFEXITED(status)) << signal;
        EXPECT_EQ(WEXITSTATUS(status), 130) << signal << bytes_of(log());
        const std::string manifest = bytes_of(out / "manifest.json");
        EXPECT_NE(manifest.find("\"complete\": false"), std::string::npos) << signal << manifest;
    }
}

// The real sinks, which make folders and rename: nothing is written where a link leads.
TEST_F(Processes, NoSinkWritesThroughALinkOutOfTheFolder)
{
    std::string text = falling;
    text.replace(text.find("block.####.ply"), 14, "frames/####.ply");
    folder_.write("falling.json", text);
    fs::create_directories(folder_.path / "out");
    fs::create_directories(folder_.path / "elsewhere");
    fs::create_symlink("../elsewhere", folder_.path / "out/frames");
    const int status = wait_for(begin(folder_.path / "cache", folder_.path / "out"));
    EXPECT_EQ(WEXITSTATUS(status), 1) << bytes_of(log());
    EXPECT_TRUE(fs::is_empty(folder_.path / "elsewhere"));
}

// Names are names: nothing of a document reaches a shell.
TEST_F(Processes, ADocumentRunsNoCommands)
{
    const fs::path owned = folder_.path / "owned";
    const std::string name =
        "$(touch " + owned.filename().string() + "); touch owned; `touch owned`";
    folder_.write("falling.json", R"({ "aspic": 1, "nodes": {
      "block": { "type": "Primitive@1" },
      "picture": { "type": "Render@2", "inputs": { "mesh": "block.mesh" },
                   "params": { "width": 16, "height": 16 } },
      "frames": { "type": "WriteImage@1", "inputs": { "image": "picture.image" },
                  "params": { "path": ")" +
                                      name + R"( ####.png" } },
      "video": { "type": "WriteVideo@1", "inputs": { "frames": "frames.file" },
                 "params": { "path": ")" +
                                      name + R"(.mp4" } } } })");
    const auto files = cook(folder_.path / "cache", folder_.path / "out");
    EXPECT_TRUE(files.contains(name + " 0001.png"));
    EXPECT_TRUE(files.contains(name + ".mp4"));
    EXPECT_FALSE(fs::exists("owned") || fs::exists(owned) ||
                 fs::exists(folder_.path / "out/owned"));
}
