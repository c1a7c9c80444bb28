#pragma once

// The accuracy card of a cook: what its nodes told of their results, of all frames together.

#include "graph/document/graph.hpp"
#include "runtime/cook/keys.hpp"
#include "runtime/cook/observer.hpp"

#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace runtime {

// A figure of all frames: of a balance, the share that it gained or lost.
struct CardLine : graph::Figure {
    int frame = 0;             // at which it is largest
    std::vector<int> at = {};  // of Over::frames, whose value is their number
};

// What one node told.
struct AccuracyCard {
    std::string node, kind;  // "cubes", "body"
    std::size_t frames = 0;  // that it told of
    std::vector<CardLine> lines;
    bool rigid = false;  // a body that nothing bends: of its stiffness summaries say nothing
};

// The figures of a cook as they arrive.
class AccuracyFigures {
public:
    void add(const Told& told) { all_.push_back(told); }

    // One card for each node that told of its results, in the order of the graph. Figures from a
    // cache go to the node of the graph that would make that result, whatever it was called then.
    std::vector<AccuracyCard> cards(const graph::Graph& graph, Keys& keys) const;

private:
    std::vector<Told> all_;
};

// A table of what is compared, or of values.
std::string card_table(const AccuracyCard& card);

// "'cubes': 80 cubes; against the mesh: volume +0.1 %, inertia -2 %": all on one line.
std::string card_summary(const AccuracyCard& card);

// What is worth a warning: "'sim': 3 of 48 frames did not converge (5, 9-10)", a volume or a depth
// of contact far from what is meant, energy from nothing.
std::vector<std::string> card_warnings(const AccuracyCard& card);

nlohmann::ordered_json card_json(const AccuracyCard& card);

}  // namespace runtime
