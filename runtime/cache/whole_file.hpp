#pragma once

// Files that are there whole or not at all: written under another name, synced and renamed. A full
// disk or a kill never costs what was there before.

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace runtime {

struct Wrote {
    int error = 0;         // errno, or 0
    std::size_t size = 0;  // bytes that it takes on disk, in whole blocks
};

// The pieces, one after the other, as the content of the file. One that is there keeps its
// permissions. Never throws; where it fails, it
// leaves nothing.
Wrote write_whole_file(const std::filesystem::path& path, std::span<const std::string_view> pieces);

// Bytes that a file takes on disk; 0 when that is not known.
std::size_t size_on_disk(const std::filesystem::path& path);

// Whether a file has a name that write_whole_file() gives for the time of writing. A killed process
// may leave one.
bool is_unfinished(const std::filesystem::path& path);

}  // namespace runtime
