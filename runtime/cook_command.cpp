#include "runtime/cook_command.hpp"

#include "graph/standard_wires.hpp"
#include "runtime/profile.hpp"
#include "runtime/text_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <fcntl.h>
#include <fstream>
#include <optional>
#include <ostream>
#include <sys/file.h>
#include <unistd.h>

namespace runtime {

namespace {

namespace fs = std::filesystem;

std::pair<std::string, double> parse_variable(const std::string& text)
{
    const std::size_t equals = text.find('=');
    double value = 0;
    const char* const end = text.data() + text.size();
    if (equals == std::string::npos || equals == 0 ||
        std::from_chars(text.data() + equals + 1, end, value).ptr != end) {
        throw std::invalid_argument(fmt::format("--var: expected name=number, found '{}'", text));
    }
    return {text.substr(0, equals), value};
}

std::uint32_t find_node(const graph::Graph& graph, const std::string& name)
{
    std::vector<std::string_view> names;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        if (graph.nodes[n].name == name) return static_cast<std::uint32_t>(n);
        names.push_back(graph.nodes[n].name);
    }
    throw std::invalid_argument(
        fmt::format("{} has no node '{}'; {}", graph.file, name, graph::suggest(name, names)));
}

// The numbers that a graph's expectations look at, as they arrive.
class Numbers {
public:
    // Adds to `wants` what the expectations at the cooked frames need.
    Numbers(const graph::Graph& graph, const std::vector<int>& frames, bool all_frames,
            std::vector<Want>& wants)
    {
        for (const graph::Expectation& e : graph.expectations) {
            for (const int f : e.frames) {
                if (!all_frames && !std::binary_search(frames.begin(), frames.end(), f)) continue;
                checks_.push_back({&e, f, {}, false});
                wants.push_back({e.value.node, f});
            }
        }
        std::sort(wants.begin(), wants.end());
        wants.erase(std::unique(wants.begin(), wants.end()), wants.end());
    }

    void arrived(const Want& want, std::span<const graph::Value> values, bool varies)
    {
        for (ExpectationResult& check : checks_) {
            const graph::Link& link = check.expectation->value;
            if (link.node != want.node || (varies && check.frame != want.frame)) continue;
            const graph::Value& value = values[link.output];
            if (!value || *value.type()->type != typeid(double)) continue;
            check.value = *value.as<double>();
            check.met =
                *check.value >= check.expectation->min && *check.value <= check.expectation->max;
        }
    }

    const std::vector<ExpectationResult>& checks() const { return checks_; }

private:
    std::vector<ExpectationResult> checks_;
};

// Keeps which files were written, for the manifest.
class Outputs : public Relay {
public:
    Outputs(Observer& next, const graph::Graph& graph, fs::path folder, Manifest& manifest)
        : Relay(next), graph_(graph), folder_(std::move(folder)), manifest_(manifest)
    {}
    void wrote(std::uint32_t n, int frame, const Written& w) override
    {
        if (!w.digest) shared_.push_back({manifest_.outputs.size(), w.path});
        add({graph_.nodes[n].name,
             {},
             frame,
             {w.path.lexically_proximate(folder_).generic_string(), to_hex(w.digest)}});
        Relay::wrote(n, frame, w);
    }
    // Files that frames share are now what they will be.
    void finish(FileDigests& digests)
    {
        for (const auto& [place, path] : shared_) {
            manifest_.outputs[place].file.digest = to_hex(digests.of(path));
        }
    }
    // Values that were asked for and go into no file.
    void arrived(const Want& want, std::span<const graph::Value> values, ContentNames& names)
    {
        const graph::Node& node = graph_.nodes[want.node];
        for (std::size_t i = 0; i < values.size(); ++i) {
            const graph::ContentName name = names.of(values[i]);
            add({node.name,
                 node.type->outputs[i].name,
                 want.frame,
                 {{}, to_hex({name[0], name[1]})}});
        }
    }

private:
    void add(Manifest::Output output) { manifest_.outputs.push_back(std::move(output)); }

    const graph::Graph& graph_;
    const fs::path folder_;
    Manifest& manifest_;
    std::vector<std::pair<std::size_t, fs::path>> shared_;  // places in manifest_.outputs
};

void begin_manifest(const CookRequest& request, const Console& console,
                    const std::vector<int>& frames, Manifest& m)
{
    m.version = console.version;
    m.program = to_hex(console.salt);
    m.frames = frames_text(frames);
    m.sets = request.sets, m.variables = request.variables, m.only = request.nodes;
    m.root = request.root.empty() ? "" : fs::absolute(request.root).lexically_normal().string();
    m.allow_outside = request.allow_outside;
}

// Beside the files that it tells of. Its loss is no reason to fail a cook.
void write_manifest(const fs::path& folder, Manifest& m, Console& console)
{
    std::sort(m.outputs.begin(), m.outputs.end(),
              [](const Manifest::Output& a, const Manifest::Output& b) {
                  return std::tie(a.node, a.frame, a.port, a.file.path) <
                         std::tie(b.node, b.frame, b.port, b.file.path);
              });
    try {
        replace_text(folder / manifest_name, to_text(m));
    } catch (const std::exception& e) {
        console.err << "warning: no manifest was left: " << e.what() << "\n";
    }
}

}  // namespace

std::vector<std::uint32_t> chosen_nodes(const graph::Graph& graph, const CookRequest& request)
{
    std::vector<std::uint32_t> nodes;
    if (request.expectations_only) return nodes;
    for (const std::string& name : request.nodes) nodes.push_back(find_node(graph, name));
    if (!nodes.empty()) return nodes;
    std::vector<char> used(graph.nodes.size(), 0);
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        if (graph.nodes[n].type->sink) nodes.push_back(static_cast<std::uint32_t>(n));
        for (const auto& port : graph.nodes[n].inputs) {
            for (const graph::Link& link : port) used[link.node] = 1;
        }
    }
    if (!nodes.empty()) return nodes;
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        if (!used[n]) nodes.push_back(static_cast<std::uint32_t>(n));
    }
    return nodes;
}

std::vector<int> chosen_frames(const graph::Graph& graph, const CookRequest& request)
{
    if (request.frames.empty()) {
        std::vector<int> all;
        for (int f = graph.range.first; f <= graph.range.last; ++f) all.push_back(f);
        return all;
    }
    const std::vector<int> frames = parse_frames(request.frames);
    for (const int f : frames) {
        if (f < graph.range.first || f > graph.range.last) {
            throw std::invalid_argument(
                fmt::format("{} has frames {} to {}; frame {} is none of them", graph.file,
                            graph.range.first, graph.range.last, f));
        }
    }
    return frames;
}

fs::path output_folder(const graph::Graph& graph, const CookRequest& request)
{
    const fs::path name = fs::path(graph.file).stem();
    if (request.output_folder.empty()) return fs::path("out") / name;
    return request.files.size() > 1 ? request.output_folder / name
                                    : fs::path(request.output_folder);
}

void make_output_folder(const fs::path& folder)
{
    std::error_code error;
    fs::create_directories(folder, error);
    if (!error) return;
    throw std::invalid_argument(
        fmt::format("the output folder {} can't be made ({}): say --out DIR", folder.string(),
                    error.message()));
}

// Held while a cook writes into a folder, as far as its file system has locks.
class FolderLock {
public:
    explicit FolderLock(const fs::path& folder)
        : number_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)),
          taken_(number_ >= 0 && ::flock(number_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    {}
    ~FolderLock()
    {
        if (number_ >= 0) ::close(number_);
    }
    FolderLock(const FolderLock&) = delete;

    bool taken() const { return taken_; }  // by another cook

private:
    int number_;
    bool taken_;
};

int cook_graph(const graph::Graph& graph, const CookRequest& request, Caches& caches,
               FrontEnd& front_end, Console& console, Manifest& manifest)
{
    const std::vector<int> frames = chosen_frames(graph, request);
    std::vector<Want> wants;
    const std::vector<std::uint32_t> nodes = chosen_nodes(graph, request);
    for (const int f : frames) {
        for (const std::uint32_t n : nodes) wants.push_back({n, f});
    }
    Numbers numbers(graph, frames, request.expectations_only && request.frames.empty(), wants);

    Options options;
    options.threads = request.threads;
    options.keep_going = request.keep_going || request.expectations_only;
    options.output_folder = output_folder(graph, request);
    options.stop = console.stop;
    options.salt = console.salt;
    options.recheck = request.recheck / 100;
    options.recheck_seed =
        static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
    std::optional<FolderLock> lock;
    if (!nodes.empty()) {
        make_output_folder(options.output_folder);
        if (lock.emplace(options.output_folder).taken()) {
            console.err << fmt::format("warning: another cook is writing into {}; files of the two "
                                       "may mix there: say --out DIR\n",
                                       options.output_folder.string());
        }
    }
    begin_manifest(request, console, frames, manifest);

    front_end.began(graph, frames.size());
    Recorder recorder(front_end);
    Observer* const observer = request.profile ? static_cast<Observer*>(&recorder) : &front_end;
    Outputs outputs(*observer, graph, options.output_folder, manifest);
    Evaluator evaluator(graph, caches, options, &outputs);
    // Before it, as the files that it reads may change while it goes on.
    if (!nodes.empty()) {
        evaluator.aim(wants);
        describe_graph(graph, evaluator.keys(), frames, caches.files, manifest);
    }
    const Cooked cooked =
        evaluator.cook(wants, [&](const Want& want, std::span<const graph::Value> values) {
            numbers.arrived(want, values, evaluator.keys().varies(want.node));
            const bool asked = std::find(nodes.begin(), nodes.end(), want.node) != nodes.end();
            if (asked && !graph.nodes[want.node].type->sink) {
                outputs.arrived(want, values, caches.names);
            }
        });
    outputs.finish(caches.files);
    manifest.complete = !cooked.cancelled && cooked.failures == 0;
    if (!nodes.empty()) {
        for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
            const Tally& t = cooked.tallies[n];
            if (t.runs == 0) continue;
            manifest.nodes[graph.nodes[n].name].seconds = t.seconds / static_cast<double>(t.runs);
        }
        write_manifest(options.output_folder, manifest, console);
    }
    bool missed = false;
    if (!cooked.cancelled) {
        std::size_t left_out = 0;
        for (const ExpectationResult& check : numbers.checks()) {
            if (!check.value && cooked.failures > 0) {  // the failure was told
                ++left_out;
                continue;
            }
            front_end.expectation(check);
            missed = missed || !check.met;
        }
        front_end.expectations_left_out(left_out);
    }
    const int exit = cooked.cancelled      ? exit_cancelled
                     : cooked.failures > 0 ? exit_failed
                     : missed              ? exit_missed
                                           : exit_ok;
    front_end.finished(cooked, exit);
    if (request.profile) write_table(graph, cooked, console.out);
    if (!request.trace.empty()) {
        std::ofstream file(request.trace);
        write_trace(graph, recorder.runs, file);
        if (!file.flush()) throw std::runtime_error("can't write " + request.trace);
        console.out << "trace: " << request.trace << "\n";
    }
    return exit;
}

Style style_of(const CookRequest& request, const Console& console)
{
    return request.json       ? Style::json
           : request.quiet    ? Style::quiet
           : console.terminal ? Style::terminal
                              : Style::lines;
}

std::unique_ptr<DiskCache> open_cache(const CookRequest& request, Console& console)
{
    const fs::path folder =
        request.cache.empty() ? DiskCache::default_folder() : fs::path(request.cache);
    if (request.no_disk_cache || folder.empty()) return nullptr;
    return std::make_unique<DiskCache>(
        folder, request.cache_budget,
        [&console](const std::string& text) { console.err << "warning: " + text + "\n"; });
}

graph::LoadOptions load_options(const CookRequest& request)
{
    graph::LoadOptions options;
    options.root = request.root;
    options.allow_outside = request.allow_outside;
    for (const std::string& set : request.sets) options.sets.push_back(graph::parse_override(set));
    for (const std::string& v : request.variables) options.variables.push_back(parse_variable(v));
    return options;
}

std::optional<graph::Graph> load(const std::string& file, const CookRequest& request,
                                 const graph::Registry& registry, Console& console)
{
    graph::Loaded loaded = graph::load_file(file, registry, load_options(request));
    for (const graph::Problem& problem : loaded.problems) {
        console.err << graph::describe(problem) << "\n";
    }
    if (!loaded.ok()) return std::nullopt;
    return std::move(loaded.graph);
}

int cook(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    // All documents first: a slip in the last should not wait for the first to be cooked.
    std::vector<graph::Graph> graphs;
    for (const std::string& file : request.files) {
        if (auto graph = load(file, request, registry, console))
            graphs.push_back(std::move(*graph));
    }
    if (graphs.size() < request.files.size()) return exit_usage;

    const std::unique_ptr<FrontEnd> front_end = make_front_end(style_of(request, console), console);
    Caches caches;
    caches.memory = MemoryCache(request.memory);
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    int exit = exit_ok;
    for (const graph::Graph& graph : graphs) {
        Manifest manifest;
        const int one = cook_graph(graph, request, caches, *front_end, console, manifest);
        if (exit == exit_ok || one == exit_cancelled) exit = one;
        if (one == exit_cancelled || (one == exit_failed && !request.keep_going)) break;
    }
    return exit;
}

}  // namespace runtime
