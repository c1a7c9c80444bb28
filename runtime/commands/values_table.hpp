#pragma once

// The numbers of a cook as a table that spreadsheets and scripts read.

#include "runtime/commands/front_end.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace runtime {

inline constexpr const char* values_name = "values.csv";

// Whether a file begins as such a table does.
bool is_values_table(const std::filesystem::path& file);

// The nodes with an output that is a number.
std::vector<std::uint32_t> nodes_with_numbers(const graph::Graph& graph);

// A row for each frame: its number, its time in seconds, and the numbers of `wires`, each
// in a column of its own under its name and unit, "tip (m)". Where none was made, nothing stands.
// `numbers` as FrontEnd::numbers() has them; `unit_of` as in Console.
std::string values_table(const graph::Graph& graph, const std::vector<int>& frames,
                         const std::vector<graph::Link>& wires,
                         const std::vector<AskedNumber>& numbers,
                         const std::function<std::string(const graph::Node&)>& unit_of);

}  // namespace runtime
