#pragma once

// Settings to try: every combination of the values given for some parameters and variables.

#include "graph/document/document.hpp"

#include <string_view>
#include <utility>

namespace runtime {

// "sim.substeps=1,2,4": one parameter, or one variable of the document, and what to set it to in
// turn.
struct Vary {
    std::string target;               // "sim.substeps", "cell"
    std::vector<std::string> values;  // each as after `=` in graph::Override
};

// Values are parted by commas outside of brackets, parentheses and quotes, so that a vector is one
// value, and so is a call in an expression. Blanks around a value are left out. Throws
// std::invalid_argument on anything that does not read node.param=a,b,c or variable=a,b,c.
Vary parse_vary(std::string_view text);

// As in graph::Override, or a variable of the document and a number for it: "cell", "0.05".
using Settings = std::vector<graph::Override>;

// "sim.substeps=4" or "cell=0.05". Throws std::invalid_argument.
graph::Override parse_setting(std::string_view text);

// Whether what is set is a variable of the document: its name has no dot.
bool is_variable(std::string_view target);

// "cell=0.05". Throws std::invalid_argument.
std::pair<std::string, double> parse_variable(const std::string& text);

// Puts them over those of `options`.
void add_settings(graph::LoadOptions& options, const Settings& settings);

// All combinations, the last parameter varying fastest; one empty combination when nothing varies.
// Throws std::invalid_argument when there would be more than `most`.
std::vector<Settings> combinations(const std::vector<Vary>& varied, std::size_t most = 10'000);

// "sim.substeps=4 cubes.size=0.02", for people and picture labels.
std::string describe(const Settings& settings);

}  // namespace runtime
