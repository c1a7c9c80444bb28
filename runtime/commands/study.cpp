// Parts: what is measured of one cook (Stopwatch, Series), the study itself (class Study), and its
// reports: the table, the plot and the sentence at the end.

#include "runtime/commands/study.hpp"

#include "graph/types/standard_wires.hpp"
#include "runtime/commands/cook_request.hpp"
#include "runtime/commands/wires.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

namespace runtime {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

const std::string& wire_of(const graph::Graph& graph, graph::Link link)
{
    return graph.nodes[link.node].type->outputs[link.output].type;
}

double number_distance(const graph::Value& a, const graph::Value& b)
{
    return std::abs(*a.as<double>() - *b.as<double>());
}

// What runs anew each frame, and the seconds of what runs once.
class Stopwatch : public Observer {
public:
    explicit Stopwatch(const graph::Graph& graph) : varies(graph.nodes.size(), false), graph_(graph)
    {}
    void ran(const Run& run) override
    {
        if (varies[run.node] && run.preparation < 0) {
            of_frames.push_back(run);
        } else {
            setup += run.seconds;
        }
    }
    void failed(const Failure& f) override
    {
        if (failure.empty()) failure = f.what;
    }

    void warned(const Warning& w) override
    {
        warnings.push_back(fmt::format("'{}': {}", graph_.nodes[w.node].name, w.text));
    }

    std::vector<bool> varies;
    std::vector<Run> of_frames;
    double setup = 0;
    std::string failure;
    std::vector<std::string> warnings;

private:
    const graph::Graph& graph_;
};

// What a trial gave at each frame; a wire that is the same at all frames has one entry.
using Series = std::map<int, graph::Value>;

const graph::Value& at(const Series& series, int frame)
{
    static const graph::Value none;
    if (series.empty()) return none;
    auto after = series.upper_bound(frame);
    return after == series.begin() ? none : std::prev(after)->second;
}

// What a measure is of, and how far two of its values are apart.
struct Kind {
    Distance distance;
    bool number = false;
};

Kind kind_of(const graph::Graph& graph, const std::string& measure, const StudyOptions& options)
{
    const std::string& type = wire_of(graph, find_wire(graph, measure));
    if (type == graph::wire_name<double>) return {number_distance, true};
    const auto known = options.distances.find(type);
    if (known != options.distances.end()) return {known->second};
    throw std::invalid_argument(fmt::format(
        "expected '{}' to be a number or a mesh, found type {}; add a Measure node after it",
        measure, type));
}

class Study {
public:
    Study(const std::filesystem::path& file, const graph::Registry& registry,
          const StudyOptions& options)
        : file_(file), registry_(registry), options_(options)
    {
        const graph::Graph graph = load({}).graph;
        if (options.measures.empty()) throw std::invalid_argument("expected something to measure");
        for (const std::string& measure : options.measures) {
            kinds_.push_back(kind_of(graph, measure, options));
        }
        if (options.exact && !kinds_[0].number) {
            throw std::invalid_argument("a number as reference needs a number as measure");
        }
        if (!options.look.empty()) {
            const graph::Link look = find_wire(graph, options.look);
            if (!is_picture(graph.nodes[look.node].type->outputs[look.output])) {
                throw std::invalid_argument(
                    fmt::format("expected '{}' to be a picture, found type {}", options.look,
                                wire_of(graph, look)));
            }
        }
        if (!options.exact && !options.reference && combinations(options.varied).size() < 2) {
            throw std::invalid_argument("expected at least two settings, found one; vary more "
                                        "values or give a --reference");
        }
        frames_ = options.frames;
        for (const int f : frames_) require_frame(graph, f);
        if (frames_.empty()) {
            for (int f = graph.range.first; f <= graph.range.last; ++f) frames_.push_back(f);
        }
    }

    std::vector<Trial> run(const std::function<void(const Trial&)>& told)
    {
        const std::vector<Settings> all = combinations(options_.varied);
        std::vector<Trial> trials(all.size());
        for (std::size_t i = 0; i < all.size(); ++i) trials[i].settings = all[i];

        // The reference first: the others are compared with it frame by frame as they cook.
        if (options_.exact) {
            reference_.resize(kinds_.size());
            for (const int f : frames_) {
                reference_[0][f] = graph::Value::of(double(*options_.exact));
            }
        } else if (options_.reference) {
            Trial outside;
            outside.settings = *options_.reference;
            reference_ = cook(outside);
            need(outside);
        } else {
            Trial& last = trials.back();
            reference_ = cook(last);
            need(last);
            last.reference = true;
            tell_measured(last, reference_);
            if (told) told(last);
        }
        scale_ = scale_of_reference();
        for (Trial& trial : trials) {
            if (trial.reference) continue;
            const std::vector<Series> series = cook(trial);
            compare(trial, series[0]);
            tell_measured(trial, series);
            if (told) told(trial);
        }
        mark_best(trials);
        return trials;
    }

private:
    graph::Loaded load(const Settings& settings) const
    {
        return load_with(file_, registry_, options_.load, settings);
    }

    // What each measure gave. Everything from a cold cache, so that times can be compared. Throws
    // graph::Cancelled when told to stop: what is missing then is no failure of the trial.
    std::vector<Series> cook(Trial& trial) const
    {
        std::vector<Series> series(kinds_.size());
        try {
            const graph::Loaded loaded = load(trial.settings);
            const graph::Graph& graph = loaded.graph;
            std::vector<graph::Link> wires;
            std::vector<std::uint32_t> nodes;
            for (const std::string& measure : options_.measures) {
                wires.push_back(find_wire(graph, measure));
                nodes.push_back(wires.back().node);
            }
            std::sort(nodes.begin(), nodes.end());
            nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
            std::vector<Want> wants;
            for (const int f : frames_) {
                for (const std::uint32_t node : nodes) wants.push_back({node, f});
            }
            std::optional<graph::Link> look;
            if (!options_.look.empty()) look = find_wire(graph, options_.look);

            Caches caches;
            Stopwatch watch(graph);
            watch.warnings = warnings_of(loaded);
            Evaluator evaluator(graph, caches, options_.cook, &watch);
            evaluator.keys().aim(nodes, frames_);
            for (const std::uint32_t n : evaluator.keys().reached()) {
                watch.varies[n] = evaluator.keys().varies(n);
            }
            const Cooked cooked = evaluator.cook(
                std::move(wants), [&](const Want& want, std::span<const graph::Value> values) {
                    for (std::size_t m = 0; m < wires.size(); ++m) {
                        if (wires[m].node != want.node) continue;
                        series[m][want.frame] = values[wires[m].output];
                    }
                });
            if (cooked.cancelled) throw graph::Cancelled();
            trial.failure = watch.failure;
            trial.warnings = std::move(watch.warnings);
            trial.frame_seconds = seconds_a_frame(watch.of_frames, frames_);
            trial.setup_seconds = watch.setup;
            if (look && trial.failure.empty()) trial.look = evaluator.pull(*look, frames_.back());
        } catch (const std::exception& error) {
            // pull() has no other word for a cook that was stopped than a failure.
            if (options_.cook.stop.stop_requested()) throw graph::Cancelled();
            trial.failure = error.what();
        }
        return series;
    }

    static void need(const Trial& reference)
    {
        if (reference.failure.empty()) return;
        throw std::invalid_argument(fmt::format("the reference ({}) could not be cooked: {}",
                                                describe(reference.settings), reference.failure));
    }

    double scale_of_reference() const
    {
        double scale = 0;
        for (const int f : frames_) {
            scale = std::max(scale, kinds_[0].number ? std::abs(*at(reference_[0], f).as<double>())
                                                     : departure_of_reference(f));
        }
        return scale;
    }

    // From its first frame; 0 where it has become something that can't be compared with that.
    double departure_of_reference(int frame) const
    {
        try {
            return kinds_[0].distance(at(reference_[0], frame), at(reference_[0], frames_[0]));
        } catch (const std::invalid_argument&) {
            return 0;
        }
    }

    void compare(Trial& trial, const Series& series) const
    {
        if (!trial.failure.empty()) {
            trial.error = trial.worst = trial.relative = nan;
            return;
        }
        double sum_sq = 0;
        for (const int f : frames_) {
            double d = 0;
            try {
                d = kinds_[0].distance(at(series, f), at(reference_[0], f));
            } catch (const std::invalid_argument& why) {
                trial.incomparable = fmt::format("at frame {} {}", f, why.what());
                trial.error = trial.worst = trial.relative = nan;
                return;
            }
            sum_sq += d * d;
            if (!(d <= trial.worst) && !std::isnan(trial.worst)) trial.worst = d;
        }
        trial.error = std::sqrt(sum_sq / static_cast<double>(frames_.size()));
        trial.relative = scale_ > 0 ? trial.error / scale_ : nan;
    }

    // Not a number where it can't be compared.
    double error_of(std::size_t measure, const Series& series) const
    {
        double sum_sq = 0;
        try {
            for (const int f : frames_) {
                if (!at(series, f) || !at(reference_[measure], f)) return nan;
                const double d =
                    kinds_[measure].distance(at(series, f), at(reference_[measure], f));
                sum_sq += d * d;
            }
        } catch (const std::invalid_argument&) {
            return nan;
        }
        return std::sqrt(sum_sq / static_cast<double>(frames_.size()));
    }

    void tell_measured(Trial& trial, const std::vector<Series>& series) const
    {
        if (!trial.failure.empty()) return;
        for (std::size_t m = 0; m < kinds_.size(); ++m) {
            Measured one{options_.measures[m]};
            const graph::Value& last = at(series[m], frames_.back());
            if (kinds_[m].number && last) one.value = *last.as<double>();
            if (!trial.reference) one.error = m == 0 ? trial.error : error_of(m, series[m]);
            trial.measured.push_back(std::move(one));
        }
    }

    const std::filesystem::path& file_;
    const graph::Registry& registry_;
    const StudyOptions& options_;
    std::vector<Kind> kinds_;  // of each measure
    std::vector<int> frames_;
    std::vector<Series> reference_;  // of each measure
    double scale_ = 0;
};

}  // namespace

// By the time of a frame; by that of what runs once where those are equal, as where nothing varies
// by frame.
static bool quicker(const Trial& a, const Trial& b)
{
    if (a.frame_seconds != b.frame_seconds) return a.frame_seconds < b.frame_seconds;
    return a.setup_seconds < b.setup_seconds;
}

void mark_best(std::vector<Trial>& trials)
{
    for (Trial& t : trials) {
        if (t.reference || !t.failure.empty() || std::isnan(t.error)) continue;
        t.best = std::none_of(trials.begin(), trials.end(), [&](const Trial& o) {
            return &o != &t && !o.reference && o.failure.empty() && o.error <= t.error &&
                   !quicker(t, o) && (o.error < t.error || quicker(o, t));
        });
    }
}

double seconds_a_frame(const std::vector<Run>& runs, const std::vector<int>& asked)
{
    struct Node {
        double seconds = 0;
        std::set<int> frames;
    };
    std::map<std::uint32_t, Node> nodes;
    for (const Run& run : runs) {
        Node& node = nodes[run.node];
        if (node.frames.empty()) node.frames.insert(asked.begin(), asked.end());
        node.seconds += run.seconds;
        node.frames.insert(run.frame);
    }
    double sum = 0;
    for (const auto& [n, node] : nodes) sum += node.seconds / double(node.frames.size());
    return sum;
}

std::vector<Trial> study(const std::filesystem::path& file, const graph::Registry& registry,
                         const StudyOptions& options, const std::function<void(const Trial&)>& told)
{
    return Study(file, registry, options).run(told);
}

bool any_compared(const std::vector<Trial>& trials)
{
    return std::any_of(trials.begin(), trials.end(), [](const Trial& t) {
        return !t.reference && t.failure.empty() && !std::isnan(t.relative);
    });
}

// Whether a plot is over the time of a frame, or over that of what runs once.
static bool any_by_frame(const std::vector<Trial>& trials)
{
    return std::any_of(trials.begin(), trials.end(),
                       [](const Trial& t) { return t.frame_seconds > 0; });
}

bool any_to_plot(const std::vector<Trial>& trials)
{
    const bool by_frame = any_by_frame(trials);
    return std::any_of(trials.begin(), trials.end(), [&](const Trial& t) {
        return !t.reference && t.failure.empty() && t.relative > 0 &&
               (by_frame ? t.frame_seconds : t.setup_seconds) > 0;
    });
}

std::string time_of(const Trial& t)
{
    return t.frame_seconds > 0 ? fmt::format("{:.3g} ms per frame", 1e3 * t.frame_seconds)
                               : fmt::format("{:.3g} ms in all", 1e3 * t.setup_seconds);
}

std::string soonest(const std::vector<Trial>& trials, double wanted)
{
    const Trial* found = nullptr;
    const Trial* nearest = nullptr;
    for (const Trial& t : trials) {
        if (t.reference || !t.failure.empty() || std::isnan(t.relative)) continue;
        if (!nearest || t.relative < nearest->relative) nearest = &t;
        if (t.relative <= wanted && (!found || quicker(t, *found))) found = &t;
    }
    if (found) {
        return fmt::format("Fastest setting within {:g} %: {} ({}, error {:.2g} %).", 100 * wanted,
                           describe(found->settings), time_of(*found), 100 * found->relative);
    }
    if (!nearest) return "No setting could be compared with the reference.";
    return fmt::format("No setting is within {:g} %; the closest is {} ({:.2g} %, {}).",
                       100 * wanted, describe(nearest->settings), 100 * nearest->relative,
                       time_of(*nearest));
}

static std::vector<std::string> measured_in(const std::vector<Trial>& trials)
{
    std::vector<std::string> wires;
    for (const Trial& t : trials) {
        if (t.measured.size() <= wires.size()) continue;
        wires.clear();
        for (const Measured& one : t.measured) wires.push_back(one.wire);
    }
    return wires;
}

std::string to_csv(const std::vector<Trial>& trials)
{
    std::string out;
    if (trials.empty()) return out;
    for (const graph::Override& s : trials[0].settings)
        out.append(csv_quoted(s.target)).append(1, ',');
    out += "error_rms,error_max,error_relative,ms_per_frame,setup_ms,best,reference,failure,"
           "warnings,first_warning";
    const std::vector<std::string> wires = measured_in(trials);
    for (const std::string& wire : wires) {
        out += fmt::format(",{},{}", csv_quoted(wire), csv_quoted(wire + " error_rms"));
    }
    out += '\n';
    for (const Trial& t : trials) {
        for (const graph::Override& s : t.settings) out.append(csv_quoted(s.value)).append(1, ',');
        const std::string why =
            t.incomparable.empty() ? t.failure : "not comparable: " + t.incomparable;
        out += fmt::format("{:.9g},{:.9g},{:.9g},{:.6g},{:.6g},{:d},{:d},{},{},{}", t.error,
                           t.worst, t.relative, 1e3 * t.frame_seconds, 1e3 * t.setup_seconds,
                           t.best, t.reference, csv_quoted(why), t.warnings.size(),
                           csv_quoted(t.warnings.empty() ? "" : t.warnings.front()));
        for (std::size_t m = 0; m < wires.size(); ++m) {
            const Measured none, &one = m < t.measured.size() ? t.measured[m] : none;
            out += fmt::format(",{:.9g},{:.9g}", one.value, one.error);
        }
        out += '\n';
    }
    return out;
}

// Within apostrophes, those inside doubled: gnuplot takes all else as it is.
static std::string gnuplot_quoted(const std::string& text)
{
    std::string out = "'";
    for (const char c : text) out.append(c == '\'' ? 2 : 1, c);
    return out + "'";
}

std::string plot_program(const std::vector<Trial>& trials, const std::string& csv_file,
                         const std::string& png_file, const std::string& title)
{
    const std::size_t settings = trials.empty() ? 0 : trials[0].settings.size();
    const bool by_frame = any_by_frame(trials);
    const std::size_t relative = settings + 3, ms = settings + (by_frame ? 4 : 5),
                      best = settings + 6;
    std::string label = "''";  // the settings' values, joined
    for (std::size_t k = 1; k <= settings; ++k) label += fmt::format(".' '.strcol({})", k);
    return fmt::format(
        "set terminal pngcairo size 960,640 enhanced font 'sans,10'\n"
        "set output {png}\n"
        "set datafile separator ','\n"
        "set title {title} noenhanced\n"
        "set xlabel 'milliseconds {per}'\n"
        "set ylabel 'relative error'\n"
        "set logscale xy\nset format y '%.0e'\nset grid\nset key top right\nset offsets graph 0.1, "
        "graph 0.15, graph 0.1, graph 0.1\n"
        "plot {csv} skip 1 using {ms}:{rel} with points pt 7 lc rgb '#888888' title 'tried', \\\n"
        "     '' skip 1 using {ms}:(column({best}) == 1 ? column({rel}) : NaN) with points pt 7 ps "
        "1.6 lc rgb '#d0561f' title 'best choices', \\\n"
        "     '' skip 1 using {ms}:{rel}:({label}) with labels offset 1,0.6 left font ',8' "
        "noenhanced "
        "notitle\n",
        fmt::arg("png", gnuplot_quoted(png_file)), fmt::arg("title", gnuplot_quoted(title)),
        fmt::arg("csv", gnuplot_quoted(csv_file)),
        fmt::arg("per", by_frame ? "per frame" : "in all"), fmt::arg("ms", ms),
        fmt::arg("rel", relative), fmt::arg("best", best), fmt::arg("label", label));
}

}  // namespace runtime
