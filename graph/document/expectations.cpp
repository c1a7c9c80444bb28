#include "graph/document/expectations.hpp"

#include "graph/document/check_json.hpp"
#include "graph/document/links.hpp"
#include "graph/document/read_constants.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace graph {

namespace {

bool read_bounds(const Json& json, Expectation& e, Problems& problems)
{
    const auto read = [&](const char* key) -> std::optional<double> {
        const Json* found = json.find(key);
        if (!found) return {};
        return read_number(*found, "a number", problems);
    };
    const auto min = read("min"), max = read("max"), near = read("near"), around = read("within"),
               percent = read("percent");
    const bool has_near = json.find("near") != nullptr;
    const bool has_width = json.find("within") || json.find("percent");
    if (has_near != has_width || (json.find("within") && json.find("percent")) ||
        (!has_near && !json.find("min") && !json.find("max"))) {
        Problem p = problem_at(json.place());
        p.expected = "\"min\", \"max\", or \"near\" with either \"within\" or \"percent\"";
        problems.add(std::move(p));
        return false;
    }
    if (min) e.min = *min;
    if (max) e.max = *max;
    if (near && (around || percent)) {
        const double width = around ? *around : std::fabs(*near) * *percent / 100;
        e.min = std::max(e.min, *near - width);
        e.max = std::min(e.max, *near + width);
    }
    if (e.min > e.max) {
        problems.add(
            problem_at(json.place(), fmt::format("the lower bound {} is above the upper bound {}",
                                                 e.min, e.max)));
        return false;
    }
    return true;
}

std::vector<int> expected_frames(Loading& loading, const Json& json)
{
    const FrameRange& range = loading.graph.range;
    std::vector<int> frames;
    const auto add = [&](const Json& item) {
        const std::optional<int> frame = read_frame(item, loading.problems);
        if (frame && *frame >= range.first && *frame <= range.last) {
            frames.push_back(*frame);
        } else if (frame) {
            loading.problems.add(
                wrong(item, fmt::format("a frame from {} to {}", range.first, range.last)));
        }
    };
    if (json.text() && *json.text() == "first") {
        frames = {range.first};
    } else if (json.text() && *json.text() == "last") {
        frames = {range.last};
    } else if (json.text() && *json.text() == "every") {
        for (int f = range.first; f <= range.last; ++f) frames.push_back(f);
    } else if (json.array()) {
        for (const Json& item : *json.array()) add(item);
    } else if (json.number()) {
        add(json);
    } else {
        loading.problems.add(
            wrong(json, "a frame, a list of frames, \"first\", \"last\" or \"every\""));
    }
    return frames;
}

void read_expectation(Loading& loading, const Json& json)
{
    static constexpr std::string_view known[] = {"value", "frame",  "min",     "max",
                                                 "near",  "within", "percent", "why"};
    refuse_unknown(json, known, "an expectation", {}, loading.problems);
    want_text(json.find("why"), {}, loading.problems);
    Expectation e;
    e.place = json.place();
    if (const Json* why = json.find("why"); why && why->text()) e.why = *why->text();
    const Json* value = json.find("value");
    std::optional<Link> link;
    if (!value) {
        Problem p = problem_at(json.place());
        p.expected = "\"value\": \"node.output\" of type number";
        loading.problems.add(std::move(p));
    } else {
        link = find_link(loading, *value, "number", "", "");
    }
    const Json* frame = json.find("frame");
    e.frames =
        frame ? expected_frames(loading, *frame) : std::vector<int>{loading.graph.range.last};
    if (!read_bounds(json, e, loading.problems) || !link) return;
    e.value = *link;
    loading.graph.expectations.push_back(std::move(e));
}

}  // namespace

void read_expectations(Loading& loading)
{
    const Json* json = loading.expect ? &*loading.expect : nullptr;
    if (!json) return;
    if (!json->array()) {
        loading.problems.add(wrong(*json, "a list, [{ \"value\": \"node.output\", ... }]"));
        return;
    }
    for (const Json& item : *json->array()) {
        if (!item.object()) {
            loading.problems.add(wrong(item, "{ \"value\": \"node.output\", \"min\": 0 }"));
        } else {
            read_expectation(loading, item);
        }
    }
}

}  // namespace graph
