#include "graph/tools/schema.hpp"

#include "graph/types/registry.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

#include <fmt/format.h>

namespace graph {

namespace {

using Object = nlohmann::ordered_json;

constexpr const char* name_pattern = "^[A-Za-z][A-Za-z0-9_-]*$";
constexpr const char* link_pattern = "^[A-Za-z][A-Za-z0-9_-]*(\\.[A-Za-z_][A-Za-z0-9_]*)?$";
constexpr const char* file_pattern = "\\.json(@[0-9]+)?$";

Object reference(const char* definition)
{
    return {{"$ref", fmt::format("#/definitions/{}", definition)}};
}

Object limited(const char* type, const Limits& limits)
{
    Object schema = {{"type", type}};
    if (std::isfinite(limits.min)) schema["minimum"] = limits.min;
    if (std::isfinite(limits.max)) schema["maximum"] = limits.max;
    return schema;
}

Object triple(Object item)
{
    return {{"type", "array"}, {"items", std::move(item)}, {"minItems", 3}, {"maxItems", 3}};
}

// Keyframes whose values follow `value`.
Object curve(Object value)
{
    Object key = {{"type", "array"},
                  {"items", {{{"type", {"number", "string"}}}, std::move(value)}},
                  {"minItems", 2},
                  {"maxItems", 2}};
    return {{"type", "object"},
            {"required", {"keys"}},
            {"properties",
             {{"keys", {{"type", "array"}, {"minItems", 1}, {"items", std::move(key)}}},
              {"interpolation", {{"enum", {"monotone", "smooth", "linear", "step"}}}},
              {"extend", {{"enum", {"hold", "cycle"}}}},
              {"times", {{"enum", {"frames", "seconds"}}}}}},
            {"additionalProperties", false}};
}

Object params_schema(const std::vector<Param>& params);

Object default_of(const Param& p)
{
    if (const auto* v = std::get_if<std::array<double, 3>>(&p.fallback.is)) return *v;
    if (const auto* b = std::get_if<bool>(&p.fallback.is)) return *b;
    if (const auto* i = std::get_if<std::int64_t>(&p.fallback.is)) return *i;
    if (const auto* d = std::get_if<double>(&p.fallback.is)) return *d;
    if (const auto* s = std::get_if<std::string>(&p.fallback.is)) return *s;
    return nullptr;
}

Object value_schema(const Param& p)
{
    const Object number = limited(p.kind == ParamKind::integer ? "integer" : "number", p.limits);
    const Object moving = {{"anyOf", {number, reference("expression")}}};
    const Object hex = {{"type", "string"}, {"pattern", "^#([0-9a-fA-F]{3}|[0-9a-fA-F]{6})$"}};
    switch (p.kind) {
    case ParamKind::boolean:
        return {{"type", "boolean"}};
    case ParamKind::integer:
    case ParamKind::number:
        return {{"anyOf", {number, reference("expression"), curve(limited("number", p.limits))}}};
    case ParamKind::vector:
    case ParamKind::colour: {
        const Object one = {{"anyOf", {number, reference("expression"), curve(moving)}}};
        Object key = triple(moving);
        if (p.kind == ParamKind::colour) key = {{"anyOf", {key, hex}}};
        Object any = Object::array({triple(one), curve(key)});
        if (p.kind == ParamKind::colour) any.push_back(hex);
        return {{"anyOf", std::move(any)}};
    }
    case ParamKind::text:
    case ParamKind::path_in:
    case ParamKind::path_out:
        return {{"type", "string"}};
    case ParamKind::choice:
        return {{"enum", p.choices}};
    case ParamKind::list:
        return {{"type", "array"}, {"items", params_schema(p.children)}};
    case ParamKind::block:
        return params_schema(p.children);
    }
    return Object::object();
}

Object params_schema(const std::vector<Param>& params)
{
    Object properties = Object::object();
    for (const Param& p : params) {
        Object schema = value_schema(p);
        std::string text = p.doc;
        if (!p.limits.unit.empty()) text += fmt::format(" In {}.", p.limits.unit);
        if (!p.shown_when.param.empty()) {
            text += fmt::format(" Only while {} is {}.", p.shown_when.param,
                                fmt::join(p.shown_when.values, " or "));
        }
        schema["description"] = std::move(text);
        if (p.kind != ParamKind::list && p.kind != ParamKind::block) {
            schema["default"] = default_of(p);
        }
        properties[p.name] = std::move(schema);
    }
    return {
        {"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
}

// Those of a type, some of which have short forms.
Object params_schema(const NodeType& type)
{
    Object schema = params_schema(type.params);
    for (const auto& [name, form] : type.short_forms.schemas) {
        schema["properties"][name]["anyOf"].push_back(Object::parse(form));
    }
    return schema;
}

// What a node of this type has beside its type.
Object type_schema(const NodeType& type)
{
    Object inputs = Object::object(), required = Object::array();
    for (const InputPort& port : type.inputs) {
        Object schema = reference(port.many ? "links" : "link");
        // draft-07 looks at nothing beside $ref, so the description goes around it.
        inputs[port.name] = {{"allOf", Object::array({std::move(schema)})},
                             {"description", fmt::format("{} ({})", port.doc, port.type)}};
    }
    return {{"properties",
             {{"inputs",
               {{"type", "object"},
                {"properties", std::move(inputs)},
                {"additionalProperties", false}}},
              {"params", params_schema(type)}}}};
}

Object node_schema(const Registry& registry)
{
    Object types = Object::array(), cases = Object::array();
    for (const auto& [name, type] : registry.types()) {
        types.push_back(
            {{"const", fmt::format("{}@{}", name, type.version)}, {"description", type.summary}});
        cases.push_back(
            {{"if",
              {{"properties",
                {{"type", {{"pattern", fmt::format("^{}(@{})?$", name, type.version)}}}}},
               {"required", {"type"}}}},
             {"then", type_schema(type)}});
    }
    types.push_back({{"type", "string"},
                     {"pattern", "^[A-Za-z0-9]+(@[0-9]+)?$"},
                     {"description", "A node type, perhaps of an older version."}});
    types.push_back({{"type", "string"},
                     {"pattern", file_pattern},
                     {"description", "A subgraph: the path of its file."}});
    return {{"type", "object"},
            {"properties",
             {{"type", {{"anyOf", std::move(types)}}},
              {"inputs", {{"type", "object"}}},
              {"params", {{"type", "object"}}},
              {"doc", {{"type", "string"}, {"description", "A note for people."}}},
              {"ui", {{"description", "What an editor keeps for itself."}}}}},
            {"additionalProperties", false},
            {"allOf", std::move(cases)}};
}

Object frames_schema()
{
    const Object number = {{"anyOf", {{{"type", "number"}}, reference("expression")}}};
    return {{"type", "object"},
            {"description", "The frames to cook, both ends included."},
            {"properties", {{"first", number}, {"last", number}, {"fps", number}}},
            {"additionalProperties", false}};
}

Object expectation_schema()
{
    const Object number = {{"type", {"number", "string"}}};
    const Object frames = {{"anyOf",
                            {{{"enum", {"first", "last", "every"}}},
                             {{"type", "integer"}},
                             {{"type", "array"}, {"items", {{"type", "integer"}}}}}}};
    return {{"type", "object"},
            {"required", {"value"}},
            {"properties",
             {{"value", reference("link")},
              {"frame", frames},
              {"min", number},
              {"max", number},
              {"near", number},
              {"within", number},
              {"percent", number},
              {"why", {{"type", "string"}}}}},
            {"additionalProperties", false}};
}

Object subgraph_schema()
{
    const Object targets = {
        {"anyOf", {{{"type", "string"}}, {{"type", "array"}, {"items", {{"type", "string"}}}}}}};
    const Object text = {{"type", "string"}};
    const auto each = [](Object properties, const char* required) {
        return Object{{"type", "object"},
                      {"propertyNames", {{"pattern", name_pattern}}},
                      {"additionalProperties",
                       {{"type", "object"},
                        {"required", {required}},
                        {"properties", std::move(properties)},
                        {"additionalProperties", false}}}};
    };
    return {
        {"type", "object"},
        {"description", "Makes this document a node type for others."},
        {"properties",
         {{"version", {{"type", "integer"}, {"minimum", 1}}},
          {"inputs",
           each({{"to", targets}, {"doc", text}, {"optional", {{"type", "boolean"}}}}, "to")},
          {"outputs", each({{"from", reference("link")}, {"doc", text}}, "from")},
          {"params", each({{"to", targets}, {"doc", text}, {"default", Object::object()}}, "to")}}},
        {"additionalProperties", false}};
}

}  // namespace

std::string schema_text(const Registry& registry)
{
    const Object node = reference("node");
    Object schema = {
        {"$schema", "http://json-schema.org/draft-07/schema#"},
        {"title", "Aspic graph document"},
        {"type", "object"},
        {"required", {"aspic", "nodes"}},
        {"properties",
         {{"$schema", {{"type", "string"}}},
          {"aspic", {{"const", 1}, {"description", "The version of the format."}}},
          {"doc", {{"type", "string"}, {"description", "A note for people."}}},
          {"extends",
           {{"type", "string"},
            {"description", "A base document that this one changes: its path from here."}}},
          {"subgraph", reference("subgraph")},
          {"frames", reference("frames")},
          {"variables",
           {{"type", "object"},
            {"description", "Numbers that expressions may use."},
            {"propertyNames", {{"pattern", "^[A-Za-z_][A-Za-z0-9_]*$"}}},
            {"additionalProperties",
             {{"anyOf", {{{"type", "number"}}, reference("expression")}}}}}},
          {"nodes", {{"type", "object"}, {"propertyNames", {{"pattern", name_pattern}}}}},
          {"expect", {{"type", "array"}, {"items", reference("expectation")}}},
          {"ui", {{"description", "What an editor keeps for itself."}}}}},
        {"additionalProperties", false},
        // In a document that changes another, a node may be given in part, or as null to go.
        {"if", {{"required", {"extends"}}}},
        {"then",
         {{"properties",
           {{"nodes", {{"additionalProperties", {{"anyOf", {{{"type", "null"}}, node}}}}}}}}}},
        {"else",
         {{"properties",
           {{"nodes",
             {{"additionalProperties", {{"allOf", {node, {{"required", {"type"}}}}}}}}}}}}},
        {"definitions",
         {{"link",
           {{"type", "string"},
            {"pattern", link_pattern},
            {"description", "\"node.output\", or \"node\" when it has one output."}}},
          {"links",
           {{"anyOf", {reference("link"), {{"type", "array"}, {"items", reference("link")}}}}}},
          {"expression",
           {{"type", "string"},
            {"pattern", "^="},
            {"description", "\"=\" and a formula over frame, time, pi and the variables."}}},
          {"frames", frames_schema()},
          {"expectation", expectation_schema()},
          {"subgraph", subgraph_schema()},
          {"node", node_schema(registry)}}}};
    return schema.dump(2) + "\n";
}

}  // namespace graph
