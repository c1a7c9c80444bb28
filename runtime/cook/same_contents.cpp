#include "runtime/cook/same_contents.hpp"

#include "runtime/cook/storing.hpp"

namespace runtime {

namespace {

// A result that was made of the same contents, with the warnings that this task's inputs came with.
// Null when there is none.
SharedResult find_same(CookState& cook, const Task& task, const Key& same)
{
    SharedResult found;
    {
        const std::lock_guard lock(cook.mutex);
        const auto known = cook.caches.same.find(same);
        if (known != cook.caches.same.end()) found = cook.caches.memory.find(known->second);
    }
    const bool on_disk =
        cook.caches.disk && task.preparation < 0 && storable(*cook.graph.nodes[task.node].type);
    if (!found && on_disk) {
        found = cook.caches.disk->load_same(same, *cook.graph.nodes[task.node].type);
    }
    if (!found || !still_there(*found, cook.caches.files)) return nullptr;
    if (task.preparation >= 0) return found;
    // Inputs of equal bytes may have come with other warnings and figures.
    auto heard = warnings_before(cook, task);
    auto told = told_with(cook, task, found->figures);
    if (heard != found->heard || !tell_the_same(told, found->told)) {
        auto copy = std::make_shared<Result>(*found);
        copy->heard = std::move(heard);
        copy->told = std::move(told);
        found = std::move(copy);
        if (worth_storing(cook, task, *found)) cook.caches.disk->store(task.key, found);
    } else if (on_disk) {
        cook.caches.disk->call(task.key, same);
    }
    return found;
}

// Whether to hash what the inputs hold may take a good part of what the task itself takes.
bool dear_to_compare(const Task& task)
{
    const auto cost_of = [](const Task* t) {
        return t ? 1e-10 * static_cast<double>(t->result->bytes) : 0;
    };
    double cost = cost_of(task.previous);
    for (const Task* input : task.inputs) cost += cost_of(input);
    return task.usual > 0 && task.usual < 5 * cost;
}

// The task's key by the names of its inputs' contents.
Key content_key(CookState& cook, const Task& task)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    std::vector<graph::ContentName> names;
    std::size_t at = 0;
    const auto add_port = [&](std::size_t port) {
        for (const graph::Link& link : node.inputs[port]) {
            const std::size_t frames = cook.keys.input_frames(task.node, port, task.frame).size();
            for (std::size_t i = 0; i < frames; ++i) {
                const Result& input = *task.inputs[at++]->result;
                names.push_back(input.names(cook.caches.names)[link.output]);
            }
        }
    };
    if (task.preparation >= 0) {
        const auto which = static_cast<std::size_t>(task.preparation);
        for (const std::size_t port : node.type->preparations[which].inputs) add_port(port);
        return cook.keys.preparation_by_content(task.node, which, task.frame, names);
    }
    for (std::size_t port = 0; port < node.inputs.size(); ++port) add_port(port);
    for (const graph::Previous& p : node.type->previous) {
        names.push_back(task.previous ? task.previous->result->names(cook.caches.names)[p.output]
                                      : graph::ContentName{});
    }
    return cook.keys.by_content(task.node, task.frame, names);
}

}  // namespace

bool compare_contents(CookState& cook, Task& task, Outcome& outcome)
{
    const bool is_node = task.preparation < 0;
    const bool worth_it = !(is_node && quick(task)) && !dear_to_compare(task);
    if (worth_it) {
        outcome.same = content_key(cook, task);
        outcome.result = find_same(cook, task, outcome.same);
        outcome.equal = outcome.result != nullptr;
        if (outcome.equal) return true;
        task.same = outcome.same;
    }
    outcome.other = is_node && !cook.graph.nodes[task.node].type->preparations.empty();
    return outcome.other;
}

}  // namespace runtime
