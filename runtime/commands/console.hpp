#pragma once

// What commands are given by the program, and the exit codes that they give back.

#include "graph/types/value.hpp"
#include "runtime/cache/key.hpp"

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace graph {
struct Node;
}

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

    // For `tune`: how many cubes a value of a wire of cubes is.
    std::function<double(const graph::Value& cubes)> count_cubes = {};
    // For `cook`: the unit of the number that a node gives; empty: none.
    std::function<std::string(const graph::Node& node)> unit_of = {};
    // For `info`: a mesh file whose lengths are in `unit`, in words or as a line of JSON. Throws
    // std::exception when the file can't be read, graph::Cancelled when told to stop.
    std::function<std::string(const std::string& file, const std::string& unit, bool json,
                              const std::stop_token& stop)>
        mesh_info = {};
    // For `sweep` and `study`: writes labelled pictures on one sheet, and says how many there were.
    std::function<std::size_t(const std::vector<std::pair<graph::Value, std::string>>& pictures,
                              int columns, const std::filesystem::path& path)>
        write_sheet = {};
    // For `study` and `farm`: runs a program and waits for its end, or kills it when it is to stop.
    // Its exit status; 128 and the signal's number of one that a signal ended, -1 of one that is
    // not there.
    std::function<int(const std::vector<std::string>& words, const std::stop_token& stop)>
        run_program = {};
    std::string program = {};  // for `farm`: the path of this program
    // For --threads: libraries that have threads of their own, as many as the machine has cores,
    // keep to this number. Before they are used.
    std::function<void(int threads)> limit_libraries = {};
    // For `doctor`: the OpenGL that pictures are drawn with. Throws when it will not do.
    std::function<std::string()> opengl = {};
    // For `new`: a graph that a newcomer can change.
    std::string starter = {};
};

}  // namespace runtime
