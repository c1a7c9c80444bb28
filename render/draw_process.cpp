#include "render/draw_process.hpp"

#include "geometry/base/beside_program.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>

extern char** environ;

namespace render {
namespace {

namespace fs = std::filesystem;
using geometry::Descriptor;

[[noreturn]] void fail_to(const std::string& what, int code)
{
    throw std::runtime_error("could not " + what + ": " + std::strerror(code));
}

Descriptor memory_file()
{
    Descriptor file(::memfd_create("aspic-draw", MFD_CLOEXEC));
    if (file.fd < 0) fail_to("make memory to share with aspic-draw", errno);
    return file;
}

// Above the numbers that the other program finds its descriptors at.
Descriptor moved_up(const Descriptor& from)
{
    Descriptor up(::fcntl(from.fd, F_DUPFD_CLOEXEC, 10));
    if (up.fd < 0) fail_to("start aspic-draw", errno);
    return up;
}

// 0 or an error. Ctrl-C in a terminal does not reach the process: that is for the cook to decide.
int spawn(const fs::path& program, int socket, int memory, int said, pid_t& pid)
{
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&files, said, 1);
    posix_spawn_file_actions_adddup2(&files, said, 2);
    posix_spawn_file_actions_adddup2(&files, socket, draw_socket);
    posix_spawn_file_actions_adddup2(&files, memory, draw_memory);
    posix_spawn_file_actions_addclosefrom_np(&files, draw_memory + 1);

    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setpgroup(&attributes, 0);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);

    std::string name = "aspic-draw";
    std::array<char*, 2> words{name.data(), nullptr};
    const int code =
        posix_spawn(&pid, program.c_str(), &files, &attributes, words.data(), ::environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return code;
}

// The last line that the process wrote.
std::string last_line(int said)
{
    std::array<char, 1024> piece{};
    const off_t size = ::lseek(said, 0, SEEK_END);
    const off_t from = std::max<off_t>(0, size - off_t{piece.size()});
    const ssize_t got = ::pread(said, piece.data(), piece.size(), from);
    std::string text(piece.data(), std::size_t(std::max<ssize_t>(0, got)));
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text.substr(text.rfind('\n') + 1);
}

// The textures of a job, and which of them the process lacks that has those of `kept`.
std::vector<SentTexture> to_send(const DrawJob& job, const std::vector<std::uint64_t>& kept)
{
    std::vector<SentTexture> textures;
    for (const JobTexture& t : job.textures) {
        const bool has = std::find(kept.begin(), kept.end(), t.digest) != kept.end();
        textures.push_back({t.digest, t.width, t.height, t.normals, !has});
    }
    return textures;
}

DrawRequest request_for(const DrawJob& job, const std::vector<SentTexture>& textures)
{
    DrawRequest request;
    request.vertices = job.vertices.size();
    request.uvs = job.uvs.size();
    request.textures = textures.size();
    for (std::size_t i = 0; i < textures.size(); ++i) {
        if (textures[i].sent) request.texel_bytes += job.textures[i].bytes();
    }
    request.indices = job.indices.size();
    request.opaque = job.opaque.size();
    request.clear = job.clear.size();
    request.traced = job.traced.size();
    request.traced_samples = job.traced_samples.size();
    request.traced_shadow = job.traced_shadow.size();
    request.numbers = job.numbers;
    return request;
}

void copy_in(const DrawJob& job, const std::vector<SentTexture>& textures, const DrawPlaces& at,
             std::byte* memory)
{
    const auto copy = [&](std::size_t place, const auto& data) {
        if (!data.empty()) std::memcpy(memory + place, data.data(), data.size_bytes());
    };
    copy(at.vertices, job.vertices);
    copy(at.indices, job.indices);
    copy(at.opaque, job.opaque);
    copy(at.clear, job.clear);
    copy(at.uvs, job.uvs);
    copy(at.traced, job.traced);
    copy(at.traced_samples, job.traced_samples);
    copy(at.traced_shadow, job.traced_shadow);
    copy(at.textures, std::span<const SentTexture>(textures));
    std::byte* texels = memory + at.texels;
    for (std::size_t i = 0; i < textures.size(); ++i) {
        if (!textures[i].sent) continue;
        std::memcpy(texels, job.textures[i].rgba, job.textures[i].bytes());
        texels += job.textures[i].bytes();
    }
}

// The next reply; false when the process is gone.
bool receive(int socket, DrawReply& reply, const std::function<void()>& check)
{
    for (;;) {
        pollfd ready{socket, POLLIN, 0};
        const int n = ::poll(&ready, 1, 50);
        if (n < 0 && errno != EINTR) fail_to("wait for aspic-draw", errno);
        if (n > 0) {
            const ssize_t got = ::recv(socket, &reply, sizeof reply, 0);
            if (got == ssize_t{sizeof reply}) return true;
            if (got >= 0 || errno != EINTR) return false;
        }
        if (check) check();
    }
}

}  // namespace

fs::path draw_program()
{
    if (const char* named = std::getenv("ASPIC_DRAW"); named && *named) {
        return std::strcmp(named, "none") == 0 ? fs::path() : fs::path(named);
    }
    return geometry::beside_program("aspic-draw");
}

DrawProcess::DrawProcess(fs::path program)
    : program_(std::move(program)), memory_fd_(memory_file()), said_(memory_file()),
      memory_(memory_fd_.fd)
{
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
        fail_to("make a socket for aspic-draw", errno);
    }
    socket_.fd = ends[0];
    const Descriptor theirs(ends[1]);
    ::fcntl(said_.fd, F_SETFL, O_APPEND);
    const Descriptor socket = moved_up(theirs), memory = moved_up(memory_fd_),
                     said = moved_up(said_);
    parent_ = ::getpid();
    const int code = spawn(program_, socket.fd, memory.fd, said.fd, pid_);
    if (code != 0) fail_to("start " + program_.string(), code);
}

DrawProcess::~DrawProcess()
{
    end();
}

bool DrawProcess::draw(const DrawJob& job, const Pixels& to, const std::function<void()>& check)
{
    const std::vector<SentTexture> textures = to_send(job, kept_);
    const DrawRequest request = request_for(job, textures);
    const DrawPlaces at = places_of(request);
    if (at.end > size_) {
        if (::ftruncate(memory_fd_.fd, static_cast<off_t>(at.end)) != 0) throw std::bad_alloc();
        size_ = at.end;
    }
    std::byte* const memory = memory_.map(at.end);
    copy_in(job, textures, at, memory);
    const ssize_t sent = ::send(socket_.fd, &request, sizeof request, MSG_NOSIGNAL);
    DrawReply reply;
    if (sent != ssize_t{sizeof request} || !receive(socket_.fd, reply, check)) return false;
    resident_ = reply.resident;
    if (reply.is == DrawReply::Is::out_of_memory) throw std::bad_alloc();
    if (reply.is == DrawReply::Is::failed) throw std::runtime_error(reply.why.data());
    std::memcpy(to.rgba.data(), memory + at.pixels, to.rgba.size());
    if (!to.linear.empty()) {
        std::memcpy(to.linear.data(), memory + at.linear, to.linear.size_bytes());
    }
    kept_.clear();
    for (const JobTexture& t : job.textures) kept_.push_back(t.digest);
    if (request.texel_bytes > 0) {  // sent once: their room is given back
        if (::ftruncate(memory_fd_.fd, static_cast<off_t>(at.texels)) == 0) size_ = at.texels;
    }
    return true;
}

bool DrawProcess::alive() const
{
    pollfd other_end{socket_.fd, 0, 0};
    return pid_ > 0 && ::poll(&other_end, 1, 0) == 0;
}

std::string DrawProcess::end()
{
    if (pid_ <= 0 || parent_ != ::getpid()) return {};  // in a copy made by fork() it is not ours
    // What has hung up has ended, or is about to.
    if (alive()) ::kill(pid_, SIGKILL);
    socket_.close();
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    std::string how = WIFSIGNALED(status) ? ::strsignal(WTERMSIG(status))
                                          : "exit status " + std::to_string(WEXITSTATUS(status));
    const std::string said = last_line(said_.fd);
    return said.empty() ? how : how + ": " + said;
}

}  // namespace render
