#include "runtime/command_line.hpp"

#include "runtime/cook_command.hpp"
#include "runtime/deadline.hpp"
#include "runtime/doctor.hpp"
#include "runtime/document_commands.hpp"
#include "runtime/explain.hpp"
#include "runtime/memory_limit.hpp"
#include "runtime/sweep_command.hpp"
#include "runtime/verify.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

namespace runtime {

namespace {

int validate(const CookRequest& request, const graph::Registry& registry, Console& console)
{
    bool all = true;
    for (const std::string& file : request.files) {
        const auto graph = load(file, request, registry, console);
        all = all && graph.has_value();
        if (graph && !request.quiet) {
            console.out << fmt::format("{}: good: {} nodes, frames {} to {}\n", file,
                                       graph->nodes.size(), graph->range.first, graph->range.last);
        }
    }
    return all ? exit_ok : exit_usage;
}

void add_loading_options(CLI::App& command, CookRequest& request)
{
    command.add_option("--set", request.sets, "Another value for a parameter, as node.param=value")
        ->type_name("NODE.PARAM=VALUE")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_option("--var", request.variables, "Another value for a variable of the document")
        ->type_name("NAME=NUMBER")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_option("--root", request.root, "Folder outside which no file is read")
        ->type_name("DIR");
    command.add_flag("--allow-outside", request.allow_outside,
                     "Lets the graph read files outside its root");
    command.add_flag("-q,--quiet", request.quiet, "Says only what is wrong");
}

void add_cache_options(CLI::App& command, CookRequest& request)
{
    command.add_option("--cache", request.cache, "Folder of stored results; else the user's own")
        ->type_name("DIR");
    command
        .add_option_function<std::string>(
            "--cache-size",
            [&](const std::string& text) { request.cache_budget = parse_bytes(text); },
            "At most this much on disk; what is worth least goes first (20G)")
        ->type_name("BYTES");
}

int tend_cache(const std::string& what, const CookRequest& request, Console& console)
{
    const std::unique_ptr<DiskCache> cache = open_cache(request, console);
    if (!cache) throw std::invalid_argument("no cache folder: HOME is not set; say --cache DIR");
    if (what == "verify") {
        const DiskCheck check = cache->verify();
        console.out << fmt::format("{} files good, {} damaged and set aside\n", check.good,
                                   check.bad);
        return check.bad == 0 ? exit_ok : exit_failed;
    }
    if (what == "gc") {
        const auto gone = static_cast<double>(cache->shrink(request.cache_budget));
        console.out << format_bytes(gone) << " removed\n";
    } else if (what == "clear") {
        cache->clear();
    }
    const DiskUse use = cache->use();
    console.out << fmt::format("{}: {} results, {} values, {}\n", cache->folder().string(),
                               use.records, use.contents,
                               format_bytes(static_cast<double>(use.bytes)));
    if (use.aside > 0) console.out << fmt::format("{} damaged files were set aside\n", use.aside);
    return exit_ok;
}

// Of nothing, too: a script whose variable is empty does not mean all frames.
std::string what_is_wrong_with_frames(const std::string& text)
{
    try {
        static_cast<void>(parse_frames(text));
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return {};
}

void add_cooking_options(CLI::App& command, CookRequest& request)
{
    command.add_option("--frames", request.frames, "Which, as 1-48, 1-48x2 or 10,20; else all")
        ->type_name("FRAMES")
        ->check(what_is_wrong_with_frames);
    command.add_option("--threads", request.threads, "At most; the results are the same")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
    command
        .add_option_function<std::string>(
            "--memory", [&](const std::string& text) { request.memory = parse_bytes(text); },
            "For results kept in memory, as 500M or 2G")
        ->type_name("BYTES");
    add_cache_options(command, request);
    command.add_flag("--no-disk-cache", request.no_disk_cache, "Keeps nothing beyond this cook");
    command
        .add_option("--time-limit", request.time_limit,
                    "Ends the cook after so long, as Ctrl-C would")
        ->type_name("SECONDS")
        ->check(CLI::Range(1e-3, 1e8));
    command
        .add_option_function<std::string>(
            "--memory-limit",
            [&](const std::string& text) { request.memory_limit = parse_bytes(text); },
            "A node that wants more than this in all fails; else nine tenths of the machine's")
        ->type_name("BYTES");
    command.add_flag("--json", request.json, "Tells everything as JSON lines");
}

int within_limits(const CookRequest& request, Console& console, const std::function<int()>& work)
{
    const MemoryLimit memory(request.memory_limit);
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

std::string nearest_of(const std::string& word, const std::vector<std::string>& names)
{
    const std::vector<std::string_view> views(names.begin(), names.end());
    return graph::nearest(word, views);
}

void add_target_options(CLI::App& command, CookRequest& request)
{
    command.add_option("--out", request.output_folder, "Where files go; else out/<graph>")
        ->type_name("DIR");
    command.add_option("--node", request.nodes, "Only this node, and what it needs; repeatable")
        ->type_name("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command.add_flag("--keep-going", request.keep_going,
                     "Cooks on where nothing depends on a failed node");
    command
        .add_option("--recheck", request.recheck,
                    "Makes this share of what is stored again, and fails where it differs")
        ->type_name("PERCENT")
        ->check(CLI::Range(0.0, 100.0));
}

std::vector<std::string> commands_of(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
    return names;
}

// "\n  stat    How much there is", a line for each command below this one.
std::string listed(const CLI::App& app)
{
    std::string text;
    for (const CLI::App* sub : app.get_subcommands({})) {
        text += fmt::format("\n  {:<9} {}", sub->get_name(), sub->get_description());
    }
    return text;
}

// "cook wants FILE: Graph documents": the first thing that a command can't do without.
std::string wanted(const CLI::App& command)
{
    for (const CLI::Option* option : command.get_options()) {
        const auto found = static_cast<int>(option->count());
        const int least = std::max(option->get_items_expected_min(), 1);
        if (!option->get_required() || found >= least) continue;
        const std::string name = option->get_positional() ? "" : option->get_name() + " ";
        return fmt::format("{} wants {}{}{}: {}", command.get_name(),
                           least > 1 ? fmt::format("{} times ", least) : "", name,
                           option->get_type_name(), option->get_description());
    }
    return {};
}

// What was not understood, and the nearest name that would be.
std::string mistake(const CLI::App& app, const std::vector<std::string>& args,
                    const std::string& otherwise)
{
    const auto said = [](const char* what, const std::string& word, const std::string& near) {
        return fmt::format("there is no {} '{}'{}", what, word,
                           near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
    };
    const CLI::App* command = &app;  // the innermost that was named
    for (const std::string& arg : args) {
        const std::vector<std::string> names = commands_of(*command);
        if (names.empty() || arg.starts_with("-")) break;
        if (std::find(names.begin(), names.end(), arg) == names.end()) {
            const std::string near = nearest_of(arg, names);
            return said("command", arg, near) + (near.empty() ? listed(*command) : "");
        }
        command = command->get_subcommand(arg);
    }
    if (!commands_of(*command).empty() && command != &app) {
        return fmt::format("{} what?{}", command->get_name(), listed(*command));
    }
    std::vector<std::string> flags;
    for (const CLI::Option* option : command->get_options()) {
        for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
    }
    for (const std::string& arg : args) {
        const std::string word = arg.substr(0, arg.find('='));
        if (!word.starts_with("--") || word == "--") continue;
        if (std::find(flags.begin(), flags.end(), word) != flags.end()) continue;
        return said("option", word, nearest_of(word, flags));
    }
    const std::string missing = wanted(*command);
    return missing.empty() ? otherwise : missing;
}

}  // namespace

int run_command_line(const std::vector<std::string>& args, const graph::Registry& registry,
                     Console& console)
{
    CLI::App app(
        "Aspic cooks node graphs of deformation effects: each node once, each frame in turn, "
        "everything cached.",
        "aspic");
    app.set_version_flag("--version", "aspic " + console.version);
    app.require_subcommand(1);
    app.footer(
        "Examples:\n"
        "  aspic cook graphs/bridge.json\n"
        "  aspic cook graphs/bridge.json --frames 1-48x2 --set cubes.size=0.05\n"
        "  aspic cook graphs/*.json --keep-going --json > log\n"
        "  aspic validate graphs/*.json\n"
        "  aspic nodes Voxelize\n"
        "  aspic new ball.json\n"
        "  aspic explain graphs/bridge.json --frame 12\n"
        "  aspic sweep graphs/chair.json --vary cubes.size=0.02,0.04\n"
        "  aspic study graphs/beam.json --vary sim.step.substeps=1,2,4 --measure tip.value\n"
        "Exit codes: 0 good, 1 a node failed, 2 wrong command or document,\n"
        "            3 an expectation was missed, 130 cancelled (Ctrl-C; twice stops at once).");

    CookRequest request;
    int exit = exit_ok;
    const auto positional_files = [&](CLI::App* command) {
        command->add_option("files", request.files, "Graph documents")
            ->required()
            ->type_name("FILE");
    };

    CLI::App* cook_app =
        app.add_subcommand("cook", "Cooks graphs and writes what their sinks write");
    positional_files(cook_app);
    add_loading_options(*cook_app, request);
    add_cooking_options(*cook_app, request);
    add_target_options(*cook_app, request);
    const auto limited = [&](const std::function<int()>& work) {
        exit = within_limits(request, console, work);
    };
    cook_app->callback([&] { limited([&] { return cook(request, registry, console); }); });

    CLI::App* validate_app =
        app.add_subcommand("validate", "Tells everything that is wrong with graph documents");
    positional_files(validate_app);
    add_loading_options(*validate_app, request);
    validate_app->callback([&] { exit = validate(request, registry, console); });

    CLI::App* check_app =
        app.add_subcommand("check", "Cooks only what a graph's expectations look at");
    positional_files(check_app);
    add_loading_options(*check_app, request);
    add_cooking_options(*check_app, request);
    check_app->callback([&] {
        request.expectations_only = true;
        limited([&] { return cook(request, registry, console); });
    });

    CLI::App* profile_app = app.add_subcommand(
        "profile", "Cooks, and shows what each node took; --trace writes it for Perfetto");
    positional_files(profile_app);
    add_loading_options(*profile_app, request);
    add_cooking_options(*profile_app, request);
    add_target_options(*profile_app, request);
    profile_app->add_option("--trace", request.trace, "Trace file, for ui.perfetto.dev")
        ->type_name("FILE");
    profile_app->callback([&] {
        request.profile = true;
        limited([&] { return cook(request, registry, console); });
    });

    CLI::App* explain_app = app.add_subcommand(
        "explain", "Tells what a cook would make at a frame and why: what changed since the last");
    explain_app->add_option("files", request.files, "A graph document")
        ->required()
        ->expected(1)
        ->type_name("FILE");
    int frame = 0;
    explain_app->add_option("--frame", frame, "Which frame")->required()->type_name("N");
    add_loading_options(*explain_app, request);
    add_cache_options(*explain_app, request);
    explain_app
        ->add_option("--out", request.output_folder,
                     "Where the last cook's files are; else "
                     "out/<graph>")
        ->type_name("DIR");
    explain_app->add_option("--node", request.nodes, "As if only this node were cooked; repeatable")
        ->type_name("NAME")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    explain_app->callback([&] { exit = explain(request, frame, registry, console); });

    CLI::App* verify_app = app.add_subcommand(
        "verify", "Cooks again what a manifest tells of, without any cache, and compares");
    std::string manifest;
    verify_app->add_option("manifest", manifest, "The manifest.json that a cook left")
        ->required()
        ->type_name("MANIFEST");
    verify_app->add_option("--threads", request.threads, "At most; the results are the same")
        ->type_name("N")
        ->check(CLI::Range(1, 1024));
    verify_app->add_option("--root", request.root, "Folder outside which no file is read")
        ->type_name("DIR");
    verify_app->add_flag("--allow-outside", request.allow_outside,
                         "Lets the graph read files outside its root");
    verify_app->callback(
        [&] { limited([&] { return verify(manifest, request, registry, console); }); });

    SweepRequest swept;
    CLI::App* sweep_app = app.add_subcommand(
        "sweep", "Cooks every combination of settings: pictures side by side, and a table");
    sweep_app->add_option("files", request.files, "A graph document")
        ->required()
        ->expected(1)
        ->type_name("FILE");
    sweep_app->add_option("--vary", swept.vary, "A parameter and its values; repeatable")
        ->type_name("NODE.PARAM=A,B,C")
        ->required()
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    sweep_app->add_option("--frame", request.frames, "The same as --frames")
        ->type_name("N")
        ->check(what_is_wrong_with_frames);
    sweep_app
        ->add_option("--picture", swept.picture, "What to show; else the graph's first picture")
        ->type_name("NODE.PORT");
    sweep_app
        ->add_option("--measure", swept.measures, "A number for the table; else all; repeatable")
        ->type_name("NODE.PORT")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    sweep_app->add_option("--columns", swept.columns, "Pictures side by side")
        ->type_name("N")
        ->check(CLI::Range(1, 100));
    sweep_app->add_option("--out", request.output_folder, "Where files go; else out/<graph>")
        ->type_name("DIR");
    add_loading_options(*sweep_app, request);
    add_cooking_options(*sweep_app, request);
    sweep_app->get_option("--frames")->description("Which, as 12 or 1-48x12; else the last");
    sweep_app->callback(
        [&] { limited([&] { return run_sweep(request, swept, registry, console); }); });

    CLI::App* doctor_app =
        app.add_subcommand("doctor", "Checks that the machine has what it takes");
    add_cache_options(*doctor_app, request);
    doctor_app->callback([&] { exit = doctor(request, console); });

    StudyRequest wanted;
    CLI::App* study_app =
        app.add_subcommand("study", "Measures speed against error over settings of a graph");
    study_app->add_option("files", request.files, "A graph document")
        ->required()
        ->expected(1)
        ->type_name("FILE");
    add_loading_options(*study_app, request);
    add_cooking_options(*study_app, request);
    study_app->add_option("--out", request.output_folder, "Where files go; else out/<graph>")
        ->type_name("DIR");
    study_app->add_option("--vary", wanted.vary, "A parameter and its values; repeatable")
        ->type_name("NODE.PARAM=A,B,C")
        ->required()
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    study_app->add_option("--measure", wanted.measure, "What to compare: a number or a mesh")
        ->type_name("NODE.PORT")
        ->required();
    study_app
        ->add_option("--reference", wanted.reference,
                     "With what: a number, or a setting node.param=value; else the last values")
        ->type_name("VALUE");
    study_app
        ->add_option("--look", wanted.look,
                     "The picture to put on the sheet; else the first that the graph draws")
        ->type_name("NODE.PORT");
    study_app->add_option("--error", wanted.wanted_error, "Relative error to meet soonest; 0.01")
        ->type_name("SHARE");
    study_app->callback(
        [&] { limited([&] { return run_study(request, wanted, registry, console); }); });

    add_document_commands(app, request, registry, console, exit);

    CLI::App* cache_app = app.add_subcommand("cache", "Tends the stored results");
    cache_app->require_subcommand(1);
    for (const auto& [name, text] :
         {std::pair("stat", "How much there is"), std::pair("verify", "Reads and checks all of it"),
          std::pair("gc", "Makes it as small as --cache-size says"),
          std::pair("clear", "Removes all of it")}) {
        CLI::App* what = cache_app->add_subcommand(name, text);
        add_cache_options(*what, request);
        what->callback(
            [&, what = std::string(name)] { exit = tend_cache(what, request, console); });
    }

    try {
        app.parse(std::vector<std::string>(args.rbegin(), args.rend()));
        return exit;
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) return app.exit(e, console.out, console.err);  // help, version
        console.err << "aspic: "
                    << (args.empty() ? "it wants a command:" + listed(app)
                                     : mistake(app, args, e.what()))
                    << "\naspic --help tells more\n";
        return exit_usage;
    } catch (const std::invalid_argument& e) {
        console.err << "aspic: " << e.what() << "\n";
        return exit_usage;
    } catch (const std::bad_alloc&) {
        console.err << "aspic: " << out_of_memory() << "\n";
        return exit_failed;
    } catch (const std::exception& e) {
        console.err << "aspic: " << e.what() << "\n";
        return exit_failed;
    }
}

}  // namespace runtime
