#include "runtime/commands/cook_command.hpp"

#include "runtime/commands/cook_graph.hpp"
#include "runtime/commands/kept_sources.hpp"
#include "runtime/commands/openjd_front_end.hpp"
#include "runtime/cook/memory_limit.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <map>

namespace runtime {

namespace {

Style style_of(const CookRequest& request, const Console& console)
{
    return request.json       ? Style::json
           : request.quiet    ? Style::quiet
           : console.terminal ? Style::terminal
                              : Style::lines;
}

void run_cook_command(const CommandSet& set)
{
    run_limited(set, [&set] { return cook(set.request, set.registry, set.console); });
}

// Of the exit codes of two cooks.
int worse(int a, int b)
{
    for (const int exit : {exit_cancelled, exit_failed, exit_missed}) {
        if (a == exit || b == exit) return exit;
    }
    return exit_ok;
}

// Documents of one name in several folders would write over each other's files.
void require_own_folders(const std::vector<graph::Graph>& graphs, const CookRequest& request)
{
    std::map<std::filesystem::path, std::string> taken;
    for (const graph::Graph& graph : graphs) {
        const std::filesystem::path folder = output_folder(graph, request);
        const auto [other, first] = taken.emplace(folder, graph.file);
        if (first || std::filesystem::equivalent(other->second, graph.file)) continue;
        throw std::invalid_argument(
            fmt::format("{} and {} would write into one folder, {}: cook them one at a time, each "
                        "with its own --out DIR",
                        other->second, graph.file, folder.string()));
    }
}

}  // namespace

void add_cook_commands(const CommandSet& set)
{
    CLI::App* cook_app =
        set.app.add_subcommand("cook", "Cooks graphs and writes their output files");
    add_files(*cook_app, set.request);
    add_loading_options(*cook_app, set.request);
    add_cooking_options(*cook_app, set.request);
    add_target_options(*cook_app, set.request);
    cook_app->add_flag("--values", set.request.values,
                       "Cooks every node that gives a number as well, and writes the numbers to "
                       "values.csv instead of printing them");
    cook_app
        ->add_option("--part", set.request.part,
                     "Cooks a part of what others cook into the same folder: its manifest goes to "
                     "this file, and expectations are left to the whole cook")
        ->type_name("FILE");
    cook_app->add_flag("--record-missed", set.request.record_missed,
                       "Exit code 0 where an expectation is missed: the manifest tells it");
    cook_app->add_flag("--openjd", set.request.openjd,
                       "Writes lines for Open Job Description: progress, status, failure");
    cook_app->callback([&set] {
        set.request.writes = true;
        if (!set.request.part.empty() && set.request.files.size() > 1) {
            throw std::invalid_argument("--part: expected one document, found " +
                                        std::to_string(set.request.files.size()));
        }
        run_cook_command(set);
    });

    CLI::App* check_app = set.app.add_subcommand(
        "check", "Cooks only what a graph's expectations need, and checks them");
    add_files(*check_app, set.request);
    add_loading_options(*check_app, set.request);
    add_cooking_options(*check_app, set.request);
    check_app->callback([&set] {
        set.request.expectations_only = true;
        run_cook_command(set);
    });

    CLI::App* profile_app = set.app.add_subcommand(
        "profile", "Cooks and shows the time per node; --trace writes a trace for Perfetto");
    add_files(*profile_app, set.request);
    add_loading_options(*profile_app, set.request);
    add_cooking_options(*profile_app, set.request);
    add_target_options(*profile_app, set.request);
    profile_app->add_option("--trace", set.request.trace, "Trace file for ui.perfetto.dev")
        ->type_name("FILE");
    profile_app->callback([&set] {
        set.request.writes = set.request.profile = true;
        run_cook_command(set);
    });
}

int cook(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    // All documents first: a slip in the last should not wait for the first to be cooked.
    std::vector<graph::Graph> graphs;
    for (const std::string& file : request.files) {
        if (auto graph = load(file, request, registry, console))
            graphs.push_back(std::move(*graph));
    }
    if (graphs.size() < request.files.size()) return exit_usage;
    if (request.writes) {
        require_own_folders(graphs, request);
        for (const graph::Graph& graph : graphs) {
            require_sources_stay(graph, output_folder(graph, request), chosen_nodes(graph, request),
                                 chosen_frames(graph, request));
        }
    }

    const std::unique_ptr<FrontEnd> front_end =
        request.openjd ? openjd_front_end(console)
                       : make_front_end(style_of(request, console), console);
    Caches caches;
    caches.memory = MemoryCache(request.memory);
    caches.disk = open_cache(request, console);
    caches.side_files.remember_in(caches.disk.get());
    int exit = exit_ok;
    for (const graph::Graph& graph : graphs) {
        Manifest manifest;
        int one = exit_failed;
        try {
            one = cook_graph(graph, request, caches, *front_end, console, manifest);
        } catch (const std::bad_alloc&) {  // not in a node: that is a failure of the node
            throw std::runtime_error(graph.file + ": " + out_of_memory());
        }
        exit = worse(exit, one);
        const bool goes_on = request.keep_going || request.expectations_only;
        if (one == exit_cancelled || (one == exit_failed && !goes_on)) break;
    }
    return exit;
}

}  // namespace runtime
