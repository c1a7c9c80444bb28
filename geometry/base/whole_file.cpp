#include "geometry/base/whole_file.hpp"

#include "geometry/base/stop.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

namespace geometry {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int code)
{
    throw std::runtime_error(
        "could not write " + path.string() + ": " + std::strerror(code) +
        (code == ENOSPC || code == EDQUOT ? "; free some disk space there" : ""));
}

// Names beside `path`, until use(name) returns 0 or an error that is not EEXIST, which is returned.
template <class Use> int with_name_beside(const fs::path& path, const Use& use)
{
    for (std::int64_t n = std::chrono::steady_clock::now().time_since_epoch().count();; ++n) {
        fs::path beside = path;
        beside += fmt::format(".aspic-{}-{}.part", ::getpid(), n);  // commands/leftovers.hpp
        const int error = use(beside);
        if (error != EEXIST) return error;
    }
}

// Where /proc is, a file without a name can be given one.
bool can_name_later()
{
    static const bool can = ::access("/proc/self/fd", X_OK) == 0;
    return can;
}

// A file that is being written. Where the system can, it has no name until it is whole, so that
// nothing of it stays when the process is killed.
struct Unfinished {
    int fd = -1;
    fs::path name;  // empty: it has none

    explicit Unfinished(const fs::path& path)
    {
        const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
        if (can_name_later()) {
            fd = ::open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666);
        }
        if (fd >= 0) return;
        const int error = with_name_beside(path, [&](const fs::path& beside) {
            fd = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
            name = beside;
            return fd >= 0 ? 0 : errno;
        });
        if (error != 0) fail(path, error);
    }
    ~Unfinished()
    {
        if (fd >= 0) ::close(fd);
        if (!name.empty()) ::unlink(name.c_str());
    }
    Unfinished(const Unfinished&) = delete;

    // 0 or an error. Some megabytes at a time, so that it can be stopped between.
    int write(std::string_view bytes)
    {
        constexpr std::size_t most = 1 << 24;
        while (!bytes.empty()) {
            stop_if_asked();
            const ssize_t n = ::write(fd, bytes.data(), std::min(most, bytes.size()));
            if (n < 0 && errno != EINTR) return errno;
            if (n > 0) bytes.remove_prefix(static_cast<std::size_t>(n));
        }
        return 0;
    }

    // Gives it its place, over what stands there. 0 or an error.
    int finish(const fs::path& path)
    {
        if (name.empty()) {
            const std::string self = fmt::format("/proc/self/fd/{}", fd);
            const auto link = [&](const fs::path& to) {
                return ::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, to.c_str(), AT_SYMLINK_FOLLOW) ==
                               0
                           ? 0
                           : errno;
            };
            const int error = link(path);
            if (error != EEXIST) return error;
            const int taken = with_name_beside(path, [&](const fs::path& beside) {
                const int code = link(beside);
                if (code == 0) name = beside;
                return code;
            });
            if (taken != 0) return taken;
        }
        if (::rename(name.c_str(), path.c_str()) != 0) return errno;
        name.clear();
        const int open = std::exchange(fd, -1);
        return ::close(open) == 0 ? 0 : errno;
    }
};

}  // namespace

std::optional<std::string> read_whole_file(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    if (!in) return std::nullopt;
    return std::string{std::istreambuf_iterator<char>(in), {}};
}

void write_whole_file(const fs::path& path, std::string_view bytes)
{
    std::error_code code;
    if (path.has_parent_path()) fs::create_directories(path.parent_path(), code);
    if (code) fail(path, code.value());

    Unfinished file(path);
    int error = file.write(bytes);
    if (error == 0) error = file.finish(path);
    if (error != 0) fail(path, error);
}

}  // namespace geometry
