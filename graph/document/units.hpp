#pragma once

// Numbers that a document gives with a unit, such as "2 cm" or "1 g/cm^3". Parameters take plain
// numbers in units of their own: what is found here only helps to say which number to write.

#include <optional>
#include <string_view>

namespace graph {

// How much `text`, a number and a unit, is in `unit`: 1000 for "1 g/cm3" in "kg/m^3". Null where it
// is not both, or not of that kind. Of a unit that is empty only percentages are.
std::optional<double> number_in(std::string_view text, std::string_view unit);

}  // namespace graph
