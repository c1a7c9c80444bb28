#pragma once

// The command line in this process, with the toys for nodes.

#include "runtime/commands/command_line.hpp"
#include "tests/runtime/toys.hpp"

#include <sstream>
#include <utility>

namespace toys {

struct Said {
    int exit;
    std::string out, err;
};

// Without the user's own cache, unless a test says where one is.
inline Said run(std::vector<std::string> args, std::stop_token stop = {})
{
    const bool cooks =
        !args.empty() && (args[0] == "cook" || args[0] == "check" || args[0] == "profile" ||
                          args[0] == "sweep" || args[0] == "study" || args[0] == "tune");
    if (cooks && std::find(args.begin(), args.end(), "--cache") == args.end()) {
        args.push_back("--no-disk-cache");
    }
    std::ostringstream out, err;
    runtime::Console console{out, err, false, std::move(stop), {}, "1.2.3"};
    console.starter = "{ \"aspic\": 1, \"nodes\": {} }  // aspic cook starter.json\n";
    const int exit = runtime::run_command_line(args, registry(), console);
    return {exit, out.str(), err.str()};
}

inline bool has(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

inline const char* const three_frames = R"({ "aspic": 1, "frames": { "first": 1, "last": 3 },
  "nodes": {
    "clock": { "type": "Clock@1" },
    "sum": { "type": "Sum@1", "inputs": { "values": ["clock.value"] }, "params": { "bias": 10 } },
    "write": { "type": "WriteNumber@1", "inputs": { "value": "sum.value" } } },
  "expect": [ { "value": "sum.value", "frame": 1, "min": 11, "max": 11, "why": "10 + 1" } ] })";

}  // namespace toys
