// A Slurm of two nodes on this machine, started by the test itself, and the program as it is. Each
// node has mounts of its own: of what other machines write, it sees the shared folder and nothing
// else.

#include "geometry/base/sanitizers.hpp"
#include "tests/runtime/toys.hpp"

#include <csignal>
#include <gtest/gtest.h>
#include <set>
#include <thread>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;
using toys::bytes_of;

bool there_is(const std::string& program)
{
    for (const char* const folder : {"/usr/bin/", "/usr/sbin/"}) {
        if (::access((folder + program).c_str(), X_OK) == 0) return true;
    }
    return false;
}

class Slurm : public testing::Test {
protected:
    void SetUp() override
    {
        for (const char* const program : {"munged", "slurmctld", "slurmd", "sbatch"}) {
            if (!there_is(program)) GTEST_SKIP() << program << " is not installed";
        }
#if defined(ASPIC_ADDRESS_SANITIZER) || defined(ASPIC_THREAD_SANITIZER)
        GTEST_SKIP() << "the tasks are the same cooks that other tests run under a sanitizer";
#endif
        if (::geteuid() != 0) GTEST_SKIP() << "munged and slurmd need to be started by root";
        document_ = folder_.write("block.json", document());
        for (const char* const name : {"log", "state", "spool"}) fs::create_directories(in(name));
        folder_.write("node.sh", mounts_of_a_node());
        const int port = 10000 + ::getpid() % 5000 * 4;
        folder_.write("slurm.conf", configuration(port));
        ::setenv("SLURM_CONF", in("slurm.conf").c_str(), 1);
        // A machine may forbid what a Slurm of its own needs: ports, pid files, the keys of munge.
        const std::string failed = start_slurm();
        if (!failed.empty()) GTEST_SKIP() << "a Slurm does not start here: " << failed;
    }
    void TearDown() override
    {
        if (!fs::exists(in("slurm.conf"))) return;
        said("scancel -u root");
        for (const char* const name : {"slurmd.n0", "slurmd.n1", "slurmctld", "munged"}) {
            const pid_t pid = number_in(in(std::string(name) + ".pid"));
            if (pid > 0) ::kill(pid, SIGTERM);
        }
        for (const char* const name : {"slurmd.n0", "slurmd.n1", "slurmctld", "munged"}) {
            for (int i = 0; i < 200 && fs::exists(in(std::string(name) + ".pid")); ++i) nap();
        }
    }

    // What did not work; empty where two nodes are idle.
    std::string start_slurm() const
    {
        for (const std::string& command :
             {std::string("dd if=/dev/urandom of=munge.key bs=1024 count=1 2>log/dd; "
                          "chmod 400 munge.key"),
              std::string("munged --force --key-file=munge.key --socket=$PWD/munge.sock "
                          "--pid-file=$PWD/munged.pid --log-file=$PWD/log/munged.log "
                          "--seed-file=$PWD/munged.seed 2>log/munged"),
              std::string("slurmctld -f $PWD/slurm.conf"), start_of_node("n0"),
              start_of_node("n1")}) {
            if (status(command) != 0) return command;
        }
        for (int i = 0; i < 3000; ++i, nap()) {
            if (said("sinfo -h -r -o %D%t -t idle").find("2idle") != std::string::npos) return "";
        }
        return "two nodes are not idle: " + said("sinfo");
    }

    static void nap()
    {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    static pid_t number_in(const fs::path& file)
    {
        pid_t pid = 0;
        std::ifstream(file) >> pid;
        return pid;
    }
    fs::path in(const std::string& name) const
    {
        return folder_.path / name;
    }
    int status(const std::string& command) const
    {
        const std::string line = "cd " + folder_.path.string() + " && " + command;
        return WEXITSTATUS(std::system(line.c_str()));
    }
    void must(const std::string& command) const
    {
        ASSERT_EQ(status(command), 0) << command;
    }
    std::string said(const std::string& command) const
    {
        status(command + " >said 2>&1");
        return bytes_of(in("said"));
    }
    static std::string start_of_node(const std::string& node)
    {
        return "unshare --mount --propagation private sh node.sh $PWD " + node;
    }
    // Folders where a program might leave something for another one are the node's own, but for
    // one that holds the program. The shared folder is mounted a second time.
    static std::string mounts_of_a_node()
    {
        const std::string program = ASPIC_PROGRAM;
        std::string script = "set -e\nmount --bind $1 /mnt\n";
        const char* home = std::getenv("HOME");
        const std::string kept = std::string(home ? home : "/root") + "/.cache";
        for (const std::string& folder :
             {std::string("/tmp"), std::string("/var/tmp"), std::string("/dev/shm"), kept}) {
            if (program.starts_with(folder + "/")) continue;
            script += "[ ! -d " + folder + " ] || mount -t tmpfs tmpfs " + folder + "\n";
        }
        return script +
               "mkdir -p $1\nmount --move /mnt $1\ncd $1\nexec slurmd -N $2 -f $1/slurm.conf\n";
    }
    // The files are in a folder of their own below the output folder.
    static std::string document(int last = 12, double cube = 0.0625)
    {
        std::string text = toys::falling_block(last, cube);
        return text.replace(text.find("block.####"), 5, "mesh/block");
    }
    // A command where a node's mounts are.
    void must_on(const std::string& node, const std::string& command) const
    {
        const pid_t pid = number_in(in("slurmd." + node + ".pid"));
        must("nsenter --mount --target " + std::to_string(pid) + " " + command);
    }
    template <class F> void wait_until(const std::string& what, const F& f) const
    {
        const auto begin = steady_clock::now();
        while (!f()) {
            ASSERT_LT(steady_clock::now() - begin, std::chrono::seconds(60)) << "until " << what;
            nap();
        }
    }
    std::string configuration(int port) const
    {
        const std::string d = folder_.path.string();
        return "ClusterName=test\nSlurmctldHost=localhost(127.0.0.1)\nSlurmctldPort=" +
               std::to_string(port) +
               "\nSlurmUser=root\nSlurmdUser=root\nAuthType=auth/munge\nAuthInfo=socket=" + d +
               "/munge.sock\nCredType=cred/munge\nProctrackType=proctrack/linuxproc\n"
               "TaskPlugin=task/none\nSelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n"
               "MpiDefault=none\nReturnToService=2\nStateSaveLocation=" +
               d + "/state\nSlurmdSpoolDir=" + d + "/spool/%n\nSlurmdPidFile=" + d +
               "/slurmd.%n.pid\nSlurmctldPidFile=" + d + "/slurmctld.pid\nSlurmdLogFile=" + d +
               "/log/slurmd.%n.log\nSlurmctldLogFile=" + d +
               "/log/slurmctld.log\nAccountingStorageType=accounting_storage/none\n"
               "MinJobAge=3600\nKillWait=1\nSlurmdParameters=config_overrides\n"
               "SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0,"
               "sched_min_interval=0\n"
               "NodeName=n[0-1] NodeHostname=localhost NodeAddr=127.0.0.1 Port=[" +
               std::to_string(port + 1) + "-" + std::to_string(port + 2) +
               "] CPUs=" + std::to_string(cpus_) +
               " RealMemory=4000\n"
               "PartitionName=main Nodes=n[0-1] Default=YES MaxTime=INFINITE State=UP\n";
    }

    // Sends the document to Slurm and waits for the end.
    std::string farm(const std::string& more = "--wait", const std::string& seconds = "4") const
    {
        return "timeout 60 " ASPIC_PROGRAM
               " farm block.json --engine slurm --out out --cache cache --task-seconds " +
               seconds + " " + more;
    }
    std::map<std::string, std::string> files(const std::string& folder) const
    {
        std::map<std::string, std::string> all;
        for (const auto& f : fs::directory_iterator(in(folder) / "mesh")) {
            if (f.path().extension() == ".ply") all[f.path().filename()] = bytes_of(f.path());
        }
        return all;
    }
    std::map<std::string, std::string> cooked() const
    {
        must(ASPIC_PROGRAM " cook block.json --no-disk-cache --out plain --quiet");
        return files("plain");
    }
    // Waits for the process of a task, and returns its number.
    pid_t process_of(const std::string& task) const
    {
        const std::string part = in("out/farm/parts/" + task + ".json").string();
        pid_t found = 0;
        wait_until(task + " runs", [&] {
            for (const auto& p : fs::directory_iterator("/proc")) {
                std::string words;
                try {
                    words = bytes_of(p.path() / "cmdline");
                } catch (const std::exception&) {  // it has ended since it was listed
                    continue;
                }
                if (words.find(part) == std::string::npos) continue;
                found = std::stoi(p.path().filename());
            }
            return found > 0;
        });
        return found;
    }

    toys::Folder folder_;
    fs::path document_;
    int cpus_ = 1;  // of a node
};

// Nodes that run several tasks at once: what is waited for is Slurm's next look at its queue.
class WideSlurm : public Slurm {
protected:
    WideSlurm() { cpus_ = 4; }
    std::map<std::string, std::string> files_if_any(const std::string& folder) const
    {
        return fs::exists(in(folder) / "mesh") ? files(folder)
                                               : std::map<std::string, std::string>();
    }
    // Results in the cache.
    std::size_t stored() const
    {
        std::size_t count = 0;
        if (!fs::exists(in("cache/5/records"))) return count;
        for (auto f = fs::recursive_directory_iterator(in("cache/5/records")); f != fs::end(f);
             ++f) {
            count += f->is_regular_file();
        }
        return count;
    }
    // All files by name, but for what tells of times.
    std::map<std::string, std::string> all_files(const std::string& folder) const
    {
        std::map<std::string, std::string> all;
        for (auto f = fs::recursive_directory_iterator(in(folder)); f != fs::end(f); ++f) {
            if (f->path().filename() == "farm") f.disable_recursion_pending();
            if (!f->is_regular_file() || f->path().filename() == "manifest.json") continue;
            all[fs::relative(f->path(), in(folder))] = bytes_of(f->path());
        }
        return all;
    }
};

}  // namespace

TEST_F(Slurm, TwoNodesWriteTheBytesOfACook)
{
    EXPECT_EQ(status(farm() + " >log/farm 2>&1"), 0) << bytes_of(in("log/farm"));
    const std::string text = bytes_of(in("log/farm"));
    EXPECT_NE(text.find("sent: 5 tasks in 3 jobs"), std::string::npos) << text;
    EXPECT_NE(text.find("5 of 5 tasks are done"), std::string::npos) << text;
    EXPECT_NE(text.find("verified: 12 files of 1 cook"), std::string::npos) << text;
    EXPECT_TRUE(files("out") == cooked());
    EXPECT_EQ(files("out").size(), 12u);
    // Both nodes took part.
    std::string logs;
    for (const auto& f : fs::directory_iterator(in("out/farm/logs"))) logs += bytes_of(f.path());
    EXPECT_NE(logs.find("on n0, job"), std::string::npos) << logs;
    EXPECT_NE(logs.find("on n1, job"), std::string::npos) << logs;
}

TEST_F(Slurm, AKilledTaskIsNamedAndTheNextRunCooksWhatIsMissing)
{
    must(farm("") + " >log/farm 2>&1");
    const pid_t task = process_of("block.frames-2");
    ASSERT_GT(task, 1) << bytes_of(in("log/farm"));
    ::kill(task, SIGKILL);
    const std::string state = ASPIC_PROGRAM " farm status block.json --out out";
    wait_until("none is in the queue", [&] { return said("squeue -h").empty(); });
    const std::string text = said(state);
    EXPECT_NE(status(state + " >log/status 2>&1"), 0);
    EXPECT_NE(text.find("3 of 5 tasks are done"), std::string::npos) << text;
    EXPECT_NE(text.find("block.frames-2 (frames 5-8) failed on n"), std::string::npos) << text;
    EXPECT_NE(text.find("1 did not run"), std::string::npos) << "the last one: " << text;
    EXPECT_FALSE(fs::exists(in("out/manifest.json")));

    EXPECT_EQ(status(farm() + " >log/farm 2>&1"), 0) << bytes_of(in("log/farm"));
    EXPECT_TRUE(files("out") == cooked());
}

TEST_F(Slurm, WhatIsCancelledGoesOnLaterAndWhatADiskHasNoRoomForToo)
{
    must(farm("") + " >log/farm 2>&1");
    must(ASPIC_PROGRAM " farm cancel block.json --out out >log/cancel 2>&1");
    wait_until("none is in the queue", [&] { return said("squeue -h").empty(); });

    // On one of the nodes, the files go to a disk with room for one of them.
    fs::create_directories(in("out/mesh"));
    must_on("n1", "mount -t tmpfs -o size=4k tmpfs $PWD/out/mesh");
    EXPECT_NE(status(farm() + " >log/farm 2>&1"), 0);
    const std::string text = bytes_of(in("log/farm"));
    EXPECT_NE(text.find(") failed on n1; its log is "), std::string::npos) << text;
    EXPECT_EQ(text.find(") failed on n0"), std::string::npos) << text;
    EXPECT_NE(text.find("'files' (WriteMesh) failed at frame "), std::string::npos) << text;
    EXPECT_NE(text.find("No space left on device; free some disk space"), std::string::npos)
        << text;
    EXPECT_NE(text.find("1 did not run"), std::string::npos) << "the last one: " << text;

    must_on("n1", "umount --lazy $PWD/out/mesh");
    EXPECT_EQ(status(farm() + " >log/farm 2>&1"), 0) << bytes_of(in("log/farm"));
    EXPECT_TRUE(files("out") == cooked());
}

TEST_F(Slurm, ANodeThatIsLostGivesItsTaskToAnother)
{
    must(farm("") + " >log/farm 2>&1");
    const pid_t task = process_of("block.frames-2");
    ASSERT_GT(task, 1) << bytes_of(in("log/farm"));
    const std::string log = bytes_of(in("out/farm/logs/block.frames-2.log"));
    const std::string node = log.find(" on n0,") != std::string::npos ? "n0" : "n1";
    // As when its power is cut: the task, what watches over it, and the node's own process.
    std::string parent;
    std::ifstream stat("/proc/" + std::to_string(task) + "/stat");
    for (int field = 0; field < 4; ++field) stat >> parent;
    for (const pid_t pid :
         {number_in(in("slurmd." + node + ".pid")), static_cast<pid_t>(std::stoi(parent)), task}) {
        if (pid > 1) ::kill(pid, SIGKILL);
    }
    fs::remove(in("slurmd." + node + ".pid"));
    must("scontrol update nodename=" + node + " state=down reason=power");
    // Slurm itself would give the task two minutes of rest.
    std::string job;
    wait_until("the task waits again", [&] {
        job = said("squeue -h -r -t pending -o '%i %r' | grep BeginTime");
        return !job.empty();
    });
    must("scontrol update job=" + job.substr(0, job.find(' ')) + " starttime=now");
    wait_until("none is in the queue", [&] { return said("squeue -h").empty(); });
    const std::string text = said(ASPIC_PROGRAM " farm status block.json --out out");
    EXPECT_NE(text.find("5 of 5 tasks are done"), std::string::npos) << text;
    EXPECT_TRUE(files("out") == cooked());
}

// What a disk does to the store while a task waits.
TEST_F(WideSlurm, ACacheFileThatIsDamagedBetweenTasksIsMadeAgain)
{
    must(farm("--sbatch=--hold") + " >log/farm 2>&1");
    std::istringstream jobs(bytes_of(in("out/farm/jobs.txt")));
    std::string name, number, job;
    while (jobs >> name >> number) {
        if (name == "block.frames-1-to-3") {
            job = number;
        } else {
            must("scontrol release " + number);
        }
    }
    ASSERT_FALSE(job.empty()) << bytes_of(in("out/farm/jobs.txt"));
    wait_until("the simulation is there",
               [&] { return fs::exists(in("out/farm/parts/block.chain-sim.json")); });
    ASSERT_TRUE(files_if_any("out").empty()) << "no task of the frames has begun";
    int damaged = 0;
    for (const auto& f : fs::recursive_directory_iterator(in("cache/5/contents"))) {
        if (!f.is_regular_file() || f.file_size() < 40) continue;
        std::fstream file(f.path());
        file.seekp(static_cast<std::streamoff>(f.file_size() - 9));
        file << "damage";
        ++damaged;
    }
    EXPECT_GE(damaged, 6) << "a state for most of the frames";
    must("scontrol release " + job);
    wait_until("none is in the queue", [&] { return said("squeue -h").empty(); });
    const std::string text = said(ASPIC_PROGRAM " farm status block.json --out out");
    EXPECT_NE(text.find("5 of 5 tasks are done"), std::string::npos) << text;
    EXPECT_NE(text.find("verified: 12 files of 1 cook"), std::string::npos) << text;
    EXPECT_TRUE(files("out") == cooked());
    EXPECT_FALSE(fs::is_empty(in("cache/5/aside"))) << "the damaged files were read";
}

TEST_F(WideSlurm, ASimulationThatIsKilledGoesOnFromItsLastStoredFrame)
{
    folder_.write("block.json", document(80, 0.05));
    const std::string asked = farm("--node sim", "0.2");
    must(asked + " >log/farm 2>&1");
    const pid_t task = process_of("block.chain-sim");
    ASSERT_GT(task, 1) << bytes_of(in("log/farm"));
    wait_until("it has stored some frames", [&] { return stored() > 20; });
    ::kill(task, SIGKILL);
    wait_until("none is in the queue", [&] { return said("squeue -h").empty(); });
    const std::string text = said(ASPIC_PROGRAM " farm status block.json --out out");
    EXPECT_NE(text.find("block.chain-sim (frames 1-80) failed on n"), std::string::npos) << text;
    // A result is a record of the store, beside that of the cubes.
    const int frames = static_cast<int>(stored()) - 1;
    ASSERT_LT(frames, 75) << "it ended before it was killed";

    EXPECT_EQ(status(asked + " --wait >log/farm 2>&1"), 0) << bytes_of(in("log/farm"));
    const std::string log = bytes_of(in("out/farm/logs/block.chain-sim.log"));
    const std::size_t cooked = log.find(" cooked, ");
    ASSERT_NE(cooked, std::string::npos) << log;
    const int again = std::stoi(log.substr(log.rfind(' ', cooked - 1)));
    EXPECT_LE(again, 80 - frames + 4) << frames << " frames were stored; " << log;
    EXPECT_GT(again, 0) << log;
}

TEST_F(WideSlurm, ANodeWithoutRoomInItsCacheWritesTheSameBytes)
{
    fs::create_directories(in("cache"));
    must_on("n0", "mount -t tmpfs -o size=64k tmpfs $PWD/cache");
    EXPECT_EQ(status(farm() + " >log/farm 2>&1"), 0) << bytes_of(in("log/farm"));
    EXPECT_TRUE(files("out") == cooked());
    std::string logs;
    for (const auto& f : fs::directory_iterator(in("out/farm/logs"))) logs += bytes_of(f.path());
    EXPECT_NE(logs.find("No space left"), std::string::npos) << logs;
}

TEST_F(WideSlurm, ASweepOfEightGivesTheBytesOfPlainCooks)
{
    // What falls freely is the same at any stiffness: the block stands on the floor.
    std::string text = toys::falling_block(3, 0.125);
    text.replace(text.find("[0, 0.8, 0]"), 11, "[0, 0.5, 0]");
    text.insert(text.find("\"files\": {"),
                R"("low": { "type": "Measure@1", "inputs": { "mesh": "shape.mesh" },
                            "params": { "what": "lowest" } }, )");
    folder_.write("sweep.json", text);
    std::string values;
    for (int i = 1; i <= 8; ++i) values += (i > 1 ? "," : "") + std::to_string(i * 100000);
    EXPECT_EQ(status("timeout 60 " ASPIC_PROGRAM
                     " farm sweep.json --engine slurm --out out --cache cache --wait "
                     "--task-seconds 100 --vary cubes.matter.young=" +
                     values + " >log/farm 2>&1"),
              0)
        << bytes_of(in("log/farm"));
    std::set<std::string> different;
    for (int i = 1; i <= 8; ++i) {
        const std::string number = std::to_string(i);
        must(ASPIC_PROGRAM " cook sweep.json --no-disk-cache --quiet --set cubes.matter.young=" +
             number + "00000 --out plain" + number);
        const auto files = all_files("out/00" + number);
        ASSERT_EQ(files.size(), 3u) << number;
        EXPECT_TRUE(files == all_files("plain" + number)) << number;
        different.insert(files.rbegin()->second);
    }
    EXPECT_EQ(different.size(), 8u) << "each stiffness settles in its own way";

    // The table is that of a plain sweep, but for the seconds: the fourth column.
    must(ASPIC_PROGRAM " sweep sweep.json --no-disk-cache --quiet --vary cubes.matter.young=" +
         values + " --out plain >log/sweep 2>&1");
    const std::string cut = "cut -d, -f 1-3,5- ";
    EXPECT_EQ(said("head -1 out/sweep.csv | cut -d, -f 3,4"), "\"low.value\",seconds\n");
    EXPECT_EQ(said(cut + "out/sweep.csv"), said(cut + "plain/sweep.csv"));
}

TEST_F(WideSlurm, TheBridgeAndTheKitchenGiveTheBytesOfPlainCooks)
{
    const std::string graphs = ASPIC_SOURCE_DIR "/graphs/";
    const std::string asked = " --frames 1-3 --set picture.width=96 --set picture.height=54 ";
    EXPECT_EQ(status("timeout 400 " ASPIC_PROGRAM " farm " + graphs + "bridge.json " + graphs +
                     "kitchen.json --engine slurm --out out --cache cache --wait --task-seconds 2" +
                     asked + ">log/farm 2>&1"),
              0)
        << bytes_of(in("log/farm"));
    EXPECT_NE(bytes_of(in("log/farm")).find("sent: 6 tasks in 6 jobs"), std::string::npos)
        << "a simulation, pictures and the last of each: " << bytes_of(in("log/farm"));
    for (const std::string name : {"bridge", "kitchen"}) {
        must(ASPIC_PROGRAM " cook " + graphs + name + ".json --no-disk-cache --quiet --out plain/" +
             name + asked + "2>log/cook");
        EXPECT_EQ(all_files("out/" + name).size(), name == "bridge" ? 5u : 3u);
        EXPECT_TRUE(all_files("out/" + name) == all_files("plain/" + name)) << name;
    }
}
