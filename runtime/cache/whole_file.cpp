#include "runtime/cache/whole_file.hpp"

#include <atomic>
#include <cerrno>
#include <fcntl.h>
#include <string>
#include <sys/stat.h>
#include <unistd.h>

namespace runtime {

namespace {

bool write_all(int file, std::string_view bytes)
{
    while (!bytes.empty()) {
        const ssize_t put = ::write(file, bytes.data(), bytes.size());
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return false;
        bytes.remove_prefix(static_cast<std::size_t>(put));
    }
    return true;
}

std::size_t size_of(const struct stat& info)
{
    return static_cast<std::size_t>(info.st_blocks) * 512;  // whatever the blocks of the disk are
}

// The permissions of the file that is to be replaced; 0: there is none.
mode_t mode_of(const std::filesystem::path& path)
{
    struct stat info = {};
    return ::lstat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode) ? info.st_mode & 0777 : 0;
}

}  // namespace

std::size_t size_on_disk(const std::filesystem::path& path)
{
    struct stat info = {};
    return ::lstat(path.c_str(), &info) == 0 ? size_of(info) : 0;
}

Wrote write_whole_file(const std::filesystem::path& path, std::span<const std::string_view> pieces)
{
    static std::atomic<unsigned> counter{0};
    std::string unfinished;
    int file = -1;
    do {  // on a shared folder, a process of the same number on another machine has some names
        unfinished = path.string() + ".aspic-" + std::to_string(::getpid()) + "-" +
                     std::to_string(counter++) + "~";
        file = ::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    } while (file < 0 && errno == EEXIST);
    if (file < 0) return {errno, 0};
    // Where a file system has no permissions, there is nothing to keep.
    if (const mode_t mode = mode_of(path); mode != 0) ::fchmod(file, mode);
    errno = 0;
    bool good = true;
    for (const std::string_view piece : pieces) good = good && write_all(file, piece);
    good = good && ::fsync(file) == 0;
    struct stat info = {};
    const std::size_t size = good && ::fstat(file, &info) == 0 ? size_of(info) : 0;
    int error = good ? 0 : errno != 0 ? errno : EIO;
    if (::close(file) != 0 && error == 0) error = errno;
    if (error == 0 && ::rename(unfinished.c_str(), path.c_str()) != 0) error = errno;
    if (error == 0) return {0, size};
    ::unlink(unfinished.c_str());
    return {error, 0};
}

bool is_unfinished(const std::filesystem::path& path)
{
    return path.native().ends_with('~');
}

}  // namespace runtime
