#pragma once

// The command line, as functions of arguments and streams, so that tests need no process.

#include "graph/node_type.hpp"
#include "runtime/key.hpp"

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <stop_token>
#include <string>
#include <vector>

namespace runtime {

enum Exit {
    exit_ok = 0,
    exit_failed = 1,       // a node failed
    exit_usage = 2,        // the command or a document is wrong
    exit_missed = 3,       // cooked, but a scene's expectation was missed
    exit_cancelled = 130,  // as a shell says it of Ctrl-C
};

struct Console {
    std::ostream& out;      // what was asked for
    std::ostream& err;      // progress, warnings, mistakes
    bool terminal = false;  // err is one: show a line that changes
    std::stop_token stop;
    Key salt;             // which program this is, see Options::salt
    std::string version;  // "0.1.0"

    // How far values of a wire type are apart, by its name, for `study`.
    std::map<std::string, std::function<double(const graph::Value&, const graph::Value&)>>
        distances = {};

    // For `sweep` and `study`: writes labelled pictures on one sheet, and says how many there were.
    std::function<std::size_t(const std::vector<std::pair<graph::Value, std::string>>& pictures,
                              int columns, const std::filesystem::path& path)>
        write_sheet = {};
    // For `doctor`: the OpenGL that pictures are drawn with. Throws when it will not do.
    std::function<std::string()> opengl = {};
    // For `new`: a graph that a newcomer can change.
    std::string starter = {};
};

// `args` without the program's name.
int run_command_line(const std::vector<std::string>& args, const graph::Registry& registry,
                     Console& console);

// "1-48", "1-48x2", "10,20", and any list of these, ascending and without doubles. Throws
// std::invalid_argument.
std::vector<int> parse_frames(std::string_view text);

// "500M", "2G", "1.5G", "4096" in bytes; K, M, G and T are powers of 1024. Throws
// std::invalid_argument.
std::size_t parse_bytes(std::string_view text);

// 1536 -> "1.5 kB".
std::string format_bytes(double bytes);

// 75 -> "1 min 15 s".
std::string format_seconds(double seconds);

}  // namespace runtime
