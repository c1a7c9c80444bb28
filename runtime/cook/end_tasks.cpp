#include "runtime/cook/end_tasks.hpp"

namespace runtime {

namespace {

// Staged tasks look again how far up their past they can go.
void call_followers(CookState& cook, Task& task)
{
    for (Task* follower : task.followers) cook.unsettled.push_back(follower);
    task.followers.clear();
}

// Nobody can want it any more.
void forget_task(CookState& cook, Task& task)
{
    cook.table.erase(task.key, task.place);
    // Lists may still name one that came to nothing: its place stays its own.
    if (task.state != TaskState::done) return;
    cook.free.push_back(task.place);
    task = {};
}

void release_inputs(CookState& cook, Task& task)
{
    const ShortList<Task*> inputs = std::exchange(task.inputs, {});
    for (Task* input : inputs) release(cook, input);
    release(cook, std::exchange(task.previous, nullptr));
}

// The task failed, and with it all that waits for it. `cause`: the task itself is the reason, else
// it counts as blocked, too.
void spread_failure(CookState& cook, Task& task, bool cause)
{
    std::vector<Task*> failing{&task};
    while (!failing.empty()) {
        Task& t = *failing.back();
        failing.pop_back();
        if (t.state == TaskState::failed || t.state == TaskState::dropped) continue;
        if (!std::exchange(cause, false) && t.preparation < 0) {
            ++cook.cooked.blocked;
            ++cook.cooked.tallies.of(t.node).blocked;
        }
        t.state = TaskState::failed;
        cook.failed.insert(t.key);
        for (Task* d : t.dependants) failing.push_back(d);
        for (Task* f : t.followers) failing.push_back(f);
        t.dependants.clear();
        t.followers.clear();
        cook.in_flight -= t.wants.size();
        t.users -= static_cast<std::uint32_t>(t.wants.size());
        t.wants.clear();
        release_inputs(cook, t);
        ++t.users;
        release(cook, &t);
    }
}

}  // namespace

void make_ready(CookState& cook, Task& task)
{
    const graph::NodeType& type = *cook.graph.nodes[task.node].type;
    task.state = TaskState::ready;
    const int rank = type.sink ? 2 : cook.keys.rolls(task.node) ? 0 : 1;
    cook.ready.push({task.frame, rank, task.node, &task});
    call_followers(cook, task);
}

void input_arrived(CookState& cook, Task& task)
{
    if (--task.missing == 0 && task.state == TaskState::waiting) make_ready(cook, task);
}

void arrive(CookState& cook, Task& task, SharedResult result)
{
    task.result = std::move(result);
    task.state = TaskState::done;
    release_inputs(cook, task);
    call_followers(cook, task);
    const ShortList<Task*> dependants = std::exchange(task.dependants, {});
    for (Task* dependant : dependants) input_arrived(cook, *dependant);
    const ShortList<std::uint32_t> wants = std::exchange(task.wants, {});
    for (const std::uint32_t want : wants) deliver(cook, want, task.result);
    if (cook.observer && warns(*task.result)) {
        for (Warning& w : cook.warners.news(task.key, task.node, task.frame, *task.result)) {
            cook.events.emplace_back(std::move(w));
        }
    }
    for (const Written& file : task.result->files) {
        cook.events.emplace_back(WroteEvent{task.node, task.frame, file});
    }
    // Its own hold: a result that nobody wants leaves at once.
    ++task.users;
    for (std::size_t i = 0; i <= wants.size(); ++i) release(cook, &task);
}

void deliver(CookState& cook, std::uint32_t want, const SharedResult& result)
{
    --cook.in_flight;
    ++cook.cooked.done;
    cook.events.emplace_back(ArrivedEvent{want, result, cook.cooked.done});
    if (!cook.observer) return;
    for (const ToldEvent& told : result->told) {
        if (cook.told.insert(told->from).second) cook.events.emplace_back(told);
    }
}

void fail(CookState& cook, Task& task, std::string what)
{
    ++cook.cooked.failures;
    ++cook.cooked.tallies.of(task.node).failures;
    cook.events.emplace_back(Failure{task.node, task.frame, std::move(what)});
    if (!cook.options.keep_going) cook.stopping = true;
    spread_failure(cook, task, true);
}

void block(CookState& cook, Task& task)
{
    spread_failure(cook, task, false);
}

void release(CookState& cook, Task* first)
{
    if (!first || --first->users > 0) return;
    std::vector<Task*> unused{first};
    while (!unused.empty()) {
        Task& task = *unused.back();
        unused.pop_back();
        if (task.state == TaskState::running) continue;  // it leaves when it ends
        for (Task* input : task.inputs) {
            if (input && --input->users == 0) unused.push_back(input);
        }
        if (task.previous && --task.previous->users == 0) unused.push_back(task.previous);
        task.inputs.clear(), task.previous = nullptr;
        if (task.state < TaskState::done) task.state = TaskState::dropped;
        forget_task(cook, task);
    }
}

}  // namespace runtime
