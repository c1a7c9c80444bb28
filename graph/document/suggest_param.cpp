#include "graph/document/suggest_param.hpp"

#include "graph/document/other_names.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace graph {

namespace {

using Names = std::vector<std::string_view>;

Names names_of(const std::vector<Param>& params)
{
    Names names;
    for (const Param& p : params) names.emplace_back(p.name);
    return names;
}

// Whether the choice that `param` depends on is made in `given`, or is the default.
bool is_shown(const std::vector<Param>& params, const Json* given, const Param& param)
{
    const ShownWhen& when = param.shown_when;
    const Json* const chosen = given && given->object() ? given->find(when.param) : nullptr;
    for (const Param& p : params) {
        if (p.name != when.param) continue;
        const auto* const text = chosen ? chosen->text() : std::get_if<std::string>(&p.fallback.is);
        return !text ||
               std::find(when.values.begin(), when.values.end(), *text) != when.values.end();
    }
    return true;
}

enum class By { name, other_name };
enum class Blocks { shown, all };

// Paths of the parameters in blocks, and in blocks of blocks, that `key` names.
std::vector<std::string> within(const std::vector<Param>& params, const Json* given,
                                const std::string& key, By by, Blocks which)
{
    std::vector<std::string> found;
    for (const Param& block : params) {
        if (block.kind != ParamKind::block) continue;
        if (which == Blocks::shown && !is_shown(params, given, block)) continue;
        const Names names = names_of(block.children);
        Names matches;
        if (by == By::other_name) {
            matches = own_names_of(key, names);
        } else if (std::find(names.begin(), names.end(), key) != names.end()) {
            matches = {key};
        }
        for (const std::string_view match : matches) {
            found.push_back(fmt::format("{}.{}", block.name, match));
        }
        const Json* const inner = given && given->object() ? given->find(block.name) : nullptr;
        for (const std::string& path : within(block.children, inner, key, by, which)) {
            found.push_back(fmt::format("{}.{}", block.name, path));
        }
    }
    return found;
}

// Of the items of lists, "properties[].part".
std::vector<std::string> within_lists(const std::vector<Param>& params, const std::string& key)
{
    std::vector<std::string> found;
    for (const Param& list : params) {
        if (list.kind != ParamKind::list) continue;
        for (const Param& p : list.children) {
            if (p.name == key) found.push_back(fmt::format("{}[].{}", list.name, key));
        }
    }
    return found;
}

}  // namespace

std::string suggest_param(const ParamReading& reading, const std::vector<Param>& params,
                          const Json& given, const std::string& key)
{
    const NodeType& type = *reading.node.type;
    for (const InputPort& input : type.inputs) {
        if (!reading.names.empty() || input.name != key) continue;
        return fmt::format("'{}' is an input: link it in \"inputs\"", key);
    }
    const Names names = names_of(params);
    if (const auto advice = advice_on_param(key, names); !advice.empty()) {
        return std::string(advice);
    }
    for (const Blocks which : {Blocks::shown, Blocks::all}) {
        for (const By by : {By::name, By::other_name}) {
            if (by == By::other_name && !own_names_of(key, names).empty()) {
                return suggest(key, names);
            }
            const std::vector<std::string> paths = within(params, &given, key, by, which);
            if (!paths.empty()) {
                return fmt::format("did you mean '{}'?", fmt::join(paths, "' or '"));
            }
        }
    }
    if (const auto paths = within_lists(params, key); !paths.empty()) {
        return fmt::format("did you mean '{}', in each item of the list?",
                           fmt::join(paths, "' or '"));
    }
    for (const Param& p : type.params) {
        if (reading.names.empty() || p.name != key) continue;
        return fmt::format("'{}' belongs outside '{}'", key, reading.names.front());
    }
    std::string near = suggest(key, names);
    if (near.empty() && !names.empty()) near = fmt::format("`aspic nodes {}` lists all", type.name);
    return near;
}

}  // namespace graph
