#include "runtime/commands/values_table.hpp"

#include "graph/types/standard_wires.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <tuple>

namespace runtime {
namespace {

constexpr const char* first_columns = "frame,seconds";

// One number a frame, or one for all.
struct Column {
    graph::Link from;
    std::map<int, double> at;
    std::optional<double> always;
};

std::vector<Column> columns_of(const std::vector<graph::Link>& wires,
                               const std::vector<AskedNumber>& numbers)
{
    std::vector<Column> out;
    for (const graph::Link& wire : wires) {
        Column& column = out.emplace_back(Column{wire, {}, {}});
        for (const AskedNumber& number : numbers) {
            if (number.from.node != wire.node || number.from.output != wire.output) continue;
            if (number.frame) {
                column.at[*number.frame] = number.value;
            } else {
                column.always = number.value;
            }
        }
    }
    return out;
}

// "tip (m)"; with the output where that says more than `value`.
std::string title_of(const graph::Graph& graph, const graph::Link& from,
                     const std::function<std::string(const graph::Node&)>& unit_of)
{
    const graph::Node& node = graph.nodes[from.node];
    const std::string& output = node.type->outputs[from.output].name;
    std::string title = output == "value" ? node.name : node.name + "." + output;
    const std::string unit = unit_of ? unit_of(node) : "";
    if (!unit.empty()) title += " (" + unit + ")";
    return title;
}

}  // namespace

bool is_values_table(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    std::string line;
    return std::getline(in, line) && line.starts_with(std::string(first_columns) + ",");
}

std::vector<std::uint32_t> nodes_with_numbers(const graph::Graph& graph)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        const auto& outputs = graph.nodes[n].type->outputs;
        if (std::any_of(outputs.begin(), outputs.end(), [](const graph::OutputPort& port) {
                return port.type == graph::wire_name<double>;
            })) {
            out.push_back(n);
        }
    }
    return out;
}

std::string values_table(const graph::Graph& graph, const std::vector<int>& frames,
                         const std::vector<graph::Link>& wires,
                         const std::vector<AskedNumber>& numbers,
                         const std::function<std::string(const graph::Node&)>& unit_of)
{
    const std::vector<Column> columns = columns_of(wires, numbers);
    std::string out = first_columns;
    for (const Column& column : columns) out += "," + title_of(graph, column.from, unit_of);
    out += "\n";
    for (const int frame : frames) {
        out += fmt::format("{},{:.9g}", frame, graph.range.time(frame));
        for (const Column& column : columns) {
            const auto at = column.at.find(frame);
            out += ",";
            if (at != column.at.end()) {
                out += fmt::format("{}", at->second);
            } else if (column.always) {
                out += fmt::format("{}", *column.always);
            }
        }
        out += "\n";
    }
    return out;
}

}  // namespace runtime
