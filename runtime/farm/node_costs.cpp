#include "runtime/farm/node_costs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

namespace runtime {

namespace {

constexpr std::size_t most_looked_at = 16;  // frames of one node

// The mean of what is stored of the node, at frames evenly spread among those that are stored: the
// first frame alone would tell of a start, too.
std::optional<double> stored_seconds(std::uint32_t n, Keys& keys, const std::vector<int>& frames,
                                     const Stored& stored)
{
    if (stored.keys.empty()) return std::nullopt;
    std::vector<Key> there;
    const std::size_t all = keys.varies(n) ? frames.size() : 1;
    for (std::size_t i = 0; i < all; ++i) {
        const Key& key = keys.at(n, frames[i]);
        if (stored.holds(key)) there.push_back(key);
    }
    double sum = 0;
    int found = 0;
    const std::size_t count = std::min(there.size(), most_looked_at);
    for (std::size_t i = 0; i < count; ++i) {
        const auto record = stored.disk->record(there[i * there.size() / count]);
        if (record) sum += record->seconds, ++found;
    }
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
        simulated[n] = keys.rolls(n);
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
            if (keys.rolls(n)) in_the_dark.push_back(n);
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
