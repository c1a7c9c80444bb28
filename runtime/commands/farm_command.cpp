#include "runtime/commands/farm_command.hpp"

#include "runtime/commands/farm_drawing.hpp"
#include "runtime/commands/farm_local.hpp"
#include "runtime/commands/farm_openjd.hpp"
#include "runtime/commands/farm_slurm.hpp"
#include "runtime/commands/farm_status.hpp"
#include "runtime/commands/text_file.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <ostream>

namespace runtime {

namespace {

int run_farm(const CookRequest& request, const FarmRequest& farm, const graph::Registry& registry,
             Console& console)
{
    if (request.files.empty()) {
        throw std::invalid_argument("farm: expected graph documents, as in aspic farm FILE --plan");
    }
    if (!farm.plan && farm.engine.empty()) {
        throw std::invalid_argument(
            "farm: expected --plan, or --engine local, slurm or openjd; found neither");
    }
    if (!farm.plan && farm.engine != "slurm" && (farm.wait || !farm.sbatch.empty())) {
        throw std::invalid_argument(fmt::format("farm: --wait and --sbatch are for --engine slurm, "
                                                "found --engine {}: leave them out",
                                                farm.engine));
    }
    const std::optional<Cut> cut = plan_farm(request, farm, registry, console);
    if (!cut) return exit_usage;
    if (farm.plan) {
        if (!farm.svg.empty()) replace_text(farm.svg, plan_svg(*cut));
        console.out << (request.json ? plan_json(*cut) : plan_text(*cut));
        return exit_ok;
    }
    FarmJob job = new_job(*cut, request, console);
    job.sbatch = farm.sbatch;
    job.vary = farm.vary;
    if (farm.engine == "slurm") check_for_slurm(job);
    if (farm.engine == "openjd") check_for_openjd(job);
    begin_job(job);
    if (farm.engine == "slurm") {
        send_to_slurm(job, console);
        return farm.wait ? wait_for_slurm(job, console) : exit_ok;
    }
    if (farm.engine == "openjd") {
        write_openjd(job, console);
        return exit_ok;
    }
    return run_local(job, farm.machines, console);
}

int run_cancel(const FarmJob& job, Console& console)
{
    std::error_code error;  // without jobs.txt there is no size
    const auto sent = std::filesystem::file_size(job.folder / "jobs.txt", error);
    if (error || sent == 0) {  // empty: sbatch refused the first job
        throw std::runtime_error(fmt::format(
            "nothing was sent to Slurm from {}: Ctrl-C ends a run of --engine local, and other "
            "schedulers cancel their jobs themselves",
            job.folder.string()));
    }
    cancel_slurm(job, console);
    console.out << "cancelled; the same farm command goes on from the cache\n";
    return exit_ok;
}

// What is done with a job that was sent.
void add_job_commands(const CommandSet& set, CLI::App& farm)
{
    const auto add = [&](const char* name, const char* text, auto work) {
        CLI::App* app = farm.add_subcommand(name, text);
        add_files(*app, set.request);
        add_out(*app, set.request);
        app->callback([&set, work = std::move(work)] {
            set.exit = work(read_job(set.request), set.console);
        });
        return app;
    };
    add("status", "Shows what became of the tasks, and verifies what came out",
        [](const FarmJob& job, Console& console) { return farm_status(job, console); });
    const auto task = std::make_shared<std::string>();
    add("logs", "Shows what tasks said that failed",
        [task](const FarmJob& job, Console& console) { return farm_logs(job, *task, console); })
        ->add_option("--task", *task, "Shows what this task said")
        ->type_name("NAME");
    add("cancel", "Ends the tasks that Slurm was sent",
        [](const FarmJob& job, Console& console) { return run_cancel(job, console); });
}

}  // namespace

void add_farm_command(const CommandSet& set)
{
    const auto farm = std::make_shared<FarmRequest>();
    CLI::App* app =
        set.app.add_subcommand("farm", "Cooks graphs in tasks that several machines run");
    app->add_option("files", set.request.files, "Graph documents")->type_name("FILE");
    app->add_option("--engine", farm->engine,
                    "What runs the tasks: local (this machine), slurm or openjd")
        ->type_name("NAME")
        ->check(CLI::IsMember({"local", "slurm", "openjd"}));
    app->add_option("--at-once", farm->machines,
                    "Tasks that run at once on this machine (default: cores by --threads)")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
    CLI::Option* plan =
        app->add_flag("--plan", farm->plan, "Shows the tasks, and how long machines would take");
    app->add_option("--svg", farm->svg, "With --plan: draws it into this file")
        ->type_name("FILE")
        ->needs(plan);
    add_repeatable(*app, "--vary", farm->vary,
                   "Parameter or variable and its values, each combination a cook of its own; "
                   "repeatable",
                   "NODE.PARAM=A,B,C");
    app->add_option("--task-seconds", farm->task_seconds,
                    "Work of a task that can be cut anywhere (default: 30)")
        ->type_name("SECONDS")
        ->check(CLI::Range(1e-3, 1e6));
    app->add_flag("--wait", farm->wait,
                  "With Slurm: waits for the end, and verifies what came out");
    add_repeatable(*app, "--sbatch", farm->sbatch,
                   "With Slurm: an option of each job, as --sbatch=--partition=long; repeatable",
                   "OPTION");
    add_loading_options(*app, set.request);
    add_frames(*app, set.request);
    add_threads(*app, set.request);
    add_cache_options(*app, set.request);
    add_out(*app, set.request);
    add_nodes(*app, set.request);
    add_json(*app, set.request);
    add_job_commands(set, *app);
    app->callback([&set, farm, app] {
        if (!app->get_subcommands().empty()) return;
        set.request.writes = true;
        run_limited(set, [&] { return run_farm(set.request, *farm, set.registry, set.console); });
    });
}

}  // namespace runtime
