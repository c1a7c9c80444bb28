#pragma once

// Problems with a piece of a document: it is of the wrong kind, or has members that nobody knows.

#include "graph/document/json.hpp"
#include "graph/document/problem.hpp"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace graph {

Problem problem_at(Place place, std::string message = {});

// "expected ..., found ...".
Problem wrong(const Json& found, std::string expected);

// Reports the members of an object that are none of `known`.
void refuse_unknown(const Json& json, std::span<const std::string_view> known,
                    const std::string& what, const std::string& node, Problems& problems);

// Reports what is there and no text.
void want_text(const Json* json, const std::string& node, Problems& problems);

// The keys of an object; none of anything else.
std::vector<std::string_view> member_names(const Json* json);

}  // namespace graph
