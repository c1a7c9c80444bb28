#pragma once

// The state of one cook, between the first want and the last result. The functions that work on it
// stand in the files beside this one:
//
//   open_tasks   from what is wanted up to what it depends on            lock held
//   end_tasks    from what is done or failed down to what waits for it   lock held
//   run_task     one run of a node                                       lock not held
//   cook_events  what observers are told                                 lock not held
//   cooking      the threads that take tasks, run them and end them
//
// "The lock" is `mutex`. A running task belongs to the thread that runs it; of all other state that
// a run reads, the graph, the keys and the results do not change while a cook goes on, and the
// caches guard themselves (all but `memory` and `same`, which need the lock).

#include "runtime/cook/caches.hpp"
#include "runtime/cook/cook_options.hpp"
#include "runtime/cook/cooked.hpp"
#include "runtime/cook/keys.hpp"
#include "runtime/cook/task.hpp"
#include "runtime/cook/warners.hpp"

#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <deque>
#include <mutex>
#include <queue>
#include <unordered_set>
#include <variant>

namespace runtime {

// What observers will be told, in this order.
struct ArrivedEvent {
    std::uint32_t want;
    SharedResult result;
    std::size_t done;  // wants, this one included
};
struct WroteEvent {
    std::uint32_t node;
    int frame;
    Written file;
};
using ToldEvent = std::shared_ptr<const Told>;
using CookEvent = std::variant<ArrivedEvent, WroteEvent, ToldEvent, Warning, Failure, Run>;

// What a cook works with and does not own.
struct CookTools {
    const graph::Graph& graph;
    Caches& caches;
    const Options& options;
    Observer* observer;  // may be null
    Keys& keys;
    std::vector<Usual>& usual;  // by type of node
    tbb::task_arena& arena;
    const Arrived& arrived;
};

struct CookState : CookTools {
    CookState(const CookTools& tools, std::vector<int> frames)
        : CookTools(tools), threads(arena.max_concurrency()),
          shared(std::make_shared<graph::Cook>(std::move(frames))), warners(graph, keys)
    {
        cooked.tallies = Tallies(graph.nodes.size());
        usual.resize(keys.type_count());
    }

    const int threads;
    const std::shared_ptr<graph::Cook> shared;  // what all nodes of this cook may look at
    const Clock::time_point start = Clock::now();

    std::mutex mutex;  // guards what follows

    std::vector<Want> wants;  // lowest frame first
    std::size_t next_want = 0, in_flight = 0, at_once = 1;
    std::priority_queue<Demand> demands;

    std::deque<Task> tasks;
    std::vector<std::uint32_t> free;  // places of tasks
    KeyTable table;                   // into tasks
    std::unordered_set<Key, KeyHash> failed;
    std::vector<Task*> unsettled;  // to be looked up, or to climb on
    std::priority_queue<Ready> ready;

    int running = 0, brief_running = 0, workers = 0;
    bool first_here = true;  // the first worker is between tasks or runs a brief one
    bool stopping = false;
    std::exception_ptr fatal;

    Warners warners;
    std::unordered_set<Key, KeyHash> told;  // by the results that it is told of
    std::vector<CookEvent> events;          // not told yet
    Cooked cooked;
    tbb::task_group group;

    std::mutex reporting;  // guards what follows; taken before `mutex`
    double repeating_seconds = 0, busy_seconds = 0;
};

}  // namespace runtime
