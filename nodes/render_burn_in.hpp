#pragma once

// What Render writes into a corner of its picture, so that one who sees it alone knows what it is.

#include "graph/document/json.hpp"
#include "graph/types/param_builder.hpp"
#include "graph/types/value.hpp"
#include "nodes/named_units.hpp"
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
    std::string names, units = {};
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
        .param(
            "names", &BurnInParams::names,
            "Names of `values`, parted by commas, with the units to show them in in brackets: `tip "
            "(mm), force (kN)`. Empty: those of the nodes that they come from.")
        .param("units", &BurnInParams::units,
               "Units that `values` have as they are linked, parted by commas: numbers are turned "
               "from these into those of `names`. Empty: as Measure has them; of attributes it has "
               "none, and the unit in `names` is shown as it is.");
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

// Why `units` do not suit so many linked numbers and what `names` call for; empty: they do.
inline std::string wrong_units(const BurnInParams& of, std::size_t numbers)
{
    const auto units = parted_units(of.units);
    const auto named = named_units(of.names);
    if (!units.empty() && units.size() != numbers) {
        return fmt::format("burn_in.units must have one for each number that is linked to "
                           "`values`: it has {} for {}",
                           units.size(), numbers);
    }
    for (std::size_t i = 0; i < std::min(units.size(), named.size()); ++i) {
        if (factor_between(units[i], named[i].unit)) continue;
        return fmt::format("`{}` is in {}, which `{}` is no unit of: name one to show it in, "
                           "such as `{} ({})`",
                           named[i].name, units[i], named[i].unit, named[i].name, units[i]);
    }
    return {};
}

// One line for each of `values`. Throws std::invalid_argument unless each has a name, or none has,
// and as wrong_units() says.
inline std::vector<std::string> value_lines(const BurnInParams& of, const Numbers& values)
{
    auto named = named_units(of.names);
    std::string wrong = wrong_names(of.names, values.size());
    if (wrong.empty()) wrong = wrong_units(of, values.size());
    if (!wrong.empty()) throw std::invalid_argument(wrong);
    auto units = parted_units(of.units);
    units.resize(values.size());
    std::vector<std::string> lines;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (named.size() == i) named.push_back({fmt::format("value {}", i + 1), ""});
        const std::string& unit = named[i].unit.empty() ? units[i] : named[i].unit;
        const double value = factor_between(units[i], unit).value_or(1) * *values[i];
        lines.push_back(named[i].name + "   " + ::render::quantity_text(value, unit));
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
    for (std::string& text : value_lines(of, values)) lines.push_back(std::move(text));
    lines.push_back(label);
    std::string all;
    for (const std::string& text : lines) {
        if (!text.empty()) all += (all.empty() ? "" : "\n") + text;
    }
    return all;
}

}  // namespace nodes::render
