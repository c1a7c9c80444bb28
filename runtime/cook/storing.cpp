#include "runtime/cook/storing.hpp"

#include <algorithm>
#include <cmath>

namespace runtime {

namespace {

// s. Any frame of a stored simulation is at most this much work away: a third of what a person who
// scrubs through the frames notices.
constexpr double scrub_seconds = 5e-3;

}  // namespace

bool storable(const graph::OutputPort& port)
{
    return port.wire && port.wire->encode;
}

bool storable(const graph::NodeType& type)
{
    return std::all_of(type.outputs.begin(), type.outputs.end(),
                       [](const graph::OutputPort& port) { return storable(port); });
}

bool still_there(const Result& result, FileDigests& files)
{
    return std::all_of(result.files.begin(), result.files.end(),
                       [&](const Written& w) { return w.digest && files.of(w.path) == w.digest; });
}

double since_stored(const Task& task)
{
    return task.previous ? task.previous->result->since_stored : 0;
}

bool worth_storing(const CookState& cook, const Task& task, const Result& result)
{
    const graph::NodeType& type = *cook.graph.nodes[task.node].type;
    if (!cook.caches.disk || task.preparation >= 0 || !storable(type)) return false;
    if (std::any_of(result.files.begin(), result.files.end(),
                    [](const Written& w) { return !w.digest; })) {
        return false;
    }
    const bool pays = DiskCache::pays(result.seconds, result.bytes);
    if (!cook.keys.rolls(task.node)) return pays || !result.files.empty();
    const double all = static_cast<double>(result.bytes) * cook.graph.range.count();
    const double share = static_cast<double>(cook.caches.disk->budget()) / 4;
    const int spacing = static_cast<int>(std::ceil(std::max(all / std::max(share, 1.0), 1.0)));
    const bool due = (task.frame - cook.graph.range.first) % spacing == 0;
    return (pays && due) || since_stored(task) + result.seconds > scrub_seconds * spacing;
}

std::vector<Heard> warnings_before(CookState& cook, const Task& task)
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
    const std::lock_guard lock(cook.mutex);
    Warners::Heap heap(cook.warners);
    each([&](const Task& t) { heap.add(t.key, t.node, t.frame, *t.result); });
    return heap.take();
}

std::vector<std::shared_ptr<const Told>> told_with(const CookState& cook, const Task& task,
                                                   const graph::Figures& own)
{
    std::vector<std::shared_ptr<const Told>> all;
    const bool varies = cook.keys.varies(task.node);
    for (const Task* input : task.inputs) {
        // What gathered all frames is told by them, and would be told again in each of these.
        if (varies && cook.graph.nodes[input->node].type->gather_frames) continue;
        all.insert(all.end(), input->result->told.begin(), input->result->told.end());
    }
    if (!own.all.empty()) {
        const graph::Node& node = cook.graph.nodes[task.node];
        all.push_back(
            std::make_shared<Told>(Told{task.key, task.frame, node.name, node.type->name, own}));
    }
    if (all.size() < 2) return all;
    std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) {
        return std::tie(a->node, a->frame, a->from) < std::tie(b->node, b->frame, b->from);
    });
    const auto same = [](const auto& a, const auto& b) { return a->from == b->from; };
    all.erase(std::unique(all.begin(), all.end(), same), all.end());
    return all;
}

bool tell_the_same(const std::vector<std::shared_ptr<const Told>>& a,
                   const std::vector<std::shared_ptr<const Told>>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& x, const auto& y) {
        return x->from == y->from && x->frame == y->frame && x->figures == y->figures;
    });
}

}  // namespace runtime
