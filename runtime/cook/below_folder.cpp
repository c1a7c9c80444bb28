#include "runtime/cook/below_folder.hpp"

#include "runtime/cache/descriptor.hpp"

#include <cerrno>
#include <fcntl.h>
#include <linux/openat2.h>
#include <string>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;

namespace {

bool is_link(int descriptor)
{
    struct stat info = {};
    return ::fstat(descriptor, &info) == 0 && S_ISLNK(info.st_mode);
}

// For systems without openat2: a step at a time, through no symbolic link at all.
int open_by_steps(int folder, const fs::path& path, int flags)
{
    int at = ::dup(folder);
    const auto last = std::prev(path.end());
    for (auto step = path.begin(); step != path.end() && at >= 0; ++step) {
        const Descriptor before(at);
        if (*step == "..") return errno = EXDEV, -1;
        at = ::openat(before.number, step->c_str(), O_NOFOLLOW | O_CLOEXEC | O_PATH);
        if (at >= 0 && is_link(at)) return ::close(at), errno = EXDEV, -1;
        if (at < 0 || step != last || (flags & O_PATH) != 0) continue;
        const Descriptor found(at);
        at = ::openat(before.number, step->c_str(), flags | O_NOFOLLOW | O_CLOEXEC);
    }
    return at;
}

int open_beneath(const fs::path& folder, const fs::path& path, int flags)
{
    if (path.empty() || path.is_absolute()) return errno = EXDEV, -1;
    const Descriptor from(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    if (from.number < 0) return -1;
    open_how how = {};
    how.flags = static_cast<std::uint64_t>(flags | O_CLOEXEC);
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_MAGICLINKS;
    constexpr int most = 100;  // EAGAIN: something above was renamed meanwhile
    for (int i = 0; i < most; ++i) {
        const long got = ::syscall(SYS_openat2, from.number, path.c_str(), &how, sizeof how);
        if (got >= 0) return static_cast<int>(got);
        if (errno == ENOSYS || errno == EPERM) return open_by_steps(from.number, path, flags);
        if (errno != EAGAIN && errno != EINTR) return -1;
    }
    return -1;
}

}  // namespace

fs::path resolved(const fs::path& folder)
{
    std::error_code error;
    const fs::path whole = fs::absolute(folder, error);
    const fs::path known = fs::weakly_canonical(whole, error);
    const fs::path path = error ? whole.lexically_normal() : known;
    return path.has_filename() ? path : path.parent_path();  // without a last "/"
}

bool names_outside(const fs::path& path)
{
    const fs::path plain = path.lexically_normal();
    return plain.is_absolute() || (!plain.empty() && *plain.begin() == "..");
}

int open_below(const fs::path& folder, const fs::path& path)
{
    return open_beneath(folder, path, O_RDONLY | O_NONBLOCK);
}

bool leads_out(const fs::path& folder, const fs::path& path)
{
    const Descriptor found(open_beneath(folder, path, O_PATH));
    return found.number < 0 && (errno == EXDEV || errno == ELOOP);
}

}  // namespace runtime
