#pragma once

// All node types by name. Filled once at start (nodes/registry.hpp), read by everything after.

#include "graph/types/node_type.hpp"

#include <map>
#include <string>
#include <utility>

namespace graph {

template <class In, class Out> class NodeBuilder;

class Registry {
public:
    template <class In, class Out>
    NodeBuilder<In, Out> add(std::string name, int version, Out (*run)(const In&, const Context&))
    {
        NodeType& type = types_[name];
        type.name = std::move(name);
        type.version = version;
        return {type, run};
    }

    // Null when there is no such type.
    const NodeType* find(const std::string& name) const
    {
        const auto found = types_.find(name);
        return found == types_.end() ? nullptr : &found->second;
    }
    const std::map<std::string, NodeType>& types() const { return types_; }

    // For what all types are given alike.
    template <class Change> void for_each(const Change& change)
    {
        for (auto& [name, type] : types_) change(type);
    }

private:
    std::map<std::string, NodeType> types_;
};

}  // namespace graph
