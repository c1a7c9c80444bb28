#pragma once

// What Render writes into a corner of its picture, so that one who sees it alone knows what it is.

#include "graph/document/json.hpp"
#include "graph/types/param_builder.hpp"
#include "graph/types/value.hpp"
#include "nodes/scene_seconds.hpp"
#include "render/captions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace nodes::render {

struct BurnInParams {
    std::string scene;
    bool frame = false, seconds = false;
    double slow_motion = 0;
    std::string names;
};

inline void describe(graph::ParamsOf<BurnInParams>& p)
{
    p.param("scene", &BurnInParams::scene, "Name of the scene, or any text; empty: none.")
        .param("frame", &BurnInParams::frame, "Whether the number of the frame is shown.")
        .param("seconds", &BurnInParams::seconds,
               "Whether the time since the first frame is shown, as it passes in the scene: that "
               "of the video over `slow_motion`.")
        .param("slow_motion", &BurnInParams::slow_motion,
               "How many times slower than in the scene time passes in the video, which is shown; "
               "1 shows nothing, below 1 it is a time lapse. 0: as the Simulate, Vibrate or "
               "ReadState that the picture depends on has it by `dt`, 1 / (dt * frames a second), "
               "shown with `seconds` alone. Where several have different ones, or `dt` moves, "
               "that is 1.",
               {0, 1e6})
        .param("names", &BurnInParams::names,
               "Names of `values`, parted by commas, with their units in brackets: `tip (m), force "
               "(N)`. Empty: those of the nodes that they come from.");
}

// Numbers that a document gives no names have those of the nodes that they come from, with the
// output where that says more than `value`.
inline void name_values(graph::Json& node)
{
    graph::Json* const inputs = node.find("inputs");
    const graph::Json* const values = inputs ? inputs->find("values") : nullptr;
    if (!values) return;
    std::string names;
    const auto add = [&](const graph::Json& link) {
        constexpr std::string_view usual = ".value";
        std::string name = link.text() ? *link.text() : "";
        if (name.ends_with(usual)) name.resize(name.size() - usual.size());
        names += (names.empty() ? "" : ", ") + name;
    };
    if (const auto* const links = values->array()) {
        for (const graph::Json& link : *links) add(link);
    } else {
        add(*values);
    }
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object{});
    graph::Json* const burn_in =
        params ? graph::put_missing(*params, "burn_in", graph::Json::Object{}) : nullptr;
    graph::Json* const said =
        burn_in ? graph::put_missing(*burn_in, "names", std::string()) : nullptr;
    if (said && said->text() && said->text()->empty()) said->is = std::move(names);
}

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

using Numbers = std::vector<graph::Wire<double>>;

// Why `names` do not suit so many linked numbers; empty: each has a name, or none has.
inline std::string wrong_names(std::string_view names, std::size_t numbers)
{
    const std::size_t named = named_units(names).size();
    if (named == 0 || named == numbers) return {};
    return fmt::format("burn_in.names must name each number that is linked to `values`: it has {} "
                       "{}, for {} {}",
                       named, named == 1 ? "name" : "names", numbers,
                       numbers == 1 ? "number" : "numbers");
}

// One line for each of `values`. Throws std::invalid_argument unless each has a name, or none has.
inline std::vector<std::string> value_lines(const std::string& names, const Numbers& values)
{
    auto named = named_units(names);
    const std::string wrong = wrong_names(names, values.size());
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (named.size() == i) named.push_back({fmt::format("value {}", i + 1), ""});
        lines.push_back(named[i].name + "   " + ::render::quantity_text(*values[i], named[i].unit));
    }
    return lines;
}

// Lines of text, parted by '\n', the label last. `time` is that of the video, s; `upstream` how
// many times slower than that of the scene it is, as what the picture depends on says.
inline std::string burn_in_text(const BurnInParams& of, const Numbers& values, int frame,
                                double time, const std::string& label, double upstream = 1)
{
    std::string line;
    const auto add = [&](const std::string& part) { line += (line.empty() ? "" : "   ") + part; };
    const bool stated = of.slow_motion > 0;
    const double slow = stated ? of.slow_motion : of.seconds ? upstream : 1;
    const bool as_it_is = is_real_time(slow);
    if (of.frame) add(fmt::format("frame {}", frame));
    if (of.seconds) add(seconds_text(time, slow));
    if (!as_it_is && slow > 1) add("slow motion " + ::render::number_text(slow) + "x");
    if (!as_it_is && slow < 1) add("time lapse " + ::render::number_text(1 / slow) + "x");
    std::vector<std::string> lines{of.scene, line};
    for (std::string& text : value_lines(of.names, values)) lines.push_back(std::move(text));
    lines.push_back(label);
    std::string all;
    for (const std::string& text : lines) {
        if (!text.empty()) all += (all.empty() ? "" : "\n") + text;
    }
    return all;
}

}  // namespace nodes::render
