#include "graph/document/check_json.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace graph {

Problem problem_at(Place place, std::string message)
{
    Problem p;
    p.place = std::move(place);
    p.message = std::move(message);
    return p;
}

Problem wrong(const Json& found, std::string expected)
{
    Problem p = problem_at(found.place());
    p.expected = std::move(expected);
    p.found = found.snippet();
    return p;
}

void refuse_unknown(const Json& json, std::span<const std::string_view> known,
                    const std::string& what, const std::string& node, Problems& problems)
{
    for (const Member& member : *json.object()) {
        if (std::find(known.begin(), known.end(), member.key) != known.end()) continue;
        Problem p = problem_at(member.key_place(), fmt::format("{} has no '{}'", what, member.key));
        p.node = node;
        p.suggestion = suggest(member.key, known);
        problems.add(std::move(p));
    }
}

void want_text(const Json* json, const std::string& node, Problems& problems)
{
    if (!json || json->text()) return;
    Problem p = wrong(*json, "text in quotes");
    p.node = node;
    problems.add(std::move(p));
}

std::vector<std::string_view> member_names(const Json* json)
{
    std::vector<std::string_view> names;
    if (json && json->object()) {
        for (const Member& m : *json->object()) names.emplace_back(m.key);
    }
    return names;
}

}  // namespace graph
