#include "graph/document/scene_pace.hpp"

#include <cmath>
#include <string_view>

namespace graph {

namespace {

constexpr double not_said = 0, not_one = -1;

// What a node says itself. `path`: "block.parameter".
double said_by(const Node& node, std::string_view path, Pace::By by, double fps)
{
    const std::vector<Param>* params = &node.type->params;
    const ParamValues* values = &node.params;
    std::vector<std::uint32_t> where;
    double value = 0;
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('.', begin), path.size());
        const std::string_view name = path.substr(begin, end - begin);
        std::uint32_t i = 0;
        while (i < params->size() && (*params)[i].name != name) ++i;
        if (i == params->size()) return not_said;
        where.push_back(i);
        if (const auto* inside = std::get_if<ParamValues>(&(*values)[i].is)) {
            params = &(*params)[i].children, values = inside;
        } else if (const auto* number = std::get_if<double>(&(*values)[i].is)) {
            value = *number;
        }
        begin = end + 1;
    }
    for (const Animated& a : node.animated) {
        if (a.where == where) return not_one;
    }
    if (by == Pace::By::seconds_a_frame) return value > 0 ? value : 1 / fps;
    return value > 0 ? 1 / (value * fps) : not_said;
}

bool same(double a, double b)
{
    return std::abs(a - b) <= 1e-9 * std::abs(a);
}

}  // namespace

double scene_pace(const Graph& graph, std::uint32_t node)
{
    std::vector<char> wanted(node + std::size_t{1}, 0);
    wanted[node] = 1;
    for (std::size_t n = wanted.size(); n-- > 0;) {
        for (const auto& links : graph.nodes[n].inputs) {
            for (const Link& link : links) wanted[link.node] |= wanted[n];
        }
    }
    std::vector<double> pace(wanted.size(), not_said);
    for (std::size_t n = 0; n < wanted.size(); ++n) {
        const Node& at = graph.nodes[n];
        if (!wanted[n]) continue;
        if (!at.type->pace.param.empty()) {
            pace[n] = said_by(at, at.type->pace.param, at.type->pace.by, graph.range.fps);
        }
        if (pace[n] != not_said) continue;
        for (const auto& links : at.inputs) {
            for (const Link& link : links) {
                const double other = pace[link.node];
                if (other == not_said || pace[n] == not_one) continue;
                pace[n] = pace[n] == not_said || same(pace[n], other) ? other : not_one;
            }
        }
    }
    return pace[node] > 0 ? pace[node] : 0;
}

}  // namespace graph
