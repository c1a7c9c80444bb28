#pragma once

// What `tune` varies: the size of cubes, and the steps a frame.

#include "graph/document/graph.hpp"

#include <cmath>
#include <limits>
#include <optional>
#include <string>

namespace runtime {

// A number of the graph that is tuned: halved spacings are half the value, or twice a count.
struct Dial {
    std::string target;   // a parameter, or a variable of the document
    double value = 0;     // in the document
    bool counts = false;  // takes whole numbers alone
    bool grows = false;   // finer is larger
    double least = -std::numeric_limits<double>::infinity(),
           most = std::numeric_limits<double>::infinity();
    std::string cubes = {};  // the node's output "cubes" as node.port; empty: it has none

    double at(int halvings) const { return std::ldexp(value, grows ? halvings : -halvings); }
    bool allows(int halvings) const
    {
        const double there = at(halvings);
        return there >= least && there <= most &&
               (!counts || (there >= 1 && there == std::floor(there)));
    }
};

// What a variable of the document is tuned by. What follows it is found by the numbers of the graph
// once the variable is `factor` times its value.
Dial following(const graph::Graph& graph, const graph::Graph& other, const std::string& name,
               double value, double factor);

// What --size names: the edge of cubes, or their number along the longest side where that says it.
// Where it is empty, that of the one Voxelize; nothing where there is none. Throws
// std::invalid_argument where there are several, or no such number.
std::optional<Dial> find_size(const graph::Graph& graph, const std::string& given);

// What --steps names, likewise: the number of steps a frame, or the error that chooses it where
// that is 0.
std::optional<Dial> find_steps(const graph::Graph& graph, const std::string& given);

bool is_name_of_variable(const std::string& given);

// "cubes" of "cubes.cubes".
std::string node_of(const std::string& wire);

// A node that chooses the size by itself would do so whatever is tried: throws
// std::invalid_argument.
void need_size_by_hand(const graph::Graph& graph, const std::string& node_name);

// Whether cubes of a node are solids with their stiffness as filled.
bool are_filled(const graph::Graph& graph, const std::string& node_name);

}  // namespace runtime
