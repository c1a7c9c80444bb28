#include "runtime/commands/command_line.hpp"

#include "runtime/commands/cache_command.hpp"
#include "runtime/commands/card.hpp"
#include "runtime/commands/cook_command.hpp"
#include "runtime/commands/doctor.hpp"
#include "runtime/commands/document_commands.hpp"
#include "runtime/commands/explain.hpp"
#include "runtime/commands/farm_command.hpp"
#include "runtime/commands/info_command.hpp"
#include "runtime/commands/study_command.hpp"
#include "runtime/commands/sweep_command.hpp"
#include "runtime/commands/tune_command.hpp"
#include "runtime/commands/usage.hpp"
#include "runtime/commands/verify.hpp"
#include "runtime/cook/memory_limit.hpp"

#include <CLI/CLI.hpp>

#include <ostream>

namespace runtime {

namespace {

constexpr const char* examples =
    "Examples:\n"
    "  aspic cook graphs/bridge.json\n"
    "  aspic cook graphs/bridge.json --frames 1-48x2 --set cubes.size=0.05\n"
    "  aspic cook graphs/*.json --keep-going --json > log\n"
    "  aspic validate graphs/*.json\n"
    "  aspic nodes Voxelize\n"
    "  aspic new ball.json\n"
    "  aspic info chair.obj\n"
    "  aspic explain graphs/bridge.json --frame 12\n"
    "  aspic sweep graphs/chair.json --vary cubes.size=0.02,0.04\n"
    "  aspic study graphs/beam.json --vary sim.step.substeps=1,2,4 --measure tip.value\n"
    "  aspic tune graphs/beam.json --error 5%\n"
    "Exit codes: 0 success, 1 a node failed, 2 invalid command line or document,\n            "
    "3 an expectation was missed, 130 cancelled (Ctrl-C; press it twice to stop at once).";

// Success takes that what was asked for came out.
int written(int exit, Console& console)
{
    if (console.out.flush()) return exit;
    console.err << "aspic: standard output can't be written\n";
    return exit == exit_ok ? exit_failed : exit;
}

}  // namespace

int run_command_line(const std::vector<std::string>& args, const graph::Registry& registry,
                     Console& console)
{
    CLI::App app("Aspic cooks node graphs of deformation effects. A node runs once for each frame "
                 "that it is needed at, and results are cached.",
                 "aspic");
    app.set_version_flag("--version", "aspic " + console.version);
    app.require_subcommand(1);

    CookRequest request;
    int exit = exit_ok;
    const CommandSet set{app, request, registry, console, exit};
    add_cook_commands(set);
    add_explain_command(set);
    add_verify_command(set);
    add_sweep_command(set);
    add_study_command(set);
    add_tune_command(set);
    add_farm_command(set);
    add_card_command(set);
    add_info_command(set);
    add_document_commands(set);
    add_doctor_command(set);
    add_cache_command(set);
    // After the commands, which would each repeat it.
    app.footer(examples);

    try {
        app.parse(std::vector<std::string>(args.rbegin(), args.rend()));
        return written(exit, console);
    } catch (const CLI::ParseError& e) {
        if (e.get_exit_code() == 0) {  // help, version
            return written(app.exit(e, console.out, console.err), console);
        }
        console.err << "aspic: "
                    << (args.empty() ? "expected a command:" + command_list(app)
                                     : usage_mistake(app, args, e.what()))
                    << "\nSee aspic --help.\n";
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
