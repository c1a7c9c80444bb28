#pragma once

// Settings to try: every combination of the values given for some parameters.

#include "graph/document/document.hpp"

namespace runtime {

// "sim.substeps=1,2,4": one parameter and what to set it to in turn.
struct Vary {
    std::string target;               // "sim.substeps"
    std::vector<std::string> values;  // each as after `=` in graph::Override
};

// Values are parted by commas outside of brackets, parentheses and quotes, so that a vector is one
// value, and so is a call in an expression. Blanks around a value are left out. Throws
// std::invalid_argument on anything that does not read node.param=a,b,c.
Vary parse_vary(std::string_view text);

using Settings = std::vector<graph::Override>;

// All combinations, the last parameter varying fastest; one empty combination when nothing varies.
// Throws std::invalid_argument when there would be more than `most`.
std::vector<Settings> combinations(const std::vector<Vary>& varied, std::size_t most = 10'000);

// "sim.substeps=4 cubes.size=0.02", for people and picture labels.
std::string describe(const Settings& settings);

}  // namespace runtime
