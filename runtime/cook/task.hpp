#pragma once

// A task is one result on its way: wanted, looked up in the caches, or made by running its node.
// Here is its plain state, and what one run of it gave.
//
//            look_up()
//   fresh ──────┬─ in memory ──────────────────────────────────────────────────> done
//               ├─ on disk ─────────────────────────> ready ──> running: load ──> done
//               └─ in neither: begin_task()                        └ gone: begin_task()
//                       │
//          a simulation ├──> staged   follows its own past up, a frame at a time, until the
//                       │      │      frame before is about to run
//                       v      v
//                     expand()        wants all inputs
//                       │
//                       v    the last input arrived
//                    waiting ───────────────────────> ready ──> running
//                       ^                                          ├─ its inputs' contents were
//                       │  wants its preparations too              │  met before ───────> done
//                       ├──────────────────────────────────────────┤ they were not
//                                                                  └─ the node ran ─────> done
//
//   failed: its run threw, or something before it failed.   dropped: nobody needs it any more.

#include "graph/document/graph.hpp"
#include "runtime/cache/result.hpp"
#include "runtime/cook/observer.hpp"
#include "runtime/cook/short_list.hpp"

#include <chrono>
#include <optional>
#include <set>
#include <tuple>

namespace runtime {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

enum class TaskState : std::uint8_t {
    fresh,    // not looked up
    staged,   // missed; follows its own past up until the frame before is about to run
    waiting,  // for inputs
    ready,
    running,
    done,
    failed,   // or blocked by something that did
    dropped,  // nobody needs it any more
};

struct Task {
    Key key;
    std::uint32_t node = 0;
    int frame = 0;
    int preparation = -1;       // which of the node's, or -1 for the node itself
    std::uint32_t place = 0;    // in the tasks of the cook
    std::uint32_t missing = 0;  // inputs that have not arrived
    std::uint32_t users = 0;    // inputs of tasks, and wants, that need the result
    TaskState state = TaskState::fresh;
    bool load = false;               // from disk, instead of running
    bool compare = false;            // by the inputs' contents, before it runs
    Task* previous = nullptr;        // the frame before; of a staged task, one further back
    ShortList<Task*> inputs;         // by port, link and frame; then preparations
    ShortList<Task*> dependants;     // to be told when this is done
    ShortList<Task*> followers;      // staged tasks that have come up to this one
    ShortList<std::uint32_t> wants;  // by their place among the wants of the cook
    SharedResult result;
    double usual = 0;       // s, that nodes of its type take; 0 when not known
    Key same;               // its key by content, once known
    SharedResult expected;  // what a recheck must come to
};

// About what it takes to hash a few inputs, or to wake a thread.
inline constexpr double brief_seconds = 20e-6;

inline bool quick(const Task& task)
{
    return task.usual > 0 && task.usual < brief_seconds;
}

// Lowest frame first; at one frame simulations first, because the next frame waits for them, and
// sinks last.
struct Ready {
    int frame;
    int rank;
    std::uint32_t node;
    Task* task;
    bool operator<(const Ready& other) const
    {
        return std::tie(frame, rank, node) > std::tie(other.frame, other.rank, other.node);
    }
};

// A gathering node's input at one frame, opened when its frame's turn comes.
struct Demand {
    int frame;
    Task* task;
    std::size_t slot;  // into Task::inputs
    graph::Link link;
    bool operator<(const Demand& other) const { return frame > other.frame; }
};

// What one run made: a result, or why there is none.
struct Outcome {
    SharedResult result;
    std::optional<std::string> failure;
    bool cancelled = false;
    bool absent = false;  // it was to be loaded and could not be
    bool equal = false;   // the inputs' contents were met before, and so was the result
    bool other = false;   // they were not, and there are preparations to make first
    Key same;             // key by content
    bool store = false;   // on disk
    std::set<std::filesystem::path> opened;  // files, beside those its parameters name
    Run run;
};

}  // namespace runtime
