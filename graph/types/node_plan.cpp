#include "graph/types/node_plan.hpp"

#include <cstdio>
#include <exception>
#include <stdexcept>
#include <utility>

namespace graph {

namespace {

void add_seen(const NodeType& type, const std::string& name, Preparation& p)
{
    for (std::size_t i = 0; i < type.inputs.size(); ++i) {
        if (type.inputs[i].name == name) return p.inputs.push_back(i);
    }
    for (std::size_t i = 0; i < type.params.size(); ++i) {
        if (type.params[i].name == name) return p.params.push_back(i);
    }
    std::fprintf(stderr, "%s: prepare() names no input or parameter: %s\n", type.name.c_str(),
                 name.c_str());
    std::terminate();  // a mistake in a description: every start of the program finds it
}

}  // namespace

void NodePlan::fill(const Call& call, void* in) const
{
    params.decode(call.params, in);
    for (std::size_t i = 0; i < inputs.size(); ++i) inputs[i](in, call.inputs[i]);
    for (std::size_t i = 0; i < previous.size(); ++i) previous[i](in, call.previous[i]);
    for (std::size_t i = 0; i < preparations.size(); ++i) {
        preparations[i].set(in, call.prepared[i]);
    }
}

void NodePlan::fill_for(const Preparation& preparation, const Call& call, void* in) const
{
    for (const std::size_t i : preparation.inputs) inputs[i](in, call.inputs[i]);
    for (const std::size_t i : preparation.params) params.set[i](in, call.params[i]);
}

std::vector<Value> NodePlan::take(void* out) const
{
    std::vector<Value> values;
    values.reserve(outputs.size());
    for (const auto& output : outputs) values.push_back(output(out));
    return values;
}

void NodePlan::add_input(NodeType& type, std::string& name, const char* wire, std::string& doc)
{
    type.inputs.push_back({std::move(name), wire, std::move(doc), false, false, false});
}

void NodePlan::add_output(NodeType& type, std::string& name, const WireType& wire, std::string& doc)
{
    type.outputs.push_back({std::move(name), wire.name, std::move(doc), &wire});
}

void NodePlan::add_previous(NodeType& type, const std::string& output, Memory memory)
{
    type.memory = memory;
    for (std::size_t i = 0; i < type.outputs.size(); ++i) {
        if (type.outputs[i].name == output) return type.previous.push_back({i});
    }
    throw std::logic_error(type.name + ": previous() names no output: " + output);
}

void NodePlan::finish(NodeType& type) const
{
    type.params = params.params;
    for (std::size_t i = 0; i < preparations.size(); ++i) {
        for (const std::string& name : preparations[i].sees) {
            add_seen(type, name, type.preparations[i]);
        }
    }
}

}  // namespace graph
