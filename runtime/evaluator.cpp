#include "runtime/evaluator.hpp"

#include "graph/standard_wires.hpp"
#include "runtime/few.hpp"
#include "runtime/memory_limit.hpp"
#include "runtime/warners.hpp"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <chrono>
#include <mutex>
#include <queue>
#include <thread>

namespace runtime {

using graph::Value;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

enum class State : std::uint8_t {
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
    int preparation = -1;
    std::uint32_t place = 0;    // in the tasks of the cook
    std::uint32_t missing = 0;  // inputs that have not arrived
    std::uint32_t users = 0;    // inputs of tasks, and wants, that need the result
    State state = State::fresh;
    bool load = false;         // from disk, instead of running
    bool compare = false;      // by the inputs' contents, before it runs
    Task* previous = nullptr;  // the frame before; of a staged task, one further back
    Few<Task*> inputs;         // by port, link and frame; then preparations
    Few<Task*> dependants;     // to be told when this is done
    Few<Task*> followers;      // staged tasks that have come up to this one
    Few<std::uint32_t> wants;
    SharedResult result;
    double usual = 0;       // s, that nodes of its type take; 0 when not known
    Key same;               // its key by content, once known
    SharedResult expected;  // what a recheck must come to
};

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
    std::set<std::filesystem::path> opened;
    Run run;
};

// Buffers that a worker uses for one run after the other.
struct Scratch {
    std::vector<std::vector<Value>> inputs;
    std::vector<Value> previous;
    std::vector<std::shared_ptr<const void>> prepared;

    void clear()
    {
        for (auto& port : inputs) port.clear();
        previous.clear(), prepared.clear();
    }
};

std::string text_of(const std::exception_ptr& error)
{
    try {
        std::rethrow_exception(error);
    } catch (const std::bad_alloc&) {
        return out_of_memory();
    } catch (const std::length_error& e) {  // a container that no memory could hold
        return out_of_memory() + " (" + e.what() + ")";
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "an exception that is no std::exception";
    }
}

}  // namespace

// One cook: the state between the first want and the last result.
class Cooking {
public:
    Cooking(const graph::Graph& graph, Caches& caches, const Options& options, Observer* observer,
            Keys& keys, std::vector<Usual>& usual, tbb::task_arena& arena,
            const Evaluator::Arrived& arrived, std::vector<int> frames)
        : graph_(graph), caches_(caches), options_(options), observer_(observer), keys_(keys),
          usual_(usual), arena_(arena), arrived_(arrived), threads_(arena.max_concurrency()),
          cook_(std::make_shared<graph::Cook>(std::move(frames))), warners_(graph, keys)
    {
        cooked_.tallies = Tallies(graph.nodes.size());
        usual_.resize(keys.type_count());
    }

    Cooked cook(std::vector<Want> wants, std::size_t at_once)
    {
        wants_ = std::move(wants);
        at_once_ = at_once;
        arena_.execute([this] {
            {
                const std::lock_guard lock(mutex_);
                guarded([this] { open(); });
                ++workers_;
            }
            work(true);
            group_.wait();
        });
        report();
        if (fatal_) std::rethrow_exception(fatal_);
        cooked_.seconds = seconds_since(start_);
        return std::move(cooked_);
    }

    const std::vector<Failure>& failures() const { return failures_; }

private:
    // ---- all below with mutex_ held, unless it says otherwise

    Task& want(const Key& key, std::uint32_t node, int frame, int preparation = -1)
    {
        if (Task* const known = find(key)) {
            ++known->users;
            return *known;
        }
        if (free_.empty()) {
            free_.push_back(static_cast<std::uint32_t>(tasks_.size()));
            tasks_.emplace_back();
        }
        const std::uint32_t place = free_.back();
        table_.insert(key, place);
        free_.pop_back();
        Task& task = tasks_[place];
        task.key = key, task.node = node, task.frame = frame, task.preparation = preparation;
        task.place = place;
        task.users = 1;
        unsettled_.push_back(&task);
        return task;
    }

    Task* find(const Key& key)
    {
        const std::uint32_t place =
            table_.find(key, [this](std::uint32_t p) { return tasks_[p].key; });
        return place == KeyTable::none ? nullptr : &tasks_[place];
    }

    // Nobody can want it any more.
    void forget(Task& task)
    {
        table_.erase(task.key, task.place);
        // Lists may still name one that came to nothing: its place stays its own.
        if (task.state != State::done) return;
        free_.push_back(task.place);
        task = {};
    }

    // Opens wants and demands, lowest frame first, as long as few enough are under way. Those in
    // flight may wait for demands that are not open yet: then nothing runs, and one more is opened.
    void open()
    {
        settle();
        for (;;) {
            const bool more = next_want_ < wants_.size() || !demands_.empty();
            const bool idle = ready_.empty() && running_ == 0;
            if (!more || stopping_ || (in_flight_ >= at_once_ && !idle)) return;
            const bool demand =
                next_want_ == wants_.size() ||
                (!demands_.empty() && demands_.top().frame < wants_[next_want_].frame);
            demand ? open_demand() : open_want();
            settle();
        }
    }

    void open_want()
    {
        const Want& w = wants_[next_want_];
        Task& task = want(keys_.at(w.node, w.frame), w.node, w.frame);
        const auto index = static_cast<std::uint32_t>(next_want_++);
        ++in_flight_;
        if (task.state == State::done) {
            deliver(index, task.result);
            release(&task);
        } else if (task.state == State::failed) {
            --in_flight_;
            release(&task);
        } else {
            task.wants.push_back(index);
        }
    }

    void open_demand()
    {
        const Demand demand = demands_.top();
        demands_.pop();
        if (demand.task->state != State::waiting) return;
        Task& input =
            want(keys_.at(demand.link.node, demand.frame), demand.link.node, demand.frame);
        demand.task->inputs[demand.slot] = &input;
        if (input.state == State::done) {
            told(*demand.task);
        } else if (input.state == State::failed) {
            block(*demand.task);
        } else {
            input.dependants.push_back(demand.task);
        }
    }

    void settle()
    {
        while (!unsettled_.empty()) {
            Task& task = *unsettled_.back();
            unsettled_.pop_back();
            if (task.state == State::fresh)
                look_up(task);
            else if (task.state == State::staged)
                climb(task);
        }
    }

    void look_up(Task& task)
    {
        if (failed_.contains(task.key)) return block(task);
        if (SharedResult found = caches_.memory.find(task.key); found && still_there(*found)) {
            if (task.preparation < 0) ++cooked_.tallies.of(task.node).hits;
            if (!rechecked(task)) return arrive(task, std::move(found));
            task.expected = std::move(found);
            return begin(task);
        }
        if (task.preparation >= 0) return expand(task);
        if (caches_.disk && storable(task.node) && caches_.disk->holds(task.key)) {
            task.load = true;
            return make_ready(task);
        }
        begin(task);
    }

    static bool stored(const graph::OutputPort& port) { return port.wire && port.wire->encode; }
    bool storable(std::uint32_t node) const
    {
        const auto& outputs = graph_.nodes[node].type->outputs;
        return std::all_of(outputs.begin(), outputs.end(), stored);
    }

    // Whether a result that was found is to be made again.
    bool rechecked(const Task& task) const
    {
        if (options_.recheck <= 0 || task.preparation >= 0 || !storable(task.node)) return false;
        const std::uint64_t draw = (task.key.high ^ options_.recheck_seed) * 0x9e3779b97f4a7c15u;
        return static_cast<double>(draw >> 11) * 0x1p-53 < options_.recheck;
    }

    // A node that no cache knows. Its own past comes first, from the last frame of it that is there
    // or under way: what lies between is opened a frame at a time on the way up.
    void begin(Task& task)
    {
        const graph::NodeType& type = *graph_.nodes[task.node].type;
        if (type.previous.empty() || task.frame == graph_.range.first) return expand(task);
        if (!task.previous) {
            int frame = task.frame - 1;
            while (frame > graph_.range.first && !at_hand(task.node, frame)) --frame;
            task.previous = &want(keys_.at(task.node, frame), task.node, frame);
        }
        task.state = State::staged;
        climb(task);
    }

    // Whether there is no need to look further back than this frame of a simulation.
    bool at_hand(std::uint32_t node, int frame)
    {
        const Key& key = keys_.at(node, frame);
        return find(key) || caches_.memory.holds(key) || failed_.contains(key) ||
               (caches_.disk && storable(node) && caches_.disk->holds(key));
    }

    // The staged task goes up its own past as far as that is about to run.
    void climb(Task& task)
    {
        while (task.previous->frame < task.frame - 1 && task.previous->state >= State::ready &&
               task.previous->state != State::failed) {
            Task* const before = task.previous;
            const int frame = before->frame + 1;
            task.previous = &want(keys_.at(task.node, frame), task.node, frame);
            if (task.previous->state == State::fresh && !task.previous->previous) {
                task.previous->previous = before;  // the hold on it passes on
            } else {
                release(before);
            }
        }
        Task& before = *task.previous;
        if (before.state == State::failed) return block(task);
        if (before.state < State::ready) return before.followers.push_back(&task);
        if (before.state != State::done) {
            ++task.missing;
            before.dependants.push_back(&task);
        }
        expand(task);
    }

    // A sink's result is good only as long as its files are what it wrote. Of one that all frames
    // share nobody can tell, and to read it all for each frame would take long.
    bool still_there(const Result& result)
    {
        return std::all_of(result.files.begin(), result.files.end(), [this](const Written& w) {
            return w.digest && caches_.files.of(w.path) == w.digest;
        });
    }

    // One more that the task waits for. False when that failed.
    bool attach(Task& task, Task& input)
    {
        task.inputs.push_back(&input);
        if (input.state >= State::done) return input.state == State::done;
        ++task.missing;
        input.dependants.push_back(&task);
        return true;
    }

    bool attach_port(Task& task, std::size_t port)
    {
        const graph::Node& node = graph_.nodes[task.node];
        bool good = true;
        for (const graph::Link& link : node.inputs[port]) {
            for (const int frame : keys_.input_frames(task.node, port, task.frame)) {
                if (node.type->inputs[port].gather) {
                    demands_.push({frame, &task, task.inputs.size(), link});
                    task.inputs.push_back(nullptr);
                    ++task.missing;
                } else {
                    good &= attach(task, want(keys_.at(link.node, frame), link.node, frame));
                }
            }
        }
        return good;
    }

    // Wants everything that a missed task runs on.
    void expand(Task& task)
    {
        const graph::Node& node = graph_.nodes[task.node];
        const graph::NodeType& type = *node.type;
        if (task.preparation < 0 && type.gather_frames && !keys_.trouble(task.node).empty()) {
            return fail(task, keys_.trouble(task.node));
        }
        bool good = true;
        if (task.preparation >= 0) {
            const auto which = static_cast<std::size_t>(task.preparation);
            for (const std::size_t port : type.preparations[which].inputs) {
                good &= attach_port(task, port);
            }
        } else {
            for (std::size_t port = 0; port < node.inputs.size(); ++port) {
                good &= attach_port(task, port);
            }
        }
        task.usual = usual_[keys_.type(task.node)].mean;
        task.compare = worth_comparing(task);
        wait(task, good, !task.compare);
    }

    // Until all that was attached is there; preparations, too, unless it may come to nothing.
    void wait(Task& task, bool good, bool preparations)
    {
        const graph::NodeType& type = *graph_.nodes[task.node].type;
        if (preparations && task.preparation < 0) {
            try {
                for (std::size_t i = 0; i < type.preparations.size(); ++i) {
                    good &= attach(task, want(keys_.preparation(task.node, i, task.frame),
                                              task.node, task.frame, static_cast<int>(i)));
                }
            } catch (const std::exception& e) {
                return fail(task, e.what());
            }
        }
        task.state = State::waiting;
        if (!good) return block(task);
        if (task.missing == 0) make_ready(task);
    }

    // About what it takes to hash a few inputs, or to wake a thread.
    static constexpr double brief_seconds = 20e-6;

    static bool quick(const Task& task) { return task.usual > 0 && task.usual < brief_seconds; }

    // Comparing costs a hash of what the inputs hold: not for what is made in no time. Nodes that
    // open files are left out: their keys are made of contents already.
    bool worth_comparing(const Task& task) const
    {
        if (task.expected || (task.inputs.empty() && !task.previous) || opens(task.node))
            return false;
        if (task.preparation < 0 && quick(task)) return false;
        for (const auto& port : graph_.nodes[task.node].inputs) {
            for (const graph::Link& link : port) {
                if (!stored(graph_.nodes[link.node].type->outputs[link.output])) return false;
            }
        }
        return !task.previous || storable(task.node);
    }

    // One of the task's inputs is there.
    void told(Task& task)
    {
        if (--task.missing == 0 && task.state == State::waiting) make_ready(task);
    }

    void make_ready(Task& task)
    {
        const graph::NodeType& type = *graph_.nodes[task.node].type;
        task.state = State::ready;
        ready_.push({task.frame, type.sink ? 2 : type.previous.empty() ? 1 : 0, task.node, &task});
        call_followers(task);
    }

    void call_followers(Task& task)
    {
        for (Task* follower : task.followers) unsettled_.push_back(follower);
        task.followers.clear();
    }

    void arrive(Task& task, SharedResult result)
    {
        task.result = std::move(result);
        task.state = State::done;
        release_inputs(task);
        call_followers(task);
        const Few<Task*> dependants = std::exchange(task.dependants, {});
        for (Task* dependant : dependants) told(*dependant);
        const Few<std::uint32_t> wants = std::exchange(task.wants, {});
        for (const std::uint32_t want : wants) deliver(want, task.result);
        if (observer_ && warns(*task.result)) {
            for (Warning& w : warners_.news(task.key, task.node, task.frame, *task.result)) {
                events_.emplace_back(std::move(w));
            }
        }
        for (const Written& file : task.result->files) {
            events_.emplace_back(WroteEvent{task.node, task.frame, file});
        }
        // Its own hold: a result that nobody wants leaves at once.
        ++task.users;
        for (std::size_t i = 0; i <= wants.size(); ++i) release(&task);
    }

    void deliver(std::uint32_t want, const SharedResult& result)
    {
        --in_flight_;
        ++cooked_.done;
        events_.emplace_back(ArrivedEvent{want, result, cooked_.done});
    }

    // The cause.
    void fail(Task& task, std::string what)
    {
        failures_.push_back({task.node, task.frame, std::move(what)});
        ++cooked_.failures;
        ++cooked_.tallies.of(task.node).failures;
        events_.emplace_back(failures_.back());
        if (!options_.keep_going) stopping_ = true;
        spread_failure(task, true);
    }

    // What a failure before it leaves without an input.
    void block(Task& task) { spread_failure(task, false); }

    void spread_failure(Task& task, bool cause)
    {
        std::vector<Task*> failing{&task};
        while (!failing.empty()) {
            Task& t = *failing.back();
            failing.pop_back();
            if (t.state == State::failed || t.state == State::dropped) continue;
            if (!std::exchange(cause, false) && t.preparation < 0) {
                ++cooked_.blocked;
                ++cooked_.tallies.of(t.node).blocked;
            }
            t.state = State::failed;
            failed_.insert(t.key);
            for (Task* d : t.dependants) failing.push_back(d);
            for (Task* f : t.followers) failing.push_back(f);
            t.dependants.clear();
            t.followers.clear();
            in_flight_ -= t.wants.size();
            t.users -= static_cast<std::uint32_t>(t.wants.size());
            t.wants.clear();
            release_inputs(t);
            ++t.users;
            release(&t);
        }
    }

    void release_inputs(Task& task)
    {
        const Few<Task*> inputs = std::exchange(task.inputs, {});
        for (Task* input : inputs) release(input);
        release(std::exchange(task.previous, nullptr));
    }

    // One user less. What nobody needs leaves, and what only it needed with it; without recursion.
    void release(Task* first)
    {
        if (!first || --first->users > 0) return;
        std::vector<Task*> unused{first};
        while (!unused.empty()) {
            Task& task = *unused.back();
            unused.pop_back();
            if (task.state == State::running) continue;  // it leaves when it ends
            for (Task* input : task.inputs) {
                if (input && --input->users == 0) unused.push_back(input);
            }
            if (task.previous && --task.previous->users == 0) unused.push_back(task.previous);
            task.inputs.clear(), task.previous = nullptr;
            if (task.state < State::done) task.state = State::dropped;
            forget(task);
        }
    }

    // Over sooner than another thread could be told of it: several threads with such tasks only
    // wait for each other's bookkeeping.
    bool is_brief(const Task& task) const
    {
        const double longest = usual_[keys_.type(task.node)].longest;
        return longest > 0 && longest < brief_seconds && !task.load && task.preparation < 0;
    }

    // The next task to run; null when none may start, or when it is brief and a thread that will
    // be back at once takes it: the first one, if it can, whose memory most of the others is.
    Task* next(bool first)
    {
        if (!stopping_ && options_.stop.stop_requested()) stopping_ = cooked_.cancelled = true;
        while (!stopping_ && !ready_.empty()) {
            Task* task = ready_.top().task;
            const bool good = task->state == State::ready;
            if (good && !first && (first_here_ || brief_running_ > 0) && is_brief(*task)) {
                return nullptr;
            }
            ready_.pop();
            if (!good) continue;
            table_.expect(task->key);  // it leaves soon after it ran
            caches_.memory.expect(task->key);
            return task;
        }
        return nullptr;
    }

    // Another thread for what is ready, while this one is away.
    void call_another()
    {
        if (ready_.empty() || workers_ >= threads_) return;
        ++workers_;
        group_.run([this] { work(false); });
    }

    // Runs what is ready until nothing is. Called without the lock.
    void work(bool first)
    {
        Scratch scratch;
        std::unique_lock lock(mutex_);
        while (Task* task = next(first)) {
            task->state = State::running;
            task->usual = usual_[keys_.type(task->node)].mean;
            const bool brief = is_brief(*task);
            ++running_, brief_running_ += brief;
            if (first) first_here_ = brief;
            if (!brief) call_another();
            lock.unlock();
            Outcome outcome = run(*task, scratch);
            scratch.clear();
            std::vector<SharedResult> gone;  // dies without the lock
            Stored keep;
            lock.lock();
            --running_, brief_running_ -= brief;
            if (first) first_here_ = true;
            guarded([&] {
                keep = finish(*task, outcome, gone);
                open();
            });
            if (!events_.empty() || !gone.empty() || keep.result) {
                if (first) first_here_ = false;
                if (keep.result) call_another();  // to store it may take long
                lock.unlock();
                gone.clear();
                if (keep.result) caches_.disk->store(keep.key, std::move(keep.result), keep.same);
                report();
                lock.lock();
                if (first) first_here_ = true;
            }
        }
        --workers_;
        if (first) first_here_ = false;
    }

    // Trouble in the bookkeeping itself (memory) ends the cook, not the process.
    template <class F> void guarded(const F& f)
    {
        try {
            f();
        } catch (...) {
            if (!fatal_) fatal_ = std::current_exception();
            stopping_ = true;
        }
    }

    // For the disk.
    struct Stored {
        Key key;
        SharedResult result = nullptr;
        Key same = {};
    };

    // Returns what is to be stored on disk, if anything.
    Stored finish(Task& task, Outcome& outcome, std::vector<SharedResult>& gone)
    {
        Tally& tally = cooked_.tallies.of(task.node);
        if (outcome.absent) {
            task.load = false;
            begin(task);
            return {};
        }
        if (outcome.other) {
            task.compare = false;
            task.same = outcome.same;
            wait(task, true, true);
            return {};
        }
        tally.seconds += outcome.run.seconds;
        if (outcome.cancelled) {
            stopping_ = cooked_.cancelled = true;
            return {};
        }
        if (outcome.failure) {
            fail(task, std::move(*outcome.failure));
            return {};
        }
        SharedResult result = std::move(outcome.result);
        if (task.load) {
            ++tally.loads;
            if (rechecked(task)) {
                task.load = false;
                task.expected = std::move(result);
                begin(task);
                return {};
            }
        }
        if (outcome.equal) ++tally.equal;
        if (task.load || outcome.equal) {
            gone = caches_.memory.insert(task.key, result);
            arrive(task, std::move(result));
            return {};
        }
        ++tally.runs;
        if (task.expected) ++tally.rechecked;
        tally.bytes += outcome.run.bytes;
        if (observer_) events_.emplace_back(outcome.run);
        const bool is_node = task.preparation < 0;
        const Key key = is_node && opens(task.node)
                            ? keys_.opened(task.node, task.frame, outcome.opened)
                            : task.key;
        // A sink that does not say what it wrote can't be checked later, so it runs each time.
        const bool silent = is_node && graph_.nodes[task.node].type->sink && result->files.empty();
        // A file that changed under the run: nobody knows what the node read of it.
        const bool torn = is_node && opens(task.node) && keys_.files_changed(task.node, task.frame);
        const bool keep = !silent && !torn;
        const Key same = keep ? task.same : Key{};
        if (keep) gone = caches_.memory.insert(key, result);
        if (same) remember_same(same, key);
        if (is_node) {
            auto& [mean, longest] = usual_[keys_.type(task.node)];
            const double seconds = outcome.run.seconds;
            mean = mean > 0 ? (mean + seconds) / 2 : seconds;
            longest = std::max(seconds, 0.9 * longest);
        }
        arrive(task, result);
        if (!keep || !outcome.store) return {};
        return {key, std::move(result), same};
    }

    void remember_same(const Key& same, const Key& key)
    {
        constexpr std::size_t most = std::size_t{1} << 20;  // 64 MB
        if (caches_.same.size() >= most) caches_.same.clear();
        caches_.same[same] = key;
    }

    bool opens(std::uint32_t node) const
    {
        const auto& openers = keys_.openers();
        return std::binary_search(openers.begin(), openers.end(), node);
    }

    // ---- without the lock

    Outcome run(Task& task, Scratch& scratch)
    {
        Outcome outcome;
        const Clock::time_point begin = Clock::now();
        outcome.run = {task.node,
                       task.frame,
                       task.preparation,
                       tbb::this_task_arena::current_thread_index(),
                       std::chrono::duration<double>(begin - start_).count(),
                       0,
                       0};
        // Isolated: a parallel loop in the node waits for its own pieces only and never picks up
        // another node, which could take long or wait for this one.
        std::shared_ptr<Result> made;
        tbb::this_task_arena::isolate([&] {
            try {
                if (task.load) {
                    outcome.result = load(task);
                    outcome.absent = !outcome.result;
                } else if (task.compare && compare(task, outcome)) {
                    return;
                } else {
                    made = task.preparation < 0 ? run_node(task, scratch, outcome)
                                                : run_preparation(task, scratch);
                }
            } catch (const graph::Cancelled&) {
                outcome.cancelled = true;
            } catch (...) {
                outcome.failure = text_of(std::current_exception());
            }
        });
        outcome.run.seconds = seconds_since(begin);
        if (made && task.expected) check_again(task, *made, outcome);
        if (made) {
            made->seconds = outcome.run.seconds;
            outcome.run.bytes = made->bytes;
            if (task.preparation < 0) made->heard = heard(task);
            outcome.store = worth_storing(task, *made);
            made->since_stored = outcome.store ? 0 : since_stored(task) + made->seconds;
            outcome.result = std::move(made);
        }
        return outcome;
    }

    static double since_stored(const Task& task)
    {
        return task.previous ? task.previous->result->since_stored : 0;
    }

    // On disk goes what is read back quicker than made again, and what a sink wrote. Of simulations
    // also a frame every so often however cheap their steps are, since a late frame costs all those
    // before it; and not every frame when all together would fill the disk's budget.
    bool worth_storing(const Task& task, const Result& result) const
    {
        if (!caches_.disk || task.preparation >= 0 || !storable(task.node)) return false;
        const graph::NodeType& type = *graph_.nodes[task.node].type;
        if (std::any_of(result.files.begin(), result.files.end(),
                        [](const Written& w) { return !w.digest; })) {
            return false;
        }
        const bool pays = DiskCache::pays(result.seconds, result.bytes);
        if (type.previous.empty()) return pays || !result.files.empty();
        const double all = static_cast<double>(result.bytes) * graph_.range.count();
        const double share = static_cast<double>(caches_.disk->budget()) / 4;
        const int spacing = static_cast<int>(std::ceil(std::max(all / std::max(share, 1.0), 1.0)));
        const bool due = (task.frame - graph_.range.first) % spacing == 0;
        return (pays && due) || since_stored(task) + result.seconds > scrub_seconds * spacing;
    }

    // Any frame of a stored simulation is at most this much work away: a third of what a person
    // who scrubs through the frames notices.
    static constexpr double scrub_seconds = 5e-3;

    // Puts values into the scratch in the order in which expand() made the inputs.
    std::size_t fill_port(const Task& task, std::size_t port, std::size_t at, Scratch& scratch)
    {
        const graph::Node& node = graph_.nodes[task.node];
        const graph::InputPort& description = node.type->inputs[port];
        for (const graph::Link& link : node.inputs[port]) {
            const std::size_t frames = keys_.input_frames(task.node, port, task.frame).size();
            for (std::size_t i = 0; i < frames; ++i) {
                const Value& value = task.inputs[at++]->result->values[link.output];
                const graph::Node& from = graph_.nodes[link.node];
                if (!value && !description.optional) {
                    throw std::runtime_error("input '" + description.name + "' got nothing: '" +
                                             from.name + "." +
                                             from.type->outputs[link.output].name + "' is empty");
                }
                if (value || description.many || description.gather) {
                    scratch.inputs[port].push_back(value);
                }
            }
        }
        return at;
    }

    std::shared_ptr<Result> run_node(const Task& task, Scratch& scratch, Outcome& outcome)
    {
        const graph::Node& node = graph_.nodes[task.node];
        const graph::NodeType& type = *node.type;
        if (scratch.inputs.size() < type.inputs.size()) scratch.inputs.resize(type.inputs.size());
        std::size_t at = 0;
        for (std::size_t port = 0; port < type.inputs.size(); ++port) {
            at = fill_port(task, port, at, scratch);
        }
        for (const graph::Previous& p : type.previous) {
            scratch.previous.push_back(task.previous ? task.previous->result->values[p.output]
                                                     : Value());
        }
        for (std::size_t i = 0; i < type.preparations.size(); ++i) {
            scratch.prepared.push_back(task.inputs[at++]->result->prepared);
        }

        auto result = std::make_shared<Result>();
        std::mutex talking;  // a node may warn and open from many threads
        graph::Context context(task.frame, graph_.range, type.reads);
        context.stop = options_.stop;
        context.output_folder = options_.output_folder;
        context.root = graph_.root;
        context.cook = cook_;
        context.warn = [&](const std::string& text) {
            const std::lock_guard lock(talking);
            auto& all = result->warnings;
            if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(text);
        };
        context.opened = [&](const std::filesystem::path& path) {
            if (!opens(task.node)) {
                throw std::logic_error("this node opens files but has no path_in parameter");
            }
            const std::lock_guard lock(talking);
            outcome.opened.insert(path);
        };
        if (type.gather_frames) {
            for (std::size_t port = 0; port < type.inputs.size(); ++port) {
                if (!type.inputs[port].gather) continue;
                const auto frames = keys_.input_frames(task.node, port, task.frame);
                context.gathered.assign(frames.begin(), frames.end());
            }
        }
        const graph::ParamValues params =
            node.animated.empty() ? graph::ParamValues() : keys_.params(task.node, task.frame);
        result->values = type.run({{scratch.inputs.data(), type.inputs.size()},
                                   node.animated.empty() ? node.params : params,
                                   scratch.previous,
                                   scratch.prepared,
                                   context});
        if (result->values.size() != type.outputs.size()) {
            throw std::logic_error("gave " + std::to_string(result->values.size()) +
                                   " outputs, its description says " +
                                   std::to_string(type.outputs.size()));
        }
        for (const Value& value : result->values) {
            result->bytes += value.bytes();
            if (!type.sink || !value || *value.type()->type != typeid(graph::WrittenFile)) continue;
            const auto written = value.as<graph::WrittenFile>();
            result->files.push_back(
                {written->path, written->shared ? Key() : caches_.files.of(written->path)});
            for (const std::filesystem::path path : written->beside) {
                result->files.push_back({path, caches_.files.of(path)});
            }
        }
        return result;
    }

    // Whether the task need not run now: its result was met under the names of its inputs'
    // contents, or it was not and there are preparations to make first.
    bool compare(Task& task, Outcome& outcome)
    {
        const auto hidden_cost = [&](const Task* t) {
            return t ? 1e-10 * static_cast<double>(t->result->bytes) : 0;
        };
        const graph::Node& node = graph_.nodes[task.node];
        const bool is_node = task.preparation < 0;
        const auto not_met = [&] {
            outcome.other = is_node && !node.type->preparations.empty();
            return outcome.other;
        };
        if (is_node && quick(task)) return not_met();
        double cost = hidden_cost(task.previous);
        for (const Task* input : task.inputs) cost += hidden_cost(input);
        if (task.usual > 0 && task.usual < 5 * cost) return not_met();

        std::vector<graph::ContentName> names;
        std::size_t at = 0;
        const auto add_port = [&](std::size_t port) {
            for (const graph::Link& link : node.inputs[port]) {
                const std::size_t frames = keys_.input_frames(task.node, port, task.frame).size();
                for (std::size_t i = 0; i < frames; ++i) {
                    const Result& input = *task.inputs[at++]->result;
                    names.push_back(input.names(caches_.names)[link.output]);
                }
            }
        };
        if (is_node) {
            for (std::size_t port = 0; port < node.inputs.size(); ++port) add_port(port);
            for (const graph::Previous& p : node.type->previous) {
                names.push_back(task.previous
                                    ? task.previous->result->names(caches_.names)[p.output]
                                    : graph::ContentName{});
            }
            outcome.same = keys_.by_content(task.node, task.frame, names);
        } else {
            const auto which = static_cast<std::size_t>(task.preparation);
            for (const std::size_t port : node.type->preparations[which].inputs) add_port(port);
            outcome.same = keys_.preparation_by_content(task.node, which, task.frame, names);
        }
        outcome.result = find_same(task, outcome.same);
        outcome.equal = outcome.result != nullptr;
        if (!outcome.equal) task.same = outcome.same;
        return outcome.equal || not_met();
    }

    SharedResult find_same(const Task& task, const Key& same)
    {
        SharedResult found;
        {
            const std::lock_guard lock(mutex_);
            const auto known = caches_.same.find(same);
            if (known != caches_.same.end()) found = caches_.memory.find(known->second);
        }
        const bool on_disk = caches_.disk && task.preparation < 0 && storable(task.node);
        if (!found && on_disk) {
            found = caches_.disk->load_same(same, *graph_.nodes[task.node].type);
        }
        if (!found || !still_there(*found)) return nullptr;
        if (task.preparation >= 0) return found;
        // Inputs of equal bytes may have come with other warnings.
        if (std::vector<Heard> now = heard(task); now != found->heard) {
            auto copy = std::make_shared<Result>(*found);
            copy->heard = std::move(now);
            found = std::move(copy);
            if (worth_storing(task, *found)) caches_.disk->store(task.key, found);
        } else if (on_disk) {
            caches_.disk->call(task.key, same);
        }
        return found;
    }

    static bool warns(const Result& result)
    {
        return !result.warnings.empty() || !result.heard.empty();
    }

    // What the results that the task runs on warned of, and what they had heard.
    std::vector<Heard> heard(const Task& task)
    {
        const auto each = [&](const auto& see) {
            if (task.previous && warns(*task.previous->result)) see(*task.previous);
            for (const Task* input : task.inputs) {
                if (warns(*input->result)) see(*input);
            }
        };
        bool any = false;
        each([&](const Task&) { any = true; });
        if (!any) return {};
        const std::lock_guard lock(mutex_);
        Warners::Heap heap(warners_);
        each([&](const Task& t) { heap.add(t.key, t.node, t.frame, *t.result); });
        return heap.take();
    }

    // What was made again must be what was found.
    void check_again(const Task& task, const Result& made, Outcome& outcome)
    {
        const auto& was = task.expected->names(caches_.names);
        const auto& is = made.names(caches_.names);
        const auto& outputs = graph_.nodes[task.node].type->outputs;
        for (std::size_t i = 0; i < is.size(); ++i) {
            if (was[i] == is[i]) continue;
            outcome.failure = "made again to check it, output '" + outputs[i].name +
                              "' is not what was stored: the node depends on something that is "
                              "not in its key, or the stored result is wrong";
            return;
        }
        for (std::size_t i = 0; i < made.files.size() && i < task.expected->files.size(); ++i) {
            if (made.files[i].digest == task.expected->files[i].digest) continue;
            outcome.failure = "written again to check it, " + made.files[i].path.string() +
                              " is not the file that it was";
            return;
        }
    }

    SharedResult load(const Task& task)
    {
        SharedResult result = caches_.disk->load(task.key, *graph_.nodes[task.node].type);
        return result && still_there(*result) ? result : nullptr;
    }

    std::shared_ptr<Result> run_preparation(const Task& task, Scratch& scratch)
    {
        const graph::Node& node = graph_.nodes[task.node];
        const graph::NodeType& type = *node.type;
        const graph::Preparation& preparation =
            type.preparations[static_cast<std::size_t>(task.preparation)];
        if (scratch.inputs.size() < type.inputs.size()) scratch.inputs.resize(type.inputs.size());
        std::size_t at = 0;
        for (const std::size_t port : preparation.inputs) at = fill_port(task, port, at, scratch);
        const graph::ParamValues params = keys_.params(task.node, task.frame);
        auto result = std::make_shared<Result>();
        result->prepared = preparation.build(
            {{scratch.inputs.data(), type.inputs.size()}, params, {}, {}, graph::Context()});
        if (result->prepared) result->bytes = preparation.bytes(result->prepared.get());
        return result;
    }

    // Hands events to the observer, one thread at a time, in order.
    void report()
    {
        const std::lock_guard one(reporting_);
        std::vector<Event> events;
        {
            const std::lock_guard lock(mutex_);
            events.swap(events_);
        }
        for (const Event& event : events) {
            std::visit([this](const auto& e) { tell(e); }, event);
        }
    }

    struct ArrivedEvent {
        std::uint32_t want;
        SharedResult result;
        std::size_t done;
    };
    struct WroteEvent {
        std::uint32_t node;
        int frame;
        Written file;
    };
    using Event = std::variant<ArrivedEvent, WroteEvent, Warning, Failure, Run>;

    void tell(const ArrivedEvent& e)
    {
        if (arrived_) arrived_(wants_[e.want], e.result->values);
        if (observer_) observer_->progressed(progress(e.done));
    }
    void tell(const WroteEvent& e)
    {
        if (observer_) observer_->wrote(e.node, e.frame, e.file);
    }
    void tell(const Warning& w)
    {
        if (observer_) observer_->warned(w);
    }
    void tell(const Failure& f)
    {
        if (observer_) observer_->failed(f);
    }
    void tell(const Run& r)
    {
        // Work that comes back each frame foretells what is left; what ran once does not.
        if (keys_.varies(r.node) && r.preparation < 0) repeating_seconds_ += r.seconds;
        busy_seconds_ += r.seconds;
        if (observer_) observer_->ran(r);
    }

    Progress progress(std::size_t done) const
    {
        Progress p{done, wants_.size(), seconds_since(start_), 0};
        const double finished = static_cast<double>(done);
        const double remaining = static_cast<double>(wants_.size() - done);
        const double at_once = std::clamp(busy_seconds_ / std::max(p.elapsed, 1e-9), 1.0,
                                          static_cast<double>(threads_));
        p.left = done == 0 ? std::nan("") : repeating_seconds_ / finished * remaining / at_once;
        return p;
    }

    const graph::Graph& graph_;
    Caches& caches_;
    const Options& options_;
    Observer* observer_;
    Keys& keys_;
    std::vector<Usual>& usual_;
    tbb::task_arena& arena_;
    const Evaluator::Arrived& arrived_;
    const int threads_;
    const std::shared_ptr<graph::Cook> cook_;
    const Clock::time_point start_ = Clock::now();

    std::mutex mutex_;
    std::vector<Want> wants_;
    std::size_t next_want_ = 0, in_flight_ = 0, at_once_ = 1;
    std::priority_queue<Demand> demands_;
    std::deque<Task> tasks_;
    std::vector<std::uint32_t> free_;  // places of tasks_
    KeyTable table_;                   // into tasks_
    std::unordered_set<Key, KeyHash> failed_;
    Warners warners_;
    std::vector<Task*> unsettled_;
    std::priority_queue<Ready> ready_;
    int running_ = 0, brief_running_ = 0, workers_ = 0;
    bool first_here_ = true;  // the first worker is between tasks or runs a brief one
    bool stopping_ = false;
    std::exception_ptr fatal_;
    std::vector<Failure> failures_;
    std::vector<Event> events_;
    Cooked cooked_;
    tbb::task_group group_;

    std::mutex reporting_;  // what follows belongs to its holder
    double repeating_seconds_ = 0, busy_seconds_ = 0;
};

Evaluator::Evaluator(const graph::Graph& graph, Caches& caches, Options options, Observer* observer)
    : graph_(graph), caches_(caches), options_(std::move(options)), observer_(observer),
      keys_(graph, caches.files, caches.side_files, {options_.salt, options_.output_folder})
{
    for (std::size_t n = 0; n < graph.nodes.size(); ++n) {
        for (const auto& port : graph.nodes[n].inputs) {
            for (const graph::Link& link : port) {
                if (link.node < n) continue;
                throw std::invalid_argument("node '" + graph.nodes[n].name +
                                            "' stands before one that it takes an input from");
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
                                        " lies before the first frame, " +
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
    Cooking cooking(graph_, caches_, options_, observer_, keys_, usual_, *arena_, arrived,
                    std::move(frames));
    return cooking.cook(std::move(wants), frames_ahead() * a_frame);
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
        Cooking(graph_, caches_, options, nullptr, keys_, usual_, *arena_, {}, unknown)
            .cook(std::move(wants), frames_ahead());
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
