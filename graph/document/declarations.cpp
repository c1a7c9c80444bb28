#include "graph/document/declarations.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/expression.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/read_constants.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace graph {

namespace {

constexpr std::size_t most_variables = 10'000;

bool good_name(std::string_view name)
{
    const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
    return !name.empty() && letter(name[0]) && std::all_of(name.begin(), name.end(), [&](char c) {
        return letter(c) || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
}

}  // namespace

FrameRange read_frames(Loading& loading, const Json* json)
{
    FrameRange range;
    if (!json) return range;
    if (!json->object()) {
        loading.problems.add(wrong(*json, "{ \"first\": 1, \"last\": 120, \"fps\": 24 }"));
        return range;
    }
    static constexpr std::string_view known[] = {"first", "last", "fps"};
    refuse_unknown(*json, known, "\"frames\"", {}, loading.problems);
    const Json *first = json->find("first"), *last = json->find("last"), *fps = json->find("fps");
    if (first) range.first = read_frame(*first, loading.problems).value_or(range.first);
    range.last = range.first;
    if (last) range.last = read_frame(*last, loading.problems).value_or(range.last);
    if (range.last < range.first) {
        loading.problems.add(
            wrong(last ? *last : *json, fmt::format("a last frame of at least {}", range.first)));
        range.last = range.first;
    } else if (std::int64_t{range.last} - range.first >= loading.options.max_frames) {
        loading.problems.add(
            wrong(*last, fmt::format("at most {} frames", loading.options.max_frames)));
        range.last = range.first;
    }
    if (fps) {
        const std::string expected = "frames per second above 0, at most 1e6";
        const std::optional<double> x = read_number(*fps, expected, loading.problems);
        if (x && *x > 0 && *x <= 1e6) {
            range.fps = *x;
        } else if (x) {
            loading.problems.add(wrong(*fps, expected));
        }
    }
    return range;
}

Variables read_variables(Loading& loading, Document& document, const Json* json,
                         std::map<std::string, double, std::less<>>& given)
{
    Variables all;
    auto grammar = std::make_shared<Grammar>();
    grammar->define("fps", loading.graph.range.fps);
    for (Origin* origin : document.origins) origin->grammar = grammar;
    if (!json) return all;
    if (!json->object()) {
        loading.problems.add(wrong(*json, "an object of numbers, { \"scale\": 0.02 }"));
        return all;
    }
    if (json->object()->size() > most_variables) {
        loading.problems.add(
            problem_at(json->place(), fmt::format("more than {} variables", most_variables)));
        return all;
    }
    for (const Member& member : *json->object()) grammar->announce(member.key);
    for (const Member& member : *json->object()) {
        if (!Grammar::free_name(member.key)) {
            Problem p = problem_at(member.key_place(),
                                   fmt::format("invalid variable name '{}'", member.key));
            p.expected = "letters, digits and _, not starting with a digit, and not the name of a "
                         "function or constant";
            loading.problems.add(std::move(p));
            continue;
        }
        const auto found = given.find(member.key);
        // After a report any number will do.
        const double value =
            found != given.end()
                ? found->second
                : read_number(member.value, "a number", loading.problems).value_or(1);
        if (found != given.end()) given.erase(found);
        grammar->define(member.key, value);
        all.emplace_back(member.key, value);
    }
    return all;
}

std::vector<Declaration> declare_nodes(Json& root, const std::string& prefix, Problems& problems)
{
    std::vector<Declaration> declarations;
    Json* nodes = root.find("nodes");
    if (!nodes) return declarations;
    if (!nodes->object()) {
        problems.add(wrong(*nodes, "an object of nodes, { \"name\": {...} }"));
        return declarations;
    }
    declarations.reserve(nodes->object()->size());
    for (Member& member : *nodes->object()) {
        Place place = member.key_place();
        if (!good_name(member.key)) {
            Problem p = problem_at(place, fmt::format("invalid node name '{}'", member.key));
            p.expected = "letters, digits, _ and -, starting with a letter";
            problems.add(std::move(p));
        } else if (!member.value.object()) {
            Problem p = wrong(member.value, "{ \"type\": \"...\", ... }");
            p.node = prefix + member.key;
            problems.add(std::move(p));
        } else {
            declarations.push_back(
                {prefix + member.key, std::move(place), std::move(member.value)});
        }
    }
    return declarations;
}

}  // namespace graph
