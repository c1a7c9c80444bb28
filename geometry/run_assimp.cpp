#include "geometry/run_assimp.hpp"

#include "geometry/beside_program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace geometry {
namespace {

namespace fs = std::filesystem;

// A file descriptor that closes itself.
struct Descriptor {
    int fd = -1;

    explicit Descriptor(int d) : fd(d) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() { close(); }
    void close()
    {
        if (fd >= 0) ::close(fd);
        fd = -1;
    }
};

[[noreturn]] void fail(const std::string& what, int code)
{
    throw std::runtime_error(what + ": " + std::strerror(code));
}

fs::path assimp_program()
{
    if (const char* named = std::getenv("ASPIC_ASSIMP"); named && *named) return named;
    const fs::path program = beside_program("aspic-assimp");
    if (!program.empty()) return program;
    std::error_code none;
    throw std::runtime_error(
        "aspic-assimp, the program that reads and writes mesh files, is not in " +
        fs::read_symlink("/proc/self/exe", none).parent_path().string() +
        "; build it there, or set ASPIC_ASSIMP to where it is");
}

// Our own environment, with large pages for what it allocates: assimp clears 16 MB for
// any OBJ, and a file of one face then takes 6 ms, against 15 in pages of 4 KiB.
std::vector<std::string> its_environment()
{
    const std::string tunables = "GLIBC_TUNABLES=", large_pages = "glibc.malloc.hugetlb=1";
    std::vector<std::string> all;
    std::string ours = tunables + large_pages;
    for (char** at = ::environ; *at; ++at) {
        const std::string variable = *at;
        if (variable.starts_with(tunables)) {
            ours = variable + ":" + large_pages;
        } else {
            all.push_back(variable);
        }
    }
    all.push_back(ours);
    return all;
}

// As C wants a list of words.
std::vector<char*> pointers(std::vector<std::string>& words)
{
    std::vector<char*> out;
    for (std::string& word : words) out.push_back(word.data());
    out.push_back(nullptr);
    return out;
}

// The process while it runs. Never left behind: whatever happens here, it ends.
class Child {
public:
    Child(const fs::path& program, std::vector<std::string> words, int input, int made,
          int messages)
    {
        posix_spawn_file_actions_t files;
        posix_spawn_file_actions_init(&files);
        posix_spawn_file_actions_adddup2(&files, input, 0);
        posix_spawn_file_actions_adddup2(&files, messages, 1);
        posix_spawn_file_actions_adddup2(&files, messages, 2);
        posix_spawn_file_actions_adddup2(&files, made, 3);
        posix_spawn_file_actions_addclosefrom_np(&files, 4);

        // A group of its own: Ctrl-C is for the cook, which then decides.
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        posix_spawnattr_setpgroup(&attributes, 0);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);

        std::vector<std::string> environment = its_environment();
        const int code = posix_spawn(&pid_, program.c_str(), &files, &attributes,
                                     pointers(words).data(), pointers(environment).data());
        posix_spawn_file_actions_destroy(&files);
        posix_spawnattr_destroy(&attributes);
        if (code != 0) fail("could not start " + program.string(), code);
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    ~Child()
    {
        if (pid_ <= 0) return;
        ::kill(pid_, SIGKILL);
        wait();
    }
    // How it ended, as waitpid says.
    int wait()
    {
        int status = 0;
        while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
        }
        pid_ = -1;
        return status;
    }

private:
    pid_t pid_ = -1;
};

// All that comes from `fd` until its other end is closed (the last 1,000 characters of it). False
// when that takes more than `seconds`.
bool listen(int fd, double seconds, const std::function<void()>& check, std::string& text)
{
    using Clock = std::chrono::steady_clock;
    const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
    for (;;) {
        pollfd ready{fd, POLLIN, 0};
        const int n = ::poll(&ready, 1, 50);
        if (n < 0 && errno != EINTR) fail("waiting for aspic-assimp", errno);
        if (n > 0) {
            char piece[1024];
            const ssize_t got = ::read(fd, piece, sizeof piece);
            if (got == 0) return true;
            if (got > 0) text.append(piece, static_cast<std::size_t>(got));
            if (text.size() > 1000) text.erase(0, text.size() - 1000);
        }
        if (Clock::now() > deadline) return false;
        check();
    }
}

std::string last_line(std::string text)
{
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
    const auto start = text.rfind('\n');
    return start == std::string::npos ? text : text.substr(start + 1);
}

// Exit status 3 says that memory ran out, see assimp/main.cpp.
constexpr int out_of_memory = 3;

AssimpRun how_it_ended(int status, const std::string& said)
{
    using End = AssimpRun::End;
    const std::string why = last_line(said);
    if (WIFEXITED(status)) {
        if (WEXITSTATUS(status) == 0) return {End::fine, why};
        return {WEXITSTATUS(status) == out_of_memory ? End::out_of_memory : End::gave_up, why};
    }
    if (WTERMSIG(status) == SIGXCPU) return {End::out_of_time, why};
    return {End::crashed,
            std::string(::strsignal(WTERMSIG(status))) + (why.empty() ? "" : ": " + why)};
}

// Hands on what lies in the memory file `fd`.
void read_memory(int fd, const std::function<void(const char*, std::size_t)>& use)
{
    struct stat about;
    if (::fstat(fd, &about) != 0) fail("looking at what aspic-assimp made", errno);
    const auto size = static_cast<std::size_t>(about.st_size);
    if (size == 0) throw std::runtime_error("it is empty");
    void* bytes = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, fd, 0);
    if (bytes == MAP_FAILED) fail("mapping what aspic-assimp made", errno);
    struct Unmap {
        void* bytes;
        std::size_t size;
        ~Unmap() { ::munmap(bytes, size); }
    } unmap{bytes, size};
    use(static_cast<const char*>(bytes), size);
}

// A file in memory that holds `bytes`, to be read from its start.
int memory_file(std::string_view bytes)
{
    const int fd = ::memfd_create("aspic-assimp", MFD_CLOEXEC);
    if (fd < 0) fail("making room for what aspic-assimp needs", errno);
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::pwrite(fd, bytes.data() + done, bytes.size() - done, off_t(done));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            const int code = errno;
            ::close(fd);
            fail("handing a mesh to aspic-assimp", code);
        }
        done += static_cast<std::size_t>(n);
    }
    return fd;
}

}  // namespace

std::string shorter(double number)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", number);
    return text;
}

AssimpRun run_assimp(std::vector<std::string> words, std::string_view input,
                     const ProcessLimits& limits, const std::function<void()>& check,
                     const std::function<void(const char* bytes, std::size_t size)>& use)
{
    const fs::path program = assimp_program();
    const Descriptor given(memory_file(input)), made(memory_file({}));
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) fail("making a pipe", errno);
    const Descriptor messages(ends[0]);
    Descriptor theirs(ends[1]);

    words.insert(words.begin(), "aspic-assimp");
    words.push_back(std::to_string(limits.gigabytes));
    words.push_back(std::to_string(limits.seconds));
    Child child(program, std::move(words), given.fd, made.fd, theirs.fd);
    theirs.close();

    std::string said;
    if (!listen(messages.fd, limits.seconds, check, said)) {
        return {AssimpRun::End::out_of_time, last_line(said)};
    }
    AssimpRun run = how_it_ended(child.wait(), said);
    if (run.end != AssimpRun::End::fine) return run;
    try {
        read_memory(made.fd, use);
    } catch (const std::runtime_error& error) {
        return {AssimpRun::End::not_understood, "what " + program.string() +
                                                    " made of it is not understood (" +
                                                    error.what() + "): is it of the same build?"};
    }
    return run;
}

}  // namespace geometry
