#include "runtime/commands/verify.hpp"

#include "runtime/cache/descriptor.hpp"
#include "runtime/commands/cook_graph.hpp"
#include "runtime/cook/below_folder.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cerrno>
#include <map>
#include <ostream>
#include <set>
#include <unistd.h>

namespace runtime {

namespace {

namespace fs = std::filesystem;

struct TemporaryFolder {
    fs::path path;
    TemporaryFolder()
    {
        std::string pattern = (fs::temp_directory_path() / "aspic-verify-XXXXXX").string();
        if (!mkdtemp(pattern.data())) {
            throw std::runtime_error("no temporary folder can be made in " +
                                     fs::temp_directory_path().string());
        }
        path = pattern;
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    ~TemporaryFolder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
};

// At most a few lines of one kind.
class Lines {
public:
    Lines(Console& console, std::string rest) : console_(console), rest_(std::move(rest)) {}
    ~Lines()
    {
        if (count > most) console_.out << fmt::format("  and {} more {}\n", count - most, rest_);
    }
    void add(const std::string& line)
    {
        if (++count <= most) console_.out << "  " << line << "\n";
    }
    std::size_t count = 0;

private:
    static constexpr std::size_t most = 10;
    Console& console_;
    std::string rest_;
};

// What went in then and is not the same now.
void tell_changes(const Manifest& then, const Console& console, std::ostream& out)
{
    FileDigests digests;
    std::map<std::string, std::string> files;
    for (const Manifest::File& f : then.documents) files[f.path] = f.digest;
    for (const auto& [name, node] : then.nodes) {
        for (const auto& [param, f] : node.files) files[f.path] = f.digest;
        for (const Manifest::File& f : node.side_files) files[f.path] = f.digest;
    }
    for (const auto& [path, digest] : files) {
        const Key now = digests.of(path);
        if (to_hex(now) == digest) continue;
        out << fmt::format("changed since the cook: {}{}\n", path, now ? "" : " (missing)");
    }
    if (then.program != to_hex(console.salt)) {
        out << fmt::format("cooked by another build of the program or on another kind of machine "
                           "(aspic {}; this is {})\n",
                           then.version, console.version);
    }
}

// The files beside the manifest that are not what the cook left; returns how many.
// `outside`: others may stand there, which compare() tells.
std::size_t tell_touched(const Manifest& then, const fs::path& folder, bool outside,
                         Console& console)
{
    Lines lines(console, "files");
    for (const Manifest::Output& o : then.outputs) {
        if (o.file.path.empty() || (outside && names_outside(o.file.path))) continue;
        const fs::path file = folder / o.file.path;
        const Descriptor open(open_below(folder, o.file.path));
        if (open.number < 0 && (errno == EXDEV || errno == ELOOP)) {
            lines.add(
                fmt::format("{} is outside the manifest's folder and was not read", file.string()));
            continue;
        }
        const Key now = open.number < 0 ? Key() : digest_of(open.number);
        if (to_hex(now) == o.file.digest || (now && o.file.digest.empty())) continue;
        lines.add(fmt::format("{} {} the cook", file.string(),
                              now ? "was changed after" : "was removed after"));
    }
    return lines.count;
}

using Place = std::tuple<std::string, int, std::string, std::string>;
Place place_of(const Manifest::Output& o)
{
    return {o.node, o.frame, o.port, o.file.path};
}
std::string describe(const Manifest::Output& o)
{
    return o.port.empty() ? fmt::format("{}, frame {}: {}", o.node, o.frame, o.file.path)
                          : fmt::format("{}.{}, frame {}", o.node, o.port, o.frame);
}

// The nodes that write outside of the output folder. The folder is another one now, and they would
// write over what they wrote then.
std::set<std::string> writing_outside(const graph::Graph& graph)
{
    std::set<std::string> found;
    for (const graph::Node& node : graph.nodes) {
        const std::vector<graph::Param>& params = node.type->params;
        for (std::size_t i = 0; i < params.size(); ++i) {
            const auto* const path = std::get_if<std::string>(&node.params.at(i).is);
            if (params[i].kind != graph::ParamKind::path_out || !path) continue;
            if (names_outside(*path)) found.insert(node.name);
        }
    }
    return found;
}

// The nodes of the request, or all that it means, but for those.
std::vector<std::string> all_but(const std::set<std::string>& left_out, const graph::Graph& graph,
                                 const CookRequest& request)
{
    std::vector<std::string> names;
    for (const std::uint32_t n : chosen_nodes(graph, request)) {
        if (!left_out.contains(graph.nodes[n].name)) names.push_back(graph.nodes[n].name);
    }
    return names;
}

// What is not the same as then, told; and how many outputs could not be compared.
struct Comparison {
    std::size_t differ = 0, unknown = 0;
};

Comparison compare(const Manifest& then, const Manifest& now, const std::set<std::string>& left_out,
                   Console& console)
{
    std::map<Place, const Manifest::Output*> made;
    for (const Manifest::Output& o : now.outputs) made[place_of(o)] = &o;
    Comparison found;
    std::set<std::string> parts;
    {
        Lines lines(console, "outputs");
        for (const Manifest::Output& o : then.outputs) {
            const auto again = made.find(place_of(o));
            if (left_out.contains(o.node)) {
                ++found.unknown;
            } else if (again == made.end()) {
                lines.add(describe(o) + " was not produced");
            } else if (o.file.digest.empty() || again->second->file.digest.empty()) {
                ++found.unknown;
                parts.insert(o.file.path);
            } else if (again->second->file.digest != o.file.digest) {
                lines.add(describe(o) + " differs");
            }
        }
        found.differ = lines.count;
    }
    for (const std::string& path : parts) {
        console.out << fmt::format(
            "not compared: {} holds all frames, of which the cook wrote {}\n", path, then.frames);
    }
    for (const std::string& node : left_out) {
        console.out << fmt::format("not compared: '{}' writes outside the output folder\n", node);
    }
    return found;
}

}  // namespace

int verify(const fs::path& given, const CookRequest& request, const graph::Registry& registry,
           Console& console)
{
    const fs::path path = fs::is_directory(given) ? given / manifest_name : given;
    const Manifest then = read_manifest(path);
    tell_changes(then, console, console.out);
    const fs::path beside = path.has_parent_path() ? path.parent_path() : fs::path(".");
    const std::size_t touched = tell_touched(then, beside, request.allow_outside, console);

    const TemporaryFolder folder;
    CookRequest again = request;
    again.files = {then.documents.front().path};
    again.frames = then.frames;
    again.nodes = then.only;
    again.sets = then.sets, again.variables = then.variables;
    // What a manifest says of permissions is worth nothing: it may come from a stranger.
    if ((then.allow_outside && !request.allow_outside) ||
        (!then.root.empty() && request.root.empty() && !request.allow_outside)) {
        throw std::invalid_argument(fmt::format(
            "{}: the cook was allowed to read {}; allow it again with {}", path.string(),
            then.allow_outside ? "files anywhere" : "all below " + then.root,
            then.allow_outside ? "--allow-outside" : "--root " + then.root));
    }
    again.output_folder = folder.path.string();
    const auto graph = load(again.files[0], again, registry, console);
    if (!graph) return exit_usage;
    const std::unique_ptr<FrontEnd> front_end =
        make_front_end(console.terminal ? Style::terminal : Style::quiet, console);
    Caches caches;
    caches.memory = MemoryCache(request.memory);
    const std::set<std::string> left_out = writing_outside(*graph);
    if (!left_out.empty()) again.nodes = all_but(left_out, *graph, again);
    Manifest now;
    if (left_out.empty() || !again.nodes.empty()) {
        const int exit = cook_graph(*graph, again, caches, *front_end, console, now);
        if (exit == exit_cancelled || exit == exit_failed) return exit;
    }

    const auto [differ, unknown] = compare(then, now, left_out, console);
    if (differ > 0) {
        console.out << fmt::format("{} of {} outputs differ\n", differ, then.outputs.size());
        return exit_failed;
    }
    console.out << fmt::format("cooked again: all {} outputs{} are the same{}\n",
                               then.outputs.size() - unknown, unknown > 0 ? " compared" : "",
                               touched > 0 ? ", but the files in the folder are not" : "");
    return touched > 0 ? exit_failed : exit_ok;
}

void add_verify_command(const CommandSet& set)
{
    CLI::App* verify_app = set.app.add_subcommand(
        "verify", "Repeats the cook of a manifest without caches and compares the outputs");
    const auto manifest = std::make_shared<std::string>();
    verify_app->add_option("manifest", *manifest, "The manifest.json of an earlier cook")
        ->required()
        ->type_name("MANIFEST");
    add_threads(*verify_app, set.request);
    add_permissions(*verify_app, set.request);
    verify_app->callback([&set, manifest] {
        run_limited(set, [&] { return verify(*manifest, set.request, set.registry, set.console); });
    });
}

}  // namespace runtime
