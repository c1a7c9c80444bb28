#pragma once

// Changes graph documents at random, by what node types say of themselves: parameters get values
// that they may have and values that they may not, inputs are linked to outputs of their type,
// nodes come and go. What comes out is a document that mostly loads.

#include "graph/types/registry.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

namespace fuzz {

using Json = nlohmann::json;

class Changes {
public:
    // Nodes of the types in `left_out` are not added.
    Changes(const graph::Registry& registry, std::set<std::string> left_out, unsigned seed)
        : registry_(registry), random_(seed)
    {
        for (const auto& [name, type] : registry.types()) {
            if (!left_out.contains(name)) types_.push_back(&type);
        }
    }

    void change(Json& document)
    {
        Json& nodes = document["nodes"];
        if (!nodes.is_object()) nodes = Json::object();
        const auto what = below(20);
        if (what < 12) {
            change_param(nodes);
        } else if (what < 15) {
            link(nodes);
        } else if (what < 18) {
            add(nodes);
        } else if (what < 19) {
            remove(nodes);
        } else {
            document["frames"] = {{"first", 1}, {"last", 2 + below(4)}, {"fps", pick(rates)}};
        }
    }

private:
    static inline const std::vector<double> rates{24, 1, 240, 1e-3};
    static inline const std::vector<double> numbers{0,      -1,   1,     0.5,    2,    10,   -0.25,
                                                    1e-3,   1e-9, 1e-30, 1e3,    1e6,  1e30, 1e300,
                                                    1e-300, 89.9, 180,   0.4999, 1e-6, 7e10};
    static inline const std::vector<std::string> expressions{
        "=frame",  "=t * 3 - 1", "=1 / 0",         "=frame - 2",
        "=sin(t)", "=0 * frame", "=1e200 * frame", "=x"};
    static inline const std::vector<std::string> texts{"",      "a",   "x * 2", "x > 0 ? 1 : 0",
                                                       "1 / 0", "box", "ball",  "no such thing"};
    static inline const std::vector<std::string> files{"a.obj",     "open.ply",    "points.xyz",
                                                       "lines.obj", "missing.obj", "empty.obj"};

    std::size_t below(std::size_t n)
    {
        return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
    }
    template <class T> const T& pick(const std::vector<T>& from)
    {
        return from[below(from.size())];
    }

    Json* any_node(Json& nodes)
    {
        if (nodes.empty()) return nullptr;
        auto at = nodes.begin();
        std::advance(at, static_cast<std::ptrdiff_t>(below(nodes.size())));
        return at->is_object() ? &*at : nullptr;
    }

    const graph::NodeType* type_of(const Json& node) const
    {
        if (!node.is_object() || !node.contains("type") || !node["type"].is_string())
            return nullptr;
        const auto text = node["type"].get<std::string>();
        return registry_.find(text.substr(0, text.find('@')));
    }

    double number(const graph::Param& param)
    {
        const auto* whole = std::get_if<std::int64_t>(&param.fallback.is);
        const auto* real = std::get_if<double>(&param.fallback.is);
        const double usual = whole ? double(*whole) : real ? *real : 1;
        const double any = any_number(param, usual);
        return below(10) == 0 ? any : std::clamp(any, param.limits.min, param.limits.max);
    }

    double any_number(const graph::Param& param, double usual)
    {
        switch (below(6)) {
        case 0:
            return std::isfinite(param.limits.min) ? param.limits.min : pick(numbers);
        case 1:
            return std::isfinite(param.limits.max) ? param.limits.max : pick(numbers);
        case 2:
            return usual * pick(std::vector<double>{0.1, 0.5, 2, 10, -1});
        case 3:
            return std::uniform_real_distribution<double>(-1, 2)(random_);
        default:
            return pick(numbers);
        }
    }

    Json value(const graph::Param& param)
    {
        using graph::ParamKind;
        if (below(30) == 0) return pick(expressions);
        switch (param.kind) {
        case ParamKind::boolean:
            return below(2) == 0;
        case ParamKind::integer: {
            const double n = std::clamp(std::round(number(param)), -10.0, 300.0);
            return static_cast<std::int64_t>(n);
        }
        case ParamKind::number:
            return number(param);
        case ParamKind::vector:
            return {number(param), number(param), number(param)};
        case ParamKind::colour:
            return {0.5, 0.1, number(param)};
        case ParamKind::text:
            return pick(texts);
        case ParamKind::choice:
            return pick(param.choices);
        case ParamKind::path_in:
            return pick(files);
        case ParamKind::path_out:
            return pick(std::vector<std::string>{"o/####.ply", "b.obj"});
        case ParamKind::list: {
            Json list = Json::array();
            for (auto n = below(3); n > 0; --n) list.push_back(block(param.children));
            return list;
        }
        case ParamKind::block:
            return block(param.children);
        }
        return nullptr;
    }

    Json block(const std::vector<graph::Param>& children)
    {
        Json out = Json::object();
        if (children.empty()) return out;
        for (auto n = 1 + below(3); n > 0; --n) {
            const graph::Param& child = pick(children);
            out[child.name] = value(child);
        }
        return out;
    }

    void change_param(Json& nodes)
    {
        Json* const node = any_node(nodes);
        const graph::NodeType* const type = node ? type_of(*node) : nullptr;
        if (!type || type->params.empty()) return;
        Json& params = (*node)["params"];
        if (!params.is_object()) params = Json::object();
        const graph::Param* param = &pick(type->params);
        Json* at = &params;
        while (param->kind == graph::ParamKind::block && !param->children.empty()) {
            at = &(*at)[param->name];
            if (!at->is_object()) *at = Json::object();
            param = &pick(param->children);
        }
        if (below(12) == 0) {
            at->erase(param->name);
        } else {
            (*at)[param->name] = value(*param);
            if (param->shown_when.param.empty() || below(3) == 0) return;
            (*at)[param->shown_when.param] = pick(param->shown_when.values);
        }
    }

    // Outputs of a type, as links.
    std::vector<std::string> outputs(const Json& nodes, const std::string& wire)
    {
        std::vector<std::string> out;
        for (const auto& [name, node] : nodes.items()) {
            const graph::NodeType* const type = type_of(node);
            if (!type) continue;
            for (const auto& port : type->outputs) {
                if (port.type == wire || below(40) == 0) out.push_back(name + "." + port.name);
            }
        }
        return out;
    }

    void link_port(Json& nodes, Json& node, const graph::InputPort& port)
    {
        const auto sources = outputs(nodes, port.type);
        Json& inputs = node["inputs"];
        if (!inputs.is_object()) inputs = Json::object();
        if (sources.empty()) {
            inputs.erase(port.name);
        } else if (port.many && below(2) == 0) {
            inputs[port.name] = {pick(sources), pick(sources)};
        } else {
            inputs[port.name] = pick(sources);
        }
    }

    void link(Json& nodes)
    {
        Json* const node = any_node(nodes);
        const graph::NodeType* const type = node ? type_of(*node) : nullptr;
        if (!type || type->inputs.empty()) return;
        const graph::InputPort& port = pick(type->inputs);
        if (below(6) == 0 && node->contains("inputs")) {
            (*node)["inputs"].erase(port.name);
        } else {
            link_port(nodes, *node, port);
        }
    }

    void add(Json& nodes)
    {
        if (nodes.size() > 24) return remove(nodes);
        const graph::NodeType& type = *pick(types_);
        Json node{{"type", type.name + "@" + std::to_string(type.version)}};
        for (const auto& port : type.inputs) {
            if (!port.optional || below(2) == 0) link_port(nodes, node, port);
        }
        node["params"] = block(type.params);
        nodes["n" + std::to_string(below(100))] = node;
    }

    void remove(Json& nodes)
    {
        if (nodes.size() < 2) return;
        auto at = nodes.begin();
        std::advance(at, static_cast<std::ptrdiff_t>(below(nodes.size())));
        nodes.erase(at);
    }

    const graph::Registry& registry_;
    std::vector<const graph::NodeType*> types_;
    std::mt19937 random_;
};

}  // namespace fuzz
