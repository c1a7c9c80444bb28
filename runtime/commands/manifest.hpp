#pragma once

// What went into a cook and what came out, as JSON beside the files that it wrote: the program, the
// documents and files read with their digests, each node's parameters, links and key, and the
// digest of every output. `aspic explain` compares a graph with it, `aspic verify` cooks it again.

#include "graph/document/graph.hpp"
#include "runtime/commands/accuracy_card.hpp"
#include "runtime/cook/evaluator.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace runtime {

struct Manifest {
    struct File {
        std::string path;    // documents and files: absolute; outputs: from the manifest's folder
        std::string digest;  // 32 hexadecimal digits; zeros when it was not there; empty where
                             // frames share it and the cook did not write all of them
        bool operator==(const File&) const = default;
    };
    struct Node {
        std::string type;  // "Voxelize@1"
        std::string key;   // of the result; of a node that changes with the frame, of all of them
        std::map<std::string, std::string> params, inputs;
        std::map<std::string, File> files;  // by parameter
        std::vector<File> side_files;       // opened beside those
        double seconds = 0;                 // of a run, on average; 0 when it did not run
    };
    struct Output {
        std::string node, port;  // of a value; port is empty for a file
        int frame = 0;
        File file;  // path is empty for a value
    };

    // What the cook took.
    struct Ran {
        std::string machine;
        double seconds = 0;
        std::uint64_t memory = 0;  // bytes at most, programs that it started included
        double cores = 0;          // busy, on average
    };

    std::string version, program;            // the program's, and its identity (Options::salt)
    std::vector<File> documents;             // the main one first
    std::string frames;                      // as --frames takes them
    std::optional<graph::FrameRange> range;  // of the graph; older manifests have none
    std::vector<std::string> sets, variables, only;  // --set, --var, --node
    std::string root;
    bool allow_outside = false, complete = false;
    std::optional<Ran> ran;
    std::map<std::string, Node> nodes;  // those that were needed
    std::vector<Output> outputs;        // by node and frame
    std::vector<std::string> missed;    // expectations, as missed_text() tells them
    std::vector<AccuracyCard> cards;    // written, and not read back
};

inline constexpr const char* manifest_name = "manifest.json";

// The documents and nodes that `keys` was aimed at, at `frames`, into the manifest.
void describe_graph(const graph::Graph& graph, Keys& keys, const std::vector<int>& frames,
                    FileDigests& digests, Manifest& manifest);

std::string to_text(const Manifest& manifest);
// Whether a file looks like a manifest, without a look at all that it says.
bool is_manifest(const std::filesystem::path& path);
// Throws std::invalid_argument saying what is wrong with the file.
Manifest read_manifest(const std::filesystem::path& path);

// What this process took up to now, of a cook of so many seconds.
Manifest::Ran ran_here(double seconds);

// "1-48,60" of ascending frames.
std::string frames_text(const std::vector<int>& frames);

// What is different in how this node's result comes about, a line each: "parameter 'size' is 0.1,
// was 0.08". Empty when nothing of its own is.
std::vector<std::string> changes(const Manifest::Node& was, const Manifest::Node& is);

}  // namespace runtime
