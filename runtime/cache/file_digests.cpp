#include "runtime/cache/file_digests.hpp"

#include "runtime/cache/descriptor.hpp"

#include <chrono>
#include <cstdlib>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace runtime {

namespace {

// File systems stamp times in ticks of a few ms: a file may change twice within one and keep its
// stamp, so the digest of a file this young is not kept.
constexpr std::int64_t too_young = 50'000'000;  // ns

}  // namespace

Key digest_of(int descriptor)
{
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(),
                                                                         XXH3_freeState);
    if (!state) throw std::bad_alloc();
    XXH3_128bits_reset(state.get());
    std::vector<char> buffer(1 << 18);
    for (;;) {
        const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
        if (got < 0) return {};
        if (got == 0) break;
        XXH3_128bits_update(state.get(), buffer.data(), static_cast<std::size_t>(got));
    }
    const XXH128_hash_t hash = XXH3_128bits_digest(state.get());
    return {hash.low64, hash.high64};
}

Key FileDigests::of(const std::filesystem::path& path)
{
    struct stat info = {};
    if (::stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return {};
    const Stamp stamp{info.st_size, info.st_mtim.tv_sec * 1'000'000'000 + info.st_mtim.tv_nsec,
                      info.st_ino, info.st_dev};
    {
        const std::lock_guard lock(mutex_);
        const auto found = known_.find(path.native());
        if (found != known_.end() && found->second.stamp == stamp) return found->second.digest;
    }
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.number < 0) return {};
    const Key result = digest_of(file.number);
    const auto now = std::chrono::duration_cast<std::chrono::nanoseconds>(
                         std::chrono::system_clock::now().time_since_epoch())
                         .count();
    if (result && now - stamp.changed > too_young) {
        const std::lock_guard lock(mutex_);
        known_.insert_or_assign(path.native(), Entry{stamp, result});
    }
    return result;
}

}  // namespace runtime
