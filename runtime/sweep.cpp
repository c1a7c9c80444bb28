#include "runtime/sweep.hpp"

#include "graph/standard_wires.hpp"
#include "runtime/wires.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <set>

namespace runtime {

namespace {

bool is_number(const graph::OutputPort& port)
{
    return port.type == graph::wire_name<double>;
}
std::vector<std::string> all_numbers(const graph::Graph& graph)
{
    std::vector<std::string> names;
    for (const graph::Node& node : graph.nodes) {
        for (const graph::OutputPort& port : node.type->outputs) {
            if (is_number(port)) names.push_back(node.name + "." + port.name);
        }
    }
    return names;
}

// What went wrong, in order.
struct Failures : Observer {
    std::vector<Failure> all;
    void failed(const Failure& f) override { all.push_back(f); }
    // Why a frame lacks something: what failed there, or else first.
    std::string at(const graph::Graph& graph, int frame) const
    {
        if (all.empty()) return {};
        const auto found = std::find_if(all.begin(), all.end(),
                                        [&](const Failure& f) { return f.frame == frame; });
        return describe(graph, found == all.end() ? all.front() : *found);
    }
};

}  // namespace

Swept sweep(const std::filesystem::path& file, const graph::Registry& registry,
            const SweepOptions& options, Caches& caches,
            const std::function<void(const SweepRow&)>& told)
{
    const std::vector<Settings> all = combinations(options.varied);
    Swept out;
    std::string picture = options.picture;
    std::vector<int> frames = options.frames;
    {
        const graph::Graph graph = load_with(file, registry, options.load, all.front());
        out.measures = options.measures.empty() ? all_numbers(graph) : options.measures;
        if (picture.empty()) picture = first_picture(graph);
        if (!picture.empty()) {
            const graph::Link link = find_wire(graph, picture);
            if (!is_picture(graph.nodes[link.node].type->outputs[link.output])) {
                throw std::invalid_argument(fmt::format("expected '{}' to be a picture", picture));
            }
        }
        for (const std::string& name : out.measures) {
            const graph::Link link = find_wire(graph, name);
            if (!is_number(graph.nodes[link.node].type->outputs[link.output])) {
                throw std::invalid_argument(fmt::format(
                    "expected '{}' to be a number: put a Measure node behind it", name));
            }
        }
        if (picture.empty() && out.measures.empty()) {
            throw std::invalid_argument(fmt::format(
                "{} makes neither a picture nor a number: add a Render or a Measure node",
                graph.file));
        }
        if (frames.empty()) frames = {graph.range.last};
        for (const int frame : frames) {
            if (frame >= graph.range.first && frame <= graph.range.last) continue;
            throw std::invalid_argument(fmt::format("{} has frames {} to {}; frame {} is none of "
                                                    "them",
                                                    graph.file, graph.range.first, graph.range.last,
                                                    frame));
        }
    }
    for (const Settings& settings : all) {
        SweepRow blank;
        blank.settings = settings;
        blank.numbers.assign(out.measures.size(), std::numeric_limits<double>::quiet_NaN());
        std::vector<SweepRow> rows(frames.size(), blank);
        for (std::size_t i = 0; i < frames.size(); ++i) rows[i].frame = frames[i];
        try {
            const graph::Graph graph = load_with(file, registry, options.load, settings);
            std::vector<Want> wants;
            std::vector<graph::Link> links;
            for (const std::string& name : out.measures) links.push_back(find_wire(graph, name));
            graph::Link shown;
            if (!picture.empty()) shown = find_wire(graph, picture);
            for (const SweepRow& row : rows) {
                for (const graph::Link& link : links) wants.push_back({link.node, row.frame});
                if (!picture.empty()) wants.push_back({shown.node, row.frame});
            }
            std::sort(wants.begin(), wants.end());
            wants.erase(std::unique(wants.begin(), wants.end()), wants.end());

            Failures failures;
            Options cook = options.cook;
            cook.keep_going = true;
            Evaluator evaluator(graph, caches, cook, &failures);
            std::set<Want> arrived;
            const Cooked cooked =
                evaluator.cook(wants, [&](const Want& want, std::span<const graph::Value> values) {
                    for (SweepRow& row : rows) {
                        // What is the same at all frames arrives once.
                        const bool varies = evaluator.keys().varies(want.node);
                        if (varies && row.frame != want.frame) continue;
                        arrived.insert({want.node, row.frame});
                        for (std::size_t i = 0; i < links.size(); ++i) {
                            if (links[i].node != want.node) continue;
                            const graph::Value& v = values[links[i].output];
                            if (v) row.numbers[i] = *v.as<double>();
                        }
                        if (!picture.empty() && shown.node == want.node) {
                            row.picture = values[shown.output];
                        }
                    }
                });
            for (SweepRow& row : rows) row.seconds = cooked.seconds;
            for (const Want& want : wants) {
                if (arrived.contains(want)) continue;
                for (SweepRow& row : rows) {
                    if (row.frame == want.frame) row.failure = failures.at(graph, row.frame);
                }
            }
            out.cancelled = cooked.cancelled;
        } catch (const std::exception& e) {
            for (SweepRow& row : rows) row.failure = e.what();
        }
        if (out.cancelled) break;
        for (SweepRow& row : rows) {
            if (told) told(row);
            out.rows.push_back(std::move(row));
        }
    }
    return out;
}

std::string to_csv(const Swept& swept)
{
    std::string text;
    if (swept.rows.empty()) return text;
    for (const graph::Override& s : swept.rows[0].settings) {
        text.append(csv_quoted(s.target)).append(1, ',');
    }
    text += "frame,";
    for (const std::string& name : swept.measures) text.append(csv_quoted(name)).append(1, ',');
    text += "seconds,failure\n";
    for (const SweepRow& row : swept.rows) {
        for (const graph::Override& s : row.settings) {
            text.append(csv_quoted(s.value)).append(1, ',');
        }
        text.append(std::to_string(row.frame)).append(1, ',');
        for (const double x : row.numbers) {
            if (!std::isnan(x)) text += fmt::format("{:.9g}", x);
            text += ',';
        }
        text += fmt::format("{:.6g},{}\n", row.seconds, csv_quoted(row.failure));
    }
    return text;
}

}  // namespace runtime
