#pragma once

// What a cook is asked for: how it runs, and which results are wanted.

#include "graph/types/value.hpp"
#include "runtime/cache/key.hpp"

#include <compare>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>

namespace runtime {

struct Options {
    int threads = 0;          // 0: one a core
    bool keep_going = false;  // cook what does not depend on a failed node
    std::filesystem::path output_folder = ".";
    std::stop_token stop;  // set: no node starts any more, and those that run may give up
    Key salt;              // what all results depend on: which program this is
    // Share of the results found in a cache that are made again all the same; one that differs from
    // what was stored is a failure. The seed says which.
    double recheck = 0;
    std::uint64_t recheck_seed = 0;
};

// The results of one node at one frame.
struct Want {
    std::uint32_t node = 0;
    int frame = 0;
    auto operator<=>(const Want&) const = default;
};

// Is given each wanted result, one thread at a time.
using Arrived = std::function<void(const Want&, std::span<const graph::Value>)>;

}  // namespace runtime
