#include "graph/document.hpp"

#include "graph/expression.hpp"
#include "graph/json.hpp"
#include "graph/read_params.hpp"
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

constexpr int format_version = 1;

// A node as a document puts it.
struct Declaration {
    std::string name;
    Place place;
    Json body;
};

bool good_node_name(std::string_view name)
{
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return !name.empty() && letter(name[0]) && std::all_of(name.begin(), name.end(), [&](char c) {
        return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
}

class Loader {
public:
    Loader(const Registry& registry, const LoadOptions& options)
        : registry_(registry), options_(options)
    {}

    Loaded load(std::string text, const fs::path& file)
    {
        graph_.file = file.generic_string();
        std::error_code error;
        const fs::path full = fs::absolute(file, error);
        graph_.root = options_.root.empty() ? project_root(file) : options_.root;
        paths_ = {fs::weakly_canonical(graph_.root, error), options_.allow_outside};

        origin_.source =
            std::make_shared<const Source>(graph_.file, full.parent_path(), std::move(text));
        origin_.grammar = std::make_shared<const Grammar>();
        std::optional<Json> root = parse_json(origin_, {.depth = options_.max_depth}, problems_);
        if (root && header(*root)) {
            declare_nodes(*root);
            apply_overrides();
            make_nodes();
            link_nodes();
            expectations(root->find("expect"));
            sort();
        }
        Loaded loaded;
        const bool failed = problems_.has_errors();
        loaded.problems = problems_.take();
        if (!failed) loaded.graph = std::move(graph_);
        return loaded;
    }

private:
    // ---- reporting -----------------------------------------------------------------------------

    static Problem problem(Place place, std::string message = {})
    {
        Problem p;
        p.place = std::move(place);
        p.message = std::move(message);
        return p;
    }
    static Problem wrong(const Json& json, std::string expected)
    {
        Problem p = problem(json.place());
        p.expected = std::move(expected);
        p.found = json.snippet();
        return p;
    }
    void refuse_unknown(const Json& json, std::span<const std::string_view> known,
                        const std::string& what, const std::string& node = {})
    {
        for (const Member& member : *json.object()) {
            if (std::find(known.begin(), known.end(), member.key) != known.end()) continue;
            Problem p =
                problem(member.key_place(), fmt::format("{} has no '{}'", what, member.key));
            p.node = node;
            p.suggestion = suggest(member.key, known);
            problems_.add(std::move(p));
        }
    }
    void want_text(const Json* json, const std::string& node = {})
    {
        if (!json || json->text()) return;
        Problem p = wrong(*json, "a text in quotes");
        p.node = node;
        problems_.add(std::move(p));
    }

    // ---- the document's head -------------------------------------------------------------------

    // False when nothing below can make sense.
    bool header(const Json& root)
    {
        if (!root.object()) {
            problems_.add(wrong(root, "a graph document, { \"aspic\": 1, \"nodes\": {...} }"));
            return false;
        }
        const Json* version = root.find("aspic");
        const std::string expected =
            fmt::format("\"aspic\": {}, the format's version", format_version);
        if (!version) {
            Problem p = problem(root.place(), "this does not say that it is a graph document");
            p.expected = expected;
            problems_.add(std::move(p));
        } else if (const auto v = version->number(); !v || *v != format_version) {
            Problem p = wrong(*version, expected);
            if (v && *v > format_version) p.suggestion = "a newer aspic wrote it";
            problems_.add(std::move(p));
            if (v && *v > format_version) return false;
        }
        static constexpr std::string_view known[] = {"aspic",  "frames", "variables", "nodes",
                                                     "expect", "ui",     "doc",       "$schema"};
        refuse_unknown(root, known, "a graph document");
        want_text(root.find("doc"));
        frames(root.find("frames"));
        variables(root.find("variables"));
        return true;
    }

    std::optional<double> number(const Json& json, const std::string& expected)
    {
        Problem p = problem(json.place());
        const std::optional<double> x = read_constant(json, p);
        if (!x) {
            if (p.message.empty()) p.expected = expected;
            problems_.add(std::move(p));
        }
        return x;
    }

    std::optional<int> frame_number(const Json& json)
    {
        const std::string expected = "a whole number between -1e9 and 1e9";
        const std::optional<double> x = number(json, expected);
        if (x && (std::fabs(*x) > 1e9 || *x != std::floor(*x))) {
            problems_.add(wrong(json, expected));
            return {};
        }
        if (!x) return {};
        return static_cast<int>(*x);
    }

    void frames(const Json* json)
    {
        if (!json) return;
        if (!json->object()) {
            problems_.add(wrong(*json, "{ \"first\": 1, \"last\": 120, \"fps\": 24 }"));
            return;
        }
        static constexpr std::string_view known[] = {"first", "last", "fps"};
        refuse_unknown(*json, known, "\"frames\"");
        const Json *first = json->find("first"), *last = json->find("last"),
                   *fps = json->find("fps");
        FrameRange range;
        if (first) range.first = frame_number(*first).value_or(range.first);
        range.last = range.first;
        if (last) range.last = frame_number(*last).value_or(range.last);
        if (range.last < range.first) {
            problems_.add(
                wrong(last ? *last : *json, fmt::format("a last frame from {} on", range.first)));
        } else if (std::int64_t{range.last} - range.first >= options_.max_frames) {
            problems_.add(wrong(*last, fmt::format("at most {} frames", options_.max_frames)));
        } else {
            graph_.range.first = range.first;
            graph_.range.last = range.last;
        }
        if (fps) {
            const std::string expected = "frames a second, a number above 0, at most 1e6";
            const std::optional<double> x = number(*fps, expected);
            if (x && *x > 0 && *x <= 1e6) {
                graph_.range.fps = *x;
            } else if (x) {
                problems_.add(wrong(*fps, expected));
            }
        }
    }

    void variables(const Json* json)
    {
        auto grammar = std::make_shared<Grammar>();
        grammar->define("fps", graph_.range.fps);
        origin_.grammar = grammar;
        if (json && !json->object()) {
            problems_.add(wrong(*json, "an object of numbers, { \"scale\": 0.02 }"));
            json = nullptr;
        }
        std::map<std::string, double, std::less<>> given(options_.variables.begin(),
                                                         options_.variables.end());
        std::vector<std::string_view> names;
        for (std::size_t i = 0; json && i < json->object()->size(); ++i) {
            const Member& member = (*json->object())[i];
            names.push_back(member.key);
            if (!Grammar::free_name(member.key)) {
                Problem p = problem(member.key_place(),
                                    fmt::format("a variable cannot be called '{}'", member.key));
                p.expected = "letters, digits and _, first no digit, and no function's name";
                problems_.add(std::move(p));
                continue;
            }
            const auto found = given.find(member.key);
            if (found != given.end()) {
                grammar->define(found->first, found->second);
                given.erase(found);
            } else {
                // After a report any number will do.
                grammar->define(member.key, number(member.value, "a number").value_or(1));
            }
        }
        for (const auto& [name, value] : given) {
            Problem p = problem({graph_.file, 0, 0},
                                fmt::format("the document declares no variable '{}'", name));
            p.suggestion = suggest(name, names);
            problems_.add(std::move(p));
        }
    }

    // ---- nodes ---------------------------------------------------------------------------------

    void declare_nodes(Json& root)
    {
        Json* nodes = root.find("nodes");
        if (!nodes || !nodes->object()) {
            problems_.add(nodes ? wrong(*nodes, "an object of nodes, { \"name\": {...} }")
                                : problem(root.place(), "a graph document has \"nodes\""));
            return;
        }
        declarations_.reserve(nodes->object()->size());
        for (Member& member : *nodes->object()) {
            Place place = member.key_place();
            if (!good_node_name(member.key)) {
                Problem p = problem(place, fmt::format("a node cannot be called '{}'", member.key));
                p.expected = "letters, digits, _ and -, first a letter";
                problems_.add(std::move(p));
            } else if (!member.value.object()) {
                Problem p = wrong(member.value, "{ \"type\": \"...\", ... }");
                p.node = member.key;
                problems_.add(std::move(p));
            } else {
                declarations_.push_back(
                    {std::move(member.key), std::move(place), std::move(member.value)});
            }
        }
        for (std::uint32_t i = 0; i < declarations_.size(); ++i) {
            index_.emplace(declarations_[i].name, i);
        }
    }

    const std::vector<std::string_view>& node_names()
    {
        if (names_.empty()) {
            for (const Declaration& d : declarations_) names_.push_back(d.name);
        }
        return names_;
    }

    // ---- parameters from outside ---------------------------------------------------------------

    void apply_overrides()
    {
        for (const Override& o : options_.sets) {
            auto origin = std::make_unique<Origin>();
            const std::string text = o.target + "=" + o.value;
            origin->source = std::make_shared<const Source>(
                "--set " + text, origin_.source->folder(), o.value, false);
            origin->grammar = origin_.grammar;
            Problems ignored;
            std::optional<Json> value = parse_json(*origin, {.depth = options_.max_depth}, ignored);
            if (!value) value = Json{o.value, origin.get(), 0, std::uint32_t(o.value.size())};
            origins_.push_back(std::move(origin));
            if (std::optional<Problem> p = override_param(o.target, std::move(*value))) {
                p->place = {"--set " + text, 0, 0};
                problems_.add(std::move(*p));
            }
        }
    }

    std::optional<Problem> override_param(const std::string& target, Json value)
    {
        const std::size_t dot = target.find('.');
        const std::string name = target.substr(0, dot);
        const auto found = index_.find(name);
        if (found == index_.end()) {
            Problem p = problem({}, fmt::format("there is no node '{}'", name));
            p.suggestion = suggest(name, node_names());
            return p;
        }
        Json* at = &child(declarations_[found->second].body, "params", value);
        for (std::size_t begin = dot + 1; begin <= target.size();) {
            const std::size_t end = std::min(target.find('.', begin), target.size());
            const std::string key = target.substr(begin, end - begin);
            begin = end + 1;
            if (Json::Array* items = at->array()) {
                std::size_t i = 0;
                const auto [stop, error] = std::from_chars(key.data(), key.data() + key.size(), i);
                if (error != std::errc() || stop != key.data() + key.size() || i >= items->size()) {
                    Problem p = problem({}, "this is no element of the list");
                    p.node = name;
                    p.expected = fmt::format("an index below {}", items->size());
                    p.found = key;
                    return p;
                }
                at = &(*items)[i];
            } else {
                at = &child(*at, key, value);
            }
        }
        *at = std::move(value);
        return {};
    }

    // The member `key` of `parent`, which becomes an object if it was none.
    static Json& child(Json& parent, const std::string& key, const Json& like)
    {
        if (!parent.object()) {
            parent.is = Json::Object{};
            parent.origin = like.origin;
            parent.begin = parent.end = 0;
        }
        if (Json* found = parent.find(key)) return *found;
        parent.object()->push_back({key, 0, {Json::Object{}, like.origin, 0, 0}});
        return parent.object()->back().value;
    }

    // ---- types ---------------------------------------------------------------------------------

    void make_nodes()
    {
        graph_.nodes.resize(declarations_.size());
        const ReadContext context{graph_.range, paths_, problems_};
        for (std::size_t i = 0; i < declarations_.size(); ++i) {
            Declaration& d = declarations_[i];
            Node& node = graph_.nodes[i];
            node.name = d.name;
            node.place = d.place;
            static constexpr std::string_view known[] = {"type", "inputs", "params", "doc", "ui"};
            refuse_unknown(d.body, known, "a node", d.name);
            want_text(d.body.find("doc"), d.name);
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
            Problem p = json ? wrong(*json, "") : problem(d.place);
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
            Problem p = problem(json->place(), fmt::format("there is no node type '{}'", name));
            p.suggestion = suggest(name, names);
            refuse_node(d, std::move(p));
            return nullptr;
        }
        int version = type->version;
        if (at == std::string::npos) {
            Problem p = problem(json->place(), fmt::format("this says no version; it is read as "
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

    bool known_version(Declaration& d, const Json& json, const NodeType& type, int version)
    {
        if (version == type.version) return true;
        Problem p = problem(json.place());
        p.expected = fmt::format("{} of version {}", type.name, type.version);
        p.found = fmt::format("version {}", version);
        if (version > type.version) p.suggestion = "a newer aspic knows it";
        refuse_node(d, std::move(p));
        return false;
    }

    // ---- links ---------------------------------------------------------------------------------

    void link_nodes()
    {
        for (std::size_t i = 0; i < declarations_.size(); ++i) {
            Node& node = graph_.nodes[i];
            if (!node.type) continue;
            const Json* inputs = declarations_[i].body.find("inputs");
            if (inputs && !inputs->object()) {
                refuse_node(declarations_[i], wrong(*inputs, "an object, { \"input\": "
                                                             "\"node.output\" }"));
                continue;
            }
            for (std::size_t k = 0; inputs && k < inputs->object()->size(); ++k) {
                link_input(declarations_[i], node, (*inputs->object())[k]);
            }
            for (const InputPort& port : node.type->inputs) {
                if (port.optional || (inputs && inputs->find(port.name))) continue;
                Problem p = problem(node.place, "this input must be linked");
                p.node = node.name;
                p.part = Part::input;
                p.port = port.name;
                p.suggestion = fitting(port.type);
                problems_.add(std::move(p));
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
            Problem p =
                problem(member.key_place(), fmt::format("{} has no such input", node.type->name));
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

    // "node.output", or "node" when it has one output. Reports for input `port` of node `name`.
    std::optional<Link> find_link(const Json& json, const std::string& type,
                                  const std::string& name, const std::string& port)
    {
        Problem p = problem(json.place());
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
        const std::string& text = *json.text();
        const std::size_t dot = text.find('.');
        const std::string node = text.substr(0, dot);
        const auto found = index_.find(node);
        if (found == index_.end()) {
            p.message = fmt::format("there is no node '{}'", node);
            p.suggestion = suggest(node, node_names());
            return {};
        }
        const NodeType* source = graph_.nodes[found->second].type;
        if (!source) return {};  // its own report is enough
        const std::optional<std::uint32_t> output =
            output_of(*source, dot == std::string::npos ? "" : text.substr(dot + 1), node, p);
        if (!output) return {};
        if (source->outputs[*output].type != type) {
            p.expected = fmt::format("a wire of type {}", type);
            p.found = fmt::format("'{}.{}' of type {}", node, source->outputs[*output].name,
                                  source->outputs[*output].type);
            p.suggestion = fitting(type);
            return {};
        }
        return Link{found->second, *output};
    }

    static std::optional<std::uint32_t> output_of(const NodeType& type, const std::string& name,
                                                  const std::string& node, Problem& p)
    {
        std::vector<std::string_view> names;
        for (std::uint32_t i = 0; i < type.outputs.size(); ++i) {
            if (type.outputs[i].name == name) return i;
            names.emplace_back(type.outputs[i].name);
        }
        if (name.empty() && names.size() == 1) return 0;
        if (names.empty()) {
            p.message = fmt::format("node '{}' has no outputs", node);
        } else if (name.empty()) {
            p.message = fmt::format("node '{}' has several outputs", node);
            p.expected = "one of " + list_names(names);
        } else {
            p.message = fmt::format("node '{}' ({}) has no output '{}'", node, type.name, name);
            p.suggestion = suggest(name, names);
        }
        return {};
    }

    // "'a.mesh' and 'b.mesh' would fit": outputs of a wire type.
    std::string fitting(const std::string& type)
    {
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
            Problem p =
                problem(graph_.nodes[cycle[0]].place,
                        "these nodes wait for each other: " + text + graph_.nodes[cycle[0]].name);
            p.suggestion = "a node's memory of the frame before is its own affair; no link may "
                           "lead back";
            p.node = graph_.nodes[cycle[0]].name;
            problems_.add(std::move(p));
        }
    }

    // ---- expectations --------------------------------------------------------------------------

    void expectations(const Json* json)
    {
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
        refuse_unknown(json, known, "an expectation");
        want_text(json.find("why"));
        Expectation e;
        e.place = json.place();
        if (const Json* why = json.find("why"); why && why->text()) e.why = *why->text();
        const Json* value = json.find("value");
        std::optional<Link> link;
        if (!value) {
            Problem p = problem(json.place());
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
            const std::optional<int> frame = frame_number(item);
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
            return number(*found, "a number");
        };
        const auto min = read("min"), max = read("max"), near = read("near"),
                   around = read("within"), percent = read("percent");
        const bool has_near = json.find("near") != nullptr;
        const bool has_width = json.find("within") || json.find("percent");
        if (has_near != has_width || (json.find("within") && json.find("percent")) ||
            (!has_near && !json.find("min") && !json.find("max"))) {
            Problem p = problem(json.place());
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
            problems_.add(
                problem(json.place(), fmt::format("no number lies from {} to {}", e.min, e.max)));
            return false;
        }
        return true;
    }

    const Registry& registry_;
    const LoadOptions& options_;
    Problems problems_;
    Graph graph_;
    PathRules paths_;
    Origin origin_;
    std::vector<std::unique_ptr<Origin>> origins_;  // of overrides
    std::vector<Declaration> declarations_;
    std::unordered_map<std::string_view, std::uint32_t> index_;  // into declarations_ and nodes
    std::vector<std::string_view> names_;
    std::map<std::string, std::vector<std::string>> outputs_;  // by wire type: "node.output"
};

Loaded unreadable(const fs::path& file, std::string message, std::string suggestion = {})
{
    Loaded loaded;
    Problem p;
    p.place.file = file.generic_string();
    p.message = std::move(message);
    p.suggestion = std::move(suggestion);
    loaded.problems.push_back(std::move(p));
    return loaded;
}

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
    std::error_code error;
    if (!fs::exists(file, error)) {
        return unreadable(file, "there is no such file", suggest_file(fs::absolute(file, error)));
    }
    if (!fs::is_regular_file(file, error)) return unreadable(file, "this is not a file");
    const auto size = fs::file_size(file, error);
    if (error) return unreadable(file, "this cannot be read: " + error.message());
    if (size > options.max_bytes) {
        return unreadable(file, fmt::format("this is too large for a graph document: {} bytes, {} "
                                            "are allowed",
                                            size, options.max_bytes));
    }
    std::string text(size, '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(text.data(), static_cast<std::streamsize>(size));
    if (!in) return unreadable(file, "this cannot be read");
    return load_text(std::move(text), file, registry, options);
}

Loaded load_text(std::string text, const fs::path& file, const Registry& registry,
                 const LoadOptions& options)
{
    const std::size_t most = std::min<std::size_t>(options.max_bytes, UINT32_MAX - 1);
    if (text.size() > most) {
        return unreadable(file, fmt::format("this is too large for a graph document: {} bytes, {} "
                                            "are allowed",
                                            text.size(), most));
    }
    return Loader(registry, options).load(std::move(text), file);
}

}  // namespace graph
