#pragma once

// What files hold, as a hash: keys of results contain it, and outputs are compared by it.

#include "runtime/cache/key.hpp"

#include <filesystem>
#include <mutex>
#include <unordered_map>

namespace runtime {

// The digest of an open file, read from where it stands; zero when it can't be read.
Key digest_of(int descriptor);

// Digests of files by their bytes. A file is read again only when its size, time of change or inode
// say that it may be another one. Safe to use from many threads.
class FileDigests {
public:
    // The zero key when there is no such file, or it is not a regular file, or it can't be read.
    Key of(const std::filesystem::path& path);

private:
    struct Stamp {
        std::int64_t size = 0, changed = 0;  // bytes, ns since the epoch
        std::uint64_t inode = 0, device = 0;
        bool operator==(const Stamp&) const = default;
    };
    struct Entry {
        Stamp stamp;
        Key digest;
    };
    std::mutex mutex_;
    std::unordered_map<std::string, Entry> known_;
};

}  // namespace runtime
