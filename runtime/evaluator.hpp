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

#include "runtime/disk_cache.hpp"
#include "runtime/keys.hpp"
#include "runtime/observer.hpp"

#include <deque>
#include <stop_token>

namespace tbb::detail::d1 {
class global_control;
class task_arena;
}  // namespace tbb::detail::d1

namespace runtime {

// What several graphs cooked by one process share. Used by one cook at a time.
struct Caches {
    MemoryCache memory{std::size_t{1} << 30};
    FileDigests files;
    SideFiles side_files;
    std::unique_ptr<DiskCache> disk;  // null: nothing outlives the process
    ContentNames names;
    std::unordered_map<Key, Key, KeyHash> same;  // keys by content (Keys::by_content) to keys
};

struct Options {
    int threads = 0;          // 0: one a core
    bool keep_going = false;  // cook what does not depend on a failed node
    std::filesystem::path output_folder = ".";
    std::stop_token stop;  // set: no node starts any more, and those that run may give up
    Key salt;              // what all results depend on: which program this is
    // Share of the results found in a cache that are made again all the same; one that differs from
    // what was stored is a failure. The seed says which.
    double recheck = 0;
    std::uint64_t recheck_seed = 0;
};

struct Want {
    std::uint32_t node = 0;
    int frame = 0;
    auto operator<=>(const Want&) const = default;
};

// How often a node ran and what that took, in one cook; preparations included.
struct Tally {
    std::size_t runs = 0, hits = 0, loads = 0, failures = 0, blocked = 0;
    std::size_t equal = 0;      // results taken over because all inputs came out as before
    std::size_t rechecked = 0;  // of the hits and loads: made again and compared
    double seconds = 0;
    std::size_t bytes = 0;  // of all results that it made

    std::size_t found() const { return hits + loads + equal; }
};

// Of all nodes of a graph; those that had nothing to do take no room.
class Tallies {
public:
    Tallies() = default;
    explicit Tallies(std::size_t nodes) : places_(nodes, 0) {}

    Tally& of(std::uint32_t node)
    {
        std::uint32_t& place = places_[node];
        if (place == 0) {
            all_.emplace_back();
            place = static_cast<std::uint32_t>(all_.size());
        }
        return all_[place - 1];
    }
    const Tally& operator[](std::size_t node) const
    {
        static const Tally nothing;
        return places_[node] == 0 ? nothing : all_[places_[node] - 1];
    }
    // Of the nodes that had something to do.
    auto begin() const { return all_.begin(); }
    auto end() const { return all_.end(); }

private:
    std::vector<std::uint32_t> places_;  // into all_, from 1
    std::deque<Tally> all_;
};

struct Cooked {
    std::size_t done = 0;  // wants that arrived
    std::size_t failures = 0, blocked = 0;
    bool cancelled = false;
    Tallies tallies;
    double seconds = 0;
};

// What runs of a type of node take, as far as this process knows; 0 when not known yet.
struct Usual {
    double mean = 0;     // s, of the last few
    double longest = 0;  // s, of the last, those before them counting for less
};

class Evaluator {
public:
    // The graph may be edited between cooks, see edited(). Throws std::invalid_argument when its
    // nodes do not stand in order.
    Evaluator(const graph::Graph& graph, Caches& caches, Options options,
              Observer* observer = nullptr);
    ~Evaluator();

    using Arrived = std::function<void(const Want&, std::span<const graph::Value>)>;

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
