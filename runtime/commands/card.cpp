#include "runtime/commands/card.hpp"

#include "runtime/commands/motion_card.hpp"
#include "runtime/cook/evaluator.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <ostream>

namespace runtime {
namespace {

using Lines = std::vector<std::pair<std::string, std::array<double, 2>>>;

// A node that makes cubes of a mesh.
struct Body {
    std::uint32_t node = 0;
    graph::Link mesh;
    std::uint32_t cubes = 0;  // output
};

std::vector<Body> bodies_of(const graph::Graph& graph)
{
    std::vector<Body> bodies;
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        const graph::Node& node = graph.nodes[n];
        if (node.type->name != "Voxelize") continue;
        for (std::size_t i = 0; i < node.type->inputs.size(); ++i) {
            if (node.type->inputs[i].name != "mesh" || node.inputs[i].empty()) continue;
            bodies.push_back({n, node.inputs[i].front(), 0});
        }
    }
    return bodies;
}

std::string number_text(double x)
{
    return std::isnan(x) ? "-" : fmt::format("{:.6g}", x);
}

// "0.12 %", of what is known and not 0.
std::string error_text(const std::array<double, 2>& pair)
{
    const double error = pair[1] / pair[0] - 1;
    return std::isfinite(error) ? fmt::format("{:+.2g} %", 100 * error) : "";
}

void write_text(const std::string& name, const Lines& lines, std::ostream& out)
{
    out << fmt::format("{:<42} {:>12} {:>12}  {}\n", name, "mesh", "cubes", "error");
    for (const auto& [quantity, pair] : lines) {
        out << fmt::format("  {:<40} {:>12} {:>12}  {}\n", quantity, number_text(pair[0]),
                           number_text(pair[1]),
                           quantity.starts_with("centre") ? "" : error_text(pair));
    }
}

nlohmann::ordered_json to_json(const std::string& name, const Lines& lines)
{
    const auto number = [](double x) {
        return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json();
    };
    nlohmann::ordered_json all{{"body", name}};
    for (const auto& [quantity, pair] : lines) {
        all["card"][quantity] = {{"mesh", number(pair[0])}, {"cubes", number(pair[1])}};
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
    const graph::Graph& graph;
    std::ostream& err;
    std::string failure;
};

void write_card(const std::string& name, const Lines& lines, bool json, std::ostream& out)
{
    if (json) {
        out << to_json(name, lines).dump() << "\n";
    } else {
        write_text(name, lines, out);
    }
}

void write_motion(const MotionCard& card, bool json, std::ostream& out)
{
    if (json) {
        nlohmann::ordered_json all{{"simulation", card.name}, {"frames", card.frames}};
        for (const auto& [quantity, x] : card.lines) {
            all["card"][quantity] =
                std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json();
        }
        out << all.dump() << "\n";
        return;
    }
    out << fmt::format("{:<42} {:>12}\n", card.name, fmt::format("{} frames", card.frames));
    for (const auto& [quantity, x] : card.lines) {
        out << fmt::format("  {:<40} {:>12}\n", quantity, number_text(x));
    }
}

// Cooks the simulations, and says how well they were solved.
int run_motion_card(Evaluator& evaluator, const CookRequest& request, Console& console,
                    const Telling& telling)
{
    Cooked cooked;
    std::vector<MotionCard> cards;
    try {
        cards = motion_cards(evaluator, request, console, cooked);
    } catch (const std::exception& e) {
        console.err << "aspic: " << e.what() << "\n";
        return exit_failed;
    }
    if (cooked.cancelled) return exit_cancelled;
    if (!telling.failure.empty()) {
        console.err << "aspic: " << telling.failure << "\n";
        return exit_failed;
    }
    if (cards.empty()) {
        console.err << fmt::format("{} simulates no cubes: --motion needs Simulate\n",
                                   evaluator.graph().file);
        return exit_failed;
    }
    for (const MotionCard& card : cards) write_motion(card, request.json, console.out);
    return exit_ok;
}

}  // namespace

int run_card(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    const auto graph = load(request.files.at(0), request, registry, console);
    if (!graph) return exit_usage;
    const std::vector<Body> bodies = bodies_of(*graph);
    if ((bodies.empty() && !request.motion) || !console.body_card) {
        console.err << fmt::format(
            "{} makes no cubes of a mesh: a card needs Voxelize with a mesh\n", graph->file);
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
    const int frame = graph->range.first;
    for (const Body& body : bodies) {
        graph::Value mesh, cubes;
        const Cooked cooked =
            evaluator.cook({{body.node, frame}, {body.mesh.node, frame}},
                           [&](const Want& want, std::span<const graph::Value> values) {
                               if (want.node == body.node) cubes = values[body.cubes];
                               if (want.node == body.mesh.node) mesh = values[body.mesh.output];
                           });
        if (cooked.cancelled) return exit_cancelled;
        if (!mesh || !cubes) {
            console.err << "aspic: " << telling.failure << "\n";
            return exit_failed;
        }
        write_card(graph->nodes[body.node].name, console.body_card(mesh, cubes), request.json,
                   console.out);
    }
    if (request.motion) return run_motion_card(evaluator, request, console, telling);
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
                       "Also cook the simulations, and tell their solver residual, balance of "
                       "energy and contact depth");
    card_app->callback([&set] {
        run_limited(set, [&] { return run_card(set.request, set.registry, set.console); });
    });
}

}  // namespace runtime
