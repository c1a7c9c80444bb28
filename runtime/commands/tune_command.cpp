#include "runtime/commands/tune_command.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/tune.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>
#include <ostream>
#include <set>

namespace runtime {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// "5%" or "0.05".
double share_of(std::string text)
{
    const std::string given = text;
    const bool percent = text.ends_with('%');
    if (percent) text.pop_back();
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stop != end || !(value > 0) || !std::isfinite(value)) {
        throw std::invalid_argument(
            fmt::format("expected 5% or 0.05 for --error, found '{}'", given));
    }
    return percent ? value / 100 : value;
}

std::string percent_of(double error)
{
    return std::isfinite(error) ? fmt::format("{:.2g} %", 100 * error) : "unknown";
}

std::string error_text(const Tuned& t)
{
    return t.failure.empty() ? percent_of(t.error) : "failed";
}

void write_table(const Tuning& tuning, std::ostream& out)
{
    for (const std::vector<Tuned>& tried : tuning.tried) {
        const std::string target = tried.front().settings.back().target;
        out << fmt::format("{:<22}{:>9}", target, "cubes");
        for (const std::string& m : tuning.measures) out << fmt::format("  {:>14}", m);
        out << fmt::format("{:>12}{:>10}{:>10}\n", "error", "time", "warnings");
        for (const Tuned& t : tried) {
            out << fmt::format("{:<22}{:>9}", t.settings.back().value,
                               t.cubes > 0 ? fmt::format("{:.0f}", t.cubes) : "");
            for (const double x : t.numbers) out << fmt::format("  {:>14.6g}", x);
            out << fmt::format("{:>12}{:>10}{:>10}\n", error_text(t), format_seconds(t.seconds),
                               t.warnings.size());
        }
    }
}

Json settings_json(const Settings& settings)
{
    Json out = Json::object();
    for (const graph::Override& s : settings) out[s.target] = Json::parse(s.value);
    return out;
}

Json number_json(double x)
{
    return std::isfinite(x) ? Json(x) : Json();
}

void write_json(const Tuning& tuning, std::ostream& out)
{
    for (const std::vector<Tuned>& tried : tuning.tried) {
        for (const Tuned& t : tried) {
            Json line{{"setting", settings_json(t.settings)}};
            if (t.cubes > 0) line["cubes"] = static_cast<std::int64_t>(t.cubes);
            for (std::size_t i = 0; i < t.numbers.size(); ++i) {
                line["values"][tuning.measures[i]] = number_json(t.numbers[i]);
            }
            line["error"] = number_json(t.error);
            line["seconds"] = t.seconds;
            line["warnings"] = t.warnings;
            if (!t.failure.empty()) line["failure"] = t.failure;
            out << line.dump(-1, ' ', false, Json::error_handler_t::replace) << "\n";
        }
    }
    const Json end{{"recommended", settings_json(tuning.recommended)},
                   {"error", number_json(tuning.error)},
                   {"seconds", tuning.seconds},
                   {"reached", tuning.reached}};
    out << end.dump() << "\n";
}

std::string recommendation(const Tuning& tuning, double wanted)
{
    const std::string setting = describe(tuning.recommended);
    const std::string error = percent_of(tuning.error);
    if (tuning.reached) {
        return fmt::format("Coarsest setting within {:g} %: {} (estimated error {}, {}).",
                           100 * wanted, setting, error, format_seconds(tuning.seconds));
    }
    return fmt::format(
        "No setting is known to be within {:g} %; the nearest is {} (estimated error "
        "{}). {}",
        100 * wanted, setting, error,
        tuning.at_end.empty() ? "Raise --most or --cubes to try finer ones."
                              : fmt::format("The range of {} ends there.", tuning.at_end));
}

// A thin or tilted body is often right in calibrated cubes as wide as it is thick.
std::string hint(const Tuning& tuning)
{
    constexpr double many = 1000;
    if (tuning.filled == 0 || (tuning.reached && tuning.filled < many)) return {};
    return fmt::format("Thin or tilted bodies are often right in far fewer cubes with --set "
                       "{}.stiffness=calibrated.\n",
                       tuning.filled_node);
}

TuneOptions options_of(const CookRequest& request, const TuneRequest& wanted,
                       const Console& console)
{
    TuneOptions options;
    options.error = share_of(wanted.error);
    options.size = wanted.size, options.steps = wanted.steps;
    options.most = wanted.most, options.most_cubes = wanted.most_cubes;
    options.count_cubes = console.count_cubes;
    SweepOptions& sweep = options.sweep;
    sweep.load = load_options(request);
    sweep.measures = wanted.measures;
    if (!request.frames.empty()) sweep.frames = parse_frames(request.frames);
    sweep.cook.threads = request.threads;
    sweep.cook.stop = console.stop;
    sweep.cook.salt = console.salt;
    return options;
}

}  // namespace

int run_tune(const CookRequest& request, const TuneRequest& wanted, const graph::Registry& registry,
             Console& console)
{
    const fs::path file = request.files.at(0);
    TuneOptions options = options_of(request, wanted, console);
    options.sweep.cook.output_folder = fs::path("out") / file.stem();
    Caches caches;
    caches.memory = MemoryCache(request.memory);
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    if (!request.quiet) {
        options.begins = [&](const Settings& settings) {
            console.err << fmt::format("cooking {}\n", describe(settings)) << std::flush;
        };
    }
    std::set<std::string> warned;
    const Tuning tuning = tune(file, registry, options, caches, [&](const Tuned& t) {
        if (!request.quiet || !t.failure.empty()) {
            console.err << fmt::format("{}, {}: {}\n", describe(t.settings),
                                       format_seconds(t.seconds),
                                       t.failure.empty() ? "done" : "failed: " + t.failure);
        }
        for (const std::string& text : t.warnings) {
            if (warned.insert(text).second) console.err << "  warning: " << text << "\n";
        }
    });
    if (tuning.cancelled) {
        if (!request.json) write_table(tuning, console.out);
        return exit_cancelled;
    }
    if (request.json) {
        write_json(tuning, console.out);
    } else {
        write_table(tuning, console.out);
        console.out << recommendation(tuning, options.error) << "\n" << hint(tuning);
    }
    return tuning.reached ? exit_ok : exit_missed;
}

void add_tune_command(const CommandSet& set)
{
    const auto wanted = std::make_shared<TuneRequest>();
    CLI::App* tune_app = set.app.add_subcommand(
        "tune", "Finds the coarsest cubes and the longest steps that are within an error");
    add_file(*tune_app, set.request);
    tune_app->add_option("--error", wanted->error, "Relative error to stay within (default: 5%)")
        ->type_name("SHARE");
    add_repeatable(*tune_app, "--measure", wanted->measures,
                   "Number to be right (default: those of all Measure nodes); repeatable",
                   "NODE.PORT");
    tune_app
        ->add_option("--size", wanted->size,
                     "Parameter of the cubes, or a variable (default: that of Voxelize)")
        ->type_name("NODE.PARAM");
    tune_app
        ->add_option(
            "--steps", wanted->steps,
            "Parameter of the steps, or a variable (default: step.substeps of the simulation, or "
            "step.error where that is 0)")
        ->type_name("NODE.PARAM");
    tune_app->add_option("--most", wanted->most, "Most values of a parameter to try (default: 6)")
        ->type_name("N")
        ->check(CLI::Range(3, 20));
    tune_app->add_option("--cubes", wanted->most_cubes, "Most cubes to try (default: 1000000)")
        ->type_name("N")
        ->check(CLI::Range(1.0, 1e9));
    add_loading_options(*tune_app, set.request);
    add_cooking_options(*tune_app, set.request);
    tune_app->get_option("--frames")
        ->description("Frames to be right: 12 or 1-48x12 (default: the last)");
    tune_app->callback([&set, wanted] {
        run_limited(set, [&] { return run_tune(set.request, *wanted, set.registry, set.console); });
    });
}

}  // namespace runtime
