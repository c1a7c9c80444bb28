// Parts: where everything stands, words and shapes of SVG, the tasks, the chart of machines.

#include "runtime/commands/farm_drawing.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/farm_plan.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/farm/schedule.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

namespace runtime {

namespace {

// px
constexpr double page_width = 1240, left_margin = 250, right_margin = 240, row_height = 26,
                 box_height = 20;
constexpr double head_height = 96;  // above the first row
constexpr double chart_height = 190;
constexpr std::size_t most_shots = 20, most_alike = 8, shown_alike = 4;

// A task, or several that are alike.
struct Box {
    std::vector<std::uint32_t> tasks;
    double start = 0, seconds = 0;  // s; of several: until the longest has ended
    bool critical = false;
    double y = 0;  // px
};

struct Band {  // of a shot
    std::uint32_t shot;
    double y, height;  // px
};

struct Layout {
    explicit Layout(const Cut& all)
        : cut(all), start(all.tasks.size(), 0), critical(all.tasks.size(), 0),
          box_of(all.tasks.size(), none)
    {}

    static constexpr std::uint32_t none = ~0u;
    const Cut& cut;
    std::vector<double> start;  // s, by task
    std::vector<char> critical;
    std::vector<std::uint32_t> box_of;  // none: its shot is not drawn
    std::vector<Box> boxes;
    std::vector<Band> bands;
    double seconds = 0;  // until all is done
    double bottom = 0;   // px
    double x(double at) const
    {
        return left_margin + at / seconds * (page_width - left_margin - right_margin);
    }
};

bool alike(const FarmTask& a, const FarmTask& b)
{
    return a.stage == b.stage && a.shot == b.shot && a.nodes == b.nodes && a.after == b.after;
}

void add_box(Layout& layout, std::vector<std::uint32_t> tasks)
{
    Box box{std::move(tasks), 0, 0, false, layout.bottom};
    box.start = layout.start[box.tasks.front()];
    for (const std::uint32_t t : box.tasks) {
        box.seconds = std::max(box.seconds, layout.cut.tasks[t].seconds);
        box.critical = box.critical || layout.critical[t];
        layout.box_of[t] = static_cast<std::uint32_t>(layout.boxes.size());
    }
    layout.boxes.push_back(std::move(box));
    layout.bottom += row_height;
}

// The first few of tasks that are alike and the one that all wait for, then the others as a stack.
void add_alike(Layout& layout, const std::vector<std::uint32_t>& tasks)
{
    const bool all = tasks.size() <= most_alike;
    std::vector<std::uint32_t> stack;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        if (all || i < shown_alike || layout.critical[tasks[i]]) {
            add_box(layout, {tasks[i]});
        } else {
            stack.push_back(tasks[i]);
        }
    }
    if (!stack.empty()) add_box(layout, std::move(stack));
}

void add_shot(Layout& layout, std::uint32_t shot, const std::vector<std::uint32_t>& tasks)
{
    const double y = layout.bottom;
    for (std::size_t begin = 0, end = 0; begin < tasks.size(); begin = end) {
        const FarmTask& first = layout.cut.tasks[tasks[begin]];
        while (end < tasks.size() && alike(first, layout.cut.tasks[tasks[end]])) ++end;
        const auto at = [&](std::size_t i) {
            return tasks.begin() + static_cast<std::ptrdiff_t>(i);
        };
        add_alike(layout, std::vector<std::uint32_t>(at(begin), at(end)));
    }
    layout.bottom = std::max(layout.bottom, y + 2 * row_height) + 8;
    layout.bands.push_back({shot, y, layout.bottom - y - 4});
}

Layout lay_out(const Cut& cut)
{
    Layout layout(cut);
    for (const std::uint32_t t : critical_path(cut)) layout.critical[t] = 1;
    std::vector<std::vector<std::uint32_t>> of_shot(cut.shots.size());
    std::vector<char> on_path(cut.shots.size(), 0);
    for (std::uint32_t t = 0; t < cut.tasks.size(); ++t) {
        const FarmTask& task = cut.tasks[t];
        for (const std::uint32_t before : task.after) {
            layout.start[t] =
                std::max(layout.start[t], layout.start[before] + cut.tasks[before].seconds);
        }
        layout.seconds = std::max(layout.seconds, layout.start[t] + task.seconds);
        of_shot[task.shot].push_back(t);
        if (layout.critical[t]) on_path[task.shot] = 1;
    }
    if (layout.seconds <= 0) layout.seconds = 1;  // nothing is left to do
    layout.bottom = head_height;
    for (std::uint32_t s = 0; s < cut.shots.size(); ++s) {
        if (s < most_shots || on_path[s]) add_shot(layout, s, of_shot[s]);
    }
    return layout;
}

// Into text or an attribute of XML: UTF-8 without the two characters that are none.
std::string escaped(const std::string& text)
{
    using Json = nlohmann::json;
    std::string whole = Json::parse(Json(text).dump(-1, ' ', false, Json::error_handler_t::replace))
                            .get<std::string>();
    for (const char* none : {"\xef\xbf\xbe", "\xef\xbf\xbf"}) {
        for (std::size_t at = 0; (at = whole.find(none, at)) != std::string::npos;) {
            whole.replace(at, 3, "?");
        }
    }
    std::string out;
    for (const char c : whole) {
        switch (c) {
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '&':
            out += "&amp;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            if (static_cast<unsigned char>(c) >= ' ') out += c;
        }
    }
    return out;
}

// `look`: attributes.
std::string text_at(double x, double y, const std::string& text, const std::string& look = "")
{
    return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" {}>{}</text>\n", x, y, look, escaped(text));
}

std::string line(double x1, double y1, double x2, double y2, const std::string& look)
{
    return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x1,
                       y1, x2, y2, look);
}

std::string rectangle(double x, double y, double w, double h, const std::string& look)
{
    return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}/>\n",
                       x, y, w, h, look);
}

const char* colour_of(Stage stage)
{
    switch (stage) {
    case Stage::shared:
        return "#cbb8e0";
    case Stage::chain:
        return "#f3c98b";
    case Stage::frames:
        return "#a9cbea";
    case Stage::sweep:
        return "#e8b4c0";
    case Stage::last:
        break;
    }
    return "#b9dcb0";
}

constexpr const char* red = "#c8201c";
constexpr const char* grey = "class=\"grey\"";

std::string what(const FarmTask& task)
{
    const std::size_t count = task.frames.size();
    if (task.stage == Stage::shared || task.stage == Stage::sweep) return name_of(task.stage);
    const std::string frames = shortened(frames_text(task.frames), 24);
    std::string text = fmt::format("{} {}", count == 1 ? "frame" : "frames", frames);
    if (count > 1) text += fmt::format(" ({})", count);
    if (task.stage == Stage::last) return "last: " + text;
    return task.stage == Stage::chain ? task.nodes.front() + ": " + text : text;
}

std::string label(const Layout& layout, const Box& box)
{
    const FarmTask& first = layout.cut.tasks[box.tasks.front()];
    if (box.tasks.size() == 1) {
        return fmt::format("{}, {}", what(first), format_seconds(first.seconds));
    }
    double sum = 0;
    std::size_t frames = 0;
    for (const std::uint32_t t : box.tasks) {
        sum += layout.cut.tasks[t].seconds;
        frames += layout.cut.tasks[t].frames.size();
    }
    return fmt::format("{} more, {} frames, up to {} each, {} in all", box.tasks.size(), frames,
                       format_seconds(box.seconds), format_seconds(sum));
}

std::string box_svg(const Layout& layout, const Box& box)
{
    const FarmTask& first = layout.cut.tasks[box.tasks.front()];
    const double x = layout.x(box.start);
    const double wide = std::max(layout.x(box.start + box.seconds) - x, 3.0);
    const std::string look =
        fmt::format(R"(fill="{}" stroke="{}" stroke-width="{}" rx="2")", colour_of(first.stage),
                    box.critical ? red : "#555555", box.critical ? 2 : 0.7);
    const std::string nodes = first.nodes.empty() ? std::string("the whole cook")
                                                  : fmt::format("{}", fmt::join(first.nodes, ", "));
    std::string out = "<g><title>" +
                      escaped(fmt::format("{}: {}; frames {}; {}", first.name, nodes,
                                          frames_text(first.frames), label(layout, box))) +
                      "</title>\n";
    if (box.tasks.size() > 1) {
        out += rectangle(x + 5, box.y + 5, wide, box_height - 2, look);
        out += rectangle(x + 2.5, box.y + 2.5, wide, box_height - 2, look);
    }
    out += rectangle(x, box.y, wide, box_height, look);
    const std::string text = label(layout, box);
    const bool inside = 6.4 * static_cast<double>(text.size()) + 10 < wide;
    const double stacked = box.tasks.size() > 1 ? 5 : 0;
    const double beside = x + wide + 6 + stacked;
    const bool fits = inside || beside + 6.4 * static_cast<double>(text.size()) < page_width;
    out += fits ? text_at(inside ? x + 5 : beside, box.y + 14, text, "class=\"label\"")
                : text_at(x - 6, box.y + 14, text, "class=\"label\" text-anchor=\"end\"");
    return out + "</g>\n";
}

// From the end of what is waited for to the beginning of what waits: along, then up or down.
std::string edge(const Layout& layout, const Box& from, const Box& to)
{
    const bool critical =
        from.critical && to.critical && from.start + from.seconds >= to.start * (1 - 1e-9);
    const double x = layout.x(to.start);
    return fmt::format("<path d=\"M{:.1f} {:.1f}H{:.1f}V{:.1f}\" fill=\"none\" stroke=\"{}\" "
                       "stroke-width=\"{}\"/>\n",
                       layout.x(from.start + from.seconds), from.y + box_height / 2, x,
                       to.y + box_height / 2, critical ? red : "#999999", critical ? 2 : 0.8);
}

std::string edges(const Layout& layout)
{
    std::vector<std::array<std::uint32_t, 2>> pairs;
    for (std::uint32_t t = 0; t < layout.cut.tasks.size(); ++t) {
        for (const std::uint32_t before : layout.cut.tasks[t].after) {
            const std::uint32_t a = layout.box_of[before], b = layout.box_of[t];
            if (a != Layout::none && b != Layout::none) pairs.push_back({a, b});
        }
    }
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    std::string thin, thick;
    for (const auto& [a, b] : pairs) {
        const Box &from = layout.boxes[a], &to = layout.boxes[b];
        (from.critical && to.critical ? thick : thin) += edge(layout, from, to);
    }
    return thin + thick;
}

// The name of a shot, its settings, and how much of it is in the cache.
std::string band_svg(const Layout& layout, const Band& band)
{
    const Shot& shot = layout.cut.shots[band.shot];
    std::string out =
        rectangle(8, band.y - 4, page_width - 16, band.height, R"(fill="#f6f6f4" rx="4")");
    out += text_at(16, band.y + 10, shortened(shot.name, 30), "font-weight=\"bold\"");
    const double share =
        shot.results > 0 ? static_cast<double>(shot.held) / static_cast<double>(shot.results) : 1;
    out += rectangle(16, band.y + 17, 90, 8, R"(fill="#ffffff" stroke="#777777")");
    out += rectangle(16, band.y + 17, 90 * share, 8, R"(fill="#777777")");
    out += text_at(112, band.y + 25, fmt::format("{} of {} cached", shot.held, shot.results), grey);
    std::vector<std::string> settings = shot.sets;
    settings.insert(settings.end(), shot.variables.begin(), shot.variables.end());
    std::string note = fmt::format("{}", fmt::join(settings, " "));
    if (!shot.measured) note = note.empty() ? "not measured: 1 s a frame" : note + ", not measured";
    return out + text_at(16, band.y + 38, shortened(note, 36), grey);
}

// A step of 1, 2 or 5 by a power of ten, or of minutes and hours, so that `most` of them suffice.
double tick(double seconds, double most)
{
    constexpr std::array steps{1.0,   2.0,   5.0,   10.0,   15.0,   30.0,   60.0,
                               120.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0, 18000.0};
    if (seconds / most < steps.front()) {
        double step = std::pow(10, std::floor(std::log10(seconds / most)));
        while (step * most < seconds) step *= 2;
        return step;
    }
    for (const double step : steps) {
        if (step * most >= seconds) return step;
    }
    return steps.back() * std::ceil(seconds / most / steps.back());
}

std::string time_axis(const Layout& layout)
{
    std::string out;
    const double step = tick(layout.seconds, 9);
    for (int i = 0; i * step <= layout.seconds * (1 + 1e-9); ++i) {
        const double x = layout.x(i * step);
        out += line(x, head_height - 12, x, layout.bottom, R"(stroke="#dddddd")");
        out += text_at(x, head_height - 18, i == 0 ? "0" : format_seconds(i * step),
                       R"(class="grey" text-anchor="middle")");
    }
    return out;
}

std::string title(const Cut& cut)
{
    double work = 0;
    for (const FarmTask& task : cut.tasks) work += task.seconds;
    const auto path = critical_path(cut);
    std::string names;
    for (const std::uint32_t t : path) names += (names.empty() ? "" : ", ") + cut.tasks[t].name;
    std::string out = text_at(16, 26,
                              fmt::format("{} task{}, {} of work", cut.tasks.size(),
                                          cut.tasks.size() == 1 ? "" : "s", format_seconds(work)),
                              R"(font-size="16" font-weight="bold")");
    out +=
        text_at(16, 46,
                fmt::format("longest path: {}: {}", format_seconds(makespan(cut, cut.tasks.size())),
                            shortened(names, 150)),
                fmt::format("fill=\"{}\"", red));
    double x = 16;
    for (const Stage stage : all_stages) {
        out += rectangle(
            x, head_height - 28, 12, 12,
            fmt::format(R"(fill="{}" stroke="#555555" stroke-width="0.7")", colour_of(stage)));
        out += text_at(x + 16, head_height - 18, name_of(stage), grey);
        x += 60;
    }
    return out;
}

// Time over the number of machines, both by powers of ten.
struct Chart {
    double top, longest, shortest;  // px, s, s
    double x(double machines) const { return left_margin + std::log10(machines) / 3 * 740; }
    double y(double seconds) const
    {
        const double range = std::max(std::log(longest / shortest), 0.7);
        return top + 20 + std::log(longest / seconds) / range * (chart_height - 70);
    }
};

std::string chart_svg(const Layout& layout)
{
    const double none = 1e-3;  // s: what takes no time at all
    const auto time_on = [&](int n) {
        return std::max(makespan(layout.cut, static_cast<std::size_t>(n)), none);
    };
    const Chart chart{layout.bottom + 30, time_on(1), time_on(machine_counts.back())};
    std::string out = text_at(16, chart.top + 10, "Time on n machines", "font-weight=\"bold\"");
    out += text_at(16, chart.top + 28, "dashed: the work shared evenly", grey);
    out += text_at(16, chart.top + 44, "red: the longest path", grey);
    const double work_ends = std::min(chart.longest / chart.shortest, 1000.0);
    out += line(chart.x(1), chart.y(chart.longest), chart.x(work_ends),
                chart.y(chart.longest / work_ends), R"(stroke="#777777" stroke-dasharray="5 4")");
    const double path = std::max(makespan(layout.cut, layout.cut.tasks.size()), none);
    out += line(left_margin, chart.y(path), chart.x(1000), chart.y(path),
                fmt::format(R"(stroke="{}" stroke-dasharray="2 3")", red));
    std::string points, dots;
    for (const int n : machine_counts) {
        const double x = chart.x(n), seconds = time_on(n), y = chart.y(seconds);
        points += fmt::format("{:.1f},{:.1f} ", x, y);
        dots +=
            fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.5\" fill=\"#2b6ca3\"/>\n", x, y);
        dots += text_at(x, y - 9, format_seconds(seconds), R"(class="label" text-anchor="middle")");
        dots += text_at(x, chart.top + chart_height - 14, fmt::format("{}", n),
                        R"(class="grey" text-anchor="middle")");
    }
    out += text_at(left_margin - 16, chart.top + chart_height - 14, "machines",
                   R"(class="grey" text-anchor="end")");
    return out + "<polyline points=\"" + points +
           "\" fill=\"none\" stroke=\"#2b6ca3\" stroke-width=\"2\"/>\n" + dots;
}

}  // namespace

std::string plan_svg(const Cut& cut)
{
    Layout layout = lay_out(cut);
    std::string body;
    for (const Band& band : layout.bands) body += band_svg(layout, band);
    body += time_axis(layout) + edges(layout);
    for (const Box& box : layout.boxes) body += box_svg(layout, box);
    if (layout.bands.size() < cut.shots.size()) {
        layout.bottom += row_height;
        body += text_at(16, layout.bottom - 10,
                        fmt::format("and {} more shots", cut.shots.size() - layout.bands.size()));
    }
    body += title(cut) + chart_svg(layout);
    const double height = layout.bottom + 30 + chart_height;
    return fmt::format(
               "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" "
               "viewBox=\"0 0 {0:.0f} {1:.0f}\" font-family=\"sans-serif\" font-size=\"12\">\n"
               "<style>.grey{{fill:#666666;font-size:11px}}.label{{paint-order:stroke;"
               "stroke:#ffffff;stroke-width:3px;stroke-opacity:0.75;font-size:11px}}</style>\n",
               page_width, height) +
           rectangle(0, 0, page_width, height, "fill=\"#ffffff\"") + body + "</svg>\n";
}

}  // namespace runtime
