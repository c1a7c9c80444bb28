#include "runtime/cook/run_task.hpp"

#include "graph/document/frame_path.hpp"
#include "graph/document/scene_pace.hpp"
#include "graph/types/standard_wires.hpp"
#include "runtime/cook/below_folder.hpp"
#include "runtime/cook/memory_limit.hpp"
#include "runtime/cook/same_contents.hpp"
#include "runtime/cook/storing.hpp"

#include <tbb/task_arena.h>

namespace runtime {

using graph::Value;

namespace {

// What an exception that left a node says.
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
        return "an unknown exception (no std::exception)";
    }
}

// From the disk cache; null when it is not there any more, or files that it tells of are not.

SharedResult load_result(CookState& cook, const Task& task)
{
    SharedResult result = cook.caches.disk->load(task.key, *cook.graph.nodes[task.node].type);
    return result && still_there(*result, cook.caches.files) ? result : nullptr;
}

// Puts values into the scratch in the order in which open_tasks.cpp attached the inputs.
// Returns where those of the next port begin.
std::size_t fill_port(CookState& cook, const Task& task, std::size_t port, std::size_t at,
                      Scratch& scratch)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    const graph::InputPort& description = node.type->inputs[port];
    for (const graph::Link& link : node.inputs[port]) {
        const std::size_t frames = cook.keys.input_frames(task.node, port, task.frame).size();
        for (std::size_t i = 0; i < frames; ++i) {
            const Value& value = task.inputs[at++]->result->values[link.output];
            const graph::Node& from = cook.graph.nodes[link.node];
            if (!value && !description.optional) {
                throw std::runtime_error("input '" + description.name + "' is empty: '" +
                                         from.name + "." + from.type->outputs[link.output].name +
                                         "' produced no value");
            }
            if (value || description.many || description.gather) {
                scratch.inputs[port].push_back(value);
            }
        }
    }
    return at;
}

void fill_inputs(CookState& cook, const Task& task, Scratch& scratch)
{
    const graph::NodeType& type = *cook.graph.nodes[task.node].type;
    if (scratch.inputs.size() < type.inputs.size()) scratch.inputs.resize(type.inputs.size());
    std::size_t at = 0;
    if (task.preparation >= 0) {
        const auto which = static_cast<std::size_t>(task.preparation);
        for (const std::size_t port : type.preparations[which].inputs) {
            at = fill_port(cook, task, port, at, scratch);
        }
        return;
    }
    for (std::size_t port = 0; port < type.inputs.size(); ++port) {
        at = fill_port(cook, task, port, at, scratch);
    }
    for (const graph::Previous& p : type.previous) {
        scratch.previous.push_back(task.previous ? task.previous->result->values[p.output]
                                                 : Value());
    }
    for (std::size_t i = 0; i < type.preparations.size(); ++i) {
        scratch.prepared.push_back(task.inputs[at++]->result->prepared);
    }
}

// What the node may ask while it runs. Its warnings go to `result`, the files that it opens to
// `outcome`; from many threads, so both wait for `talking`.
graph::Context context_of(CookState& cook, const Task& task, Result& result, Outcome& outcome,
                          std::mutex& talking)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    const graph::NodeType& type = *node.type;
    const bool paced = (type.reads & static_cast<unsigned>(graph::Variable::pace)) != 0;
    graph::Context context(task.frame, cook.graph.range, type.reads,
                           paced ? graph::scene_pace(cook.graph, task.node) : 0,
                           !node.animated.empty());
    context.stop = cook.options.stop;
    context.output_folder = cook.options.output_folder;
    context.root = cook.graph.root;
    context.cook = cook.shared;
    context.warn = [&talking, &result](const std::string& text) {
        const std::lock_guard lock(talking);
        auto& all = result.warnings;
        if (std::find(all.begin(), all.end(), text) == all.end()) all.push_back(text);
    };
    context.tell = [&talking, &result](graph::Figures figures) {
        const std::lock_guard lock(talking);
        result.figures = std::move(figures);
    };
    context.opened = [&cook, &task, &talking, &outcome](const std::filesystem::path& path) {
        if (!cook.keys.opens(task.node)) {
            throw std::logic_error("this node opens files but has no path_in parameter");
        }
        const std::lock_guard lock(talking);
        outcome.opened.insert(path);
    };
    if (type.gather_frames) {
        for (std::size_t port = 0; port < type.inputs.size(); ++port) {
            if (!type.inputs[port].gather) continue;
            const auto frames = cook.keys.input_frames(task.node, port, task.frame);
            context.gathered.assign(frames.begin(), frames.end());
        }
    }
    return context;
}

// The size of the values, and the files that a sink says it wrote.
void take_stock(Result& result, bool sink, FileDigests& digests)
{
    for (const Value& value : result.values) {
        result.bytes += value.bytes();
        if (!sink || !value || *value.type()->type != typeid(graph::WrittenFile)) continue;
        const auto written = value.as<graph::WrittenFile>();
        result.files.push_back(
            {written->path, written->shared ? Key() : digests.of(written->path)});
        for (const std::filesystem::path path : written->beside) {
            result.files.push_back({path, digests.of(path)});
        }
    }
}

// A sink's paths lie below the output folder, as far as the document says (it may have been allowed
// to name others). A symbolic link that lies there must not lead it elsewhere.
void refuse_links(const std::vector<graph::Param>& params, const graph::ParamValues& values,
                  const graph::Context& context, int frame)
{
    for (std::size_t i = 0; i < params.size(); ++i) {
        const auto* const text = std::get_if<std::string>(&values.at(i).is);
        if (params[i].kind != graph::ParamKind::path_out || !text || text->empty()) continue;
        const std::filesystem::path pattern = std::filesystem::path(*text).lexically_normal();
        if (names_outside(pattern)) continue;
        for (const auto& path : {pattern, graph::frame_path(pattern, frame)}) {
            if (!leads_out(context.output_folder, path)) continue;
            throw std::runtime_error("parameter '" + params[i].name +
                                     "': " + (context.output_folder / path).string() +
                                     " leads out of the output folder by a symbolic link; remove "
                                     "the link, or use --out DIR");
        }
    }
}

std::shared_ptr<Result> run_node(CookState& cook, const Task& task, Scratch& scratch,
                                 Outcome& outcome)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    const graph::NodeType& type = *node.type;
    fill_inputs(cook, task, scratch);
    auto result = std::make_shared<Result>();
    std::mutex talking;
    const graph::Context context = context_of(cook, task, *result, outcome, talking);
    const graph::ParamValues params =
        node.animated.empty() ? graph::ParamValues() : cook.keys.params(task.node, task.frame);
    const graph::ParamValues& values = node.animated.empty() ? node.params : params;
    if (type.sink) refuse_links(type.params, values, context, task.frame);
    result->values = type.run({{scratch.inputs.data(), type.inputs.size()},
                               values,
                               scratch.previous,
                               scratch.prepared,
                               context});
    if (result->values.size() != type.outputs.size()) {
        throw std::logic_error("returned " + std::to_string(result->values.size()) +
                               " outputs, its description declares " +
                               std::to_string(type.outputs.size()));
    }
    take_stock(*result, type.sink, cook.caches.files);
    return result;
}

std::shared_ptr<Result> run_preparation(CookState& cook, const Task& task, Scratch& scratch)
{
    const graph::Node& node = cook.graph.nodes[task.node];
    const graph::NodeType& type = *node.type;
    const graph::Preparation& preparation =
        type.preparations[static_cast<std::size_t>(task.preparation)];
    fill_inputs(cook, task, scratch);
    const graph::ParamValues params = cook.keys.params(task.node, task.frame);
    graph::Context context;
    context.stop = cook.options.stop;
    auto result = std::make_shared<Result>();
    result->prepared =
        preparation.build({{scratch.inputs.data(), type.inputs.size()}, params, {}, {}, context});
    if (result->prepared) result->bytes = preparation.bytes(result->prepared.get());
    return result;
}

// What was made again must be what was found.
void check_again(CookState& cook, const Task& task, const Result& made, Outcome& outcome)
{
    const auto& was = task.expected->names(cook.caches.names);
    const auto& is = made.names(cook.caches.names);
    const auto& outputs = cook.graph.nodes[task.node].type->outputs;
    for (std::size_t i = 0; i < is.size(); ++i) {
        if (was[i] == is[i]) continue;
        outcome.failure = "recheck failed: output '" + outputs[i].name +
                          "' differs from the stored result. The node depends on something that "
                          "is not in its key, or the stored result is wrong.";
        return;
    }
    for (std::size_t i = 0; i < made.files.size() && i < task.expected->files.size(); ++i) {
        if (made.files[i].digest == task.expected->files[i].digest) continue;
        outcome.failure = "recheck failed: " + made.files[i].path.string() +
                          " differs from the file that was written before";
        return;
    }
}

}  // namespace

Outcome run_task(CookState& cook, Task& task, Scratch& scratch)
{
    Outcome outcome;
    const Clock::time_point begin = Clock::now();
    outcome.run = {task.node,
                   task.frame,
                   task.preparation,
                   tbb::this_task_arena::current_thread_index(),
                   std::chrono::duration<double>(begin - cook.start).count(),
                   0,
                   0};
    // Isolated: a parallel loop in the node waits for its own pieces only and never picks up
    // another node, which could take long or wait for this one.
    std::shared_ptr<Result> made;
    tbb::this_task_arena::isolate([&] {
        try {
            if (task.load) {
                outcome.result = load_result(cook, task);
                outcome.absent = !outcome.result;
            } else if (task.compare && compare_contents(cook, task, outcome)) {
                return;
            } else {
                made = task.preparation < 0 ? run_node(cook, task, scratch, outcome)
                                            : run_preparation(cook, task, scratch);
            }
        } catch (const graph::Cancelled&) {
            outcome.cancelled = true;
        } catch (...) {
            outcome.failure = text_of(std::current_exception());
        }
    });
    outcome.run.seconds = seconds_since(begin);
    if (made && task.expected) check_again(cook, task, *made, outcome);
    if (made) {
        made->seconds = outcome.run.seconds;
        outcome.run.bytes = made->bytes;
        if (task.preparation < 0) {
            made->heard = warnings_before(cook, task);
            made->told = told_with(cook, task, made->figures);
        }
        outcome.store = worth_storing(cook, task, *made);
        made->since_stored = outcome.store ? 0 : since_stored(task) + made->seconds;
        outcome.result = std::move(made);
    }
    return outcome;
}

}  // namespace runtime
