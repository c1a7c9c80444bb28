#pragma once

// The state of reading one node's parameters, and what reading any kind of parameter needs: its
// path, reports, and plain numbers that are checked against its limits.

#include "graph/document/graph.hpp"
#include "graph/document/json.hpp"
#include "graph/document/path_rules.hpp"

#include <optional>
#include <string>
#include <vector>

namespace graph {

struct ReadContext {
    const FrameRange& range;
    const PathRules& paths;
    Problems& problems;
};

struct ParamReading {
    const ReadContext& context;
    Node& node;
    std::vector<std::uint32_t> where = {};  // indices of the parameter being read, see Animated
    std::vector<std::string> names = {};    // the same as names: {"boxes", "2", "centre"}
};

// "boxes.2.centre": the parameter being read, or `last` inside of it.
std::string path_of(const ParamReading& reading, const std::string& last = {});

// A problem of the parameter being read.
Problem param_problem(const ParamReading& reading, Place place,
                      Severity severity = Severity::error);

// Reports "expected ..., found ..." of the parameter being read.
void complain(const ParamReading& reading, Place place, std::string expected, const Json& found,
              std::string help = {});

// The number within the parameter's limits, a whole one where it takes only those; null after a
// report.
std::optional<double> check(const ParamReading& reading, const Param& param, double x,
                            const Json& json, bool may_round);

// A plain number or a constant expression, rounded if need be and checked; else reports.
std::optional<double> read_plain(const ParamReading& reading, const Param& param, const Json& json,
                                 bool may_round = false);

// An entry of Node::animated for the parameter being read, its value still to be set.
Animated animated(const ParamReading& reading, const Param& param, const Json& json, int component);

}  // namespace graph
