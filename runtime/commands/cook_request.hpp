#pragma once

// What a command was asked for, as its options say it, and what follows from that: the graph, its
// nodes and frames, the output folder, the disk cache.

#include "graph/document/document.hpp"
#include "runtime/cache/disk_cache.hpp"
#include "runtime/commands/console.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace runtime {

struct CookRequest {
    std::vector<std::string> files;
    std::string frames;              // empty: all
    std::vector<std::string> nodes;  // empty: every sink
    std::vector<std::string> sets, variables;
    std::string output_folder;  // empty: out/<graph>
    std::string part;           // manifest of a part of a cook; empty: the cook is no part
    std::string root;
    bool allow_outside = false;
    int threads = 0;
    std::size_t memory = std::size_t{2} << 30;
    std::string cache;  // folder; empty: the user's own
    bool no_disk_cache = false;
    double time_limit = 0;         // s; 0: none
    std::size_t memory_limit = 0;  // bytes; 0: nearly all there is
    std::uintmax_t cache_budget = std::uintmax_t{20} << 30;
    bool keep_going = false, json = false, quiet = false;
    bool values = false;         // a table of all numbers, beside what is cooked
    bool record_missed = false;  // a missed expectation is told and recorded, and no failure
    bool openjd = false;         // tells a scheduler of Open Job Description how far it is
    bool expectations_only = false;
    bool writes = false;   // files of all the frames that are asked for
    bool profile = false;  // show where the time went
    bool motion = false;   // simulations as well, for `card`
    std::string trace;     // and write it there; empty: nowhere
    double recheck = 0;    // percent of what was found in a cache, made again and compared
};

// The nodes to cook: those named, or the sinks, or where there are none, what nothing depends on.
std::vector<std::uint32_t> chosen_nodes(const graph::Graph& graph, const CookRequest& request);
std::vector<int> chosen_frames(const graph::Graph& graph, const CookRequest& request);
// Throws std::invalid_argument when the graph has no such frame.
void require_frame(const graph::Graph& graph, int frame);

// out/<graph>, or what the request says.
std::filesystem::path output_folder(const graph::Graph& graph, const CookRequest& request);
// Throws std::invalid_argument when it can't be made.
void make_output_folder(const std::filesystem::path& folder);

// The disk cache that was asked for; null for none. Its warnings go to the console.
std::unique_ptr<DiskCache> open_cache(const CookRequest& request, Console& console);

graph::LoadOptions load_options(const CookRequest& request);

// Loads a document and tells what is wrong with it. Nothing when it has errors.
std::optional<graph::Graph> load(const std::string& file, const CookRequest& request,
                                 const graph::Registry& registry, Console& console);

}  // namespace runtime
