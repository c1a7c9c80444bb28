#include "runtime/commands/accuracy_card.hpp"

#include "graph/document/kept_rigid.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace runtime {
namespace {

using graph::Figure;
using graph::Over;

// What one node told, by frame.
using ByFrame = std::map<int, graph::Figures>;

// Of each node, whether it, or one that it depends on, is another one at another frame.
std::vector<std::uint8_t> changing(const graph::Graph& graph)
{
    std::vector<std::uint8_t> out(graph.nodes.size(), 0);
    for (std::size_t n = 0; n < out.size(); ++n) {  // each stands after those it depends on
        const graph::Node& node = graph.nodes[n];
        bool changes = !node.animated.empty() || node.type->reads != 0;
        for (const auto& links : node.inputs) {
            for (const graph::Link& link : links) changes = changes || out[link.node] != 0;
        }
        out[n] = changes ? 1 : 0;
    }
    return out;
}

// Whether nothing but gravity does work on the body: what holds it stays, and so does what it
// touches.
bool is_left_alone(const graph::Node& node, const std::vector<std::uint8_t>& changes)
{
    if (!node.animated.empty() || !graph::links_to(node, "forces").empty()) return false;
    for (const char* input : {"pins", "colliders"}) {
        for (const graph::Link& link : graph::links_to(node, input)) {
            if (changes[link.node] != 0) return false;
        }
    }
    return true;
}

CardLine largest(const ByFrame& told, std::size_t which)
{
    CardLine most{told.begin()->second.all[which], told.begin()->first};
    for (const auto& [frame, figures] : told) {
        const double value = figures.all[which].value;
        if (!(value <= most.value)) most.value = value, most.frame = frame;
        if (std::isnan(value)) break;  // that is the largest
    }
    return most;
}

// The frames at which something is so; unknown where it is not known of one.
CardLine frames_of(const ByFrame& told, std::size_t which)
{
    CardLine line{told.begin()->second.all[which]};
    line.value = 0;
    for (const auto& [frame, figures] : told) {
        line.value += figures.all[which].value;
        if (figures.all[which].value > 0) line.at.push_back(frame);
    }
    return line;
}

// What rose in the frames in which it rose, and fell in the others, as shares of the most there
// was. A figure's `of` counts from nothing, as energy of motion does; the rest of its value, as
// energy of height, counts from its lowest. So what falls without a rise is never more than there
// was. Unknown of one frame, and where one is left out.
std::array<double, 2> balance(const ByFrame& told, std::size_t which)
{
    constexpr std::array<double, 2> unknown{Figure::unknown, Figure::unknown};
    if (told.size() < 2) return unknown;
    constexpr double endless = std::numeric_limits<double>::infinity();
    double gained = 0, lost = 0, highest = -endless, lowest = endless, before = Figure::unknown;
    int last = told.begin()->first - 1;
    for (const auto& [frame, figures] : told) {
        const Figure& now = figures.all[which];
        if (frame != std::exchange(last, frame) + 1 || std::isnan(now.value)) return unknown;
        const double step = now.value - std::exchange(before, now.value);
        highest = std::max(highest, now.value), lowest = std::min(lowest, now.value - now.of);
        if (step > 0) gained += step;
        if (step < 0) lost -= step;
    }
    const double most = highest - lowest;
    return most > 0 ? std::array{gained / most, lost / most} : std::array{0.0, 0.0};
}

// `left_alone`: balances are known.
AccuracyCard card_of(const std::string& name, const ByFrame& told, bool left_alone)
{
    const graph::Figures& first = told.begin()->second;
    AccuracyCard card{name, first.kind, told.size(), {}};
    for (std::size_t i = 0; i < first.all.size(); ++i) {
        const Figure& figure = first.all[i];
        if (figure.over == Over::once) card.lines.push_back({figure});
        if (figure.over == Over::largest) card.lines.push_back(largest(told, i));
        if (figure.over == Over::frames) card.lines.push_back(frames_of(told, i));
        if (figure.over != Over::balance) continue;
        auto [gained, lost] = balance(told, i);
        if (!left_alone) gained = lost = Figure::unknown;
        const std::string of = ", of the most there was";
        card.lines.push_back(
            {{figure.name + " gained" + of, gained, Figure::unknown, Over::balance}});
        card.lines.push_back({{figure.name + " lost" + of, lost, Figure::unknown, Over::balance}});
    }
    return card;
}

// Which node of the graph made a result.
struct Maker {
    std::optional<std::uint32_t> node;  // none: the graph has none of that name and type
    bool exact = false;                 // the graph would make this result again
};

Maker maker_of(const Told& told, const graph::Graph& graph, Keys& keys)
{
    Maker named;
    for (const std::uint32_t n : keys.reached()) {
        const graph::Node& node = graph.nodes[n];
        if (node.type->name != told.type) continue;
        if (told.frame >= graph.range.first && keys.at(n, told.frame) == told.from)
            return {n, true};
        if (node.name == told.node) named.node = n;
    }
    return named;
}

std::string number_text(double x)
{
    return std::isnan(x) ? "-" : fmt::format("{:.6g}", x);
}

// "0.12 %", "130 %"; a millionth counts as nothing.
std::string percent_text(double share, bool sign)
{
    const double percent = std::abs(share) < 1e-6 ? 0 : 100 * share;
    const std::string text =
        std::abs(percent) < 99.5 ? fmt::format("{:.2g}", percent) : fmt::format("{:.0f}", percent);
    return (sign && percent > 0 ? "+" : "") + text + " %";
}

// "+0.12 %" of what is known and not 0. The place of a centre is no share of anything.
std::string error_text(const Figure& line)
{
    const double error = line.value / line.of - 1;
    const bool place = line.name.starts_with("centre");
    return std::isfinite(error) && !place ? percent_text(error, true) : "";
}

// Before its unit, or what it is a share of.
std::string short_name(const std::string& name)
{
    return name.substr(0, std::min(name.find(','), name.find(" about ")));
}

// "5, 9-12", and how many frames more where there are many ranges.
std::string list_of(const std::vector<int>& frames)
{
    constexpr std::size_t most = 12;
    std::string text;
    std::size_t ranges = 0;
    for (std::size_t i = 0; i < frames.size(); ++ranges) {
        if (ranges == most) return text + fmt::format(" and {} more", frames.size() - i);
        std::size_t end = i + 1;
        while (end < frames.size() && frames[end] == frames[end - 1] + 1) ++end;
        text += fmt::format("{}{}", text.empty() ? "" : ", ", frames[i]);
        if (end - i > 1) text += fmt::format("{}{}", end - i > 2 ? "-" : ", ", frames[end - 1]);
        i = end;
    }
    return text;
}

nlohmann::ordered_json number_json(double x)
{
    return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json();
}

// What a summary says of a line; nothing of what is not known.
std::string said_of(const AccuracyCard& card, const CardLine& line)
{
    if (card.kind == "body") {
        if (card.rigid && line.name.starts_with("stiffness")) return "";
        const std::string error = error_text(line);
        return error.empty() ? "" : short_name(line.name) + " " + error;
    }
    if (std::isnan(line.value) || line.over == Over::frames) return "";
    if (line.over == Over::balance) {
        return short_name(line.name) + " " + percent_text(line.value, false);
    }
    const bool metres = line.name.ends_with(", m"), cubes = line.name.ends_with(", in cubes");
    const bool worst = line.over == Over::largest;
    std::string at = worst && line.value > 0 ? fmt::format("frame {}", line.frame) : "";
    if (cubes && line.value >= 1 && std::isnan(line.of))
        at += "; step.substeps = 0 takes steps by their error";
    return fmt::format("{} {:.2g}{}{}", short_name(line.name), line.value,
                       metres  ? " m"
                       : cubes ? " cubes"
                               : "",
                       at.empty() ? "" : " (" + at + ")");
}

// Of the volume of cubes that is not that of their mesh at all.
std::string told_of_volume(const Figure& line)
{
    constexpr double far = 10;  // times
    const double times = line.value / line.of;
    const double small = std::cbrt(line.of) / 4;
    if (times > far) {
        return fmt::format("the cubes hold {:.2g} times the volume of the mesh, which is small "
                           "against a cube: set `size` to {:.2g} m or less, or scale the mesh "
                           "(`unit` of ReadMesh, if its file is in another unit)",
                           times, small);
    }
    if (times < 1 / far) {
        return fmt::format("the cubes hold {:.2g} of the volume of the mesh: set a smaller `size`",
                           times);
    }
    return {};
}

// What is worth a warning of a line; empty: nothing is.
std::string warning_of(const AccuracyCard& card, const CardLine& line)
{
    constexpr double much = 0.5;  // of the energy
    if (line.over == Over::frames && !line.at.empty()) {
        return fmt::format("{} of {} frame{} {} ({})", line.at.size(), card.frames,
                           card.frames == 1 ? "" : "s", short_name(line.name), list_of(line.at));
    }
    if (line.over == Over::once && line.name.starts_with("volume")) return told_of_volume(line);
    if (line.over == Over::largest && line.name.ends_with(", m") && line.value > line.of) {
        return fmt::format("a {} of {:.2g} m (frame {}) is more than a cube of {:.2g} m, so that "
                           "bodies may pass through what they touch: raise step.substeps (where it "
                           "is 0, lower step.error), or start them apart",
                           short_name(line.name), line.value, line.frame, line.of);
    }
    if (line.over == Over::balance && line.name.find(" gained") != std::string::npos &&
        line.value > much) {
        return fmt::format("{} {}, and nothing that is linked drives the body: where it starts "
                           "inside a collider or another body, move it out; otherwise raise "
                           "step.substeps (where it is 0, lower step.error) or "
                           "step.newton_iterations",
                           short_name(line.name), percent_text(line.value, false));
    }
    return {};
}

}  // namespace

std::vector<AccuracyCard> AccuracyFigures::cards(const graph::Graph& graph, Keys& keys) const
{
    std::map<std::uint32_t, ByFrame> by_node;
    std::map<std::string, ByFrame> others;
    std::vector<std::pair<Maker, const Told*>> all;
    for (const Told& told : all_) all.emplace_back(maker_of(told, graph, keys), &told);
    // What the graph would make comes first: names may have gone to other nodes since.
    std::stable_partition(all.begin(), all.end(), [](const auto& a) { return a.first.exact; });
    for (const auto& [maker, told] : all) {
        ByFrame& frames = maker.node ? by_node[*maker.node] : others[told->node];
        const auto at = frames.try_emplace(told->frame, told->figures).first;
        // Frames of one node tell of the same quantities.
        if (at->second.all.size() != frames.begin()->second.all.size()) frames.erase(at);
    }
    const std::vector<std::uint8_t> changes = changing(graph);
    std::vector<AccuracyCard> cards;
    for (const auto& [n, told] : by_node) {
        const graph::Node& node = graph.nodes[n];
        cards.push_back(card_of(node.name, told, is_left_alone(node, changes)));
        cards.back().rigid = cards.back().kind == "body" && graph::kept_rigid(graph, n);
    }
    for (const auto& [name, told] : others) cards.push_back(card_of(name, told, false));
    return cards;
}

std::string card_table(const AccuracyCard& card)
{
    if (card.kind != "body") {
        std::string text =
            fmt::format("{:<42} {:>12}\n", card.node, fmt::format("{} frames", card.frames));
        for (const CardLine& line : card.lines) {
            const bool at = line.over == Over::largest && line.value > 0;
            text += fmt::format("  {:<40} {:>12}{}\n", line.name, number_text(line.value),
                                at                ? fmt::format("  frame {}", line.frame)
                                : line.at.empty() ? ""
                                                  : "  " + list_of(line.at));
        }
        return text;
    }
    std::string text =
        fmt::format("{:<42} {:>12} {:>12}  {}\n", card.node, "mesh", "cubes", "error");
    for (const CardLine& line : card.lines) {
        text += fmt::format("  {:<40} {:>12} {:>12}  {}\n", line.name, number_text(line.of),
                            number_text(line.value), error_text(line));
    }
    return text;
}

std::string card_summary(const AccuracyCard& card)
{
    // Of lines of one name, as of inertia about three axes, the one that is most wrong.
    std::vector<std::pair<std::string, const CardLine*>> told;
    for (const CardLine& line : card.lines) {
        const std::string name = short_name(line.name);
        const auto error = [](const Figure& f) { return std::abs(f.value / f.of - 1); };
        if (!told.empty() && told.back().first == name) {
            if (error(line) > error(*told.back().second)) told.back().second = &line;
        } else {
            told.emplace_back(name, &line);
        }
    }
    std::string parts;
    for (const auto& [name, line] : told) {
        const std::string said = said_of(card, *line);
        if (!said.empty()) parts += (parts.empty() ? "" : ", ") + said;
    }
    std::string text = "'" + card.node + "': ";
    if (card.kind == "body") {
        text += fmt::format("{:.0f} cubes", card.lines.front().value);
        if (card.lines.back().name == graph::overlapping_parts) {
            return text + "; nothing against the mesh, as its parts overlap: its volume counts "
                          "twice what the cubes hold once";
        }
        return parts.empty() ? text : text + "; against the mesh: " + parts;
    }
    text += fmt::format("{} frame{}", card.frames, card.frames == 1 ? "" : "s");
    return parts.empty() ? text : text + ": " + parts;
}

std::vector<std::string> card_warnings(const AccuracyCard& card)
{
    std::vector<std::string> out;
    for (const CardLine& line : card.lines) {
        const std::string warning = warning_of(card, line);
        if (!warning.empty()) out.push_back("'" + card.node + "': " + warning);
    }
    return out;
}

nlohmann::ordered_json card_json(const AccuracyCard& card)
{
    nlohmann::ordered_json all{{card.kind, card.node}};
    const bool body = card.kind == "body";
    if (!body) all["frames"] = card.frames;
    for (const CardLine& line : card.lines) {
        if (body) {
            all["card"][line.name] = {{"mesh", number_json(line.of)},
                                      {"cubes", number_json(line.value)}};
        } else if (line.over == Over::frames && !std::isnan(line.value)) {
            all["card"][line.name] = line.at;
        } else {
            all["card"][line.name] = number_json(line.value);
        }
    }
    return all;
}

}  // namespace runtime
