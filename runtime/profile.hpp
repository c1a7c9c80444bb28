#pragma once

// Where a cook's time went: a table by node, and a trace that Chrome (chrome://tracing) and
// Perfetto (ui.perfetto.dev) open.

#include "graph/graph.hpp"
#include "runtime/evaluator.hpp"

#include <iosfwd>

namespace runtime {

// Keeps every run, and hands all on to another observer.
class Recorder : public Observer {
public:
    explicit Recorder(Observer& next) : next_(next) {}

    std::vector<Run> runs;

    void progressed(const Progress& p) override { next_.progressed(p); }
    void failed(const Failure& f) override { next_.failed(f); }
    void warned(const Warning& w) override { next_.warned(w); }
    void wrote(std::uint32_t n, int frame, const Written& w) override { next_.wrote(n, frame, w); }
    void ran(const Run& run) override
    {
        runs.push_back(run);
        next_.ran(run);
    }

private:
    Observer& next_;
};

// Dearest node first: seconds, share of all work, runs, results taken from memory and disk, bytes.
void write_table(const graph::Graph& graph, const Cooked& cooked, std::ostream& out);

// The trace event format's "complete" events, one a run, one row a thread.
void write_trace(const graph::Graph& graph, const std::vector<Run>& runs, std::ostream& out);

}  // namespace runtime
