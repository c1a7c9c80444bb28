#include "graph/sort_nodes.hpp"

#include <algorithm>
#include <numeric>

namespace graph {

namespace {

// The nodes that each node takes inputs from, in one array.
struct Sources {
    std::vector<std::uint32_t> first, node;
};

Sources sources_of(const std::vector<Node>& nodes)
{
    Sources s;
    s.first.reserve(nodes.size() + 1);
    s.first.push_back(0);
    for (const Node& node : nodes) {
        for (const auto& links : node.inputs) {
            for (const Link& link : links) s.node.push_back(link.node);
        }
        s.first.push_back(static_cast<std::uint32_t>(s.node.size()));
    }
    return s;
}

}  // namespace

std::vector<std::vector<std::uint32_t>> sort_nodes(Graph& graph)
{
    const std::size_t n = graph.nodes.size();
    std::vector<std::uint32_t> by_name(n);
    std::iota(by_name.begin(), by_name.end(), 0u);
    std::sort(by_name.begin(), by_name.end(), [&](std::uint32_t a, std::uint32_t b) {
        return graph.nodes[a].name < graph.nodes[b].name;
    });

    // Depth first with a stack of our own: a node is written down after all its sources.
    enum class Mark : char { fresh, open, done };
    const Sources sources = sources_of(graph.nodes);
    std::vector<Mark> mark(n, Mark::fresh);
    std::vector<std::uint32_t> order, path, next(sources.first.begin(), sources.first.end());
    std::vector<std::vector<std::uint32_t>> cycles;
    order.reserve(n);
    for (const std::uint32_t root : by_name) {
        if (mark[root] != Mark::fresh) continue;
        path.assign(1, root);
        mark[root] = Mark::open;
        while (!path.empty()) {
            const std::uint32_t node = path.back();
            if (next[node] == sources.first[node + 1]) {
                mark[node] = Mark::done;
                order.push_back(node);
                path.pop_back();
                continue;
            }
            const std::uint32_t source = sources.node[next[node]++];
            if (mark[source] == Mark::fresh) {
                mark[source] = Mark::open;
                path.push_back(source);
            } else if (mark[source] == Mark::open && cycles.size() < 100) {
                const auto begin = std::find(path.begin(), path.end(), source);
                cycles.emplace_back(begin, path.end());
                auto& cycle = cycles.back();  // along the links, from the first by name
                std::reverse(cycle.begin(), cycle.end());
                std::rotate(cycle.begin(),
                            std::min_element(cycle.begin(), cycle.end(),
                                             [&](std::uint32_t a, std::uint32_t b) {
                                                 return graph.nodes[a].name < graph.nodes[b].name;
                                             }),
                            cycle.end());
            }
        }
    }
    if (!cycles.empty()) return cycles;

    std::vector<std::uint32_t> place(n);
    std::vector<Node> sorted(n);
    for (std::uint32_t i = 0; i < n; ++i) {
        place[order[i]] = i;
        sorted[i] = std::move(graph.nodes[order[i]]);
    }
    for (Node& node : sorted) {
        for (auto& links : node.inputs) {
            for (Link& link : links) link.node = place[link.node];
        }
    }
    for (Expectation& e : graph.expectations) e.value.node = place[e.value.node];
    graph.nodes = std::move(sorted);
    return {};
}

}  // namespace graph
