#include "runtime/commands/study_command.hpp"

#include "graph/types/context.hpp"
#include "runtime/cache/quantities.hpp"
#include "runtime/commands/study.hpp"
#include "runtime/commands/text_file.hpp"
#include "runtime/commands/wires.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ostream>

namespace runtime {

namespace {

namespace fs = std::filesystem;

double reference_number(const std::string& text)
{
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc{} && stop == end && std::isfinite(value)) return value;
    throw std::invalid_argument(fmt::format(
        "expected a number, node.parameter=value or variable=value for --reference, found "
        "'{}'",
        text));
}

// "; tip.value 0.31, mass.value 2.1 (error 0.02)": of the numbers at the last frame, and the errors
// of all but the first measure.
std::string values_of(const Trial& t)
{
    std::string text;
    for (std::size_t m = 0; m < t.measured.size(); ++m) {
        const Measured& one = t.measured[m];
        const bool known = !std::isnan(one.value), compared = m > 0 && !std::isnan(one.error);
        if (!known && !compared) continue;
        text += fmt::format("{}{}", text.empty() ? "; " : ", ", one.wire);
        if (known) text += fmt::format(" {:.6g}", one.value);
        if (compared) text += fmt::format(" (error {:.3g})", one.error);
    }
    return text;
}

std::string reading(const Trial& t)
{
    if (!t.failure.empty()) return "failed: " + t.failure;
    if (!t.incomparable.empty()) return "not comparable: " + t.incomparable;
    if (t.reference) {
        return fmt::format("reference, {}{}", time_of(t), values_of(t));
    }
    const std::string share = std::isnan(t.relative)
                                  ? "no relative error: the reference is 0 or does not move"
                                  : fmt::format("{:.2g} %", 100 * t.relative);
    return fmt::format("error {:.3g} ({}), {}{}", t.error, share, time_of(t), values_of(t));
}

StudyOptions options_of(const fs::path& file, const fs::path& folder, const CookRequest& request,
                        const StudyRequest& wanted, const graph::Registry& registry,
                        const Console& console)
{
    StudyOptions options;
    for (const std::string& text : wanted.vary) options.varied.push_back(parse_vary(text));
    options.load = load_options(request);
    options.measures = wanted.measures;
    options.look = wanted.look;
    if (console.write_sheet && wanted.look.empty()) {
        options.look = first_picture(load_with(file, registry, options.load, {}).graph);
    }
    options.distances = console.distances;
    if (!request.frames.empty()) options.frames = parse_frames(request.frames);
    if (!wanted.reference.empty()) {
        if (wanted.reference.find('=') == std::string::npos) {
            options.exact = reference_number(wanted.reference);
        } else {
            options.reference = Settings{parse_setting(wanted.reference)};
        }
    }
    options.cook.threads = request.threads;
    options.cook.stop = console.stop;
    options.cook.salt = console.salt;
    options.cook.output_folder = folder;
    return options;
}

void write_plot(const std::vector<Trial>& trials, const fs::path& folder, const std::string& title,
                Console& console)
{
    const auto path = [&](const char* name) { return (folder / name).string(); };
    std::error_code none_there;
    fs::remove(path("study.png"), none_there);  // of an earlier study
    replace_text(path("study.csv"), to_csv(trials));
    replace_text(path("study.gp"),
                 plot_program(trials, path("study.csv"), path("study.png"), title));
    if (!any_to_plot(trials)) {
        console.err << "no plot was made: no setting has an error above 0\n";
        return;
    }
    const int status =
        console.run_program ? console.run_program({"gnuplot", path("study.gp")}, console.stop) : -1;
    if (status == 0) {
        console.out << "plot: " << path("study.png") << "\n";
    } else {
        console.err << fmt::format("warning: no plot was made: {} gnuplot {}\n",
                                   status < 0 ? "install the Debian package gnuplot-nox and run"
                                              : "gnuplot failed; for its message run",
                                   path("study.gp"));
    }
}

// One picture a trial, where there are any.
void write_sheet(const std::vector<Trial>& trials, const fs::path& path, Console& console)
{
    std::vector<std::pair<graph::Value, std::string>> pictures;
    for (const Trial& t : trials) {
        pictures.emplace_back(t.look, describe(t.settings) + "  " + reading(t));
    }
    constexpr int columns = 3;
    if (console.write_sheet && console.write_sheet(pictures, columns, path) > 0) {
        console.out << "sheet: " << path.string() << "\n";
    }
}

}  // namespace

void add_study_command(const CommandSet& set)
{
    const auto wanted = std::make_shared<StudyRequest>();
    CLI::App* study_app =
        set.app.add_subcommand("study", "Compares the speed and the error of settings of a graph");
    add_file(*study_app, set.request);
    add_loading_options(*study_app, set.request);
    add_cooking_options(*study_app, set.request);
    add_out(*study_app, set.request);
    add_repeatable(*study_app, "--vary", wanted->vary,
                   "Parameter or variable and its values; repeatable", "NODE.PARAM=A,B,C")
        ->required();
    add_repeatable(*study_app, "--measure", wanted->measures,
                   "Output to compare: a number or a mesh; repeatable, the first one decides",
                   "NODE.PORT")
        ->required();
    study_app
        ->add_option("--reference", wanted->reference,
                     "Reference: a number, node.param=value or variable=value (default: the last "
                     "combination)")
        ->type_name("VALUE");
    study_app
        ->add_option("--look", wanted->look, "Picture for the sheet (default: the graph's first)")
        ->type_name("NODE.PORT");
    study_app
        ->add_option("--error", wanted->wanted_error, "Relative error to reach (default: 0.01)")
        ->type_name("SHARE");
    study_app->callback([&set, wanted] {
        run_limited(set,
                    [&] { return run_study(set.request, *wanted, set.registry, set.console); });
    });
}

int run_study(const CookRequest& request, const StudyRequest& wanted,
              const graph::Registry& registry, Console& console)
{
    const fs::path file = request.files.at(0);
    const fs::path folder = request.output_folder.empty() ? fs::path("out") / file.stem()
                                                          : fs::path(request.output_folder);
    const StudyOptions options = options_of(file, folder, request, wanted, registry, console);
    make_output_folder(folder);
    std::vector<Trial> trials;
    try {
        trials = study(file, registry, options, [&](const Trial& t) {
            console.err << describe(t.settings) << ": " << reading(t) << "\n";
            for (const std::string& w : t.warnings) console.err << "  warning: " << w << "\n";
        });
    } catch (const graph::Cancelled&) {
        return exit_cancelled;  // a table of some of the settings would name a wrong best one
    }
    write_plot(trials, folder, file.stem().string() + ": " + wanted.measures.front(), console);
    write_sheet(trials, folder / "study_sheet.png", console);
    console.out << "table: " << (folder / "study.csv").string() << "\n"
                << soonest(trials, wanted.wanted_error) << "\n";
    const bool failed = std::any_of(trials.begin(), trials.end(),
                                    [](const Trial& t) { return !t.failure.empty(); });
    return failed || !any_compared(trials) ? exit_failed : exit_ok;
}

}  // namespace runtime
