#pragma once

#include "graph/document.hpp"
#include "runtime/front_end.hpp"
#include "runtime/manifest.hpp"

namespace runtime {

// What `cook` and `check` were asked for.
struct CookRequest {
    std::vector<std::string> files;
    std::string frames;              // empty: all
    std::vector<std::string> nodes;  // empty: every sink
    std::vector<std::string> sets, variables;
    std::string output_folder;  // empty: out/<graph>
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
    bool expectations_only = false;
    bool profile = false;  // show where the time went
    std::string trace;     // and write it there; empty: nowhere
    double recheck = 0;    // percent of what was found in a cache, made again and compared
};

// Throws std::invalid_argument when it can't be made.
void make_output_folder(const std::filesystem::path& folder);

int cook(const CookRequest& request, const graph::Registry& registry, Console& console);

// Cooks one graph. What went in and came out is left in `manifest`, and beside the files that were
// written. Returns the exit code.
int cook_graph(const graph::Graph& graph, const CookRequest& request, Caches& caches,
               FrontEnd& front_end, Console& console, Manifest& manifest);

// The nodes to cook: those named, or the sinks, or where there are none, what nothing depends on.
std::vector<std::uint32_t> chosen_nodes(const graph::Graph& graph, const CookRequest& request);
std::vector<int> chosen_frames(const graph::Graph& graph, const CookRequest& request);
std::filesystem::path output_folder(const graph::Graph& graph, const CookRequest& request);
Style style_of(const CookRequest& request, const Console& console);

graph::LoadOptions load_options(const CookRequest& request);

// The disk cache that was asked for; null for none. Its warnings go to the console.
std::unique_ptr<DiskCache> open_cache(const CookRequest& request, Console& console);

// Loads a document and tells what is wrong with it. Nothing when it has errors.
std::optional<graph::Graph> load(const std::string& file, const CookRequest& request,
                                 const graph::Registry& registry, Console& console);

}  // namespace runtime
