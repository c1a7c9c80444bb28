#include "runtime/commands/vary.hpp"

#include <fmt/format.h>

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
            "expected node.parameter=value,value,... to vary, found '{}': {}", text, why));
    };
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos) refuse("there is no '='");
    Vary out{std::string(text.substr(0, equals)), {}};
    if (out.target.find('.') == std::string::npos) refuse("there is no '.' before the '='");

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
