#pragma once

// How a node type's declarations fill its struct of inputs and read its struct of outputs. The
// structs' types are forgotten, so that all kinds of node share this code: NodeBuilder collects a
// plan, and NodeType::run follows it.

#include "graph/types/node_type.hpp"
#include "graph/types/param_binding.hpp"

namespace graph {

struct NodePlan {
    struct Prepared {
        std::function<std::shared_ptr<const void>(const void* in)> build;
        std::function<void(void* in, const std::shared_ptr<const void>&)> set;
        std::vector<std::string> sees;
    };
    std::vector<std::function<void(void* in, const std::vector<Value>&)>> inputs;
    std::vector<std::function<void(void* in, const Value&)>> previous;
    std::vector<std::function<Value(void* out)>> outputs;
    std::vector<Prepared> preparations;
    ParamBinding params;

    void fill(const Call& call, void* in) const;
    // Only what the preparation may see.
    void fill_for(const Preparation& preparation, const Call& call, void* in) const;
    std::vector<Value> take(void* out) const;

    // Declarations, of `type` and of this.
    static void add_input(NodeType& type, std::string& name, const char* wire, std::string& doc);
    static void add_output(NodeType& type, std::string& name, const WireType& wire,
                           std::string& doc);
    static void add_previous(NodeType& type, const std::string& output, Memory memory);
    // Makes out which inputs and parameters the preparations see.
    void finish(NodeType& type) const;
};

}  // namespace graph
