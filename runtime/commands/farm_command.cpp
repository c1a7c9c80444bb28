#include "runtime/commands/farm_command.hpp"

#include "runtime/commands/farm_local.hpp"

#include <CLI/CLI.hpp>

#include <ostream>

namespace runtime {

namespace {

int run_farm(const CookRequest& request, const FarmRequest& farm, const graph::Registry& registry,
             Console& console)
{
    if (request.files.empty()) throw std::invalid_argument("farm: expected graph documents");
    if (!farm.plan && farm.engine.empty()) {
        throw std::invalid_argument("farm: expected --plan or --engine local");
    }
    const std::optional<Cut> cut = plan_farm(request, farm, registry, console);
    if (!cut) return exit_usage;
    if (farm.plan) {
        console.out << (request.json ? plan_json(*cut) : plan_text(*cut));
        return exit_ok;
    }
    return run_local(begin_job(*cut, request, console), farm.machines, console);
}

}  // namespace

void add_farm_command(const CommandSet& set)
{
    const auto farm = std::make_shared<FarmRequest>();
    CLI::App* app =
        set.app.add_subcommand("farm", "Cooks graphs in tasks that several machines run");
    app->add_option("files", set.request.files, "Graph documents")->type_name("FILE");
    app->add_option("--engine", farm->engine, "What runs the tasks: local, this machine")
        ->type_name("NAME")
        ->check(CLI::IsMember({"local"}));
    app->add_option("--at-once", farm->machines,
                    "Tasks that run at once on this machine (default: cores by --threads)")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
    app->add_flag("--plan", farm->plan, "Shows the tasks, and how long machines would take");
    add_repeatable(*app, "--vary", farm->vary,
                   "Parameter and its values, each combination a cook of its own; repeatable",
                   "NODE.PARAM=A,B,C");
    app->add_option("--task-seconds", farm->task_seconds,
                    "Work of a task that can be cut anywhere (default: 30)")
        ->type_name("SECONDS")
        ->check(CLI::Range(1e-3, 1e6));
    add_loading_options(*app, set.request);
    add_frames(*app, set.request);
    add_threads(*app, set.request);
    add_cache_options(*app, set.request);
    add_out(*app, set.request);
    add_nodes(*app, set.request);
    add_json(*app, set.request);
    app->callback([&set, farm] {
        set.request.writes = true;
        run_limited(set, [&] { return run_farm(set.request, *farm, set.registry, set.console); });
    });
}

}  // namespace runtime
