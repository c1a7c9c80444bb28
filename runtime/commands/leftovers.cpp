#include "runtime/commands/leftovers.hpp"

#include <cerrno>
#include <charconv>
#include <csignal>
#include <regex>
#include <string>
#include <unistd.h>

namespace runtime {

namespace fs = std::filesystem;

int process_of_unfinished(const std::string& name)
{
    static const std::regex unfinished(
        R"(.+\.aspic-(\d{1,9})(\.part\.\w+|\.frames|-\d+\.part|-\d+~))");
    std::smatch found;
    if (!std::regex_match(name, found, unfinished)) return 0;
    const std::string number = found[1].str();
    int process = 0;
    std::from_chars(number.data(), number.data() + number.size(), process);
    return process;
}

void remove_leftovers(const fs::path& folder)
{
    std::error_code error;
    fs::recursive_directory_iterator at(folder, error), end;
    for (; !error && at != end; at.increment(error)) {
        std::error_code ignored;
        if (!at->is_regular_file(ignored) || at->is_symlink(ignored)) continue;
        const int process = process_of_unfinished(at->path().filename().string());
        if (process <= 0) continue;
        // This process has written nothing yet: a file with its number is of one before it.
        const bool gone = process == ::getpid() || (::kill(process, 0) != 0 && errno == ESRCH);
        if (gone) fs::remove(at->path(), ignored);
    }
}

}  // namespace runtime
