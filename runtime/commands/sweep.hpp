#pragma once

// Cooks a graph at every combination of some parameters and lays the results side by side. What is
// equal between combinations is cooked once.

#include "runtime/commands/vary.hpp"
#include "runtime/cook/evaluator.hpp"

#include <functional>
#include <string>
#include <vector>

namespace runtime {

struct SweepOptions {
    std::vector<Vary> varied;
    std::string picture;                // node.port of an image; empty: the graph's first
    std::vector<std::string> measures;  // node.port of numbers; empty: all that the graph has
    std::vector<int> frames;            // which; none: the last
    bool pictures = true;               // false: numbers alone
    std::string keep;                   // node.port whose value rows keep; empty: none
    graph::LoadOptions load;
    Options cook;
};

// One combination at one frame.
struct SweepRow {
    Settings settings;
    int frame = 0;
    graph::Value picture;         // empty when the graph has none
    graph::Value kept;            // what SweepOptions::keep names
    std::vector<double> numbers;  // one a measure; not a number when it could not be made
    double seconds = 0;           // that the combination took, all frames together
    std::string failure;          // why something of it could not be cooked; empty when all could
    std::vector<std::string> warnings;  // of the combination: of its document, and "'node': text"
};

struct Swept {
    std::vector<std::string> measures;  // "height.value"
    std::vector<SweepRow> rows;         // by combination, then by frame
    bool cancelled = false;
};

// Throws std::invalid_argument for options that make no sense of this graph; a combination that
// fails is data. `told` is called for each row.
Swept sweep(const std::filesystem::path& file, const graph::Registry& registry,
            const SweepOptions& options, Caches& caches,
            const std::function<void(const SweepRow&)>& told = {});

// Whether a sweep of the graph has something to show.
bool makes_numbers_or_pictures(const graph::Graph& graph);

// A line a row, a column a varied parameter and a measure; the header first.
std::string to_csv(const Swept& swept);

}  // namespace runtime
