#include "runtime/cook/cooking.hpp"

#include "runtime/cook/cook_events.hpp"
#include "runtime/cook/end_tasks.hpp"
#include "runtime/cook/open_tasks.hpp"
#include "runtime/cook/run_task.hpp"

namespace runtime {

namespace {

// What goes to the disk cache after a run; nothing when there is no result.
struct ForDisk {
    Key key;
    SharedResult result = nullptr;
    Key same = {};
};

// Over sooner than another thread could be told of it. Called with the lock held, as all below.
bool is_brief(const CookState& cook, const Task& task)
{
    const double longest = cook.usual[cook.keys.type(task.node)].longest;
    return longest > 0 && longest < brief_seconds && !task.load && task.preparation < 0;
}

// The next task to run; null when none may start, or when it is brief and a thread that will
// be back at once takes it: the first one, if it can, whose memory most of the others is.
Task* next_task(CookState& cook, bool first)
{
    if (!cook.stopping && cook.options.stop.stop_requested()) {
        cook.stopping = cook.cooked.cancelled = true;
    }
    while (!cook.stopping && !cook.ready.empty()) {
        Task* task = cook.ready.top().task;
        const bool good = task->state == TaskState::ready;
        if (good && !first && (cook.first_here || cook.brief_running > 0) &&
            is_brief(cook, *task)) {
            return nullptr;
        }
        cook.ready.pop();
        if (!good) continue;
        cook.table.expect(task->key);  // it leaves soon after it ran
        cook.caches.memory.expect(task->key);
        return task;
    }
    return nullptr;
}

void work(CookState& cook, bool first);

// Another thread for what is ready, while this one is away.
void call_another(CookState& cook)
{
    if (cook.ready.empty() || cook.workers >= cook.threads) return;
    ++cook.workers;
    cook.group.run([&cook] { work(cook, false); });
}

void remember_same(CookState& cook, const Key& same, const Key& key)
{
    constexpr std::size_t most = std::size_t{1} << 20;  // 64 MB
    if (cook.caches.same.size() >= most) cook.caches.same.clear();
    cook.caches.same[same] = key;
}

void remember_time(Usual& usual, double seconds)
{
    usual.mean = usual.mean > 0 ? (usual.mean + seconds) / 2 : seconds;
    usual.longest = std::max(seconds, 0.9 * usual.longest);
}

// The node, or one of its preparations, ran and gave a result.
ForDisk end_made(CookState& cook, Task& task, Outcome& outcome, std::vector<SharedResult>& gone)
{
    SharedResult result = std::move(outcome.result);
    Tally& tally = cook.cooked.tallies.of(task.node);
    ++tally.runs;
    if (task.expected) ++tally.rechecked;
    tally.bytes += outcome.run.bytes;
    if (cook.observer) cook.events.emplace_back(outcome.run);
    const bool is_node = task.preparation < 0;
    const Key key = is_node && cook.keys.opens(task.node)
                        ? cook.keys.opened(task.node, task.frame, outcome.opened)
                        : task.key;
    // A sink that does not say what it wrote can't be checked later, so it runs each time.
    const bool silent = is_node && cook.graph.nodes[task.node].type->sink && result->files.empty();
    // A file that changed under the run: nobody knows what the node read of it.
    const bool torn =
        is_node && cook.keys.opens(task.node) && cook.keys.files_changed(task.node, task.frame);
    const bool keep = !silent && !torn;
    const Key same = keep ? task.same : Key{};
    if (keep) gone = cook.caches.memory.insert(key, result);
    if (same) remember_same(cook, same, key);
    if (is_node) remember_time(cook.usual[cook.keys.type(task.node)], outcome.run.seconds);
    arrive(cook, task, result);
    if (!keep || !outcome.store) return {};
    return {key, std::move(result), same};
}

// Moves the task on by what its run came to. What has to leave the memory cache is put in `gone`.
// Returns what is to be stored on disk.
ForDisk finish_run(CookState& cook, Task& task, Outcome& outcome, std::vector<SharedResult>& gone)
{
    Tally& tally = cook.cooked.tallies.of(task.node);
    if (outcome.absent) {
        task.load = false;
        begin_task(cook, task);
        return {};
    }
    if (outcome.other) {
        task.compare = false;
        task.same = outcome.same;
        want_preparations(cook, task);
        return {};
    }
    tally.seconds += outcome.run.seconds;
    if (outcome.cancelled) {
        cook.stopping = cook.cooked.cancelled = true;
        return {};
    }
    if (outcome.failure) {
        fail(cook, task, std::move(*outcome.failure));
        return {};
    }
    if (task.load) {
        ++tally.loads;
        if (rechecked(cook, task)) {
            task.load = false;
            task.expected = std::move(outcome.result);
            begin_task(cook, task);
            return {};
        }
    }
    if (outcome.equal) ++tally.equal;
    if (!task.load && !outcome.equal) return end_made(cook, task, outcome, gone);
    gone = cook.caches.memory.insert(task.key, outcome.result);
    arrive(cook, task, std::move(outcome.result));
    return {};
}

// Trouble in the bookkeeping itself (memory) ends the cook, not the process.
template <class F> void guarded(CookState& cook, const F& f)
{
    try {
        f();
    } catch (...) {
        if (!cook.fatal) cook.fatal = std::current_exception();
        cook.stopping = true;
    }
}

// Runs what is ready until nothing is. Called without the lock.
void work(CookState& cook, bool first)
{
    Scratch scratch;
    std::unique_lock lock(cook.mutex);
    while (Task* task = next_task(cook, first)) {
        task->state = TaskState::running;
        task->usual = cook.usual[cook.keys.type(task->node)].mean;
        const bool brief = is_brief(cook, *task);
        ++cook.running, cook.brief_running += brief;
        if (first) cook.first_here = brief;
        if (!brief) call_another(cook);
        lock.unlock();
        Outcome outcome = run_task(cook, *task, scratch);
        scratch.clear();
        std::vector<SharedResult> gone;  // dies without the lock
        ForDisk keep;
        lock.lock();
        --cook.running, cook.brief_running -= brief;
        if (first) cook.first_here = true;
        guarded(cook, [&] {
            keep = finish_run(cook, *task, outcome, gone);
            open_more(cook);
        });
        if (!cook.events.empty() || !gone.empty() || keep.result) {
            if (first) cook.first_here = false;
            if (keep.result) call_another(cook);  // to store it may take long
            lock.unlock();
            gone.clear();
            if (keep.result) cook.caches.disk->store(keep.key, std::move(keep.result), keep.same);
            report_events(cook);
            lock.lock();
            if (first) cook.first_here = true;
        }
    }
    --cook.workers;
    if (first) cook.first_here = false;
}

}  // namespace

Cooked run_cook(CookState& cook, std::vector<Want> wants, std::size_t at_once)
{
    cook.wants = std::move(wants);
    cook.at_once = at_once;
    cook.arena.execute([&cook] {
        {
            const std::lock_guard lock(cook.mutex);
            guarded(cook, [&] { open_more(cook); });
            ++cook.workers;
        }
        work(cook, true);
        cook.group.wait();
    });
    report_events(cook);
    if (cook.fatal) std::rethrow_exception(cook.fatal);
    cook.cooked.seconds = seconds_since(cook.start);
    return std::move(cook.cooked);
}

}  // namespace runtime
