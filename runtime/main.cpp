// aspic: the one place where the runtime meets the nodes.

#include "nodes/body_figures.hpp"
#include "nodes/distances.hpp"
#include "nodes/machine.hpp"
#include "nodes/mesh_info.hpp"
#include "nodes/registry.hpp"
#include "nodes/units.hpp"
#include "runtime/commands/command_line.hpp"
#include "runtime/cook/interrupt.hpp"
#include "runtime/cook/program_identity.hpp"
#include "runtime/starter.hpp"

#include <iostream>
#include <unistd.h>

int main(int argc, char** argv)
{
    runtime::Interrupt interrupt;
    runtime::Console console{std::cout,         std::cerr, isatty(STDERR_FILENO) == 1,
                             interrupt.token(), {},        ASPIC_VERSION};
    console.salt = runtime::program_identity(nodes::late_libraries, nodes::file_programs());
    console.distances = nodes::distances();
    console.count_cubes = nodes::count_cubes;
    console.unit_of = nodes::unit_of;
    console.mesh_info = nodes::describe_mesh;
    console.write_sheet = nodes::write_sheet;
    console.run_program = nodes::run_program;
    console.limit_libraries = nodes::limit_libraries;
    std::error_code unknown;
    console.program = std::filesystem::read_symlink("/proc/self/exe", unknown).string();
    console.opengl = nodes::opengl;
    console.starter = runtime::starter;
    return runtime::run_command_line({argv + 1, argv + argc}, nodes::registry(), console);
}
