// Parts: the numbers that expectations look at, what goes into the manifest, the lock of the output
// folder, and the cook itself.

#include "runtime/commands/cook_graph.hpp"

#include "graph/types/standard_wires.hpp"
#include "runtime/commands/leftovers.hpp"
#include "runtime/commands/profile.hpp"
#include "runtime/commands/text_file.hpp"
#include "runtime/commands/values_table.hpp"
#include "runtime/cook/below_folder.hpp"
#include "runtime/cook/evaluator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <fcntl.h>
#include <fstream>
#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <sys/file.h>
#include <tuple>
#include <unistd.h>

namespace runtime {

namespace {

namespace fs = std::filesystem;

// The numbers that a graph's expectations look at, and those asked for, as they arrive.
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

    // Of a node that was asked for by name.
    void asked(const Want& want, std::span<const graph::Value> values, bool varies)
    {
        came_.insert(want.node);
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!values[i] || *values[i].type()->type != typeid(double)) continue;
            const graph::Link from{want.node, static_cast<std::uint32_t>(i)};
            const std::optional<int> frame = varies ? std::optional(want.frame) : std::nullopt;
            asked_[{want.node, i, frame}] = {from, frame, *values[i].as<double>()};
        }
    }

    const std::vector<ExpectationResult>& checks() const { return checks_; }
    std::vector<AskedNumber> asked() const
    {
        std::vector<AskedNumber> out;
        for (const auto& [key, number] : asked_) out.push_back(number);
        return out;
    }
    // The columns of the table: what came, and all of those of `nodes` that failed at every frame.
    std::vector<graph::Link> columns(const graph::Graph& graph,
                                     const std::vector<std::uint32_t>& nodes) const
    {
        std::set<std::pair<std::uint32_t, std::uint32_t>> all;
        for (const auto& [key, number] : asked_) all.insert({number.from.node, number.from.output});
        for (const std::uint32_t n : nodes) {
            const auto& outputs = graph.nodes[n].type->outputs;
            for (std::uint32_t i = 0; i < outputs.size() && !came_.contains(n); ++i) {
                if (outputs[i].type == graph::wire_name<double>) all.insert({n, i});
            }
        }
        std::vector<graph::Link> out;
        for (const auto& [node, output] : all) out.push_back({node, output});
        return out;
    }

private:
    std::vector<ExpectationResult> checks_;
    std::set<std::uint32_t> came_;  // nodes that were asked for and did not fail at all frames
    std::map<std::tuple<std::uint32_t, std::size_t, std::optional<int>>, AskedNumber> asked_;
};

// Keeps which files were written, and how accurate results are, for the manifest. People are told
// of the files below the folder as it was given.
class Outputs : public Relay {
public:
    Outputs(Observer& next, const graph::Graph& graph, fs::path folder, Manifest& manifest)
        : Relay(next), graph_(graph), folder_(std::move(folder)), resolved_(resolved(folder_)),
          manifest_(manifest)
    {}
    void wrote(std::uint32_t n, int frame, const Written& w) override
    {
        if (!w.digest) shared_.push_back({manifest_.outputs.size(), w.path});
        const fs::path below = w.path.lexically_proximate(resolved_);
        add({graph_.nodes[n].name, {}, frame, {below.generic_string(), to_hex(w.digest)}});
        Relay::wrote(n, frame, {names_outside(below) ? w.path : folder_ / below, w.digest});
    }
    void told(const Told& t) override { figures_.add(t); }
    std::vector<AccuracyCard> cards(Keys& keys) const { return figures_.cards(graph_, keys); }
    // Files that frames share are now what they will be. Where this cook did not write all frames
    // of the graph, an earlier one may have written the others, and the digest is left empty.
    void finish(FileDigests& digests, bool all_frames)
    {
        for (const auto& [place, path] : shared_) {
            manifest_.outputs[place].file.digest = all_frames ? to_hex(digests.of(path)) : "";
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
    const fs::path folder_, resolved_;
    Manifest& manifest_;
    std::vector<std::pair<std::size_t, fs::path>> shared_;  // places in manifest_.outputs
    AccuracyFigures figures_;
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

// Beside the files that it tells of, or where a part's is asked for. Its loss is no reason to fail
// a cook.
void write_manifest(const fs::path& path, Manifest& m, Console& console)
{
    std::sort(m.outputs.begin(), m.outputs.end(),
              [](const Manifest::Output& a, const Manifest::Output& b) {
                  return std::tie(a.node, a.frame, a.port, a.file.path) <
                         std::tie(b.node, b.frame, b.port, b.file.path);
              });
    try {
        replace_text(path, to_text(m));
    } catch (const std::exception& e) {
        console.err << "warning: the manifest was not written: " << e.what() << "\n";
    }
}

// How long a run of each node took.
void add_seconds(const graph::Graph& graph, const Cooked& cooked, Manifest& manifest)
{
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        const Tally& t = cooked.tallies[n];
        if (t.runs == 0) continue;
        manifest.nodes[graph.nodes[n].name].seconds = t.seconds / static_cast<double>(t.runs);
    }
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

// The manifest and the table have names that the user did not choose: his own files of these names
// stay.
void require_no_other(const fs::path& path, bool is_of_a_cook)
{
    if (is_of_a_cook || !fs::exists(path)) return;
    throw std::invalid_argument(fmt::format(
        "{} was not written by a cook, and this cook would replace it; move it, or use --out DIR",
        path.string()));
}

// Locks the folder for this cook, and clears it of what a killed one left and, where it `writes`,
// of the table of an earlier cook: that tells of other frames, should this one write none.
void lock_folder(std::optional<FolderLock>& lock, const fs::path& folder, bool writes, bool table,
                 Console& console)
{
    make_output_folder(folder);
    const bool old_table = is_values_table(folder / values_name);
    require_no_other(folder / manifest_name, is_manifest(folder / manifest_name));
    if (table) require_no_other(folder / values_name, old_table);
    if (!lock.emplace(folder).taken()) {
        remove_leftovers(folder);
        std::error_code ignored;
        if (writes && old_table) fs::remove(folder / values_name, ignored);
        return;
    }
    console.err << fmt::format(
        "warning: another cook is writing into {}; the files of both may mix. Use --out DIR.\n",
        folder.string());
}

Options options_of(const graph::Graph& graph, const CookRequest& request, const Console& console)
{
    Options options;
    options.threads = request.threads;
    options.keep_going = request.keep_going || request.expectations_only;
    options.output_folder = output_folder(graph, request);
    options.stop = console.stop;
    options.salt = console.salt;
    options.recheck = request.recheck / 100;
    options.recheck_seed =
        static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
    return options;
}

// How the expectations came out. Where nodes failed, those that have no number are left out: the
// failure was told.
std::vector<ExpectationResult> checked(const Numbers& numbers, const Cooked& cooked)
{
    std::vector<ExpectationResult> checks;
    if (cooked.cancelled) return checks;
    for (const ExpectationResult& check : numbers.checks()) {
        if (check.value || cooked.failures == 0) checks.push_back(check);
    }
    return checks;
}

int exit_of(const Cooked& cooked, bool missed)
{
    return cooked.cancelled      ? exit_cancelled
           : cooked.failures > 0 ? exit_failed
           : missed              ? exit_missed
                                 : exit_ok;
}

void show_expectations(const std::vector<ExpectationResult>& checks, const Numbers& numbers,
                       const Cooked& cooked, FrontEnd& front_end)
{
    if (cooked.cancelled) return;
    for (const ExpectationResult& check : checks) front_end.expectation(check);
    front_end.expectations_left_out(numbers.checks().size() - checks.size());
}

std::vector<std::string> missed_texts(const graph::Graph& graph,
                                      const std::vector<ExpectationResult>& checks)
{
    std::vector<std::string> texts;
    for (const ExpectationResult& check : checks) {
        if (!check.met) texts.push_back(missed_text(graph, check));
    }
    return texts;
}

// A graph without a node that writes files, cooked for nothing that its user would see.
void warn_of_no_output(const graph::Graph& graph, const CookRequest& request, Console& console)
{
    const bool wanted = request.writes && !request.profile && request.nodes.empty();
    if (!wanted || !graph.expectations.empty() || graph.nodes.empty()) return;
    for (const graph::Node& node : graph.nodes) {
        if (node.type->sink) return;
    }
    console.err << fmt::format(
        "warning: {}: no node writes a file: add WriteMesh, or Render and WriteImage\n",
        graph.file);
}

bool has(const std::vector<std::uint32_t>& nodes, std::uint32_t node)
{
    return std::find(nodes.begin(), nodes.end(), node) != nodes.end();
}

// The nodes at all frames.
std::vector<Want> wants_of(const std::vector<std::uint32_t>& nodes, const std::vector<int>& frames)
{
    std::vector<Want> wants;
    for (const int f : frames) {
        for (const std::uint32_t n : nodes) wants.push_back({n, f});
    }
    return wants;
}

// With --values, what gives a number as well as `nodes`, which come first.
std::vector<std::uint32_t> with_numbers(const graph::Graph& graph, const CookRequest& request,
                                        std::vector<std::uint32_t> nodes)
{
    if (!request.values) return nodes;
    for (const std::uint32_t n : nodes_with_numbers(graph)) {
        if (!has(nodes, n)) nodes.push_back(n);
    }
    return nodes;
}

bool give_numbers(const graph::Graph& graph, const std::vector<std::uint32_t>& nodes)
{
    const std::vector<std::uint32_t> all = nodes_with_numbers(graph);
    return std::any_of(all.begin(), all.end(), [&](std::uint32_t n) { return has(nodes, n); });
}

// The numbers that were asked for, whether they were made now or came from the cache: printed, and
// as a table, which is whole at the end alone.
void tell_numbers(const graph::Graph& graph, const CookRequest& request,
                  const std::vector<int>& frames, const std::vector<std::uint32_t>& nodes,
                  const Numbers& numbers, FrontEnd& front_end, Console& console)
{
    const std::vector<AskedNumber> asked = numbers.asked();
    if (!request.values) front_end.numbers(asked);
    const std::vector<graph::Link> columns = numbers.columns(graph, nodes);
    if (columns.empty() || !request.writes || !request.part.empty()) return;
    const fs::path path = output_folder(graph, request) / values_name;
    replace_text(path, values_table(graph, frames, columns, asked, console.unit_of));
    if (request.quiet || request.json) return;
    console.err << fmt::format("values: {} ({} frame{})\n", path.string(), frames.size(),
                               frames.size() == 1 ? "" : "s");
}

void write_profile(const graph::Graph& graph, const CookRequest& request, const Cooked& cooked,
                   const std::vector<Run>& runs, Console& console)
{
    if (request.profile) write_table(graph, cooked, console.out);
    if (request.trace.empty()) return;
    std::ofstream file(request.trace);
    write_trace(graph, runs, file);
    if (!file.flush()) throw std::runtime_error("can't write " + request.trace);
    console.out << "trace: " << request.trace << "\n";
}

}  // namespace

int cook_graph(const graph::Graph& graph, const CookRequest& request, Caches& caches,
               FrontEnd& front_end, Console& console, Manifest& manifest)
{
    const std::vector<int> frames = chosen_frames(graph, request);
    warn_of_no_output(graph, request, console);
    const std::vector<std::uint32_t> chosen = chosen_nodes(graph, request);
    const auto nodes = with_numbers(graph, request, chosen);
    std::vector<Want> wants = wants_of(nodes, frames);
    const bool part = !request.part.empty();
    Numbers numbers(graph, part ? std::vector<int>() : frames,
                    request.expectations_only && request.frames.empty(), wants);
    const Options options = options_of(graph, request, console);
    std::optional<FolderLock> lock;
    if (part) {
        make_output_folder(options.output_folder);
    } else if (!nodes.empty()) {
        lock_folder(lock, options.output_folder, request.writes,
                    request.writes && give_numbers(graph, nodes), console);
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
            if (!has(nodes, want.node) || graph.nodes[want.node].type->sink) return;
            if (has(chosen, want.node)) outputs.arrived(want, values, caches.names);
            numbers.asked(want, values, evaluator.keys().varies(want.node));
        });
    manifest.complete = !cooked.cancelled && cooked.failures == 0;
    outputs.finish(caches.files,
                   manifest.complete && frames.size() == std::size_t(graph.range.count()));
    const std::vector<ExpectationResult> checks = checked(numbers, cooked);
    manifest.missed = missed_texts(graph, checks);
    manifest.cards = outputs.cards(evaluator.keys());
    if (!nodes.empty()) {
        add_seconds(graph, cooked, manifest);
        manifest.ran = ran_here(cooked.seconds);
        write_manifest(part ? fs::path(request.part) : options.output_folder / manifest_name,
                       manifest, console);
    }
    if (request.writes) front_end.accuracy(manifest.cards);
    if (!cooked.cancelled) {
        tell_numbers(graph, request, frames, nodes, numbers, front_end, console);
    }
    show_expectations(checks, numbers, cooked, front_end);
    const int exit = exit_of(cooked, !manifest.missed.empty() && !request.record_missed);
    front_end.finished(cooked, exit);
    write_profile(graph, request, cooked, recorder.runs, console);
    return exit;
}

}  // namespace runtime
