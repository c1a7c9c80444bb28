#pragma once

// How a cook shows itself: a line that changes on a terminal, plain lines in a log, or JSON lines
// for a program.

#include "graph/document/graph.hpp"
#include "runtime/commands/accuracy_card.hpp"
#include "runtime/commands/console.hpp"
#include "runtime/cook/evaluator.hpp"

namespace runtime {

struct ExpectationResult {
    const graph::Expectation* expectation = nullptr;
    int frame = 0;
    std::optional<double> value;  // none: it could not be made
    bool met = false;
};

// "bridge.json:12: sag.value at frame 7: expected at most 0.1, found 0.3 (the deck holds)"
std::string missed_text(const graph::Graph& graph, const ExpectationResult& missed);

// A number that was asked for by the node that it comes from.
struct AskedNumber {
    graph::Link from;
    std::optional<int> frame;  // none: the same at all frames
    double value = 0;
};

enum class Style { terminal, lines, json, quiet };

// What is shown of one graph's cook, beginning to end.
class FrontEnd : public Observer {
public:
    virtual void began(const graph::Graph& graph, std::size_t frames) = 0;
    virtual void expectation(const ExpectationResult& result) = 0;
    // So many had no number to look at, as nodes failed.
    virtual void expectations_left_out(std::size_t count) = 0;
    virtual void accuracy(const std::vector<AccuracyCard>& cards) = 0;
    // In the order of nodes, outputs and frames.
    virtual void numbers(const std::vector<AskedNumber>& asked) = 0;
    virtual void finished(const Cooked& cooked, int exit) = 0;
};

std::unique_ptr<FrontEnd> make_front_end(Style style, Console& console);

// Many files as few lines: "frames/####.png (48 files)" where only a number changes.
std::vector<std::string> group_files(const std::vector<std::filesystem::path>& files);

}  // namespace runtime
