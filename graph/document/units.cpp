#include "graph/document/units.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace graph {

namespace {

// A unit as a multiple of powers of the metre, the kilogram, the second and the degree.
struct Measured {
    double size = 1;
    std::array<int, 4> powers{};
};

struct UnitName {
    std::string_view name;
    Measured is;
};
constexpr std::array<int, 4> none{}, length{1, 0, 0, 0}, mass{0, 1, 0, 0}, time{0, 0, 1, 0},
    angle{0, 0, 0, 1}, force{1, 1, -2, 0}, stress{-1, 1, -2, 0}, rate{0, 0, -1, 0},
    volume{3, 0, 0, 0}, energy{2, 1, -2, 0};
constexpr UnitName known_units[] = {
    {"m", {1, length}},
    {"mm", {1e-3, length}},
    {"um", {1e-6, length}},
    {"µm", {1e-6, length}},
    {"cm", {1e-2, length}},
    {"dm", {0.1, length}},
    {"km", {1e3, length}},
    {"in", {0.0254, length}},
    {"ft", {0.3048, length}},
    {"Pa", {1, stress}},
    {"kPa", {1e3, stress}},
    {"MPa", {1e6, stress}},
    {"GPa", {1e9, stress}},
    {"bar", {1e5, stress}},
    {"psi", {6894.757293168, stress}},
    {"s", {1, time}},
    {"ms", {1e-3, time}},
    {"min", {60, time}},
    {"h", {3600, time}},
    {"Hz", {1, rate}},
    {"kg", {1, mass}},
    {"g", {1e-3, mass}},
    {"t", {1e3, mass}},
    {"lb", {0.45359237, mass}},
    {"deg", {1, angle}},
    {"degrees", {1, angle}},
    {"°", {1, angle}},
    {"N", {1, force}},
    {"mN", {1e-3, force}},
    {"kN", {1e3, force}},
    {"MN", {1e6, force}},
    {"l", {1e-3, volume}},
    {"L", {1e-3, volume}},
    {"ml", {1e-6, volume}},
    {"J", {1, energy}},
    {"mJ", {1e-3, energy}},
    {"kJ", {1e3, energy}},
    {"MJ", {1e6, energy}},
    {"%", {0.01, none}},
    {"1", {1, none}},
    {"rad", {180 / std::numbers::pi, angle}},
};

bool starts_with(std::string_view text, std::string_view start)
{
    return text.substr(0, start.size()) == start;
}

// Takes the exponent off the beginning of `text`: "^2", "2" or "²"; 1 where there is none.
int take_exponent(std::string_view& text)
{
    constexpr std::pair<std::string_view, int> written[] = {
        {"^2", 2}, {"^3", 3}, {"**2", 2}, {"**3", 3}, {"²", 2}, {"³", 3}, {"2", 2}, {"3", 3}};
    for (const auto& [mark, exponent] : written) {
        if (!starts_with(text, mark)) continue;
        text.remove_prefix(mark.size());
        return exponent;
    }
    return 1;
}

// Factors side by side, or with '*' between; all that follows a '/' divides ("N m s/rad").
std::optional<Measured> measure(std::string_view text)
{
    constexpr std::string_view ends = " *·/^23²³";
    Measured all;
    int sign = 1;
    while (!text.empty()) {
        const bool divides = text.front() == '/';
        if (divides && sign < 0) return {};
        if (divides) sign = -1;
        if (divides || text.front() == ' ' || text.front() == '*') {
            text.remove_prefix(1);
            continue;
        }
        if (starts_with(text, "·")) {
            text.remove_prefix(std::string_view("·").size());
            continue;
        }
        // Of UTF-8 the two bytes of "°" and "µ" begin like those of "·": a whole name comes first.
        const UnitName* found = nullptr;
        for (const UnitName& known : known_units) {
            if (!starts_with(text, known.name)) continue;
            const std::string_view after = text.substr(known.name.size());
            const bool whole = after.empty() || ends.find(after.front()) != ends.npos;
            if (whole && (!found || known.name.size() > found->name.size())) found = &known;
        }
        if (!found) return {};
        text.remove_prefix(found->name.size());
        const int exponent = sign * take_exponent(text);
        all.size *= std::pow(found->is.size, exponent);
        for (std::size_t i = 0; i < all.powers.size(); ++i) {
            all.powers[i] += exponent * found->is.powers[i];
        }
    }
    return all;
}

}  // namespace

std::optional<double> number_in(std::string_view text, std::string_view unit)
{
    double number = 0;
    const char* const end = text.data() + text.size();
    const auto [rest, error] = std::from_chars(text.data(), end, number);
    if (error != std::errc() || !std::isfinite(number)) return {};
    text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
    if (text.find_first_not_of(' ') == text.npos || text.size() > 32) return {};
    const std::optional<Measured> has = measure(text), wants = measure(unit);
    if (!has || !wants || has->powers != wants->powers) return {};
    const double x = number * has->size / wants->size;
    return std::isfinite(x) ? std::optional(x) : std::nullopt;
}

}  // namespace graph
