#include "runtime/cache/quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

namespace runtime {

namespace {

[[noreturn]] void bad_frames(std::string_view text)
{
    throw std::invalid_argument(
        fmt::format("expected frames like 1-48, 1-48x2 or 10,20,30-40; found '{}'", text));
}

// Reads a whole number off the front of `text`.
int take_int(std::string_view& text, std::string_view all)
{
    int number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc{}) bad_frames(all);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return number;
}

bool take(std::string_view& text, char c)
{
    if (text.empty() || text.front() != c) return false;
    text.remove_prefix(1);
    return true;
}

constexpr long most_frames = 10'000'000;

}  // namespace

std::vector<int> parse_frames(std::string_view all)
{
    std::vector<int> frames;
    std::string_view text = all;
    do {
        const int first = take_int(text, all);
        int last = first, step = 1;
        if (take(text, '-')) {
            last = take_int(text, all);
            if (take(text, 'x')) step = take_int(text, all);
        }
        if (last < first) {
            throw std::invalid_argument(
                fmt::format("frames '{}' end before they begin; use {}-{}", all, last, first));
        }
        if (step < 1) bad_frames(all);
        if (long{last} - first > most_frames) {
            throw std::invalid_argument(fmt::format("'{}': more than {} frames", all, most_frames));
        }
        for (long f = first; f <= last; f += step) frames.push_back(static_cast<int>(f));
    } while (take(text, ','));
    if (!text.empty()) bad_frames(all);
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    return frames;
}

std::size_t parse_bytes(std::string_view text)
{
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
    if (unit.ends_with('B') || unit.ends_with('b')) unit.remove_suffix(1);
    constexpr std::string_view units = "KMGT";
    double scale = 1;
    bool good = error == std::errc{} && number >= 0;
    if (unit.size() == 1) {
        const auto power = units.find(static_cast<char>(std::toupper(unit[0])));
        good = good && power != std::string_view::npos;
        scale = std::pow(1024.0, static_cast<double>(power) + 1);
    } else {
        good = good && unit.empty();
    }
    if (!good || !(number * scale < 1e18)) {
        throw std::invalid_argument(
            fmt::format("expected a size like 500M or 2G; found '{}'", text));
    }
    return static_cast<std::size_t>(number * scale);
}

std::string format_bytes(double bytes)
{
    constexpr const char* units[] = {"B", "kB", "MB", "GB", "TB"};
    std::size_t u = 0;
    while (bytes >= 1024 && u + 1 < std::size(units)) bytes /= 1024, ++u;
    return fmt::format("{:.{}f} {}", bytes, u > 0 && bytes < 10 ? 1 : 0, units[u]);
}

std::string format_seconds(double seconds)
{
    if (seconds < 0.1) return fmt::format("{:.0f} ms", seconds * 1e3);
    if (seconds < 10) return fmt::format("{:.1f} s", seconds);
    const long whole = std::lround(seconds);
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
    return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

}  // namespace runtime
