#include "geometry/whole_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <stdexcept>
#include <string>

namespace geometry {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& path, int code)
{
    throw std::runtime_error("could not write " + path.string() + ": " + std::strerror(code) +
                             (code == ENOSPC || code == EDQUOT ? "; free some space there" : ""));
}

// A new file beside `path`, by a name that nobody else has.
std::pair<int, fs::path> open_beside(const fs::path& path)
{
    for (std::int64_t n = std::chrono::steady_clock::now().time_since_epoch().count();; ++n) {
        fs::path beside = path;
        beside += fmt::format(".{}-{}.part", ::getpid(), n);
        const int fd = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd >= 0) return {fd, beside};
        if (errno != EEXIST) fail(path, errno);
    }
}

}  // namespace

void write_whole_file(const fs::path& path, std::string_view bytes)
{
    std::error_code code;
    if (path.has_parent_path()) fs::create_directories(path.parent_path(), code);
    if (code) fail(path, code.value());

    const auto [fd, beside] = open_beside(path);
    int error = 0;
    while (!bytes.empty() && error == 0) {
        const ssize_t n = ::write(fd, bytes.data(), bytes.size());
        if (n >= 0) {
            bytes.remove_prefix(static_cast<std::size_t>(n));
        } else if (errno != EINTR) {
            error = errno;
        }
    }
    if (::close(fd) != 0 && error == 0) error = errno;
    if (error == 0 && ::rename(beside.c_str(), path.c_str()) != 0) error = errno;
    if (error != 0) {
        ::unlink(beside.c_str());
        fail(path, error);
    }
}

}  // namespace geometry
