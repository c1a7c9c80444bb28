#pragma once

// Files below a folder and nowhere else: no ".." and no symbolic link leads out of it, whoever put
// them there.

#include <filesystem>

namespace runtime {

// The same path for every spelling of a folder: absolute, without symbolic links, "." and "..". The
// folder need not exist.
std::filesystem::path resolved(const std::filesystem::path& folder);

// Whether a path that is taken from a folder says that it leaves it: by ".." or from the root.
bool names_outside(const std::filesystem::path& path);

// Opens a file for reading. -1, and errno says why, when it can't be had; EXDEV when the path leads
// out of the folder.
int open_below(const std::filesystem::path& folder, const std::filesystem::path& path);

// Whether the path, taken from the folder, leads out of it. What is not there yet does not.
bool leads_out(const std::filesystem::path& folder, const std::filesystem::path& path);

}  // namespace runtime
