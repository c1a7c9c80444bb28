#pragma once

// Which files a document may name, and what to propose for a file that is not there.

#include <filesystem>
#include <string>
#include <string_view>

namespace graph {

struct PathRules {
    std::filesystem::path root;  // canonical; nothing outside of it is read
    bool allow_outside = false;
};

// Whether a file may have such a name: one with control characters is none that a person gave, and
// would break lines where names are listed.
bool can_be_a_path(std::string_view text);

// Whether `path` is `root` or below it; both lexically normal and absolute.
bool lies_in(const std::filesystem::path& path, const std::filesystem::path& root);

// The name of a file of `folder` that `name` may be a slip of; or a list of a few that there are.
std::string suggest_file(const std::filesystem::path& path);

}  // namespace graph
