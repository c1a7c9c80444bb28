#include "runtime/commands/info_command.hpp"

#include "graph/types/context.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>

namespace runtime {
namespace {

// A file that can't be read is told, and the others go on.
int info(const CookRequest& request, const std::string& unit, Console& console)
{
    if (!console.mesh_info) {
        console.err << "aspic: this program reads no meshes\n";
        return exit_failed;
    }
    int exit = exit_ok;
    for (const std::string& file : request.files) {
        try {
            console.out << console.mesh_info(file, unit, request.json, console.stop) << std::flush;
        } catch (const graph::Cancelled&) {
            return exit_cancelled;
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& e) {
            exit = exit_failed;
            console.err << "aspic: " << e.what() << "\n";
            if (request.json) {
                const nlohmann::ordered_json line{{"file", file}, {"error", e.what()}};
                console.out << line.dump(-1, ' ', false,
                                         nlohmann::ordered_json::error_handler_t::replace)
                            << "\n";
            }
        }
    }
    return exit;
}

}  // namespace

void add_info_command(const CommandSet& set)
{
    CLI::App* info_app = set.app.add_subcommand(
        "info", "Describes mesh files: size, unit, holes, pieces, materials, cubes that suit them");
    info_app->add_option("files", set.request.files, "Mesh files")->type_name("MESH")->required();
    const auto unit = std::make_shared<std::string>("auto");
    info_app
        ->add_option("--unit", *unit,
                     "Unit of length of the files: auto, m, cm, mm, inch or foot (default: auto, "
                     "what a file states, else m)")
        ->type_name("UNIT")
        ->check(CLI::IsMember({"auto", "m", "cm", "mm", "inch", "foot"}));
    info_app->add_flag("--json", set.request.json, "Writes one line of JSON per file");
    info_app->callback([&set, unit] { set.exit = info(set.request, *unit, set.console); });
}

}  // namespace runtime
