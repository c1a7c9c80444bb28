#include "graph/document.hpp"

#include "graph/assemble.hpp"
#include "graph/sort_nodes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <memory>
#include <unordered_map>

#include <fmt/format.h>

namespace graph {

namespace {

namespace fs = std::filesystem;

class Loader {
public:
    Loader(const Registry& registry, const LoadOptions& options)
        : registry_(registry), options_(options)
    {}

    Loaded load(std::string text, const fs::path& file)
    {
        graph_.file = file.generic_string();
        graph_.root = options_.root.empty() ? project_root(file) : options_.root;
        std::error_code error;
        paths_ = {fs::weakly_canonical(fs::absolute(graph_.root, error), error),
                  options_.allow_outside};
        assembly_ = assemble(std::move(text), file, paths_, options_, problems_);
        graph_.range = assembly_.range;
        graph_.documents = assembly_.documents;
        for (std::uint32_t i = 0; i < assembly_.declarations.size(); ++i) {
            index_.emplace(assembly_.declarations[i].name, i);
        }
        make_nodes();
        link_nodes();
        expectations();
        sort();
        Loaded loaded;
        const bool failed = problems_.has_errors();
        loaded.problems = problems_.take();
        if (!failed) loaded.graph = std::move(graph_);
        return loaded;
    }

private:
    // What `name` may be a slip of. Comparing with very many names takes its time, so that not
    // every mistake of a large file gets a suggestion.
    std::string suggest_node(const std::string& name)
    {
        if (names_.empty()) {
            for (const Declaration& d : assembly_.declarations) names_.push_back(d.name);
            for (const auto& subgraph : assembly_.subgraphs) names_.push_back(subgraph.first);
            std::sort(names_.begin(), names_.end());
        }
        compared_ += names_.size();
        return compared_ > 2'000'000 ? "" : suggest(name, names_);
    }

    // ---- types ---------------------------------------------------------------------------------

    void make_nodes()
    {
        graph_.nodes.resize(assembly_.declarations.size());
        const ReadContext context{graph_.range, paths_, problems_};
        for (std::size_t i = 0; i < assembly_.declarations.size(); ++i) {
            Declaration& d = assembly_.declarations[i];
            Node& node = graph_.nodes[i];
            node.name = d.name;
            node.place = d.place;
            static constexpr std::string_view known[] = {"type", "inputs", "params", "doc", "ui"};
            refuse_unknown(d.body, known, "a node", d.name, problems_);
            want_text(d.body.find("doc"), d.name, problems_);
            node.type = type_of(d);
            if (!node.type) continue;
            node.inputs.resize(node.type->inputs.size());
            read_params(d.body.find("params"), context, node);
        }
    }

    void refuse_node(const Declaration& d, Problem p)
    {
        p.node = d.name;
        problems_.add(std::move(p));
    }

    // "Name@version"; null after a report.
    const NodeType* type_of(Declaration& d)
    {
        const Json* json = d.body.find("type");
        if (!json || !json->text()) {
            Problem p = json ? wrong(*json, "") : problem_at(d.place);
            p.expected = "\"type\": \"Name@version\"";
            if (!json) p.found = "no type";
            refuse_node(d, std::move(p));
            return nullptr;
        }
        const std::string& text = *json->text();
        const std::size_t at = text.find('@');
        const std::string name = text.substr(0, at);
        const NodeType* type = registry_.find(name);
        if (!type) {
            std::vector<std::string_view> names;
            for (const auto& known : registry_.types()) names.push_back(known.first);
            Problem p = problem_at(json->place(), fmt::format("there is no node type '{}'", name));
            p.suggestion = suggest(name, names);
            refuse_node(d, std::move(p));
            return nullptr;
        }
        int version = type->version;
        if (at == std::string::npos) {
            Problem p = problem_at(json->place(), fmt::format("this says no version; it is read as "
                                                              "\"{}@{}\"",
                                                              name, version));
            p.severity = Severity::note;
            refuse_node(d, std::move(p));
        } else {
            const char *begin = text.data() + at + 1, *end = text.data() + text.size();
            const auto [stop, error] = std::from_chars(begin, end, version);
            if (error != std::errc() || stop != end || version < 1) {
                refuse_node(d, wrong(*json, fmt::format("\"{}@{}\"", name, type->version)));
                return nullptr;
            }
        }
        return known_version(d, *json, *type, version) ? type : nullptr;
    }

    // Whether this version can be read: the newest, or one from which upgrade steps lead there.
    bool known_version(Declaration& d, const Json& json, const NodeType& type, int version)
    {
        Problem p = problem_at(json.place());
        p.expected = fmt::format("{} of version {}", type.name, type.version);
        p.found = fmt::format("version {}", version);
        if (version > type.version) {
            p.suggestion = "a newer aspic knows it";
            return refuse_node(d, std::move(p)), false;
        }
        std::vector<const Upgrade*> steps;
        for (int v = version; v < type.version; ++v) {
            const auto step = std::find_if(type.upgrades.begin(), type.upgrades.end(),
                                           [&](const Upgrade& u) { return u.from == v; });
            if (step == type.upgrades.end()) {
                p.suggestion = fmt::format("nothing is known of version {} any more", v);
                return refuse_node(d, std::move(p)), false;
            }
            steps.push_back(&*step);
        }
        const auto node = static_cast<std::uint32_t>(&d - assembly_.declarations.data());
        for (const Upgrade* step : steps) {
            Problem note =
                problem_at(d.place, fmt::format("{}@{} is read as {}@{}: {}", type.name, step->from,
                                                type.name, step->from + 1, step->note));
            note.severity = Severity::note;
            refuse_node(d, std::move(note));
            if (step->change) step->change(d.body);
            auto& renamed = renamed_[node];
            renamed.insert(renamed.end(), step->outputs.begin(), step->outputs.end());
        }
        return true;
    }

    // ---- links ---------------------------------------------------------------------------------

    void link_nodes()
    {
        for (std::size_t i = 0; i < assembly_.declarations.size(); ++i) {
            Node& node = graph_.nodes[i];
            const Json* inputs = assembly_.declarations[i].body.find("inputs");
            if (inputs && !inputs->object()) {
                refuse_node(assembly_.declarations[i], wrong(*inputs, "an object, { \"input\": "
                                                                      "\"node.output\" }"));
                continue;
            }
            if (!node.type) {
                if (inputs) look_at_links(assembly_.declarations[i], *inputs->object());
                continue;
            }
            for (std::size_t k = 0; inputs && k < inputs->object()->size(); ++k) {
                link_input(assembly_.declarations[i], node, (*inputs->object())[k]);
            }
            for (const InputPort& port : node.type->inputs) {
                if (port.optional || (inputs && inputs->find(port.name))) continue;
                if (assembly_.missed.count(node.name + "." + port.name)) continue;
                Problem p = problem_at(node.place, "this input must be linked");
                p.node = node.name;
                p.part = Part::input;
                p.port = port.name;
                p.suggestion = fitting(port.type);
                problems_.add(std::move(p));
            }
        }
    }

    // Of a node whose type nobody knows: whether its links lead anywhere.
    void look_at_links(const Declaration& d, const Json::Object& inputs)
    {
        for (const Member& member : inputs) {
            if (const Json::Array* several = member.value.array()) {
                for (const Json& json : *several) find_link(json, {}, d.name, member.key);
            } else {
                find_link(member.value, {}, d.name, member.key);
            }
        }
    }

    void link_input(const Declaration& d, Node& node, const Member& member)
    {
        std::size_t port = 0;
        const auto& ports = node.type->inputs;
        while (port < ports.size() && ports[port].name != member.key) ++port;
        if (port == ports.size()) {
            std::vector<std::string_view> names;
            for (const InputPort& p : ports) names.emplace_back(p.name);
            Problem p = problem_at(member.key_place(),
                                   fmt::format("{} has no such input", node.type->name));
            p.node = d.name;
            p.part = Part::input;
            p.port = member.key;
            p.suggestion = suggest(member.key, names);
            for (const Param& param : node.type->params) {
                if (param.name == member.key) {
                    p.suggestion =
                        fmt::format("'{}' is a parameter: set it in \"params\"", member.key);
                }
            }
            problems_.add(std::move(p));
            return;
        }
        const auto add = [&](const Json& json) {
            if (const auto link = find_link(json, ports[port].type, d.name, ports[port].name)) {
                node.inputs[port].push_back(*link);
            }
        };
        if (ports[port].many && member.value.array()) {
            for (const Json& json : *member.value.array()) add(json);
        } else if (member.value.array()) {
            Problem p = wrong(member.value, "one link, \"node.output\"");
            p.node = d.name;
            p.part = Part::input;
            p.port = ports[port].name;
            problems_.add(std::move(p));
        } else {
            add(member.value);
        }
    }

    // "node.output", or "node" when it has one output. Reports for input `port` of node `name`,
    // which takes wires of type `type`; empty: of any.
    std::optional<Link> find_link(const Json& json, const std::string& type,
                                  const std::string& name, const std::string& port)
    {
        Problem p = problem_at(json.place());
        p.node = name;
        p.part = port.empty() ? Part::none : Part::input;
        p.port = port;
        const std::optional<Link> link = resolve(json, type, p);
        if (!p.message.empty() || !p.expected.empty()) problems_.add(std::move(p));
        return link;
    }

    // Fills `p` when there is something to report.
    std::optional<Link> resolve(const Json& json, const std::string& type, Problem& p)
    {
        if (!json.text()) {
            p.expected = "a link, \"node.output\"";
            p.found = json.snippet();
            return {};
        }
        const Json* at = &json;
        std::string node, port;
        // A subgraph's output stands for a link inside of it, perhaps to a subgraph again.
        for (;;) {
            const std::string& text = *at->text();
            const std::size_t dot = std::min(text.find('.'), text.size());
            node = at->origin->prefix + text.substr(0, dot);
            port = text.substr(std::min(dot + 1, text.size()));
            const auto stand = assembly_.subgraphs.find(node);
            if (stand == assembly_.subgraphs.end()) break;
            std::vector<std::string_view> names;
            for (const auto& output : stand->second.outputs) names.emplace_back(output.first);
            if (names.empty() && problems_.has_errors()) return {};  // it could not be read
            const auto k = output_index(names, port, node, "a subgraph", p);
            if (!k) return {};
            at = &stand->second.outputs[*k].second;
        }
        const auto found = index_.find(node);
        if (found == index_.end()) {
            p.message = fmt::format("there is no node '{}'", node);
            if (at != &json) p.place = at->place();
            p.suggestion = suggest_node(node);
            return {};
        }
        const NodeType* source = graph_.nodes[found->second].type;
        if (!source) return {};  // its own report is enough
        if (const auto old = renamed_.find(found->second); old != renamed_.end()) {
            for (const auto& [from, to] : old->second) {
                if (port == from) port = to;
            }
        }
        std::vector<std::string_view> names;
        for (const OutputPort& o : source->outputs) names.emplace_back(o.name);
        const auto output = output_index(names, port, node, source->name, p);
        if (!output) return {};
        if (!type.empty() && source->outputs[*output].type != type) {
            p.expected = fmt::format("a wire of type {}", type);
            p.found = fmt::format("'{}.{}' of type {}", node, source->outputs[*output].name,
                                  source->outputs[*output].type);
            p.suggestion = fitting(type);
            return {};
        }
        return Link{found->second, *output};
    }

    static std::optional<std::uint32_t> output_index(const std::vector<std::string_view>& names,
                                                     const std::string& name,
                                                     const std::string& node,
                                                     const std::string& type, Problem& p)
    {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found != names.end()) return static_cast<std::uint32_t>(found - names.begin());
        if (name.empty() && names.size() == 1) return 0;
        if (names.empty()) {
            p.message = fmt::format("node '{}' has no outputs", node);
        } else if (name.empty()) {
            p.message = fmt::format("node '{}' has several outputs", node);
            p.expected = "one of " + list_names(names);
        } else {
            p.message = fmt::format("node '{}' ({}) has no output '{}'", node, type, name);
            p.suggestion = suggest(name, names);
        }
        return {};
    }

    // "'a.mesh' and 'b.mesh' would fit": outputs of a wire type.
    std::string fitting(const std::string& type)
    {
        if (problems_.full()) return {};
        if (outputs_.empty()) {
            for (const Node& node : graph_.nodes) {
                for (std::size_t i = 0; node.type && i < node.type->outputs.size(); ++i) {
                    const OutputPort& port = node.type->outputs[i];
                    outputs_[port.type].push_back(node.name + "." + port.name);
                }
            }
        }
        const auto found = outputs_.find(type);
        if (found == outputs_.end()) {
            return fmt::format("no node here gives a wire of type {}", type);
        }
        const std::vector<std::string_view> names(found->second.begin(), found->second.end());
        return list_names(names, 5) + " would fit";
    }

    void sort()
    {
        for (const auto& cycle : sort_nodes(graph_)) {
            std::string text;
            for (std::size_t i = 0; i < cycle.size() && i < 20; ++i) {
                text += graph_.nodes[cycle[i]].name + " -> ";
            }
            if (cycle.size() > 20) text += fmt::format("({} more) -> ", cycle.size() - 20);
            Problem p = problem_at(graph_.nodes[cycle[0]].place,
                                   "these nodes wait for each other: " + text +
                                       graph_.nodes[cycle[0]].name);
            p.suggestion = "a node's memory of the frame before is its own affair; no link may "
                           "lead back";
            p.node = graph_.nodes[cycle[0]].name;
            problems_.add(std::move(p));
        }
    }

    // ---- expectations --------------------------------------------------------------------------

    void expectations()
    {
        const Json* json = assembly_.expect ? &*assembly_.expect : nullptr;
        if (!json) return;
        if (!json->array()) {
            problems_.add(wrong(*json, "a list, [{ \"value\": \"node.output\", ... }]"));
            return;
        }
        for (const Json& item : *json->array()) {
            if (!item.object()) {
                problems_.add(wrong(item, "{ \"value\": \"node.output\", \"min\": 0 }"));
            } else {
                expectation(item);
            }
        }
    }

    void expectation(const Json& json)
    {
        static constexpr std::string_view known[] = {"value", "frame",  "min",     "max",
                                                     "near",  "within", "percent", "why"};
        refuse_unknown(json, known, "an expectation", {}, problems_);
        want_text(json.find("why"), {}, problems_);
        Expectation e;
        e.place = json.place();
        if (const Json* why = json.find("why"); why && why->text()) e.why = *why->text();
        const Json* value = json.find("value");
        std::optional<Link> link;
        if (!value) {
            Problem p = problem_at(json.place());
            p.expected = "\"value\": \"node.output\", a number to look at";
            problems_.add(std::move(p));
        } else {
            link = find_link(*value, "number", "", "");
        }
        const Json* frame = json.find("frame");
        e.frames = frame ? expected_frames(*frame) : std::vector<int>{graph_.range.last};
        if (!bounds(json, e) || !link) return;
        e.value = *link;
        graph_.expectations.push_back(std::move(e));
    }

    std::vector<int> expected_frames(const Json& json)
    {
        const FrameRange& range = graph_.range;
        std::vector<int> frames;
        const auto add = [&](const Json& item) {
            const std::optional<int> frame = read_frame(item, problems_);
            if (frame && *frame >= range.first && *frame <= range.last) {
                frames.push_back(*frame);
            } else if (frame) {
                problems_.add(
                    wrong(item, fmt::format("a frame from {} to {}", range.first, range.last)));
            }
        };
        if (json.text() && *json.text() == "first") {
            frames = {range.first};
        } else if (json.text() && *json.text() == "last") {
            frames = {range.last};
        } else if (json.text() && *json.text() == "every") {
            for (int f = range.first; f <= range.last; ++f) frames.push_back(f);
        } else if (json.array()) {
            for (const Json& item : *json.array()) add(item);
        } else if (json.number()) {
            add(json);
        } else {
            problems_.add(
                wrong(json, "a frame, a list of frames, \"first\", \"last\" or \"every\""));
        }
        return frames;
    }

    bool bounds(const Json& json, Expectation& e)
    {
        const auto read = [&](const char* key) -> std::optional<double> {
            const Json* found = json.find(key);
            if (!found) return {};
            return read_number(*found, "a number", problems_);
        };
        const auto min = read("min"), max = read("max"), near = read("near"),
                   around = read("within"), percent = read("percent");
        const bool has_near = json.find("near") != nullptr;
        const bool has_width = json.find("within") || json.find("percent");
        if (has_near != has_width || (json.find("within") && json.find("percent")) ||
            (!has_near && !json.find("min") && !json.find("max"))) {
            Problem p = problem_at(json.place());
            p.expected = "\"min\", \"max\", or \"near\" with either \"within\" or \"percent\"";
            problems_.add(std::move(p));
            return false;
        }
        if (min) e.min = *min;
        if (max) e.max = *max;
        if (near && (around || percent)) {
            const double width = around ? *around : std::fabs(*near) * *percent / 100;
            e.min = std::max(e.min, *near - width);
            e.max = std::min(e.max, *near + width);
        }
        if (e.min > e.max) {
            problems_.add(problem_at(json.place(),
                                     fmt::format("no number lies from {} to {}", e.min, e.max)));
            return false;
        }
        return true;
    }

    const Registry& registry_;
    const LoadOptions& options_;
    Problems problems_;
    Graph graph_;
    PathRules paths_;
    Assembly assembly_;
    std::unordered_map<std::string_view, std::uint32_t> index_;  // into declarations and nodes
    // Old names of outputs and the new ones, of nodes that were upgraded.
    std::unordered_map<std::uint32_t, std::vector<std::pair<std::string, std::string>>> renamed_;
    std::vector<std::string_view> names_;
    std::size_t compared_ = 0;
    std::map<std::string, std::vector<std::string>> outputs_;  // by wire type: "node.output"
};

}  // namespace

Override parse_override(std::string_view text)
{
    const std::size_t equals = text.find('=');
    const std::size_t dot = text.find('.');
    if (equals == std::string_view::npos || dot == std::string_view::npos || dot == 0 ||
        dot + 1 >= equals) {
        throw std::invalid_argument(fmt::format("expected node.parameter=value, found '{}'", text));
    }
    return {std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
}

fs::path project_root(const fs::path& file)
{
    std::error_code error;
    const fs::path full = fs::weakly_canonical(fs::absolute(file, error), error);
    for (fs::path folder = full.parent_path(); !folder.empty(); folder = folder.parent_path()) {
        if (fs::is_directory(folder / "graphs", error) || fs::exists(folder / ".git", error)) {
            return folder;
        }
        if (folder == folder.parent_path()) break;
    }
    return full.parent_path();
}

Loaded load_file(const fs::path& file, const Registry& registry, const LoadOptions& options)
{
    Problem p;
    p.place.file = file.generic_string();
    std::optional<std::string> text = read_document(file, options.max_bytes, p);
    if (text) return load_text(std::move(*text), file, registry, options);
    Loaded loaded;
    loaded.problems.push_back(std::move(p));
    return loaded;
}

Loaded load_text(std::string text, const fs::path& file, const Registry& registry,
                 const LoadOptions& options)
{
    if (text.size() > options.max_bytes || text.size() >= UINT32_MAX) {
        Loaded loaded;
        Problem p = problem_at({file.generic_string(), 0, 0});
        p.message =
            fmt::format("this is too large for a graph document: {} bytes, {} are allowed",
                        text.size(), std::min<std::size_t>(options.max_bytes, UINT32_MAX - 1));
        loaded.problems.push_back(std::move(p));
        return loaded;
    }
    return Loader(registry, options).load(std::move(text), file);
}

}  // namespace graph
