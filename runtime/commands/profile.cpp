#include "runtime/commands/profile.hpp"

#include "runtime/cache/quantities.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <numeric>
#include <ostream>

namespace runtime {

void write_table(const graph::Graph& graph, const Cooked& cooked, std::ostream& out)
{
    std::vector<std::uint32_t> order(graph.nodes.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return cooked.tallies[a].seconds > cooked.tallies[b].seconds;
    });
    double all = 0;
    std::size_t width = 4;
    for (const std::uint32_t n : order) {
        all += cooked.tallies[n].seconds;
        width = std::max(width, graph.nodes[n].name.size() + graph.nodes[n].type->name.size() + 3);
    }
    out << fmt::format("{:<{}} {:>9} {:>6} {:>6} {:>9} {:>7} {:>7} {:>9}\n", "node", width, "time",
                       "share", "runs", "each", "memory", "disk", "made");
    for (const std::uint32_t n : order) {
        const Tally& t = cooked.tallies[n];
        if (t.runs + t.hits + t.loads == 0) continue;
        const double each = t.runs > 0 ? t.seconds / static_cast<double>(t.runs) : 0;
        out << fmt::format("{:<{}} {:>9} {:>5.1f}% {:>6} {:>9} {:>7} {:>7} {:>9}\n",
                           graph.nodes[n].name + " (" + graph.nodes[n].type->name + ")", width,
                           format_seconds(t.seconds), all > 0 ? 100 * t.seconds / all : 0, t.runs,
                           format_seconds(each), t.hits, t.loads,
                           format_bytes(static_cast<double>(t.bytes)));
    }
    out << fmt::format("{} of work in {}: {:.1f} at once\n", format_seconds(all),
                       format_seconds(cooked.seconds), all / std::max(cooked.seconds, 1e-9));
}

void write_trace(const graph::Graph& graph, const std::vector<Run>& runs, std::ostream& out)
{
    out << "[";
    const char* separator = "\n";
    for (const Run& run : runs) {
        const graph::Node& node = graph.nodes[run.node];
        nlohmann::ordered_json event{
            {"name",
             run.preparation < 0
                 ? node.name
                 : node.name + ": " +
                       node.type->preparations[static_cast<std::size_t>(run.preparation)].name},
            {"cat", node.type->name},
            {"ph", "X"},
            {"ts", run.begin * 1e6},
            {"dur", run.seconds * 1e6},
            {"pid", 1},
            {"tid", run.thread},
            {"args", {{"frame", run.frame}, {"bytes", run.bytes}}}};
        out << separator
            << event.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
        separator = ",\n";
    }
    out << "\n]\n";
}

}  // namespace runtime
