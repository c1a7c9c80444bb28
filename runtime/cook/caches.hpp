#pragma once

// Everything that is kept from one cook for the next.

#include "runtime/cache/disk_cache.hpp"
#include "runtime/cache/memory_cache.hpp"
#include "runtime/cook/side_files.hpp"

#include <memory>
#include <unordered_map>

namespace runtime {

// What several graphs cooked by one process share. Used by one cook at a time.
struct Caches {
    MemoryCache memory{std::size_t{1} << 30};
    FileDigests files;
    SideFiles side_files;
    std::unique_ptr<DiskCache> disk;  // null: nothing outlives the process
    ContentNames names;
    std::unordered_map<Key, Key, KeyHash> same;  // keys by content (Keys::by_content) to keys
};

}  // namespace runtime
