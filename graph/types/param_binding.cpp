#include "graph/types/param_binding.hpp"

#include <charconv>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace graph {

double detail::as_written(float in)
{
    char text[32];
    const auto end = std::to_chars(std::begin(text), std::end(text), in).ptr;
    double out = 0;
    std::from_chars(text, end, out);
    return out;
}

std::size_t detail::place_of(const ParamValue& value, const std::vector<std::string>& choices)
{
    const auto& text = std::get<std::string>(value.is);
    for (std::size_t i = 0; i < choices.size(); ++i) {
        if (choices[i] == text) return i;
    }
    throw std::invalid_argument("no such choice: " + text);
}

Param& ParamBinding::add(std::string& name, std::string& doc, ParamKind kind, ShownWhen& shown_when,
                         Set how)
{
    Param& p = params.emplace_back();
    p.name = std::move(name);
    p.doc = std::move(doc);
    p.kind = kind;
    p.shown_when = std::move(shown_when);
    set.push_back(std::move(how));
    return p;
}

}  // namespace graph
