#include "runtime/explain.hpp"

#include <fmt/format.h>

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
        const auto& openers = keys_.openers();
        if (std::binary_search(openers.begin(), openers.end(), n) && !keys_.known(n, frame)) {
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
        const bool steps = !node.type->previous.empty() && frame > graph_.range.first;
        if (steps) want(n, frame - 1);
    }

    const graph::Graph& graph_;
    Keys& keys_;
    Caches& caches_;
    std::set<std::pair<std::uint32_t, int>> seen_;
    std::vector<std::pair<std::uint32_t, int>> todo_;
};

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
            changed_[n] = was != last->nodes.end() && !changes(was->second, is->second).empty();
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
        if (!last_) return "nothing is known of an earlier cook";
        const auto was = last_->nodes.find(node.name);
        if (was == last_->nodes.end()) return "it was not part of the last cook";
        const Manifest::Node& is = now_.nodes.at(node.name);
        std::vector<std::string> all = changes(was->second, is);
        std::set<std::string> upstream;
        for (const auto& port : node.inputs) {
            for (const graph::Link& link : port) {
                if (changed_[link.node]) upstream.insert("'" + graph_.nodes[link.node].name + "'");
            }
        }
        if (!upstream.empty()) {
            all.push_back(
                fmt::format("what it gets from {} changed", fmt::join(upstream, " and ")));
        }
        if (!all.empty()) return fmt::format("{}", fmt::join(all, "; "));
        if (last_->program != now_.program) return "the program is another build";
        if (found.unread) return "its files were not read yet";
        return missing(found, was->second, node.type->sink, frame);
    }

private:
    std::string missing(const Walk::Found& found, const Manifest::Node& was, bool sink,
                        int frame) const
    {
        if (found.file_gone) return "a file that it wrote is gone or was changed";
        if (!found.kept.empty()) {
            return fmt::format("unchanged; goes on from frame {}, the nearest that is stored",
                               *found.kept.rbegin());
        }
        const std::vector<int> frames = parse_frames(last_->frames);
        if (!std::binary_search(frames.begin(), frames.end(), frame) &&
            !found.cooked.contains(graph_.range.first)) {
            return fmt::format("the last cook was of frames {}", last_->frames);
        }
        if (!sink && was.seconds > 0 && !DiskCache::pays(was.seconds, 0)) {
            return fmt::format("unchanged, but not stored: cooking it takes {}, reading it would "
                               "not be quicker",
                               was.seconds < 1e-3 ? fmt::format("{:.2g} ms", was.seconds * 1e3)
                                                  : format_seconds(was.seconds));
        }
        return "unchanged, but its result is not in the cache (any more)";
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

}  // namespace

int explain(const CookRequest& request, int frame, const graph::Registry& registry,
            Console& console)
{
    const auto graph = load(request.files.at(0), request, registry, console);
    if (!graph) return exit_usage;
    if (frame < graph->range.first || frame > graph->range.last) {
        throw std::invalid_argument(fmt::format("{} has frames {} to {}; frame {} is none of them",
                                                graph->file, graph->range.first, graph->range.last,
                                                frame));
    }
    Caches caches;
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    const fs::path folder = output_folder(*graph, request);
    Keys keys(*graph, caches.files, caches.side_files, {console.salt, folder});
    // The keys are those of a whole cook: what gathers frames would gather all.
    std::vector<std::uint32_t> targets = chosen_nodes(*graph, request);
    CookRequest all = request;
    all.frames.clear();
    const std::vector<int> frames = chosen_frames(*graph, all);
    keys.aim(targets, frames);
    Manifest now;
    now.program = to_hex(console.salt);
    describe_graph(*graph, keys, {frame}, caches.files, now);

    std::optional<Manifest> last;
    if (fs::exists(folder / manifest_name)) last = read_manifest(folder / manifest_name);

    Walk walk(*graph, keys, caches);
    std::vector<std::string> gathering;
    for (const std::uint32_t n : targets) {
        const bool gathers = static_cast<bool>(graph->nodes[n].type->gather_frames);
        if (gathers && request.nodes.empty()) {
            gathering.push_back(graph->nodes[n].name);
            for (const auto& port : graph->nodes[n].inputs) {
                for (const graph::Link& link : port) {
                    if (!graph->nodes[link.node].type->gather_frames) walk.from(link.node, frame);
                }
            }
        } else {
            walk.from(n, frame);
        }
    }
    const Reasons reasons(*graph, last ? &*last : nullptr, now);
    std::size_t cooked = 0, kept = 0, width = 0;
    for (const auto& [n, found] : walk.found) {
        found.cooked.empty() ? ++kept : ++cooked;
        width =
            std::max(width, graph->nodes[n].name.size() + graph->nodes[n].type->name.size() + 3);
    }
    console.out << fmt::format("{} at frame {}: {} would cook, {} taken from the cache, {} not "
                               "looked at\n",
                               graph->file, frame,
                               cooked == 1 ? "1 node" : fmt::format("{} nodes", cooked), kept,
                               graph->nodes.size() - cooked - kept);
    for (const auto& [n, found] : walk.found) {
        const graph::Node& node = graph->nodes[n];
        const std::string name = fmt::format("{} ({})", node.name, node.type->name);
        const bool many = found.cooked.size() > 1;
        if (!found.cooked.empty()) {
            console.out << fmt::format("  cook  {:<{}}  {}{}\n", name, width,
                                       many ? "frames " + frames_of(found.cooked) + ": " : "",
                                       reasons.of(n, found, frame));
        } else {
            console.out << fmt::format("  keep  {:<{}}  stored{}\n", name, width,
                                       keys.varies(n) ? ", frame " + frames_of(found.kept) : "");
        }
    }
    for (const std::string& name : gathering) {
        console.out << fmt::format(
            "  '{}' gathers many frames, this one looked at; --node {} looks at all\n", name, name);
    }
    console.out << (last ? fmt::format("compared with the cook in {}\n",
                                       (folder / manifest_name).string())
                         : fmt::format("there is no {} yet to compare with\n",
                                       (folder / manifest_name).string()));
    if (cooked > 0) {
        console.out << "(a node whose inputs come out with the bytes they had is not cooked again "
                       "after all)\n";
    }
    return exit_ok;
}

}  // namespace runtime
