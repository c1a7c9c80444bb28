#include "graph/document/sort_nodes.hpp"

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

// The loop that `path` closes by reaching `source` again: along the links, from the first by name.
std::vector<std::uint32_t> loop_in(const std::vector<std::uint32_t>& path, std::uint32_t source,
                                   const std::vector<Node>& nodes)
{
    std::vector<std::uint32_t> loop(std::find(path.begin(), path.end(), source), path.end());
    std::reverse(loop.begin(), loop.end());
    const auto first = std::min_element(
        loop.begin(), loop.end(), [&](auto a, auto b) { return nodes[a].name < nodes[b].name; });
    std::rotate(loop.begin(), first, loop.end());
    return loop;
}

// The nodes so that each stands after its sources, and the loops that forbid it.
struct Order {
    std::vector<std::uint32_t> nodes;
    std::vector<std::vector<std::uint32_t>> loops;
};

// Depth first with a stack of our own, from nodes in order of their names: a node is written down
// after all its sources.
Order order_of(const std::vector<Node>& nodes)
{
    const std::size_t n = nodes.size();
    std::vector<std::uint32_t> by_name(n);
    std::iota(by_name.begin(), by_name.end(), 0u);
    std::sort(by_name.begin(), by_name.end(),
              [&](std::uint32_t a, std::uint32_t b) { return nodes[a].name < nodes[b].name; });

    enum class Mark : char { fresh, open, done };
    const Sources sources = sources_of(nodes);
    std::vector<Mark> mark(n, Mark::fresh);
    std::vector<std::uint32_t> path, next(sources.first.begin(), sources.first.end());
    Order order;
    order.nodes.reserve(n);
    for (const std::uint32_t root : by_name) {
        if (mark[root] != Mark::fresh) continue;
        path.assign(1, root);
        mark[root] = Mark::open;
        while (!path.empty()) {
            const std::uint32_t node = path.back();
            if (next[node] == sources.first[node + 1]) {
                mark[node] = Mark::done;
                order.nodes.push_back(node);
                path.pop_back();
                continue;
            }
            const std::uint32_t source = sources.node[next[node]++];
            if (mark[source] == Mark::fresh) {
                mark[source] = Mark::open;
                path.push_back(source);
            } else if (mark[source] == Mark::open && order.loops.size() < 100) {
                order.loops.push_back(loop_in(path, source, nodes));
            }
        }
    }
    return order;
}

// Puts the nodes into this order and adapts all links.
void reorder(Graph& graph, const std::vector<std::uint32_t>& order)
{
    const std::size_t n = graph.nodes.size();
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
}

}  // namespace

std::vector<std::vector<std::uint32_t>> sort_nodes(Graph& graph)
{
    Order order = order_of(graph.nodes);
    if (order.loops.empty()) reorder(graph, order.nodes);
    return std::move(order.loops);
}

}  // namespace graph
