// Parts: a cook that only looks (class Walk), why each node would run (class Reasons), and the
// report.

#include "runtime/commands/explain.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/cook/caches.hpp"
#include "runtime/cook/key_parts.hpp"
#include "runtime/cook/keys.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <ostream>
#include <set>

namespace runtime {

namespace {

namespace fs = std::filesystem;

// A cook that only looks: from what is wanted upward, stopping at what is stored.
class Walk {
public:
    Walk(const graph::Graph& graph, Keys& keys, Caches& caches)
        : graph_(graph), keys_(keys), caches_(caches)
    {}

    struct Found {
        std::set<int> cooked, kept;  // frames
        bool file_gone = false;      // it is stored, but a file that it wrote is not what it was
        bool unread = false;         // its files were never opened: its key is not known yet
    };
    std::map<std::uint32_t, Found> found;

    void from(std::uint32_t node, int frame)
    {
        want(node, frame);
        while (!todo_.empty()) {
            const auto [n, f] = todo_.back();
            todo_.pop_back();
            look(n, f);
        }
    }

private:
    void want(std::uint32_t n, int frame)
    {
        if (!keys_.varies(n)) frame = graph_.range.first;
        if (seen_.insert({n, frame}).second) todo_.emplace_back(n, frame);
    }

    bool kept(std::uint32_t n, int frame)
    {
        const graph::NodeType& type = *graph_.nodes[n].type;
        if (keys_.opens(n) && !keys_.known(n, frame)) {
            found[n].unread = true;
            return false;
        }
        const Key key = keys_.at(n, frame);
        if (!caches_.disk || !caches_.disk->holds(key)) return false;
        if (!type.sink) return true;
        const SharedResult result = caches_.disk->load(key, type);
        if (!result) return false;
        for (const Written& file : result->files) {
            if (caches_.files.of(file.path) == file.digest) continue;
            found[n].file_gone = true;
            return false;
        }
        return true;
    }

    void look(std::uint32_t n, int frame)
    {
        if (kept(n, frame)) {
            found[n].kept.insert(frame);
            return;
        }
        found[n].cooked.insert(frame);
        const graph::Node& node = graph_.nodes[n];
        for (std::size_t port = 0; port < node.inputs.size(); ++port) {
            for (const graph::Link& link : node.inputs[port]) {
                for (const int f : keys_.input_frames(n, port, frame)) want(link.node, f);
            }
        }
        const bool steps = keys_.rolls(n) && frame > graph_.range.first;
        if (steps) want(n, frame - 1);
    }

    const graph::Graph& graph_;
    Keys& keys_;
    Caches& caches_;
    std::set<std::pair<std::uint32_t, int>> seen_;
    std::vector<std::pair<std::uint32_t, int>> todo_;
};

// What of the graph's frames is not what it was, as far as the node depends on it.
std::vector<std::string> changes_of_frames(const graph::Node& node, const Manifest& was,
                                           const Manifest& is)
{
    using graph::Variable;
    std::vector<std::string> lines;
    if (!was.range || !is.range) return lines;
    const bool whole = declares(node, Variable::range) || node.type->gather_frames;
    const bool time = declares(node, Variable::frame) || !node.animated.empty();
    const auto compare = [&](const char* what, auto old, auto now, bool depends) {
        if (depends && old != now) lines.push_back(fmt::format("{} is {}, was {}", what, now, old));
    };
    compare("fps", was.range->fps, is.range->fps,
            time || declares(node, Variable::fps) || declares(node, Variable::range) ||
                declares(node, Variable::pace));
    compare("the first frame", was.range->first, is.range->first,
            time || whole || !node.type->previous.empty());
    compare("the last frame", was.range->last, is.range->last, whole);
    return lines;
}

// Why each node is not what it was in the last cook.
class Reasons {
public:
    Reasons(const graph::Graph& graph, const Manifest* last, const Manifest& now)
        : graph_(graph), last_(last), now_(now), changed_(graph.nodes.size(), 0)
    {
        for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
            const auto is = now.nodes.find(graph.nodes[n].name);
            if (!last || is == now.nodes.end()) continue;
            const auto was = last->nodes.find(graph.nodes[n].name);
            // Of a node that is new, the links to it tell.
            changed_[n] = was != last->nodes.end() &&
                          !changes_of(graph.nodes[n], was->second, is->second).empty();
            for (const auto& port : graph.nodes[n].inputs) {
                for (const graph::Link& link : port) {
                    if (changed_[link.node]) changed_[n] = 1;
                }
            }
        }
    }

    std::string of(std::uint32_t n, const Walk::Found& found, int frame) const
    {
        const graph::Node& node = graph_.nodes[n];
        if (!last_) return "no earlier cook is known";
        const auto was = last_->nodes.find(node.name);
        if (was == last_->nodes.end()) return "not part of the last cook";
        const Manifest::Node& is = now_.nodes.at(node.name);
        std::vector<std::string> all = changes_of(node, was->second, is);
        std::set<std::string> upstream;
        for (const auto& port : node.inputs) {
            for (const graph::Link& link : port) {
                if (changed_[link.node]) upstream.insert("'" + graph_.nodes[link.node].name + "'");
            }
        }
        if (!upstream.empty()) {
            all.push_back(fmt::format("input from {} changed", fmt::join(upstream, " and ")));
        }
        if (!all.empty()) return fmt::format("{}", fmt::join(all, "; "));
        if (last_->program != now_.program) return "cooked by another build of the program";
        if (found.unread) return "its files have not been read yet";
        return missing(found, was->second, node.type->sink, frame);
    }

private:
    std::vector<std::string> changes_of(const graph::Node& node, const Manifest::Node& was,
                                        const Manifest::Node& is) const
    {
        std::vector<std::string> all = changes(was, is);
        for (std::string& line : changes_of_frames(node, *last_, now_)) {
            all.push_back(std::move(line));
        }
        return all;
    }

    std::string missing(const Walk::Found& found, const Manifest::Node& was, bool sink,
                        int frame) const
    {
        if (found.file_gone) return "an output file is missing or was changed";
        if (!found.kept.empty()) {
            return fmt::format("unchanged; continues from frame {}, the nearest stored one",
                               *found.kept.rbegin());
        }
        const std::vector<int> frames = parse_frames(last_->frames);
        if (!std::binary_search(frames.begin(), frames.end(), frame) &&
            !found.cooked.contains(graph_.range.first)) {
            return fmt::format("the last cook covered frames {}", last_->frames);
        }
        if (!sink && was.seconds > 0 && !DiskCache::pays(was.seconds, 0)) {
            return fmt::format("unchanged, but not stored: cooking takes only {}",
                               was.seconds < 1e-3 ? fmt::format("{:.2g} ms", was.seconds * 1e3)
                                                  : format_seconds(was.seconds));
        }
        return "unchanged, but its result is not in the cache";
    }

    const graph::Graph& graph_;
    const Manifest* last_;
    const Manifest& now_;
    std::vector<char> changed_;
};

std::string frames_of(const std::set<int>& frames)
{
    return frames_text({frames.begin(), frames.end()});
}

// Looks at all that the targets depend on. Returns the names of those that gather many frames, of
// which this is one: of them, what they gather is looked at.
std::vector<std::string> walk_targets(const graph::Graph& graph,
                                      const std::vector<std::uint32_t>& targets, int frame,
                                      bool named, Walk& walk)
{
    std::vector<std::string> gathering;
    for (const std::uint32_t n : targets) {
        const bool gathers = static_cast<bool>(graph.nodes[n].type->gather_frames);
        if (!gathers || named) {
            walk.from(n, frame);
            continue;
        }
        gathering.push_back(graph.nodes[n].name);
        for (const auto& port : graph.nodes[n].inputs) {
            for (const graph::Link& link : port) {
                if (!graph.nodes[link.node].type->gather_frames) walk.from(link.node, frame);
            }
        }
    }
    return gathering;
}

std::string title_of(const graph::Node& node)
{
    return fmt::format("{} ({})", node.name, node.type->name);
}

// A line for each node that was looked at. Returns how many would cook.
std::size_t tell_nodes(const graph::Graph& graph, Keys& keys, const Walk& walk,
                       const Reasons& reasons, int frame, std::ostream& out)
{
    std::size_t cooked = 0, kept = 0, width = 0;
    for (const auto& [n, found] : walk.found) {
        found.cooked.empty() ? ++kept : ++cooked;
        width = std::max(width, title_of(graph.nodes[n]).size());
    }
    out << fmt::format("{} at frame {}: {} would cook, {} from the cache, {} not needed\n",
                       graph.file, frame, cooked == 1 ? "1 node" : fmt::format("{} nodes", cooked),
                       kept, graph.nodes.size() - cooked - kept);
    for (const auto& [n, found] : walk.found) {
        const std::string title = title_of(graph.nodes[n]);
        const bool many = found.cooked.size() > 1;
        if (!found.cooked.empty()) {
            out << fmt::format("  cook  {:<{}}  {}{}\n", title, width,
                               many ? "frames " + frames_of(found.cooked) + ": " : "",
                               reasons.of(n, found, frame));
        } else {
            out << fmt::format("  keep  {:<{}}  stored{}\n", title, width,
                               keys.varies(n) ? ", frame " + frames_of(found.kept) : "");
        }
    }
    return cooked;
}

}  // namespace

int explain(const CookRequest& request, int frame, const graph::Registry& registry,
            Console& console)
{
    const auto graph = load(request.files.at(0), request, registry, console);
    if (!graph) return exit_usage;
    require_frame(*graph, frame);
    Caches caches;
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    const fs::path folder = output_folder(*graph, request);
    Keys keys(*graph, caches.files, caches.side_files, {console.salt, folder});
    // The keys are those of a whole cook: what gathers frames would gather all.
    const std::vector<std::uint32_t> targets = chosen_nodes(*graph, request);
    CookRequest all = request;
    all.frames.clear();
    keys.aim(targets, chosen_frames(*graph, all));
    Manifest now;
    now.program = to_hex(console.salt);
    describe_graph(*graph, keys, {frame}, caches.files, now);
    std::optional<Manifest> last;
    const fs::path manifest = folder / manifest_name;
    if (fs::exists(manifest)) last = read_manifest(manifest);

    Walk walk(*graph, keys, caches);
    const std::vector<std::string> gathering =
        walk_targets(*graph, targets, frame, !request.nodes.empty(), walk);
    const Reasons reasons(*graph, last ? &*last : nullptr, now);
    const std::size_t cooked = tell_nodes(*graph, keys, walk, reasons, frame, console.out);
    for (const std::string& name : gathering) {
        console.out << fmt::format(
            "  '{}' gathers many frames; only this one was examined (--node {} examines all)\n",
            name, name);
    }
    console.out << (last ? fmt::format("compared with the cook in {}\n", manifest.string())
                         : fmt::format("no {} to compare with\n", manifest.string()));
    if (cooked > 0) {
        console.out << "(a node is skipped after all if its inputs come out unchanged)\n";
    }
    return exit_ok;
}

void add_explain_command(const CommandSet& set)
{
    CLI::App* explain_app = set.app.add_subcommand(
        "explain", "Shows which nodes a cook of one frame would run, and why");
    add_file(*explain_app, set.request);
    const auto frame = std::make_shared<int>(0);
    explain_app->add_option("--frame", *frame, "Frame to explain")->required()->type_name("N");
    add_loading_options(*explain_app, set.request);
    add_cache_options(*explain_app, set.request);
    explain_app
        ->add_option("--out", set.request.output_folder,
                     "Output folder of the last cook (default: out/<graph>)")
        ->type_name("DIR");
    add_repeatable(*explain_app, "--node", set.request.nodes,
                   "Explains a cook of only this node; repeatable", "NAME");
    explain_app->callback(
        [&set, frame] { set.exit = explain(set.request, *frame, set.registry, set.console); });
}

}  // namespace runtime
