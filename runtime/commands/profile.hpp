#pragma once

// Where a cook's time went: a table by node, and a trace that Chrome (chrome://tracing) and
// Perfetto (ui.perfetto.dev) open.

#include "graph/document/graph.hpp"
#include "runtime/cook/evaluator.hpp"

#include <iosfwd>

namespace runtime {

// Keeps every run.
class Recorder : public Relay {
public:
    using Relay::Relay;
    std::vector<Run> runs;
    void ran(const Run& run) override
    {
        runs.push_back(run);
        Relay::ran(run);
    }
};

// Dearest node first: seconds, share of all work, runs, results taken from memory and disk, bytes.
void write_table(const graph::Graph& graph, const Cooked& cooked, std::ostream& out);

// The trace event format's "complete" events, one a run, one row a thread.
void write_trace(const graph::Graph& graph, const std::vector<Run>& runs, std::ostream& out);

}  // namespace runtime
