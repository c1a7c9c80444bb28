#pragma once

// Lists such as "tip (mm), force (kN)", and what numbers in one unit are in another.

#include "graph/document/units.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace nodes::render {

struct NamedUnit {
    std::string name, unit;
};

// "tip (m)" as its two parts.
inline NamedUnit named_unit(std::string_view text)
{
    const auto trimmed = [](std::string_view t) {
        while (!t.empty() && t.front() == ' ') t.remove_prefix(1);
        while (!t.empty() && t.back() == ' ') t.remove_suffix(1);
        return std::string(t);
    };
    const std::string whole = trimmed(text);
    const auto open = whole.rfind('(');
    if (open == std::string::npos || whole.back() != ')') return {whole, ""};
    const std::string_view rest = whole;
    return {trimmed(rest.substr(0, open)), trimmed(rest.substr(open + 1, whole.size() - open - 2))};
}

inline std::vector<NamedUnit> named_units(std::string_view names)
{
    std::vector<NamedUnit> out;
    while (!names.empty()) {
        const auto comma = names.find(',');
        out.push_back(named_unit(names.substr(0, comma)));
        names = comma == std::string_view::npos ? "" : names.substr(comma + 1);
    }
    return out;
}

// How much a number in `own` is in `shown`, as a factor; 1 where one is not known, nothing where
// they are not of one kind.
inline std::optional<double> factor_between(const std::string& own, const std::string& shown)
{
    if (own.empty() || shown.empty() || own == shown) return 1;
    return graph::number_in("1 " + own, shown);
}

inline std::vector<std::string> parted_units(std::string_view units)
{
    std::vector<std::string> out;
    for (const NamedUnit& unit : named_units(units)) out.push_back(unit.name);
    if (units.ends_with(',')) out.emplace_back();
    return out;
}

}  // namespace nodes::render
