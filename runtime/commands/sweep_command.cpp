#include "runtime/commands/sweep_command.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/commands/manifest.hpp"
#include "runtime/commands/sweep.hpp"
#include "runtime/commands/text_file.hpp"
#include "runtime/cook/task.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <ostream>
#include <set>

namespace runtime {

namespace {

namespace fs = std::filesystem;

// "height.value 0.52  mass.value 3.1", of what could be made.
std::string numbers_text(const std::vector<std::string>& measures, const SweepRow& row)
{
    std::string text;
    for (std::size_t i = 0; i < measures.size(); ++i) {
        if (std::isnan(row.numbers[i])) continue;
        text += fmt::format("{}{} {:.4g}", text.empty() ? "" : "  ", measures[i], row.numbers[i]);
    }
    return text;
}

// ", 2 warnings", or nothing.
std::string warnings_text(std::size_t count)
{
    return count == 0 ? "" : fmt::format(", {} warning{}", count, count == 1 ? "" : "s");
}

// Frames stand side by side; of one frame, the last setting varies fastest: a row of the sheet is
// one of the others.
int columns_of(const SweepRequest& wanted, const std::vector<Vary>& varied, std::size_t frames,
               std::size_t rows)
{
    if (wanted.columns > 0) return wanted.columns;
    if (frames > 1 && frames <= 8) return static_cast<int>(frames);
    const std::size_t fastest = varied.empty() ? 1 : varied.back().values.size();
    if (varied.size() > 1 && fastest <= 8) return static_cast<int>(fastest);
    return static_cast<int>(std::clamp(std::ceil(std::sqrt(static_cast<double>(rows))), 1.0, 6.0));
}

// Returns whether there was a picture.
bool write_sheet(const Swept& swept, const std::function<std::string(const SweepRow&)>& name_of,
                 int columns, const fs::path& path, Console& console)
{
    std::vector<std::pair<graph::Value, std::string>> pictures;
    for (const SweepRow& row : swept.rows) {
        const std::string numbers = numbers_text(swept.measures, row);
        pictures.emplace_back(row.picture, name_of(row) + (numbers.empty() ? "" : "   " + numbers));
    }
    const bool any = console.write_sheet && console.write_sheet(pictures, columns, path) > 0;
    if (any) {
        console.out << "sheet: " << path.string() << "\n";
    } else {
        console.err << "no sheet was made: there is no picture. Use --picture NODE.PORT.\n";
    }
    return any;
}

// The table and the sheet. Returns their names.
std::vector<std::string> write_results(const Swept& swept,
                                       const std::function<std::string(const SweepRow&)>& name_of,
                                       int columns, const fs::path& folder, Console& console)
{
    const fs::path csv = folder / "sweep.csv", png = folder / "sweep.png";
    std::vector<std::string> written{csv.filename().string()};
    replace_text(csv, to_csv(swept));
    console.out << "table: " << csv.string() << "\n";
    if (write_sheet(swept, name_of, columns, png, console)) {
        written.push_back(png.filename().string());
    }
    return written;
}

// What was written, for the farm that this sweep is a task of.
void write_part(const CookRequest& request, const Console& console, const fs::path& folder,
                const std::vector<std::string>& names, bool complete, double seconds)
{
    Manifest part;
    part.version = console.version;
    part.program = to_hex(console.salt);
    part.documents = {{fs::absolute(request.files.at(0)).lexically_normal().string(), ""}};
    part.complete = complete;
    part.ran = ran_here(seconds);
    FileDigests digests;
    for (const std::string& name : names) {
        part.outputs.push_back({"sweep", "", 0, {name, to_hex(digests.of(folder / name))}});
    }
    replace_text(request.part, to_text(part));
}

// Of the settings that the farm cooked, each in a folder of its own: those that missed an
// expectation.
std::vector<std::string> settings_that_missed(const fs::path& folder,
                                              const std::vector<Settings>& all)
{
    std::vector<std::string> missed;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const fs::path manifest = folder / fmt::format("{:03}", i + 1) / manifest_name;
        if (fs::exists(manifest) && !read_manifest(manifest).missed.empty()) {
            missed.push_back(fmt::format("{:03} ({})", i + 1, describe(all[i])));
        }
    }
    return missed;
}

// A line for a scheduler of Open Job Description.
void say_openjd(const CookRequest& request, const Console& console, const std::string& line)
{
    if (request.openjd) console.out << "openjd_" << line << "\n" << std::flush;
}

// What stops this from being a success, told. Returns the exit code.
int tell_end(const CookRequest& request, const Swept& swept, std::size_t failed,
             const fs::path& folder, const std::vector<Settings>& settings, Console& console)
{
    if (swept.cancelled) return exit_cancelled;
    if (failed > 0) {
        say_openjd(request, console, fmt::format("fail: {} settings failed", failed));
        return exit_failed;
    }
    if (request.part.empty()) return exit_ok;
    const std::vector<std::string> missed = settings_that_missed(folder, settings);
    if (missed.empty()) return exit_ok;
    const std::string text = fmt::format("expectations were missed by the setting{} {}",
                                         missed.size() == 1 ? "" : "s", fmt::join(missed, ", "));
    console.err << "missed: " << text << "\n";
    say_openjd(request, console, "fail: " + text);
    return exit_missed;
}

}  // namespace

int run_sweep(const CookRequest& request, const SweepRequest& wanted,
              const graph::Registry& registry, Console& console)
{
    const Clock::time_point began = Clock::now();
    const fs::path file = request.files.at(0);
    SweepOptions options;
    for (const std::string& text : wanted.vary) options.varied.push_back(parse_vary(text));
    options.load = load_options(request);
    options.picture = wanted.picture, options.measures = wanted.measures;
    if (!request.frames.empty()) options.frames = parse_frames(request.frames);
    const fs::path folder = request.output_folder.empty() ? fs::path("out") / file.stem()
                                                          : fs::path(request.output_folder);
    options.cook.threads = request.threads;
    options.cook.stop = console.stop;
    options.cook.salt = console.salt;
    options.cook.output_folder = folder;
    make_output_folder(folder);

    Caches caches;
    caches.memory = MemoryCache(request.memory);
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    const std::size_t frames = std::max<std::size_t>(options.frames.size(), 1);
    const std::vector<Settings> settings = combinations(options.varied);
    const std::size_t all = settings.size() * frames;
    const auto name_of = [&](const SweepRow& row) {
        return describe(row.settings) + (frames > 1 ? fmt::format(", frame {}", row.frame) : "");
    };
    std::size_t done = 0, failed = 0;
    std::set<std::string> warned;
    const Swept swept = sweep(file, registry, options, caches, [&](const SweepRow& row) {
        failed += !row.failure.empty();
        say_openjd(request, console,
                   fmt::format("progress: {:.1f}",
                               100 * static_cast<double>(++done) / static_cast<double>(all)));
        if (!request.quiet || !row.failure.empty()) {
            console.err << fmt::format("{} of {}, {}: {}: {}{}\n", done, all,
                                       format_seconds(row.seconds), name_of(row),
                                       row.failure.empty() ? "done" : "failed: " + row.failure,
                                       warnings_text(row.warnings.size()));
        }
        for (const std::string& text : row.warnings) {
            if (warned.insert(text).second) console.err << "  warning: " << text << "\n";
        }
    });
    // A table of some of the settings would replace an earlier one of all.
    std::vector<std::string> written;
    if (!swept.cancelled) {
        const int columns = columns_of(wanted, options.varied, frames, swept.rows.size());
        written = write_results(swept, name_of, columns, folder, console);
    }
    if (!request.part.empty()) {
        write_part(request, console, folder, written, !swept.cancelled && failed == 0,
                   seconds_since(began));
    }
    return tell_end(request, swept, failed, folder, settings, console);
}

void add_sweep_command(const CommandSet& set)
{
    const auto swept = std::make_shared<SweepRequest>();
    CLI::App* sweep_app = set.app.add_subcommand(
        "sweep", "Cooks every combination of settings; writes a picture sheet and a table");
    add_file(*sweep_app, set.request);
    add_repeatable(*sweep_app, "--vary", swept->vary,
                   "Parameter or variable and its values; repeatable", "NODE.PARAM=A,B,C")
        ->required();
    sweep_app->add_option("--frame", set.request.frames, "Same as --frames")
        ->type_name("N")
        ->check(what_is_wrong_with_frames);
    sweep_app
        ->add_option("--picture", swept->picture, "Picture to show (default: the graph's first)")
        ->type_name("NODE.PORT");
    add_repeatable(*sweep_app, "--measure", swept->measures,
                   "Number for the table (default: all); repeatable", "NODE.PORT");
    sweep_app->add_option("--columns", swept->columns, "Pictures in a row of the sheet")
        ->type_name("N")
        ->check(CLI::Range(1, 100));
    sweep_app
        ->add_option(
            "--part", set.request.part,
            "A manifest of the table and the sheet goes here, and the exit code is 3 where "
            "the cooks in the folders 001, 002 and so on missed an expectation")
        ->type_name("FILE");
    sweep_app->add_flag("--openjd", set.request.openjd,
                        "Writes lines for Open Job Description: progress, failure");
    add_out(*sweep_app, set.request);
    add_loading_options(*sweep_app, set.request);
    add_cooking_options(*sweep_app, set.request);
    sweep_app->get_option("--frames")
        ->description("Frames to show: 12 or 1-48x12 (default: the last)");
    sweep_app->callback([&set, swept] {
        run_limited(set, [&] { return run_sweep(set.request, *swept, set.registry, set.console); });
    });
}

}  // namespace runtime
