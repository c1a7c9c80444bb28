#include "runtime/document_commands.hpp"

#include "graph/difference.hpp"
#include "graph/format.hpp"
#include "graph/reference.hpp"
#include "graph/schema.hpp"
#include "runtime/text_file.hpp"
#include "runtime/wires.hpp"

#include <CLI/CLI.hpp>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ostream>

extern char** environ;

namespace runtime {
namespace {

int show_nodes(const std::string& name, bool markdown, const graph::Registry& registry,
               Console& console)
{
    if (!name.empty()) {
        const graph::NodeType* type = registry.find(name);
        if (!type) {
            std::vector<std::string_view> names;
            for (const auto& [known, unused] : registry.types()) names.push_back(known);
            throw std::invalid_argument(
                fmt::format("there is no node type '{}'; {}", name, graph::suggest(name, names)));
        }
        console.out << graph::reference_text(*type);
    } else {
        console.out << (markdown ? graph::reference_page(registry)
                                 : graph::reference_list(registry));
    }
    return exit_ok;
}

// `check`: says which files are not in canonical form, and changes none.
int format_files(const std::vector<std::string>& files, bool check, Console& console)
{
    int exit = exit_ok;
    for (const std::string& file : files) {
        const std::string text = read_text(file);
        graph::Problems problems;
        const auto formatted = graph::format_document(text, file, problems);
        for (const graph::Problem& p : problems.take()) console.err << graph::describe(p) << "\n";
        if (!formatted) {
            exit = exit_usage;
        } else if (*formatted != text) {
            if (check) {
                exit = exit_failed;
            } else {
                replace_text(file, *formatted);
            }
            console.out << file << "\n";
        }
    }
    return exit;
}

int show_difference(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    const auto a = load(request.files.at(0), request, registry, console);
    const auto b = load(request.files.at(1), request, registry, console);
    if (!a || !b) return exit_usage;
    const std::vector<std::string> lines = graph::difference(*a, *b);
    for (const std::string& line : lines) console.out << line << "\n";
    return lines.empty() ? exit_ok : exit_failed;
}

int start_document(const std::string& file, Console& console)
{
    if (file.empty()) {
        console.out << console.starter;
        return exit_ok;
    }
    const std::filesystem::path path =
        std::filesystem::path(file).has_extension() ? file : file + ".json";
    if (std::filesystem::exists(path)) {
        throw std::invalid_argument(
            fmt::format("{} is there already: say another name", path.string()));
    }
    std::error_code error;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
    if (error) {
        throw std::invalid_argument(fmt::format("the folder {} can't be made ({}): say another",
                                                path.parent_path().string(), error.message()));
    }
    std::string text = console.starter;
    // Its comments show commands on itself, by the name that it now has.
    const std::string own_name = "starter.json", name = path.filename().string();
    for (std::size_t at = 0; (at = text.find(own_name, at)) != std::string::npos;) {
        text.replace(at, own_name.size(), name);
        at += name.size();
    }
    replace_text(path, text);
    console.out << fmt::format("{} is written; next: aspic cook {}\n", path.string(),
                               path.string());
    return exit_ok;
}

// Runs a program with no shell between, and nothing that it says is shown: its exit status, -1 when
// it is not there or was ended.
int run_quietly(std::vector<std::string> words)
{
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    pid_t child = 0;
    const int failed = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) return -1;
    int status = 0;
    if (waitpid(child, &status, 0) != child) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

double reference_number(const std::string& text)
{
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc{} && stop == end && std::isfinite(value)) return value;
    throw std::invalid_argument(
        fmt::format("expected a number or node.parameter=value for --reference, found '{}'", text));
}

std::string reading(const Trial& t)
{
    if (!t.failure.empty()) return "failed: " + t.failure;
    if (!t.incomparable.empty()) return "not comparable: " + t.incomparable;
    if (t.reference) return fmt::format("the reference, {:.3g} ms a frame", 1e3 * t.frame_seconds);
    const std::string share = std::isnan(t.relative)
                                  ? "of a reference that is 0 or does not move: no share of it"
                                  : fmt::format("{:.2g} %", 100 * t.relative);
    return fmt::format("error {:.3g} ({}), {:.3g} ms a frame", t.error, share,
                       1e3 * t.frame_seconds);
}

}  // namespace

void add_document_commands(CLI::App& app, CookRequest& request, const graph::Registry& registry,
                           Console& console, int& exit)
{
    CLI::App* nodes = app.add_subcommand("nodes", "Tells what node types there are, or all of one");
    auto name = std::make_shared<std::string>();
    auto markdown = std::make_shared<bool>(false);
    nodes->add_option("type", *name, "A node type")->type_name("TYPE");
    nodes->add_flag("--markdown", *markdown, "The whole reference as a page");
    nodes->callback(
        [&, name, markdown] { exit = show_nodes(*name, *markdown, registry, console); });

    app.add_subcommand("schema", "Writes a JSON Schema of graph documents, for editors")
        ->callback([&] {
            console.out << graph::schema_text(registry);
            exit = exit_ok;
        });

    CLI::App* fmt_app = app.add_subcommand("fmt", "Writes documents in their one canonical form");
    auto check = std::make_shared<bool>(false);
    fmt_app->add_option("files", request.files, "Graph documents")->required()->type_name("FILE");
    fmt_app->add_flag("--check", *check, "Only names those that are not, and exits with 1");
    fmt_app->callback([&, check] { exit = format_files(request.files, *check, console); });

    CLI::App* diff = app.add_subcommand(
        "diff", "Tells how two graphs differ in meaning; exits with 1 if they do");
    diff->add_option("files", request.files, "Two graph documents")
        ->required()
        ->expected(2)
        ->type_name("FILE");
    diff->callback([&] { exit = show_difference(request, registry, console); });

    CLI::App* start = app.add_subcommand("new", "Writes a graph to start from, with comments");
    auto target = std::make_shared<std::string>();
    start->add_option("file", *target, "Where; else it is shown")->type_name("FILE");
    start->callback([&, target] { exit = start_document(*target, console); });

    CLI::App* draw = app.add_subcommand("graph", "Writes a graph for Graphviz: | dot -Tsvg");
    draw->add_option("files", request.files, "A graph document")
        ->required()
        ->expected(1)
        ->type_name("FILE");
    draw->callback([&] {
        const auto graph = load(request.files.at(0), request, registry, console);
        if (graph) console.out << graph::dot_text(*graph);
        exit = graph ? exit_ok : exit_usage;
    });
}

int run_study(const CookRequest& request, const StudyRequest& wanted,
              const graph::Registry& registry, Console& console)
{
    const std::filesystem::path file = request.files.at(0);
    StudyOptions options;
    for (const std::string& text : wanted.vary) options.varied.push_back(parse_vary(text));
    options.load = load_options(request);
    options.measure = wanted.measure;
    options.look = wanted.look;
    if (console.write_sheet && wanted.look.empty()) {
        options.look = first_picture(load_with(file, registry, options.load, {}));
    }
    options.distances = console.distances;
    if (!request.frames.empty()) options.frames = parse_frames(request.frames);
    if (!wanted.reference.empty()) {
        if (wanted.reference.find('=') == std::string::npos) {
            options.exact = reference_number(wanted.reference);
        } else {
            options.reference = Settings{graph::parse_override(wanted.reference)};
        }
    }
    options.cook.threads = request.threads;
    options.cook.stop = console.stop;
    options.cook.salt = console.salt;
    const std::filesystem::path folder = request.output_folder.empty()
                                             ? std::filesystem::path("out") / file.stem()
                                             : std::filesystem::path(request.output_folder);
    options.cook.output_folder = folder;
    make_output_folder(folder);

    const std::vector<Trial> trials = study(file, registry, options, [&](const Trial& t) {
        console.err << describe(t.settings) << ": " << reading(t) << "\n";
        for (const std::string& w : t.warnings) console.err << "  warning: " << w << "\n";
    });
    const auto path = [&](const char* name) { return (folder / name).string(); };
    replace_text(path("study.csv"), to_csv(trials));
    replace_text(path("study.gp"), plot_program(trials, path("study.csv"), path("study.png"),
                                                file.stem().string() + ": " + wanted.measure));
    if (!any_to_plot(trials)) {
        console.err << "no plot was made: no setting has an error above 0 to draw\n";
    } else if (const int status = run_quietly({"gnuplot", path("study.gp")}); status == 0) {
        console.out << "plot: " << path("study.png") << "\n";
    } else {
        console.err << fmt::format("warning: no plot was made: {} gnuplot {}\n",
                                   status < 0 ? "install the Debian package gnuplot-nox and run"
                                              : "gnuplot failed, and says why when run again:",
                                   path("study.gp"));
    }
    std::vector<std::pair<graph::Value, std::string>> pictures;
    for (const Trial& t : trials) {
        pictures.emplace_back(t.look, describe(t.settings) + "  " + reading(t));
    }
    constexpr int columns = 3;
    if (console.write_sheet &&
        console.write_sheet(pictures, columns, path("study_sheet.png")) > 0) {
        console.out << "sheet: " << path("study_sheet.png") << "\n";
    }
    console.out << "table: " << path("study.csv") << "\n"
                << soonest(trials, wanted.wanted_error) << "\n";
    const bool failed = std::any_of(trials.begin(), trials.end(),
                                    [](const Trial& t) { return !t.failure.empty(); });
    return failed || !any_compared(trials) ? exit_failed : exit_ok;
}

}  // namespace runtime
