#include "graph/document/overrides.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/load_options.hpp"
#include "graph/document/parse_json.hpp"
#include "graph/document/read_documents.hpp"

#include <algorithm>
#include <charconv>
#include <regex>

#include <fmt/format.h>

namespace graph {

std::optional<Problem> set_param(Json& body, std::string_view path, Json value)
{
    Json* at = &child(body, "params", value);
    for (std::size_t begin = 0; begin <= path.size();) {
        const std::size_t end = std::min(path.find('.', begin), path.size());
        const std::string key(path.substr(begin, end - begin));
        // A list that the document does not state has no elements yet.
        if (begin > 0 && key == "0" && at->object() && at->object()->empty()) {
            at->is = Json::Array{Json{Json::Object{}, value.origin, value.begin, value.end}};
        }
        begin = end + 1;
        if (Json::Array* items = at->array()) {
            std::size_t i = 0;
            const auto [stop, error] = std::from_chars(key.data(), key.data() + key.size(), i);
            if (error != std::errc() || stop != key.data() + key.size() || i >= items->size()) {
                Problem p = problem_at({}, "the list has no such element");
                p.expected = fmt::format("an index below {}", items->size());
                p.found = key;
                return p;
            }
            at = &(*items)[i];
        } else {
            at = &child(*at, key, value);
        }
    }
    *at = std::move(value);
    return {};
}

namespace {

// JSON's form of numbers as they are typed in a shell: "0.03" of ".03", "3" of "+3", "5.0" of "5.",
// in lists too. Other texts stay.
std::string as_json_numbers(const std::string& text)
{
    if (text.find_first_not_of("0123456789.+-eE,[] ") != std::string::npos) return text;
    static const std::regex plus(R"((^|[\[, ])\+(?=[0-9.]))"), no_zero(R"((^|[\[, -])\.(?=[0-9]))"),
        no_digit(R"(([0-9])\.(?=$|[\], eE]))");
    std::string out = std::regex_replace(text, plus, "$1");
    out = std::regex_replace(out, no_zero, "$010.");
    return std::regex_replace(out, no_digit, "$1.0");
}

}  // namespace

void apply_overrides(Loading& loading, std::vector<Declaration>& declarations, Document& document,
                     OverridesOf which)
{
    std::unordered_map<std::string, std::size_t> index;
    for (const Override& o : loading.options.sets) {
        const std::size_t dot = std::min(o.target.find('.'), o.target.size());
        const std::string name = o.target.substr(0, dot);
        if ((name.find('/') != std::string::npos) != (which == OverridesOf::subgraphs)) continue;
        if (index.empty()) {
            for (std::size_t i = 0; i < declarations.size(); ++i) {
                index.emplace(declarations[i].name, i);
            }
        }
        const std::string text = fmt::format("--set {}={}", o.target, o.value);
        const std::string given = as_json_numbers(o.value);
        Origin& origin = new_origin(loading, document,
                                    std::make_shared<const Source>(
                                        text, document.origins[0]->source->folder(), given, false));
        origin.grammar = document.origins[0]->grammar;
        origin.layer = 1;  // over all documents
        Problems ignored;
        std::optional<Json> value =
            parse_json(origin, {.depth = loading.options.max_depth}, ignored);
        if (!value) {
            value = Json{given, &origin, 0, static_cast<std::uint32_t>(given.size())};
        }
        const auto found = index.find(name);
        std::optional<Problem> p;
        if (dot + 1 >= o.target.size()) {
            p = problem_at({});
            p->expected = "node.parameter=value";
            p->found = o.target;
        } else if (found == index.end()) {
            p = problem_at({}, fmt::format("there is no node '{}'", name));
            std::vector<std::string_view> names;
            for (const Declaration& d : declarations) names.emplace_back(d.name);
            p->suggestion = suggest(name, names);
        } else {
            p = set_param(declarations[found->second].body,
                          std::string_view(o.target).substr(dot + 1), std::move(*value));
            if (p) p->node = name;
        }
        if (p) {
            p->place = {text, 0, 0};
            loading.problems.add(std::move(*p));
        }
    }
}

}  // namespace graph
