#include "runtime/commands/vary.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace runtime {
namespace {

std::string without_outer_blanks(const std::string& text)
{
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") + 1 - first);
}

}  // namespace

Vary parse_vary(std::string_view text)
{
    const auto refuse = [&](const char* why) {
        throw std::invalid_argument(fmt::format(
            "expected node.parameter=value,value,... or variable=value,value,... to vary, found "
            "'{}': {}",
            text, why));
    };
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) refuse("there is no '='");
    if (equals == 0) refuse("there is no name before the '='");
    Vary out{std::string(text.substr(0, equals)), {}};

    std::string value;
    int depth = 0;
    bool quoted = false, escaped = false;
    for (const char c : text.substr(equals + 1)) {
        if (c == '"' && !escaped) quoted = !quoted;
        escaped = quoted && c == '\\' && !escaped;
        if (!quoted) {
            depth += (c == '[' || c == '{' || c == '(') - (c == ']' || c == '}' || c == ')');
        }
        if (c == ',' && depth == 0 && !quoted) {
            out.values.push_back(without_outer_blanks(value));
            value.clear();
        } else {
            value += c;
        }
    }
    if (depth != 0 || quoted) refuse("a bracket or quote is not closed");
    out.values.push_back(without_outer_blanks(value));
    for (const std::string& v : out.values) {
        if (v.empty()) refuse("a value is empty");
    }
    return out;
}

bool is_variable(std::string_view target)
{
    return target.find('.') == std::string_view::npos;
}

graph::Override parse_setting(std::string_view text)
{
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos || !is_variable(text.substr(0, equals))) {
        return graph::parse_override(text);
    }
    parse_variable(std::string(text));
    return {std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
}

std::pair<std::string, double> parse_variable(const std::string& text)
{
    const std::size_t equals = text.find('=');
    double value = 0;
    const char* const end = text.data() + text.size();
    const char* const begin = equals < text.size() ? text.data() + equals + 1 : end;
    const auto [stop, error] = std::from_chars(begin, end, value);
    if (equals == 0 || stop != end || (error != std::errc() && begin == stop)) {
        throw std::invalid_argument(
            fmt::format("variables take numbers: expected name=number, found '{}'", text));
    }
    // Beyond the largest double, or nearer to 0 than the smallest: from_chars leaves 0 for both.
    if (error != std::errc() || !std::isfinite(value)) {
        throw std::invalid_argument(fmt::format(
            "variables: expected a number between 1e-307 and 1e308 in size, or 0, found '{}'",
            text));
    }
    return {text.substr(0, equals), value};
}

void add_settings(graph::LoadOptions& options, const Settings& settings)
{
    for (const graph::Override& s : settings) {
        if (is_variable(s.target)) {
            options.variables.push_back(parse_variable(s.target + '=' + s.value));
        } else {
            options.sets.push_back(s);
        }
    }
}

std::vector<Settings> combinations(const std::vector<Vary>& varied, std::size_t most)
{
    std::size_t count = 1;
    for (const Vary& v : varied) {
        count *= v.values.size();
        if (count > most) {
            throw std::invalid_argument(fmt::format(
                "expected at most {} combinations, found more: vary fewer parameters or values",
                most));
        }
    }
    std::vector<Settings> out;
    out.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
        Settings settings(varied.size());
        std::size_t rest = i;
        for (std::size_t k = varied.size(); k-- > 0;) {
            const Vary& v = varied[k];
            settings[k] = {v.target, v.values[rest % v.values.size()]};
            rest /= v.values.size();
        }
        out.push_back(std::move(settings));
    }
    return out;
}

std::string describe(const Settings& settings)
{
    std::string out;
    for (const graph::Override& s : settings) {
        if (!out.empty()) out += ' ';
        out += s.target + '=' + s.value;
    }
    return out;
}

}  // namespace runtime
