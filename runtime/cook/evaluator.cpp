#include "runtime/cook/evaluator.hpp"

#include "runtime/cook/below_folder.hpp"
#include "runtime/cook/cooking.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <thread>
#include <tuple>
#include <unordered_set>

namespace runtime {

using graph::Value;

Evaluator::Evaluator(const graph::Graph& graph, Caches& caches, Options options, Observer* observer)
    : graph_(graph), caches_(caches), options_(std::move(options)), observer_(observer),
      keys_(graph, caches.files, caches.side_files, {options_.salt, options_.output_folder})
{
    // Results of sinks name their files, and outlive this process and its working folder.
    options_.output_folder = resolved(options_.output_folder);
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        for (const auto& port : graph.nodes[n].inputs) {
            for (const graph::Link& link : port) {
                if (link.node < n) continue;
                throw std::invalid_argument("node '" + graph.nodes[n].name +
                                            "' comes before one of its inputs");
            }
        }
    }
    const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    const int threads = options_.threads > 0 ? options_.threads : cores;
    threads_ = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                     static_cast<std::size_t>(threads));
    arena_ = std::make_unique<tbb::task_arena>(threads);
}

Evaluator::~Evaluator() = default;

std::vector<int> Evaluator::aim(const std::vector<Want>& wants)
{
    std::vector<std::uint32_t> targets;
    std::vector<int> frames;
    for (const Want& w : wants) {
        if (w.frame < graph_.range.first) {
            throw std::invalid_argument("frame " + std::to_string(w.frame) +
                                        " is before the first frame, " +
                                        std::to_string(graph_.range.first));
        }
        targets.push_back(w.node), frames.push_back(w.frame);
    }
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    std::sort(targets.begin(), targets.end());
    targets.erase(std::unique(targets.begin(), targets.end()), targets.end());
    keys_.aim(targets, frames);
    find_side_files(targets, frames);
    return frames;
}

Cooked Evaluator::cook(std::vector<Want> wants, const Arrived& arrived)
{
    std::vector<int> frames = aim(wants);
    std::sort(wants.begin(), wants.end(), [](const Want& a, const Want& b) {
        return std::tie(a.frame, a.node) < std::tie(b.frame, b.node);
    });
    std::unordered_set<std::uint32_t> seen;
    std::erase_if(
        wants, [&](const Want& w) { return !keys_.varies(w.node) && !seen.insert(w.node).second; });
    const std::size_t a_frame =
        (wants.size() + frames.size()) / std::max<std::size_t>(frames.size(), 1);
    CookState state({graph_, caches_, options_, observer_, keys_, usual_, *arena_, arrived},
                    std::move(frames));
    return run_cook(state, std::move(wants), frames_ahead() * a_frame);
}

// How many frames are begun before the first is done.
std::size_t Evaluator::frames_ahead() const
{
    return static_cast<std::size_t>(std::max(4, 2 * arena_->max_concurrency()));
}

// Keys of what depends on a node that opens side files are known only when it has run once.
void Evaluator::find_side_files(const std::vector<std::uint32_t>& targets,
                                const std::vector<int>& frames)
{
    bool ran = false;
    Options options = options_;
    options.keep_going = true;
    for (const std::uint32_t n : std::vector<std::uint32_t>(keys_.openers())) {
        std::vector<int> unknown;
        for (const int frame : frames) {
            if (!keys_.known(n, frame)) unknown.push_back(frame);
            if (!keys_.varies(n)) break;
        }
        if (unknown.empty()) continue;
        std::vector<Want> wants;
        for (const int frame : unknown) wants.push_back({n, frame});
        const Arrived nobody;
        CookState state({graph_, caches_, options, nullptr, keys_, usual_, *arena_, nobody},
                        unknown);
        run_cook(state, std::move(wants), frames_ahead());
        keys_.edited(n);
        keys_.aim(targets, frames);
        ran = true;
    }
    if (ran) keys_.aim(targets, frames);
}

Value Evaluator::pull(graph::Link link, int frame)
{
    Value value;
    std::string cause;
    struct Listener : Observer {
        std::string first;
        const graph::Graph& graph;
        explicit Listener(const graph::Graph& g) : graph(g) {}
        void failed(const Failure& f) override
        {
            if (first.empty()) first = describe(graph, f);
        }
    } listener(graph_);
    Observer* const before = std::exchange(observer_, &listener);
    const Cooked cooked = cook({{link.node, frame}}, [&](const Want&, std::span<const Value> all) {
        value = all[link.output];
    });
    observer_ = before;
    if (cooked.done == 1) return value;
    throw std::runtime_error(cooked.cancelled ? "cancelled" : listener.first);
}

std::string describe(const graph::Graph& graph, const Failure& failure)
{
    const graph::Node& node = graph.nodes[failure.node];
    std::string text;
    if (node.place.line > 0) {
        text = node.place.file + ":" + std::to_string(node.place.line) + ":" +
               std::to_string(node.place.column) + ": ";
    }
    return text + "'" + node.name + "' (" + node.type->name + ") failed at frame " +
           std::to_string(failure.frame) + ": " + failure.what;
}

}  // namespace runtime
