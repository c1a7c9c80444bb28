#include "graph/assemble.hpp"

#include "graph/expression.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>

#include <fmt/format.h>

namespace graph {

namespace fs = std::filesystem;

Problem problem_at(Place place, std::string message)
{
    Problem p;
    p.place = std::move(place);
    p.message = std::move(message);
    return p;
}

Problem wrong(const Json& found, std::string expected)
{
    Problem p = problem_at(found.place());
    p.expected = std::move(expected);
    p.found = found.snippet();
    return p;
}

void refuse_unknown(const Json& json, std::span<const std::string_view> known,
                    const std::string& what, const std::string& node, Problems& problems)
{
    for (const Member& member : *json.object()) {
        if (std::find(known.begin(), known.end(), member.key) != known.end()) continue;
        Problem p = problem_at(member.key_place(), fmt::format("{} has no '{}'", what, member.key));
        p.node = node;
        p.suggestion = suggest(member.key, known);
        problems.add(std::move(p));
    }
}

void want_text(const Json* json, const std::string& node, Problems& problems)
{
    if (!json || json->text()) return;
    Problem p = wrong(*json, "a text in quotes");
    p.node = node;
    problems.add(std::move(p));
}

std::optional<double> read_number(const Json& json, const std::string& expected, Problems& problems)
{
    Problem p = problem_at(json.place());
    const std::optional<double> x = read_constant(json, p);
    if (!x) {
        if (p.message.empty()) p.expected = expected;
        problems.add(std::move(p));
    }
    return x;
}

std::optional<int> read_frame(const Json& json, Problems& problems)
{
    const std::string expected = "a whole number between -1e9 and 1e9";
    const std::optional<double> x = read_number(json, expected, problems);
    if (!x) return {};
    if (std::fabs(*x) > 1e9 || *x != std::floor(*x)) {
        problems.add(wrong(json, expected));
        return {};
    }
    return static_cast<int>(*x);
}

std::optional<std::string> read_document(const fs::path& file, std::size_t max_bytes,
                                         Problem& problem)
{
    std::error_code error;
    if (!fs::exists(file, error)) {
        problem.message = "there is no such file";
        problem.suggestion = suggest_file(fs::absolute(file, error));
        return {};
    }
    if (!fs::is_regular_file(file, error)) {
        problem.message =
            fs::is_directory(file, error) ? "this is a folder, not a file" : "this is not a file";
        return {};
    }
    const auto size = fs::file_size(file, error);
    if (size > max_bytes) {
        problem.message = fmt::format(
            "this is too large for a graph document: {} bytes, {} are allowed", size, max_bytes);
        return {};
    }
    std::string text(size, '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(text.data(), static_cast<std::streamsize>(size));
    if (!in) {
        problem.message = "this cannot be read";
        return {};
    }
    return text;
}

namespace {

constexpr int format_version = 1;
constexpr std::size_t most_levels = 16;  // of documents that extend, and of subgraphs
constexpr std::size_t most_variables = 10'000;

bool good_name(std::string_view name)
{
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return !name.empty() && letter(name[0]) && std::all_of(name.begin(), name.end(), [&](char c) {
        return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
}

// An object that stands where `like` does.
Json empty_object(const Json& like)
{
    return {Json::Object{}, like.origin, like.begin, like.end};
}

// The member `key` of `parent`, which becomes an object if it was none.
Json& child(Json& parent, const std::string& key, const Json& like)
{
    if (!parent.object()) parent = empty_object(like);
    if (Json* found = parent.find(key)) return *found;
    parent.object()->push_back({key, like.begin, empty_object(like)});
    return parent.object()->back().value;
}

bool is_curve(const Json& json)
{
    return json.find("keys") != nullptr;
}

using Names = std::unordered_map<std::string, std::size_t>;

// Gives each member of `over` to `merge(base's member of that key or null, member)`, which says
// whether base's member stays; members without one in base that stay are added.
template <class Merge> void merge_members(Json& base, Json over, Merge merge)
{
    Json::Object& members = *base.object();
    Names index;
    for (std::size_t i = 0; i < members.size(); ++i) index.emplace(members[i].key, i);
    const std::size_t before = members.size();
    std::vector<char> gone(before, 0);
    for (Member& member : *over.object()) {
        const auto found = index.find(member.key);
        if (found == index.end()) {
            if (merge(nullptr, member)) members.push_back(std::move(member));
        } else if (!merge(&members[found->second], member)) {
            gone[found->second] = 1;
        }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
        if (i < before && gone[i]) continue;
        if (kept != i) members[kept] = std::move(members[i]);
        ++kept;
    }
    members.resize(kept);
}

// Lays `patch` over `base`: null takes away, objects go in member by member, all else replaces.
void lay_over(Json& base, Json patch)
{
    if (!base.object() || !patch.object() || is_curve(base) || is_curve(patch)) {
        base = std::move(patch);
        return;
    }
    merge_members(base, std::move(patch), [](Member* below, Member& member) {
        if (member.value.null()) return false;
        if (below) lay_over(below->value, std::move(member.value));
        return true;
    });
}

// A node type's name that is a file: "assets/jelly.json@2" is that path and "2".
struct FileType {
    std::string path;
    std::optional<std::string> version;
};

std::optional<FileType> file_type(const Json* type)
{
    if (!type || !type->text()) return {};
    FileType f{*type->text(), {}};
    const std::size_t slash = f.path.rfind('/'), at = f.path.rfind('@');
    if (at != std::string::npos && (slash == std::string::npos || at > slash)) {
        f.version = f.path.substr(at + 1);
        f.path.resize(at);
    }
    if (!f.path.ends_with(".json")) return {};
    return f;
}

// Sets a parameter: "size", "bricks.damping", "boxes.2.centre". What is wrong, if anything, else
// null.
std::optional<Problem> set_param(Json& body, std::string_view path, Json value)
{
    Json* at = &child(body, "params", value);
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('.', begin), path.size());
        const std::string key(path.substr(begin, end - begin));
        begin = end + 1;
        if (Json::Array* items = at->array()) {
            std::size_t i = 0;
            const auto [stop, error] = std::from_chars(key.data(), key.data() + key.size(), i);
            if (error != std::errc() || stop != key.data() + key.size() || i >= items->size()) {
                Problem p = problem_at({}, "this is no element of the list");
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

class Assembler {
public:
    Assembler(const PathRules& paths, const LoadOptions& options, Problems& problems)
        : paths_(paths), options_(options), problems_(problems)
    {}

    Assembly assemble(std::string text, const fs::path& file)
    {
        std::error_code error;
        const fs::path full = fs::absolute(file, error).lexically_normal();
        Document document;
        document.chain.push_back(fs::weakly_canonical(full, error));
        std::optional<Json> root =
            read(document, std::make_shared<const Source>(file.generic_string(), full.parent_path(),
                                                          std::move(text)));
        all_.documents.push_back(full);
        for (const auto& [path, source] : sources_) all_.documents.push_back(path);
        if (root) {
            all_.range = frames(root->find("frames"));
            fps_ = all_.range.fps;
            std::map<std::string, double, std::less<>> given(options_.variables.begin(),
                                                             options_.variables.end());
            variables(document, root->find("variables"), given);
            for (const auto& [name, value] : given) {
                Problem p = problem_at({file.generic_string(), 0, 0},
                                       fmt::format("the document declares no variable '{}'", name));
                p.suggestion = suggest(name, member_names(root->find("variables")));
                problems_.add(std::move(p));
            }
            std::vector<Declaration> nodes = declare(*root, "");
            overrides(nodes, document, false);
            expand(std::move(nodes), document.chain);
            overrides(all_.declarations, document, true);
            if (Json* expect = root->find("expect")) all_.expect = std::move(*expect);
        }
        return std::move(all_);
    }

private:
    // A document with those that it extends: one set of variables and names.
    struct Document {
        std::vector<fs::path> chain;   // files that led here, against circles
        std::vector<Origin*> origins;  // of its files
        std::string prefix;            // "outer/" for a subgraph's nodes
    };

    // ---- files -----------------------------------------------------------------------------

    Origin& new_origin(Document& document, std::shared_ptr<const Source> source)
    {
        auto origin = std::make_unique<Origin>();
        origin->source = std::move(source);
        origin->grammar = plain_;
        origin->prefix = document.prefix;
        document.origins.push_back(origin.get());
        all_.origins.push_back(std::move(origin));
        return *all_.origins.back();
    }

    // The document's tree, laid over what it extends.
    std::optional<Json> read(Document& document, std::shared_ptr<const Source> source)
    {
        Origin& origin = new_origin(document, std::move(source));
        std::optional<Json> root = parse_json(origin, {.depth = options_.max_depth}, problems_);
        if (!root || !check_head(*root)) return {};
        const Json* base = root->find("extends");
        if (!base) return root;
        if (!base->text()) {
            problems_.add(wrong(*base, "the path of the document that this one changes"));
            return root;
        }
        std::shared_ptr<const Source> found = find_file(*base, *base->text(), document.chain);
        if (!found) return {};
        std::optional<Json> below = read(document, std::move(found));
        if (!below) return {};
        patch(*below, std::move(*root));
        return below;
    }

    // The document of this path, which `json` names; null after a report. It becomes part of the
    // chain.
    std::shared_ptr<const Source> find_file(const Json& json, const std::string& text,
                                            std::vector<fs::path>& chain,
                                            const std::string& node = {})
    {
        const Source& source = *json.origin->source;
        const fs::path full = (source.folder() / text).lexically_normal();
        std::error_code error;
        const fs::path canonical = fs::weakly_canonical(full, error);
        Problem p = problem_at(json.place());
        p.node = node;
        if (error || !can_be_a_path(text)) {
            p.message = "this cannot be a path";
        } else if (!paths_.allow_outside && !lies_in(canonical, paths_.root)) {
            p.message = fmt::format("this leads outside of the project's folder, {}",
                                    paths_.root.generic_string());
        } else if (const auto loop = std::find(chain.begin(), chain.end(), canonical);
                   loop != chain.end()) {
            p.message = "these documents need each other: ";
            for (auto it = loop; it != chain.end(); ++it) {
                p.message += it->filename().generic_string() + " -> ";
            }
            p.message += canonical.filename().generic_string();
        } else if (chain.size() > most_levels) {
            p.message =
                fmt::format("documents need documents more than {} levels deep", most_levels);
        } else {
            std::shared_ptr<const Source>& known = sources_[canonical];
            if (known) return chain.push_back(canonical), known;
            if (auto content = read_document(full, options_.max_bytes, p)) {
                const fs::path name = fs::path(source.name()).parent_path() / text;
                known = std::make_shared<const Source>(name.lexically_normal().generic_string(),
                                                       full.parent_path(), std::move(*content));
                return chain.push_back(canonical), known;
            }
            sources_.erase(canonical);
        }
        p.found = json.snippet();
        problems_.add(std::move(p));
        return nullptr;
    }

    // False when nothing below can make sense.
    bool check_head(const Json& root)
    {
        if (!root.object()) {
            problems_.add(wrong(root, "a graph document, { \"aspic\": 1, \"nodes\": {...} }"));
            return false;
        }
        const Json* version = root.find("aspic");
        const std::string expected =
            fmt::format("\"aspic\": {}, the format's version", format_version);
        if (!version) {
            Problem p = problem_at(root.place(), "this does not say that it is a graph document");
            p.expected = expected;
            problems_.add(std::move(p));
        } else if (const auto v = version->number(); !v || *v != format_version) {
            Problem p = wrong(*version, expected);
            if (v && *v > format_version) p.suggestion = "a newer aspic wrote it";
            problems_.add(std::move(p));
            if (v && *v > format_version) return false;
        }
        static constexpr std::string_view known[] = {"aspic",    "frames", "variables", "nodes",
                                                     "expect",   "ui",     "doc",       "extends",
                                                     "subgraph", "$schema"};
        refuse_unknown(root, known, "a graph document", {}, problems_);
        want_text(root.find("doc"), {}, problems_);
        if (!root.find("nodes") && !root.find("extends")) {
            problems_.add(problem_at(root.place(), "this has no \"nodes\": { ... }"));
        }
        return true;
    }

    // ---- shots -----------------------------------------------------------------------------

    // Lays a document over the one that it extends.
    void patch(Json& base, Json over)
    {
        // What a scene promises of its numbers holds for that scene only.
        erase(base, "expect");
        merge_members(base, std::move(over), [&](Member* below, Member& member) {
            if (!below) return true;
            const bool objects = below->value.object() && member.value.object();
            if (member.key == "nodes" && objects) {
                patch_nodes(below->value, std::move(member.value));
            } else if ((member.key == "frames" || member.key == "variables") && objects) {
                merge_members(below->value, std::move(member.value), replace);
            } else {
                replace(below, member);
            }
            return true;
        });
    }

    static bool replace(Member* below, Member& member)
    {
        if (below) *below = std::move(member);
        return true;
    }

    void patch_nodes(Json& nodes, Json over)
    {
        std::vector<Problem> lost;  // told once the names have stopped moving
        merge_members(nodes, std::move(over), [&](Member* below, Member& member) {
            const bool whole = member.value.find("type") != nullptr;
            if (!below && !whole) {
                lost.push_back(problem_at(
                    member.key_place(),
                    fmt::format("the document below has no node '{}' to change", member.key)));
                lost.back().found = member.key;
                return false;
            }
            if (!below) return true;
            if (member.value.null()) return false;
            if (whole || !member.value.object()) return replace(below, member);
            lay_over(below->value, std::move(member.value));
            return true;
        });
        const std::vector<std::string_view> left = member_names(&nodes);
        for (Problem& p : lost) {
            p.suggestion = problems_.full() ? "" : suggest(p.found, left);
            p.found.clear();
            problems_.add(std::move(p));
        }
    }

    static std::vector<std::string_view> member_names(const Json* json)
    {
        std::vector<std::string_view> names;
        if (json && json->object()) {
            for (const Member& m : *json->object()) names.emplace_back(m.key);
        }
        return names;
    }

    // ---- frames and variables --------------------------------------------------------------

    FrameRange frames(const Json* json)
    {
        FrameRange range;
        if (!json) return range;
        if (!json->object()) {
            problems_.add(wrong(*json, "{ \"first\": 1, \"last\": 120, \"fps\": 24 }"));
            return range;
        }
        static constexpr std::string_view known[] = {"first", "last", "fps"};
        refuse_unknown(*json, known, "\"frames\"", {}, problems_);
        const Json *first = json->find("first"), *last = json->find("last"),
                   *fps = json->find("fps");
        if (first) range.first = read_frame(*first, problems_).value_or(range.first);
        range.last = range.first;
        if (last) range.last = read_frame(*last, problems_).value_or(range.last);
        if (range.last < range.first) {
            problems_.add(
                wrong(last ? *last : *json, fmt::format("a last frame from {} on", range.first)));
            range.last = range.first;
        } else if (std::int64_t{range.last} - range.first >= options_.max_frames) {
            problems_.add(wrong(*last, fmt::format("at most {} frames", options_.max_frames)));
            range.last = range.first;
        }
        if (fps) {
            const std::string expected = "frames a second, a number above 0, at most 1e6";
            const std::optional<double> x = read_number(*fps, expected, problems_);
            if (x && *x > 0 && *x <= 1e6) {
                range.fps = *x;
            } else if (x) {
                problems_.add(wrong(*fps, expected));
            }
        }
        return range;
    }

    // Gives the document's origins its variables; those in `given` replace its own and are taken
    // out of there.
    void variables(Document& document, const Json* json,
                   std::map<std::string, double, std::less<>>& given)
    {
        auto grammar = std::make_shared<Grammar>();
        grammar->define("fps", fps_);
        for (Origin* origin : document.origins) origin->grammar = grammar;
        if (!json) return;
        if (!json->object()) {
            problems_.add(wrong(*json, "an object of numbers, { \"scale\": 0.02 }"));
            return;
        }
        if (json->object()->size() > most_variables) {
            problems_.add(
                problem_at(json->place(), fmt::format("more than {} variables", most_variables)));
            return;
        }
        for (const Member& member : *json->object()) {
            if (!Grammar::free_name(member.key)) {
                Problem p = problem_at(member.key_place(),
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
                grammar->define(member.key,
                                read_number(member.value, "a number", problems_).value_or(1));
            }
        }
    }

    // ---- nodes -----------------------------------------------------------------------------

    std::vector<Declaration> declare(Json& root, const std::string& prefix)
    {
        std::vector<Declaration> declarations;
        Json* nodes = root.find("nodes");
        if (!nodes) return declarations;
        if (!nodes->object()) {
            problems_.add(wrong(*nodes, "an object of nodes, { \"name\": {...} }"));
            return declarations;
        }
        declarations.reserve(nodes->object()->size());
        for (Member& member : *nodes->object()) {
            Place place = member.key_place();
            if (!good_name(member.key)) {
                Problem p =
                    problem_at(place, fmt::format("a node cannot be called '{}'", member.key));
                p.expected = "letters, digits, _ and -, first a letter";
                problems_.add(std::move(p));
            } else if (!member.value.object()) {
                Problem p = wrong(member.value, "{ \"type\": \"...\", ... }");
                p.node = prefix + member.key;
                problems_.add(std::move(p));
            } else {
                declarations.push_back(
                    {prefix + member.key, std::move(place), std::move(member.value)});
            }
        }
        return declarations;
    }

    // ---- parameters from outside -----------------------------------------------------------

    // Those for nodes of a subgraph have a slash in them, and wait until it took its place.
    void overrides(std::vector<Declaration>& declarations, Document& document, bool inner)
    {
        Names index;
        for (const Override& o : options_.sets) {
            const std::size_t dot = std::min(o.target.find('.'), o.target.size());
            const std::string name = o.target.substr(0, dot);
            if ((name.find('/') != std::string::npos) != inner) continue;
            if (index.empty()) {
                for (std::size_t i = 0; i < declarations.size(); ++i) {
                    index.emplace(declarations[i].name, i);
                }
            }
            const std::string text = fmt::format("--set {}={}", o.target, o.value);
            Origin& origin = new_origin(
                document, std::make_shared<const Source>(
                              text, document.origins[0]->source->folder(), o.value, false));
            origin.grammar = document.origins[0]->grammar;
            Problems ignored;
            std::optional<Json> value = parse_json(origin, {.depth = options_.max_depth}, ignored);
            if (!value) {
                value = Json{o.value, &origin, 0, static_cast<std::uint32_t>(o.value.size())};
            }
            const auto found = index.find(name);
            std::optional<Problem> p;
            if (dot + 1 >= o.target.size()) {
                p = problem_at({});
                p->expected = "node.parameter=value";
                p->found = o.target;
            } else if (found == index.end()) {
                p = problem_at({}, fmt::format("there is no node '{}'", name));
                std::vector<std::string_view> names;
                for (const Declaration& d : declarations) names.emplace_back(d.name);
                p->suggestion = suggest(name, names);
            } else {
                p = set_param(declarations[found->second].body,
                              std::string_view(o.target).substr(dot + 1), std::move(*value));
                if (p) p->node = name;
            }
            if (p) {
                p->place = {text, 0, 0};
                problems_.add(std::move(*p));
            }
        }
    }

    // ---- subgraphs -------------------------------------------------------------------------

    // Moves nodes to the list of all, each subgraph as what is in it.
    void expand(std::vector<Declaration> nodes, const std::vector<fs::path>& chain)
    {
        for (Declaration& d : nodes) {
            if (count_ > options_.max_nodes) return;
            if (++count_ > options_.max_nodes) {
                problems_.add(problem_at(
                    d.place, fmt::format("with its subgraphs this has more than {} nodes",
                                         options_.max_nodes)));
                return;
            }
            if (const auto type = file_type(d.body.find("type"))) {
                expand_one(d, *type, chain);
            } else {
                all_.declarations.push_back(std::move(d));
            }
        }
    }

    void expand_one(Declaration& d, const FileType& file, const std::vector<fs::path>& chain)
    {
        Stand& stand = all_.subgraphs[d.name];
        const Json& type = *d.body.find("type");
        static constexpr std::string_view known[] = {"type", "inputs", "params", "doc", "ui"};
        refuse_unknown(d.body, known, "a node", d.name, problems_);
        want_text(d.body.find("doc"), d.name, problems_);
        Document document;
        document.chain = chain;
        document.prefix = d.name + "/";
        std::shared_ptr<const Source> source = find_file(type, file.path, document.chain, d.name);
        if (!source) return;
        const std::string name = source->name();
        std::optional<Json> root = read(document, std::move(source));
        if (!root) return;
        const Json* face = root->find("subgraph");
        if (!face || !face->object()) {
            Problem p = problem_at(type.place(), "this document is no subgraph");
            p.node = d.name;
            p.expected = fmt::format("a \"subgraph\" with inputs, outputs and params in {}", name);
            problems_.add(std::move(p));
            return;
        }
        static constexpr std::string_view parts[] = {"version", "inputs", "outputs", "params"};
        refuse_unknown(*face, parts, "a subgraph", {}, problems_);
        check_version(d, type, file, *face);

        std::vector<Declaration> inner = declare(*root, document.prefix);
        Names index;
        for (std::size_t i = 0; i < inner.size(); ++i) {
            index.emplace(inner[i].name.substr(document.prefix.size()), i);
        }
        std::map<std::string, double, std::less<>> given;
        std::set<std::string> linked;
        const Face f{d, inner, index, given, linked};
        promote(f, *face, "params");
        variables(document, root->find("variables"), given);
        promote(f, *face, "inputs");
        outputs(*face, stand);
        expand(std::move(inner), document.chain);
    }

    void check_version(const Declaration& d, const Json& type, const FileType& file,
                       const Json& face)
    {
        double version = 1;
        if (const Json* json = face.find("version")) {
            version = read_number(*json, "a whole number from 1 on", problems_).value_or(1);
        }
        if (!file.version) return;
        int wanted = 0;
        const char *begin = file.version->data(), *end = begin + file.version->size();
        const auto [stop, error] = std::from_chars(begin, end, wanted);
        Problem p = wrong(type, fmt::format("version {}", version));
        p.node = d.name;
        if (error != std::errc() || stop != end || wanted < 1 || wanted > version) {
            problems_.add(std::move(p));
        } else if (wanted < version) {
            p.severity = Severity::warning;
            p.suggestion = "see in its file whether that still means the same";
            problems_.add(std::move(p));
        }
    }

    // A subgraph's node, what is inside, and where to find that by name.
    struct Face {
        const Declaration& outer;
        std::vector<Declaration>& inner;
        const Names& index;
        std::map<std::string, double, std::less<>>& variables;
        std::set<std::string>& linked;  // inputs that already got a link from outside
    };

    // Hands what the outer node gives for each promoted input or parameter to the nodes inside.
    void promote(const Face& f, const Json& face, const char* part)
    {
        const bool inputs = std::string_view(part) == "inputs";
        const Json* ports = face.find(part);
        const Json* given = f.outer.body.find(part);
        if (ports && !ports->object()) {
            problems_.add(wrong(*ports, "an object, { \"name\": { \"to\": \"node.port\" } }"));
            ports = nullptr;
        }
        if (given && !given->object()) {
            Problem p = wrong(*given, "an object {...}");
            p.node = f.outer.name;
            problems_.add(std::move(p));
            given = nullptr;
        }
        for (std::size_t i = 0; given && i < given->object()->size(); ++i) {
            const Member& member = (*given->object())[i];
            if (ports && ports->find(member.key)) continue;
            Problem p = problem_at(member.key_place(), fmt::format("the subgraph has no such {}",
                                                                   inputs ? "input" : "parameter"));
            p.node = f.outer.name;
            p.part = inputs ? Part::input : Part::parameter;
            p.port = member.key;
            p.suggestion = suggest(member.key, member_names(ports));
            problems_.add(std::move(p));
        }
        for (std::size_t i = 0; ports && i < ports->object()->size(); ++i) {
            const Member& port = (*ports->object())[i];
            promote_one(f, port, given ? given->find(port.key) : nullptr, inputs);
        }
    }

    void promote_one(const Face& f, const Member& port, const Json* value, bool inputs)
    {
        if (!port.value.object()) {
            problems_.add(wrong(port.value, "{ \"to\": \"node.port\" }"));
            return;
        }
        static constexpr std::string_view of_inputs[] = {"to", "doc", "optional"};
        static constexpr std::string_view of_params[] = {"to", "doc", "default"};
        refuse_unknown(port.value, inputs ? std::span(of_inputs) : std::span(of_params),
                       inputs ? "a subgraph's input" : "a subgraph's parameter", {}, problems_);
        const Json* to = port.value.find("to");
        std::vector<const Json*> targets;
        if (to && to->text()) targets.push_back(to);
        for (std::size_t i = 0; to && to->array() && i < to->array()->size(); ++i) {
            targets.push_back(&(*to->array())[i]);
        }
        if (targets.empty()) {
            problems_.add(wrong(to ? *to : port.value, "\"to\": \"node.port\", or a list of them"));
            return;
        }
        if (!value && !inputs) value = port.value.find("default");
        if (!value && inputs) {
            const Json* optional = port.value.find("optional");
            const bool* may_miss = optional ? std::get_if<bool>(&optional->is) : nullptr;
            if (!may_miss || !*may_miss) {
                Problem p = problem_at(f.outer.place, "this input must be linked");
                p.node = f.outer.name;
                p.part = Part::input;
                p.port = port.key;
                problems_.add(std::move(p));
                for (const Json* target : targets) {
                    if (target->text()) all_.missed.insert(f.outer.name + "/" + *target->text());
                }
            }
        }
        for (const Json* target : targets) {
            if (!target->text()) {
                problems_.add(wrong(*target, "\"node.port\""));
                continue;
            }
            hand_in(f, *target, value, inputs);
        }
    }

    // `target` is "node.port" inside; a null value leaves the inside as it is.
    void hand_in(const Face& f, const Json& target, const Json* value, bool inputs)
    {
        const std::string& text = *target.text();
        const std::size_t dot = text.find('.');
        const std::string node = text.substr(0, dot);
        const std::string port = dot == std::string::npos ? "" : text.substr(dot + 1);
        if (!inputs && node == "variables" && !port.empty()) {
            if (!value) return;
            if (const auto x = read_number(*value, "a number", problems_)) {
                f.variables.insert_or_assign(port, *x);
            }
            return;
        }
        const auto found = f.index.find(node);
        if (found == f.index.end() || port.empty()) {
            Problem p = wrong(target, inputs ? "\"node.input\" inside of the subgraph"
                                             : "\"node.parameter\" inside of the subgraph");
            std::vector<std::string_view> names;
            for (const auto& [name, i] : f.index) names.emplace_back(name);
            std::sort(names.begin(), names.end());
            if (found == f.index.end()) p.suggestion = suggest(node, names);
            problems_.add(std::move(p));
            return;
        }
        if (!value) return;
        Json& body = f.inner[found->second].body;
        if (!inputs) {
            if (auto p = set_param(body, port, *value)) {
                p->place = target.place();
                problems_.add(std::move(*p));
            }
            return;
        }
        Json& links = child(body, "inputs", *value);
        if (!links.object()) return;  // said when the inner node is read
        Json* there = links.find(port);
        const bool again = !f.linked.insert(text).second;
        if (there && (there->array() || again)) {
            // A list takes more: links from outside come after those inside.
            if (!there->array()) {
                Json first = *there;
                there->is = Json::Array{std::move(first)};
            }
            if (value->array()) {
                there->array()->insert(there->array()->end(), value->array()->begin(),
                                       value->array()->end());
            } else {
                there->array()->push_back(*value);
            }
        } else {
            put(links, {port, value->begin, *value});
        }
    }

    void outputs(const Json& face, Stand& stand)
    {
        const Json* ports = face.find("outputs");
        if (!ports) return;
        if (!ports->object()) {
            problems_.add(wrong(*ports, "an object, { \"name\": { \"from\": \"node.output\" } }"));
            return;
        }
        for (const Member& port : *ports->object()) {
            const Json* from = port.value.find("from");
            if (!from || !from->text()) {
                problems_.add(wrong(from ? *from : port.value, "{ \"from\": \"node.output\" }"));
                continue;
            }
            static constexpr std::string_view known[] = {"from", "doc"};
            refuse_unknown(port.value, known, "a subgraph's output", {}, problems_);
            stand.outputs.emplace_back(port.key, *from);
        }
    }

    const PathRules& paths_;
    const LoadOptions& options_;
    Problems& problems_;
    Assembly all_;
    std::shared_ptr<const Grammar> plain_ = std::make_shared<const Grammar>();
    double fps_ = 24;
    std::size_t count_ = 0;
    std::map<fs::path, std::shared_ptr<const Source>> sources_;  // by canonical path
};

}  // namespace

Assembly assemble(std::string text, const fs::path& file, const PathRules& paths,
                  const LoadOptions& options, Problems& problems)
{
    return Assembler(paths, options, problems).assemble(std::move(text), file);
}

}  // namespace graph
