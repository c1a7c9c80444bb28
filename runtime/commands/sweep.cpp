#include "runtime/commands/sweep.hpp"

#include "graph/types/standard_wires.hpp"
#include "runtime/commands/cook_request.hpp"
#include "runtime/commands/wires.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
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

// What went wrong, in order, and what was warned of.
struct Troubles : Observer {
    std::vector<Failure> all;
    std::vector<Warning> warnings;
    void failed(const Failure& f) override { all.push_back(f); }
    void warned(const Warning& w) override { warnings.push_back(w); }
    // Why a frame lacks something: what failed there, or else first.
    std::string at(const graph::Graph& graph, int frame) const
    {
        if (all.empty()) return {};
        const auto found = std::find_if(all.begin(), all.end(),
                                        [&](const Failure& f) { return f.frame == frame; });
        return describe(graph, found == all.end() ? all.front() : *found);
    }
};

// What is looked at of each combination.
struct Looked {
    std::string picture;  // node.port; empty: none
    std::vector<std::string> measures;
    std::vector<int> frames;
    std::string keep;  // node.port; empty: none
};

// From the options and the graph of one combination. Throws std::invalid_argument when they do not
// go together.
Looked looked_at(const graph::Graph& graph, const SweepOptions& options)
{
    Looked looked{options.picture, options.measures, options.frames, options.keep};
    if (looked.measures.empty()) looked.measures = all_numbers(graph);
    if (looked.picture.empty() && options.pictures) looked.picture = first_picture(graph);
    if (!looked.picture.empty()) {
        const graph::Link link = find_wire(graph, looked.picture);
        if (!is_picture(graph.nodes[link.node].type->outputs[link.output])) {
            throw std::invalid_argument(
                fmt::format("expected '{}' to be a picture", looked.picture));
        }
    }
    for (const std::string& name : looked.measures) {
        const graph::Link link = find_wire(graph, name);
        if (!is_number(graph.nodes[link.node].type->outputs[link.output])) {
            throw std::invalid_argument(
                fmt::format("expected '{}' to be a number; add a Measure node after it", name));
        }
    }
    if (looked.picture.empty() && looked.measures.empty()) {
        throw std::invalid_argument(fmt::format(
            "{} makes neither a picture nor a number: add a Render or a Measure node", graph.file));
    }
    if (looked.frames.empty()) looked.frames = {graph.range.last};
    for (const int frame : looked.frames) require_frame(graph, frame);
    return looked;
}

// The wires of one combination's graph that are looked at.
struct Wires {
    std::vector<graph::Link> measures;
    std::optional<graph::Link> picture, kept;
};

Wires find_wires(const graph::Graph& graph, const Looked& looked)
{
    Wires wires;
    for (const std::string& name : looked.measures)
        wires.measures.push_back(find_wire(graph, name));
    if (!looked.picture.empty()) wires.picture = find_wire(graph, looked.picture);
    if (!looked.keep.empty()) wires.kept = find_wire(graph, looked.keep);
    return wires;
}

std::vector<Want> wants_of(const Wires& wires, const std::vector<SweepRow>& rows)
{
    std::vector<Want> wants;
    for (const SweepRow& row : rows) {
        for (const graph::Link& link : wires.measures) wants.push_back({link.node, row.frame});
        if (wires.picture) wants.push_back({wires.picture->node, row.frame});
        if (wires.kept) wants.push_back({wires.kept->node, row.frame});
    }
    std::sort(wants.begin(), wants.end());
    wants.erase(std::unique(wants.begin(), wants.end()), wants.end());
    return wants;
}

// What arrived of a node into one row.
void take(std::uint32_t node, std::span<const graph::Value> values, const Wires& wires,
          SweepRow& row)
{
    for (std::size_t i = 0; i < wires.measures.size(); ++i) {
        if (wires.measures[i].node != node) continue;
        const graph::Value& v = values[wires.measures[i].output];
        if (v) row.numbers[i] = *v.as<double>();
    }
    if (wires.picture && wires.picture->node == node) row.picture = values[wires.picture->output];
    if (wires.kept && wires.kept->node == node) row.kept = values[wires.kept->output];
}

// Cooks one combination into its rows. Returns whether it was cancelled.
bool cook_combination(const graph::Loaded& loaded, const Looked& looked, Options options,
                      Caches& caches, std::vector<SweepRow>& rows)
{
    const graph::Graph& graph = loaded.graph;
    const Wires wires = find_wires(graph, looked);
    const std::vector<Want> wants = wants_of(wires, rows);
    Troubles troubles;
    options.keep_going = true;
    Evaluator evaluator(graph, caches, std::move(options), &troubles);
    std::set<Want> arrived;
    const Cooked cooked =
        evaluator.cook(wants, [&](const Want& want, std::span<const graph::Value> values) {
            for (SweepRow& row : rows) {
                // What is the same at all frames arrives once.
                const bool varies = evaluator.keys().varies(want.node);
                if (varies && row.frame != want.frame) continue;
                arrived.insert({want.node, row.frame});
                take(want.node, values, wires, row);
            }
        });
    std::vector<std::string> warnings = warnings_of(loaded);
    for (const Warning& w : troubles.warnings) {
        warnings.push_back(fmt::format("'{}': {}", graph.nodes[w.node].name, w.text));
    }
    for (SweepRow& row : rows) {
        row.seconds = cooked.seconds;
        row.warnings = warnings;
    }
    for (const Want& want : wants) {
        if (arrived.contains(want)) continue;
        for (SweepRow& row : rows) {
            if (row.frame == want.frame) row.failure = troubles.at(graph, row.frame);
        }
    }
    return cooked.cancelled;
}

// What is looked at, from the first combination that loads: one that does not is a row with its
// reason. Throws what is wrong with the first where none loads.
Looked looked_at_in(const std::filesystem::path& file, const graph::Registry& registry,
                    const SweepOptions& options, const std::vector<Settings>& all)
{
    std::exception_ptr first;
    for (const Settings& settings : all) {
        std::optional<graph::Graph> graph;
        try {
            graph = load_with(file, registry, options.load, settings).graph;
        } catch (const std::exception&) {
            if (!first) first = std::current_exception();
        }
        if (graph) return looked_at(*graph, options);
    }
    std::rethrow_exception(first);
}

}  // namespace

bool makes_numbers_or_pictures(const graph::Graph& graph)
{
    return !first_picture(graph).empty() || !all_numbers(graph).empty();
}

Swept sweep(const std::filesystem::path& file, const graph::Registry& registry,
            const SweepOptions& options, Caches& caches,
            const std::function<void(const SweepRow&)>& told)
{
    const std::vector<Settings> all = combinations(options.varied);
    const Looked looked = looked_at_in(file, registry, options, all);
    Swept out;
    out.measures = looked.measures;
    for (const Settings& settings : all) {
        SweepRow blank;
        blank.settings = settings;
        blank.numbers.assign(out.measures.size(), std::numeric_limits<double>::quiet_NaN());
        std::vector<SweepRow> rows(looked.frames.size(), blank);
        for (std::size_t i = 0; i < rows.size(); ++i) rows[i].frame = looked.frames[i];
        try {
            const graph::Loaded loaded = load_with(file, registry, options.load, settings);
            out.cancelled = cook_combination(loaded, looked, options.cook, caches, rows);
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
    text += "seconds,failure,warnings,first_warning\n";
    for (const SweepRow& row : swept.rows) {
        for (const graph::Override& s : row.settings) {
            text.append(csv_quoted(s.value)).append(1, ',');
        }
        text.append(std::to_string(row.frame)).append(1, ',');
        for (const double x : row.numbers) {
            if (!std::isnan(x)) text += fmt::format("{:.9g}", x);
            text += ',';
        }
        text += fmt::format("{:.6g},{},{},{}\n", row.seconds, csv_quoted(row.failure),
                            row.warnings.size(),
                            csv_quoted(row.warnings.empty() ? "" : row.warnings.front()));
    }
    return text;
}

}  // namespace runtime
