#include "geometry/base/run_program.hpp"

#include "geometry/base/descriptor.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>

extern char** environ;

namespace geometry {
namespace {

[[noreturn]] void fail_to(const std::string& what, int code)
{
    throw std::runtime_error("could not " + what + ": " + std::strerror(code));
}

// As C wants a list of words.
std::vector<char*> pointers(const std::vector<std::string>& words)
{
    std::vector<char*> out;
    for (const std::string& word : words) out.push_back(const_cast<char*>(word.c_str()));
    out.push_back(nullptr);
    return out;
}

// The process while it runs. Killed when it goes out of scope before it has been waited for.
struct Process {
    pid_t pid = -1;

    Process() = default;
    Process(const Process&) = delete;
    Process& operator=(const Process&) = delete;
    ~Process()
    {
        if (pid <= 0) return;
        ::kill(pid, SIGKILL);
        wait();
    }
    // How it ended, as waitpid() tells it.
    int wait()
    {
        int status = 0;
        while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
        }
        pid = -1;
        return status;
    }
};

// 0 or an error. `speaking`: where what it says goes.
int start(const ProgramCall& call, int speaking, pid_t& pid)
{
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    if (call.input >= 0) {
        posix_spawn_file_actions_adddup2(&files, call.input, 0);
    } else {
        posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    }
    posix_spawn_file_actions_adddup2(&files, speaking, 1);
    posix_spawn_file_actions_adddup2(&files, speaking, 2);
    if (call.handed >= 0) posix_spawn_file_actions_adddup2(&files, call.handed, 3);
    posix_spawn_file_actions_addclosefrom_np(&files, call.handed >= 0 ? 4 : 3);

    // A group of its own, which Ctrl-C in a terminal does not reach.
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);

    const std::vector<char*> words = pointers(call.words);
    const std::vector<char*> environment = pointers(call.environment);
    const int code = posix_spawnp(&pid, words[0], &files, &attributes, words.data(),
                                  call.environment.empty() ? ::environ : environment.data());
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return code;
}

// Adds what comes from `fd` to `said` until its other end is closed. False when that takes more
// than `seconds`.
bool listen(int fd, double seconds, const std::function<void()>& check, std::string& said)
{
    constexpr std::size_t kept = 4000;
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    for (;;) {
        pollfd ready{fd, POLLIN, 0};
        const int n = ::poll(&ready, 1, 50);
        if (n < 0 && errno != EINTR) fail_to("wait for a program", errno);
        if (n > 0) {
            char piece[1024];
            const ssize_t got = ::read(fd, piece, sizeof piece);
            if (got == 0) return true;
            if (got > 0) said.append(piece, static_cast<std::size_t>(got));
            if (said.size() > kept) said.erase(0, said.size() - kept);
        }
        if (std::chrono::duration<double>(Clock::now() - begin).count() > seconds) return false;
        check();
    }
}

}  // namespace

ProgramRun run_program(const ProgramCall& call, const std::function<void()>& check)
{
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) fail_to("make a pipe", errno);
    const Descriptor listening(ends[0]);
    Descriptor speaking(ends[1]);

    ProgramRun run;
    Process process;
    pid_t pid = -1;
    const int code = start(call, speaking.fd, pid);
    run.found = code != ENOENT;
    if (!run.found) return run;
    if (code != 0) fail_to("start " + call.words[0], code);
    process.pid = pid;
    speaking.close();
    run.in_time = listen(listening.fd, call.seconds, check, run.said);
    if (run.in_time) run.status = process.wait();
    return run;
}

}  // namespace geometry
