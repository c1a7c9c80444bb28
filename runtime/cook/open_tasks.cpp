#include "runtime/cook/open_tasks.hpp"

#include "runtime/cook/end_tasks.hpp"
#include "runtime/cook/storing.hpp"

namespace runtime {

namespace {

// Null when there is none.
Task* find_task(CookState& cook, const Key& key)
{
    const std::uint32_t place =
        cook.table.find(key, [&cook](std::uint32_t p) { return cook.tasks[p].key; });
    return place == KeyTable::none ? nullptr : &cook.tasks[place];
}

// The task for the key, a new one if need be, with one user more.
Task& want_task(CookState& cook, const Key& key, std::uint32_t node, int frame,
                int preparation = -1)
{
    if (Task* const known = find_task(cook, key)) {
        ++known->users;
        return *known;
    }
    if (cook.free.empty()) {
        cook.free.push_back(static_cast<std::uint32_t>(cook.tasks.size()));
        cook.tasks.emplace_back();
    }
    const std::uint32_t place = cook.free.back();
    cook.table.insert(key, place);
    cook.free.pop_back();
    Task& task = cook.tasks[place];
    task.key = key, task.node = node, task.frame = frame, task.preparation = preparation;
    task.place = place;
    task.users = 1;
    cook.unsettled.push_back(&task);
    return task;
}

// One more that the task waits for. False when that failed.
bool attach(Task& task, Task& input)
{
    task.inputs.push_back(&input);
    if (input.state >= TaskState::done) return input.state == TaskState::done;
    ++task.missing;
    input.dependants.push_back(&task);
    return true;
}

// Everything that stands at an input port, as attach() does it. What is gathered is demanded when
// its frame's turn comes.
bool attach_port(CookState& cook, Task& task, std::size_t port)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    bool good = true;
    for (const graph::Link& link : node.inputs[port]) {
        for (const int frame : cook.keys.input_frames(task.node, port, task.frame)) {
            if (node.type->inputs[port].gather) {
                cook.demands.push({frame, &task, task.inputs.size(), link});
                task.inputs.push_back(nullptr);
                ++task.missing;
            } else {
                good &=
                    attach(task, want_task(cook, cook.keys.at(link.node, frame), link.node, frame));
            }
        }
    }
    return good;
}

// Comparing costs a hash of what the inputs hold: not for what is made in no time. Nodes that
// open files are left out: their keys are made of contents already.
bool worth_comparing(const CookState& cook, const Task& task)
{
    if (task.expected || (task.inputs.empty() && !task.previous) || cook.keys.opens(task.node)) {
        return false;
    }
    if (task.preparation < 0 && quick(task)) return false;
    for (const auto& port : cook.graph.nodes[task.node].inputs) {
        for (const graph::Link& link : port) {
            if (!storable(cook.graph.nodes[link.node].type->outputs[link.output])) return false;
        }
    }
    return !task.previous || storable(*cook.graph.nodes[task.node].type);
}

// The task waits until all that was attached is there. `good`: none of that failed. `preparations`
// are wanted too, unless the task may turn out not to run.
void wait(CookState& cook, Task& task, bool good, bool preparations)
{
    const graph::NodeType& type = *cook.graph.nodes[task.node].type;
    if (preparations && task.preparation < 0) {
        try {
            for (std::size_t i = 0; i < type.preparations.size(); ++i) {
                good &=
                    attach(task, want_task(cook, cook.keys.preparation(task.node, i, task.frame),
                                           task.node, task.frame, static_cast<int>(i)));
            }
        } catch (const std::exception& e) {
            return fail(cook, task, e.what());
        }
    }
    task.state = TaskState::waiting;
    if (!good) return block(cook, task);
    if (task.missing == 0) make_ready(cook, task);
}

// Wants everything that a missed task runs on.
void expand(CookState& cook, Task& task)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    const graph::NodeType& type = *node.type;
    if (task.preparation < 0 && type.gather_frames && !cook.keys.trouble(task.node).empty()) {
        return fail(cook, task, cook.keys.trouble(task.node));
    }
    bool good = true;
    if (task.preparation >= 0) {
        const auto which = static_cast<std::size_t>(task.preparation);
        for (const std::size_t port : type.preparations[which].inputs) {
            good &= attach_port(cook, task, port);
        }
    } else {
        for (std::size_t port = 0; port < node.inputs.size(); ++port) {
            good &= attach_port(cook, task, port);
        }
    }
    task.usual = cook.usual[cook.keys.type(task.node)].mean;
    task.compare = worth_comparing(cook, task);
    wait(cook, task, good, !task.compare);
}

// Whether there is no need to look further back than this frame of a simulation.
bool at_hand(CookState& cook, std::uint32_t node, int frame)
{
    const Key& key = cook.keys.at(node, frame);
    return find_task(cook, key) || cook.caches.memory.holds(key) || cook.failed.contains(key) ||
           (cook.caches.disk && storable(*cook.graph.nodes[node].type) &&
            cook.caches.disk->holds(key));
}

// The staged task goes up its own past as far as that is about to run.
void climb(CookState& cook, Task& task)
{
    while (task.previous->frame < task.frame - 1 && task.previous->state >= TaskState::ready &&
           task.previous->state != TaskState::failed) {
        Task* const before = task.previous;
        const int frame = before->frame + 1;
        task.previous = &want_task(cook, cook.keys.at(task.node, frame), task.node, frame);
        if (task.previous->state == TaskState::fresh && !task.previous->previous) {
            task.previous->previous = before;  // the hold on it passes on
        } else {
            release(cook, before);
        }
    }
    Task& before = *task.previous;
    if (before.state == TaskState::failed) return block(cook, task);
    if (before.state < TaskState::ready) return before.followers.push_back(&task);
    if (before.state != TaskState::done) {
        ++task.missing;
        before.dependants.push_back(&task);
    }
    expand(cook, task);
}

// A fresh task: the memory cache first, then the disk, else it has to be made.
void look_up(CookState& cook, Task& task)
{
    if (cook.failed.contains(task.key)) return block(cook, task);
    if (SharedResult found = cook.caches.memory.find(task.key);
        found && still_there(*found, cook.caches.files)) {
        if (task.preparation < 0) ++cook.cooked.tallies.of(task.node).hits;
        if (!rechecked(cook, task)) return arrive(cook, task, std::move(found));
        task.expected = std::move(found);
        return begin_task(cook, task);
    }
    if (task.preparation >= 0) return expand(cook, task);
    if (cook.caches.disk && storable(*cook.graph.nodes[task.node].type) &&
        cook.caches.disk->holds(task.key)) {
        task.load = true;
        return make_ready(cook, task);
    }
    begin_task(cook, task);
}

// Until every task is in a cache, ready, or waits for another one.
void settle(CookState& cook)
{
    while (!cook.unsettled.empty()) {
        Task& task = *cook.unsettled.back();
        cook.unsettled.pop_back();
        if (task.state == TaskState::fresh) {
            look_up(cook, task);
        } else if (task.state == TaskState::staged) {
            climb(cook, task);
        }
    }
}

void open_want(CookState& cook)
{
    const Want& w = cook.wants[cook.next_want];
    Task& task = want_task(cook, cook.keys.at(w.node, w.frame), w.node, w.frame);
    const auto index = static_cast<std::uint32_t>(cook.next_want++);
    ++cook.in_flight;
    if (task.state == TaskState::done) {
        deliver(cook, index, task.result);
        release(cook, &task);
    } else if (task.state == TaskState::failed) {
        --cook.in_flight;
        release(cook, &task);
    } else {
        task.wants.push_back(index);
    }
}

void open_demand(CookState& cook)
{
    const Demand demand = cook.demands.top();
    cook.demands.pop();
    if (demand.task->state != TaskState::waiting) return;
    Task& input = want_task(cook, cook.keys.at(demand.link.node, demand.frame), demand.link.node,
                            demand.frame);
    demand.task->inputs[demand.slot] = &input;
    if (input.state == TaskState::done) {
        input_arrived(cook, *demand.task);
    } else if (input.state == TaskState::failed) {
        block(cook, *demand.task);
    } else {
        input.dependants.push_back(demand.task);
    }
}

}  // namespace

void open_more(CookState& cook)
{
    settle(cook);
    for (;;) {
        const bool more = cook.next_want < cook.wants.size() || !cook.demands.empty();
        const bool idle = cook.ready.empty() && cook.running == 0;
        if (!more || cook.stopping || (cook.in_flight >= cook.at_once && !idle)) return;
        const bool demand =
            cook.next_want == cook.wants.size() ||
            (!cook.demands.empty() && cook.demands.top().frame < cook.wants[cook.next_want].frame);
        demand ? open_demand(cook) : open_want(cook);
        settle(cook);
    }
}

void begin_task(CookState& cook, Task& task)
{
    const bool alone = !cook.keys.rolls(task.node) || task.frame == cook.graph.range.first;
    if (alone) return expand(cook, task);
    if (!task.previous) {
        int frame = task.frame - 1;
        while (frame > cook.graph.range.first && !at_hand(cook, task.node, frame)) --frame;
        task.previous = &want_task(cook, cook.keys.at(task.node, frame), task.node, frame);
    }
    task.state = TaskState::staged;
    climb(cook, task);
}

void want_preparations(CookState& cook, Task& task)
{
    wait(cook, task, true, true);
}

bool rechecked(const CookState& cook, const Task& task)
{
    if (cook.options.recheck <= 0 || task.preparation >= 0 ||
        !storable(*cook.graph.nodes[task.node].type)) {
        return false;
    }
    const std::uint64_t draw = (task.key.high ^ cook.options.recheck_seed) * 0x9e3779b97f4a7c15u;
    return static_cast<double>(draw >> 11) * 0x1p-53 < cook.options.recheck;
}

}  // namespace runtime
