#pragma once

// What running a node gives: its values, its warnings, the files that it wrote, and what it cost.
// Both caches keep results and hand them out as they were made: nobody changes one any more.

#include "graph/types/figure.hpp"
#include "runtime/cache/content_names.hpp"
#include "runtime/cache/key.hpp"

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace runtime {

// A file that a sink wrote, and what was in it then.
struct Written {
    std::filesystem::path path;
    Key digest;  // zero of a file that other frames write to, too
};

// A warning that came with a result that this one is made from.
struct Heard {
    Key from;  // that result's
    int frame = 0;
    std::string text;
    bool operator==(const Heard&) const = default;
};

// What a node told of the accuracy of its result.
struct Told {
    Key from;  // that result's
    int frame = 0;
    std::string node, type;  // that made it, as it was called then
    graph::Figures figures;
};

// What running a node, or one of its preparations, gave.
struct Made {
    std::vector<graph::Value> values;      // a node's, one an output port
    std::shared_ptr<const void> prepared;  // a preparation's
    std::vector<std::string> warnings;     // its own
    std::vector<Heard> heard;              // earliest first
    graph::Figures figures;                // its own; empty: none
    // Its own figures and those of what it is made from, but for the frames before of a simulation;
    // by node and frame.
    std::vector<std::shared_ptr<const Told>> told;
    std::vector<Written> files;  // a sink's
    double seconds = 0;          // it took
    double since_stored = 0;     // s of a simulation since its last frame on disk, this included
    std::size_t bytes = 0;       // it holds
};

struct Result : Made {
    Result() = default;
    Result(const Result& other) : Made(other) {}

    // Names of the values, made when first asked for. Safe from many threads.
    const std::vector<graph::ContentName>& names(ContentNames& all) const
    {
        std::call_once(named_, [&] {
            for (const graph::Value& value : values) names_.push_back(all.of(value));
        });
        return names_;
    }
    void know_names(std::vector<graph::ContentName> names)
    {
        std::call_once(named_, [&] { names_ = std::move(names); });
    }

private:
    mutable std::once_flag named_;
    mutable std::vector<graph::ContentName> names_;
};
using SharedResult = std::shared_ptr<const Result>;

}  // namespace runtime
