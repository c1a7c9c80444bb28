#pragma once

// Cooks a graph: what is wanted, from the caches where they hold it, by running nodes where not.
//
//   want ──> look up ──hit──────────────────────────────────────────────> done
//               └─miss──> want what it depends on ──> compare ──equal───> done
//                                                        └─not──> run ──> done
//
// To compare is to look up again, by the bytes of the inputs instead of their keys: an edit that
// changes nothing of what a node makes stops there.
// Equal keys are one task, so a held keyframe or a static branch is cooked once. Nothing recurses:
// a chain of any depth is a list of waiting tasks. A simulation asked for one late frame goes down
// its own past only, and wants the rest of a frame's inputs when the frame before is about to run.
// Frames are opened in order and few at a time, and a result leaves its task when the last task
// that needs it has run; the memory cache alone decides what stays.

#include "runtime/cook/caches.hpp"
#include "runtime/cook/cook_options.hpp"
#include "runtime/cook/cooked.hpp"
#include "runtime/cook/keys.hpp"
#include "runtime/cook/observer.hpp"

namespace tbb::detail::d1 {
class global_control;
class task_arena;
}  // namespace tbb::detail::d1

namespace runtime {

class Evaluator {
public:
    // The graph may be edited between cooks, see edited(). Throws std::invalid_argument when its
    // nodes do not stand in order.
    Evaluator(const graph::Graph& graph, Caches& caches, Options options,
              Observer* observer = nullptr);
    ~Evaluator();

    // Makes the keys of all that is wanted, from the files as they are now: what cook() does first,
    // for those who ask for keys before it. Returns the frames, each once, in order.
    std::vector<int> aim(const std::vector<Want>& wants);

    // Cooks all that is wanted; the frames are those of this cook. `arrived` is called as an
    // observer is. A node that is the same at all frames arrives once, at the first one wanted.
    Cooked cook(std::vector<Want> wants, const Arrived& arrived = {});

    // One value at one frame. Throws std::runtime_error with the cause when it could not be made.
    graph::Value pull(graph::Link link, int frame);

    // Tells that a parameter or link of the graph's node `n` is another one now.
    void edited(std::uint32_t n) { keys_.edited(n); }

    Keys& keys() { return keys_; }
    const graph::Graph& graph() const { return graph_; }

private:
    std::size_t frames_ahead() const;
    void find_side_files(const std::vector<std::uint32_t>& targets, const std::vector<int>& frames);

    const graph::Graph& graph_;
    Caches& caches_;
    Options options_;
    Observer* observer_;
    Keys keys_;
    std::vector<Usual> usual_;  // by type of node
    std::unique_ptr<tbb::detail::d1::global_control> threads_;
    std::unique_ptr<tbb::detail::d1::task_arena> arena_;
};

// "chair.mesh failed at frame 7: ..." with the place of the node in its document, for people.
std::string describe(const graph::Graph& graph, const Failure& failure);

}  // namespace runtime
