#include "physics/modal/modal_file.hpp"

#include "geometry/base/whole_file.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"

namespace nodes::write_modes {

struct Inputs {
    graph::Wire<physics::ModalModel> model;
    std::filesystem::path path = "modes.txt";
};
struct Outputs {
    graph::WrittenFile file;
};

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    return wrong_path(in.path, {}, 1);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const auto path = context.output_folder / in.path;
    geometry::write_whole_file(path, physics::modal_file(*in.model));
    return {{path.string()}};
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteModes", 1, run)
        .summary("Writes vibration modes as one plain text file: frequencies, damping, masses and "
                 "the shape of each mode at the vertices of the mesh.",
                 {"export", "modal", "eigenmodes"})
        .input("model", &Inputs::model, "The modes, from Modes.")
        .path_out("path", &Inputs::path,
                  "Path of the file, below the output folder. recipes.md describes the format.")
        .sink()
        .check(check)
        .output("file", &Outputs::file, "The written file.");
}

}  // namespace nodes::write_modes
