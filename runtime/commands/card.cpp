#include "runtime/commands/card.hpp"

#include "runtime/commands/accuracy_card.hpp"
#include "runtime/commands/command_options.hpp"
#include "runtime/cook/evaluator.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <ostream>

namespace runtime {
namespace {

// The nodes of a type that have a link at an input.
std::vector<std::uint32_t> nodes_with(const graph::Graph& graph, const char* type,
                                      const char* input)
{
    std::vector<std::uint32_t> all;
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        const graph::Node& node = graph.nodes[n];
        if (node.type->name == type && !graph::links_to(node, input).empty()) all.push_back(n);
    }
    return all;
}

// Warnings of the nodes that are cooked, and the first failure.
struct Telling : Observer {
    Telling(const graph::Graph& g, std::ostream& e) : graph(g), err(e) {}
    void warned(const Warning& w) override
    {
        err << fmt::format("warning: '{}': {}\n", graph.nodes[w.node].name, w.text);
    }
    void failed(const Failure& f) override
    {
        if (failure.empty()) failure = describe(graph, f);
    }
    void told(const Told& t) override { figures.add(t); }
    const graph::Graph& graph;
    std::ostream& err;
    std::string failure;
    AccuracyFigures figures;
};

// Bodies first, so that a simulation stands below what it moves.
void write_cards(const std::vector<AccuracyCard>& cards, bool json, std::ostream& out)
{
    for (const bool body : {true, false}) {
        for (const AccuracyCard& card : cards) {
            if ((card.kind == "body") != body) continue;
            out << (json ? card_json(card).dump() + "\n" : card_table(card));
        }
    }
}

}  // namespace

int run_card(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    const auto graph = load(request.files.at(0), request, registry, console);
    if (!graph) return exit_usage;
    const auto bodies = nodes_with(*graph, "Voxelize", "mesh");
    const auto simulations =
        request.motion ? nodes_with(*graph, "Simulate", "cubes") : std::vector<std::uint32_t>();
    if (bodies.empty() && !request.motion) {
        console.err << fmt::format(
            "{} makes no cubes of a mesh: a card needs Voxelize with a mesh\n", graph->file);
        return exit_failed;
    }
    if (simulations.empty() && request.motion) {
        console.err << fmt::format("{} simulates no cubes: --motion needs Simulate\n", graph->file);
        return exit_failed;
    }
    Caches caches;
    caches.memory = MemoryCache(request.memory);
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    Options options;
    options.threads = request.threads;
    options.stop = console.stop;
    options.salt = console.salt;
    Telling telling(*graph, console.err);
    Evaluator evaluator(*graph, caches, options, &telling);
    std::vector<Want> wants;
    for (const std::uint32_t n : bodies) wants.push_back({n, graph->range.first});
    for (const int frame : chosen_frames(*graph, request)) {
        for (const std::uint32_t n : simulations) wants.push_back({n, frame});
    }
    const Cooked cooked = evaluator.cook(wants);
    if (cooked.cancelled) return exit_cancelled;
    if (cooked.failures > 0) {
        console.err << "aspic: " << telling.failure << "\n";
        return exit_failed;
    }
    write_cards(telling.figures.cards(*graph, evaluator.keys()), request.json, console.out);
    return exit_ok;
}

void add_card_command(const CommandSet& set)
{
    CLI::App* card_app = set.app.add_subcommand(
        "card",
        "Compares the cubes of each body with its mesh: volume, centre, inertia, stiffness");
    add_file(*card_app, set.request);
    add_loading_options(*card_app, set.request);
    add_cooking_options(*card_app, set.request);
    card_app->add_flag("--motion", set.request.motion,
                       "Also cook the simulations, and tell their residual, balance of "
                       "energy and contact depth");
    card_app->callback([&set] {
        run_limited(set, [&] { return run_card(set.request, set.registry, set.console); });
    });
}

}  // namespace runtime
