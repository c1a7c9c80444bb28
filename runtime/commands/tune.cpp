#include "runtime/commands/tune.hpp"

#include "runtime/commands/tune_dial.hpp"
#include "runtime/commands/wires.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace runtime {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// Of the error, for the size of cubes; the rest is for steps.
constexpr double share_of_size = 0.7;

std::vector<std::string> measures_of(const graph::Graph& graph)
{
    std::vector<std::string> names;
    for (const graph::Node& node : graph.nodes) {
        if (node.type->name == "Measure") names.push_back(node.name + ".value");
    }
    return names;  // none: all numbers
}

// Estimates the errors of settings of one dial, the coarsest first, by the three finest that could
// be cooked.
void estimate(std::vector<Tuned>& tried)
{
    std::vector<const Tuned*> good;
    for (Tuned& t : tried) {
        t.error = infinity;
        if (t.failure.empty()) good.push_back(&t);
    }
    if (good.size() < 3) return;
    const std::size_t n = good.size();
    for (Tuned& t : tried) {
        if (t.failure.empty()) t.error = 0;
    }
    const std::size_t quantities = good[0]->all.size();
    const std::size_t measures = good[0]->numbers.size();
    for (std::size_t m = 0; m < measures; ++m) {
        double scale = 0;  // the largest over the frames
        for (std::size_t q = m; q < quantities; q += measures) {
            scale = std::max(scale, std::abs(good[n - 1]->all[q]));
        }
        for (std::size_t q = m; q < quantities; q += measures) {
            const Limit limit =
                limit_of({good[n - 1]->all[q], good[n - 2]->all[q], good[n - 3]->all[q]});
            for (Tuned& t : tried) {
                if (!t.failure.empty()) continue;
                const double off = std::abs(t.all[q] - limit.value) + limit.uncertainty;
                t.error = std::max(t.error, off == 0 ? 0 : off / scale);
            }
        }
    }
}

class Tuner {
public:
    Tuner(const std::filesystem::path& file, const graph::Registry& registry,
          const TuneOptions& options, Caches& caches, const std::function<void(const Tuned&)>& told)
        : file_(file), registry_(registry), options_(options), caches_(caches), told_(told)
    {}

    Tuning run()
    {
        const graph::Loaded loaded = load_with(file_, registry_, options_.sweep.load, {});
        const graph::Graph& graph = loaded.graph;
        const auto size = is_name_of_variable(options_.size)
                              ? std::optional(find_variable(loaded, options_.size, "--size"))
                              : find_size(graph, options_.size);
        const auto steps = is_name_of_variable(options_.steps)
                               ? std::optional(find_variable(loaded, options_.steps, "--steps"))
                               : find_steps(graph, options_.steps);
        if (!size && !steps) {
            throw std::invalid_argument(
                fmt::format("{} has neither a Voxelize node nor steps to tune: name a parameter "
                            "with --size or --steps NODE.PARAM",
                            graph.file));
        }
        if (size && steps && size->target == steps->target) {
            throw std::invalid_argument(
                fmt::format("expected different numbers for --size and --steps, found '{}' for "
                            "both: leave one out",
                            size->target));
        }
        if (options_.sweep.measures.empty()) measures_ = measures_of(graph);
        out_.reached = true;
        if (size) turn(*size, steps ? share_of_size * options_.error : options_.error, true);
        out_.filled_node = size ? node_of(size->cubes) : "";
        if (!are_filled(graph, out_.filled_node)) out_.filled = 0;
        const double left =
            std::max(options_.error - out_.error, (1 - share_of_size) * options_.error);
        if (steps && !out_.cancelled) turn(*steps, left, false);
        return std::move(out_);
    }

private:
    Dial find_variable(const graph::Loaded& loaded, const std::string& name,
                       const std::string& option) const
    {
        std::vector<std::string_view> names;
        for (const auto& [known, value] : loaded.variables) {
            names.emplace_back(known);
            if (known != name) continue;
            if (value == 0) {
                throw std::invalid_argument(
                    fmt::format("expected a number other than 0 for {}, found the variable '{}'",
                                option, name));
            }
            Dial dial = dial_of_variable(loaded, name, value);
            if (!dial.cubes.empty()) need_size_by_hand(loaded.graph, node_of(dial.cubes));
            return dial;
        }
        const std::string near = graph::suggest(name, names);
        throw std::invalid_argument(
            fmt::format("expected node.parameter or a variable for {}, found no such variable "
                        "'{}'{}{}",
                        option, name, near.empty() ? "" : "; ", near));
    }

    // Twice the value may be beyond what the graph allows, half of it, too.
    Dial dial_of_variable(const graph::Loaded& loaded, const std::string& name, double value) const
    {
        for (const double factor : {2.0, 0.5}) {
            try {
                const Settings settings{{name, fmt::format("{:.17g}", factor * value)}};
                const graph::Loaded other =
                    load_with(file_, registry_, options_.sweep.load, settings);
                return following(loaded.graph, other.graph, name, value, factor);
            } catch (const std::invalid_argument&) {
                continue;
            }
        }
        return {.target = name, .value = value};
    }

    // Tries settings of a dial until the coarsest that is good enough is known.
    void turn(const Dial& dial, double wanted, bool cubes)
    {
        std::vector<Tuned> tried;
        int coarsest = dial.allows(-1) ? -1 : 0, finest = coarsest - 1;
        const auto refine = [&] {
            tried.push_back(cook(dial, ++finest, cubes));
            if (!out_.cancelled) estimate(tried);
        };
        while (!out_.cancelled && static_cast<int>(tried.size()) < options_.most) {
            if (tried.size() >= 3 && best_of(tried, wanted)) break;
            if (!tried.empty() && 8 * tried.back().cubes > options_.most_cubes) break;
            if (!tried.empty() && !dial.allows(finest + 1)) break;
            refine();
        }
        const bool at_end = !dial.allows(finest + 1);
        // It takes three settings to know errors: coarser ones where finer ones are not allowed.
        while (!out_.cancelled && static_cast<int>(tried.size()) < options_.most &&
               dial.allows(coarsest - 1) &&
               (suits(tried.front(), tried, wanted) || (at_end && tried.size() < 3))) {
            tried.insert(tried.begin(), cook(dial, --coarsest, cubes));
            if (!out_.cancelled) estimate(tried);
        }
        if (out_.cancelled) return keep_cooked(std::move(tried));
        const Tuned* best = best_of(tried, wanted);
        out_.reached &= best != nullptr;
        if (!best) {
            if (at_end) out_.at_end = dial.target;
            best =
                &*std::min_element(tried.begin(), tried.end(), [](const Tuned& a, const Tuned& b) {
                    return a.error < b.error;
                });
        }
        out_.recommended = best->settings;
        out_.error += best->error;
        out_.seconds = best->seconds;
        if (cubes) out_.filled = best->cubes;
        out_.tried.push_back(std::move(tried));
    }

    // All but the one that was cancelled.
    void keep_cooked(std::vector<Tuned> tried)
    {
        std::erase_if(tried, [](const Tuned& t) { return t.settings.empty(); });
        if (tried.empty()) return;
        estimate(tried);
        out_.tried.push_back(std::move(tried));
    }

    // Whether it is good enough, with no more warnings than the finest.
    static bool suits(const Tuned& one, const std::vector<Tuned>& tried, double wanted)
    {
        return one.error <= wanted && one.warnings.size() <= tried.back().warnings.size();
    }

    // The coarsest from which on all that are finer are good enough as well.
    static const Tuned* best_of(const std::vector<Tuned>& tried, double wanted)
    {
        const Tuned* best = nullptr;
        for (auto t = tried.rbegin(); t != tried.rend() && suits(*t, tried, wanted); ++t) {
            best = &*t;
        }
        return best;
    }

    void begin(const SweepOptions& sweep_options) const
    {
        Settings settings;
        for (const auto& varied : sweep_options.varied) {
            settings.push_back({varied.target, varied.values.front()});
        }
        options_.begins(settings);
    }

    Tuned cook(const Dial& dial, int halvings, bool cubes)
    {
        SweepOptions sweep_options = options_.sweep;
        if (sweep_options.measures.empty()) sweep_options.measures = measures_;
        sweep_options.pictures = false;
        if (cubes && options_.count_cubes) sweep_options.keep = dial.cubes;
        for (const graph::Override& s : out_.recommended) {
            sweep_options.varied.push_back({s.target, {s.value}});
        }
        sweep_options.varied.push_back({dial.target, {fmt::format("{:.9g}", dial.at(halvings))}});
        if (options_.begins) begin(sweep_options);
        const Swept swept = sweep(file_, registry_, sweep_options, caches_);
        out_.cancelled = swept.cancelled;
        Tuned tuned;
        if (swept.cancelled) return tuned;
        out_.measures = swept.measures;
        tuned.spacing = std::ldexp(1.0, -halvings);
        for (const SweepRow& row : swept.rows) {
            tuned.settings = row.settings;
            // The document's own steps were cooked with the cubes.
            tuned.seconds = halvings == 0 ? std::max(row.seconds, out_.seconds) : row.seconds;
            tuned.warnings = row.warnings;
            tuned.numbers = row.numbers;
            tuned.all.insert(tuned.all.end(), row.numbers.begin(), row.numbers.end());
            if (!row.failure.empty()) tuned.failure = row.failure;
            if (row.kept && options_.count_cubes) tuned.cubes = options_.count_cubes(row.kept);
        }
        if (told_) told_(tuned);
        return tuned;
    }

    const std::filesystem::path& file_;
    const graph::Registry& registry_;
    const TuneOptions& options_;
    Caches& caches_;
    const std::function<void(const Tuned&)>& told_;
    std::vector<std::string> measures_;
    Tuning out_;
};

}  // namespace

Limit limit_of(const std::array<double, 3>& values)
{
    // Cubes and steps converge with order 2 at best: what seems faster has only begun to.
    constexpr double least = 0.5, best = 2;
    // Rounding and tolerances of solvers, of the value.
    constexpr double noise = 1e-6;
    const double last = values[0] - values[1], before = values[1] - values[2];
    const double size = std::max({std::abs(values[0]), std::abs(values[1]), std::abs(values[2])});
    if (std::max(std::abs(last), std::abs(before)) <= noise * size) {
        return {values[0], std::abs(last), best};
    }
    const double ratio = before / last;
    // No order yet. The last change may go on.
    if (last != 0 && !(ratio > std::exp2(least))) {
        return {values[0], std::max(std::abs(last), std::abs(before)), 0};
    }
    const double order = last == 0 ? best : std::min(best, std::log2(ratio));
    const double step = last / (std::exp2(order) - 1);
    return {values[0] + step, 0.25 * std::abs(step), order};
}

Tuning tune(const std::filesystem::path& file, const graph::Registry& registry,
            const TuneOptions& options, Caches& caches,
            const std::function<void(const Tuned&)>& told)
{
    if (!(options.error > 0) || !std::isfinite(options.error)) {
        throw std::invalid_argument(
            fmt::format("expected an error above 0, found {:g}", options.error));
    }
    return Tuner(file, registry, options, caches, told).run();
}

}  // namespace runtime
