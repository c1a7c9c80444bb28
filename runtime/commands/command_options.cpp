#include "runtime/commands/command_options.hpp"

#include "runtime/cache/quantities.hpp"
#include "runtime/cook/interrupt.hpp"
#include "runtime/cook/memory_limit.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <utility>

namespace runtime {

namespace {

int within_limits(const CookRequest& request, Console& console, const std::function<int()>& work)
{
    const MemoryLimit memory(request.memory_limit);
    if (request.threads > 0 && console.limit_libraries) console.limit_libraries(request.threads);
    if (request.time_limit <= 0) return work();
    const Deadline deadline(request.time_limit, console.stop);
    const std::stop_token before = std::exchange(console.stop, deadline.token());
    const int exit = work();
    console.stop = before;
    if (deadline.over() && exit == exit_cancelled) {
        console.err << fmt::format("the time limit of {} s was reached\n", request.time_limit);
    }
    return exit;
}

}  // namespace

void add_files(CLI::App& command, CookRequest& request)
{
    command.add_option("files", request.files, "Graph documents")->required()->type_name("FILE");
}

void add_file(CLI::App& command, CookRequest& request)
{
    command.add_option("files", request.files, "A graph document")
        ->required()
        ->expected(1)
        ->type_name("FILE");
}

CLI::Option* add_repeatable(CLI::App& command, const std::string& name,
                            std::vector<std::string>& texts, const std::string& description,
                            const std::string& type_name)
{
    return command.add_option(name, texts, description)
        ->type_name(type_name)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_permissions(CLI::App& command, CookRequest& request)
{
    command.add_option("--root", request.root, "Folder that all files to read must lie in")
        ->type_name("DIR");
    command.add_flag("--allow-outside", request.allow_outside,
                     "Allows the graph to read files outside its root, and to write outside "
                     "the output folder");
}

void add_loading_options(CLI::App& command, CookRequest& request)
{
    add_repeatable(command, "--set", request.sets, "Sets a parameter to another value; repeatable",
                   "NODE.PARAM=VALUE");
    add_repeatable(command, "--var", request.variables,
                   "Sets a variable of the document to another value; repeatable", "NAME=NUMBER");
    add_permissions(command, request);
    command.add_flag("-q,--quiet", request.quiet, "Prints only warnings and errors");
}

void add_cache_options(CLI::App& command, CookRequest& request)
{
    command.add_option("--cache", request.cache, "Cache folder (default: the user's own)")
        ->type_name("DIR");
    command
        .add_option_function<std::string>(
            "--cache-size",
            [&](const std::string& text) { request.cache_budget = parse_bytes(text); },
            "Limit of the cache on disk; least valuable results go first (default: 20G)")
        ->type_name("BYTES");
}

void add_threads(CLI::App& command, CookRequest& request)
{
    command
        .add_option("--threads", request.threads,
                    "Number of threads, of drawing too (default: one per core)")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
}

void add_frames(CLI::App& command, CookRequest& request)
{
    command
        .add_option("--frames", request.frames,
                    "Frames to cook: 1-48, 1-48x2 or 10,20 (default: all)")
        ->type_name("FRAMES")
        ->check(what_is_wrong_with_frames);
}

void add_json(CLI::App& command, CookRequest& request)
{
    command.add_flag("--json", request.json, "Writes all output as JSON lines");
}

void add_cooking_options(CLI::App& command, CookRequest& request)
{
    add_frames(command, request);
    add_threads(command, request);
    command
        .add_option_function<std::string>(
            "--memory", [&](const std::string& text) { request.memory = parse_bytes(text); },
            "Limit of the results kept in memory (default: 2G)")
        ->type_name("BYTES");
    add_cache_options(command, request);
    command.add_flag("--no-disk-cache", request.no_disk_cache,
                     "Neither reads nor writes the disk cache");
    command
        .add_option("--time-limit", request.time_limit,
                    "Cancels the cook after this time, as Ctrl-C does")
        ->type_name("SECONDS")
        ->check(CLI::Range(1e-3, 1e8));
    command
        .add_option_function<std::string>(
            "--memory-limit",
            [&](const std::string& text) { request.memory_limit = parse_bytes(text); },
            "Memory limit for the process (default: 90 % of the machine's)")
        ->type_name("BYTES");
    add_json(command, request);
}

void add_out(CLI::App& command, CookRequest& request)
{
    command.add_option("--out", request.output_folder, "Output folder (default: out/<graph>)")
        ->type_name("DIR");
}

void add_nodes(CLI::App& command, CookRequest& request)
{
    add_repeatable(command, "--node", request.nodes,
                   "Cooks only this node and what it depends on; repeatable", "NAME");
}

void add_target_options(CLI::App& command, CookRequest& request)
{
    add_out(command, request);
    add_nodes(command, request);
    command.add_flag("--keep-going", request.keep_going,
                     "Continues with what does not depend on a failed node");
    command
        .add_option("--recheck", request.recheck,
                    "Recomputes this percentage of cached results and fails on a difference")
        ->type_name("PERCENT")
        ->check(CLI::Range(0.0, 100.0));
}

std::string what_is_wrong_with_frames(const std::string& text)
{
    // No frames are wrong, too: a script whose variable is empty does not mean all frames.
    try {
        static_cast<void>(parse_frames(text));
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return {};
}

void run_limited(const CommandSet& set, const std::function<int()>& work)
{
    set.exit = within_limits(set.request, set.console, work);
}

}  // namespace runtime
