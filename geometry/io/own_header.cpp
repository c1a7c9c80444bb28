#include "geometry/io/own_header.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace geometry {
namespace {

constexpr std::string_view begin = "Aspic: ", of_units = "units of ", metres = " m";
constexpr std::array<std::pair<double, std::string_view>, 5> units{{{1, "metres"},
                                                                    {0.01, "centimetres"},
                                                                    {0.001, "millimetres"},
                                                                    {0.0254, "inches"},
                                                                    {0.3048, "feet"}}};

// m; 0: none.
double unit_named(std::string_view text)
{
    for (const auto& [unit, name] : units) {
        if (text == name) return unit;
    }
    if (!text.starts_with(of_units) || !text.ends_with(metres)) return 0;
    text = text.substr(of_units.size(), text.size() - of_units.size() - metres.size());
    double unit = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), unit);
    const bool whole = read.ec == std::errc() && read.ptr == text.data() + text.size();
    return whole && unit > 0 && std::isfinite(unit) ? unit : 0;
}

std::string name_of(double unit)
{
    for (const auto& [known, name] : units) {
        if (unit == known) return std::string(name);
    }
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), unit).ptr;
    return std::string(of_units) + std::string(digits.data(), end) + std::string(metres);
}

}  // namespace

std::string own_header(const FileFrame& frame)
{
    return std::string(begin) + name_of(frame.unit) + (frame.z_up ? ", z up" : ", y up");
}

std::optional<FileFrame> frame_of_header(std::string_view bytes)
{
    const std::size_t at = bytes.find(begin);
    if (at == std::string_view::npos) return {};
    const std::string_view text = bytes.substr(at + begin.size());
    const std::size_t comma = text.find(", ");
    if (comma == std::string_view::npos) return {};
    const double unit = unit_named(text.substr(0, comma));
    const std::string_view up = text.substr(comma + 2, 4);
    if (!(unit > 0) || (up != "z up" && up != "y up")) return {};
    return FileFrame{unit, up == "z up"};
}

}  // namespace geometry
