#include "runtime/farm/node_costs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace runtime {

namespace {

constexpr std::size_t most_looked_at = 16;  // frames of one node

// The mean of what is stored of the node, at frames evenly spread.
std::optional<double> stored_seconds(std::uint32_t n, Keys& keys, const std::vector<int>& frames,
                                     const Stored& stored)
{
    double sum = 0;
    int found = 0;
    const auto look = [&](int frame) {
        const Key& key = keys.at(n, frame);
        if (!stored.holds(key)) return;
        if (const auto record = stored.disk->record(key)) sum += record->seconds, ++found;
    };
    const std::size_t count = keys.varies(n) ? std::min(frames.size(), most_looked_at) : 1;
    for (std::size_t i = 0; i < count; ++i) look(frames[i * frames.size() / count]);
    if (found == 0) return std::nullopt;
    return sum / found;
}

}  // namespace

NodeCosts node_costs(const graph::Graph& graph, Keys& keys,
                     const std::vector<std::uint32_t>& targets, const std::vector<int>& frames,
                     const Stored& stored, const SecondsOf& before, SecondsOf& usual)
{
    NodeCosts costs{std::vector<double>(graph.nodes.size(), 0), false};
    bool own = false;                        // something that tells of this graph's simulations
    std::vector<std::uint32_t> in_the_dark;  // simulations
    std::vector<char> simulated(graph.nodes.size(), 0);  // they and what depends on them
    for (const std::uint32_t n : keys.reached()) {
        const graph::Node& node = graph.nodes[n];
        const std::string type = fmt::format("{}@{}", node.type->name, node.type->version);
        std::optional<double> seconds = stored_seconds(n, keys, frames, stored);
        bool known = seconds.has_value();
        simulated[n] = !node.type->previous.empty();
        for (const auto& port : node.inputs) {
            for (const graph::Link& link : port) simulated[n] |= simulated[link.node];
        }
        own = own || (known && simulated[n]);
        if (seconds) usual[type] = *seconds;
        if (const auto found = before.find(node.name); !seconds && found != before.end()) {
            seconds = found->second;
            own = true;
            known = std::find(targets.begin(), targets.end(), n) != targets.end();
        }
        if (const auto found = usual.find(type); !seconds && found != usual.end()) {
            seconds = found->second;
            known = true;
        }
        if (!seconds) {
            if (!node.type->previous.empty()) in_the_dark.push_back(n);
            continue;
        }
        costs.seconds[n] = *seconds;
        costs.measured = costs.measured || (keys.varies(n) && known);
    }
    if (costs.measured && !own) {
        for (const std::uint32_t n : in_the_dark) costs.seconds[n] = 1;
    }
    return costs;
}

}  // namespace runtime
