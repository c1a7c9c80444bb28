#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::before {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh, last;
};
struct Outputs {
    graph::Wire<geometry::TriMesh> mesh, before;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    return {in.mesh, in.last ? in.last : in.mesh};
}

void add_to(graph::Registry& registry)
{
    registry.add("Before", 1, run)
        .summary("Remembers a mesh as it was a frame ago, for motion blur.",
                 {"motion blur", "velocity", "previous frame", "delay", "time shift"})
        .input("mesh", &Inputs::mesh, "The moving mesh.")
        .output("mesh", &Outputs::mesh, "The same mesh.")
        .output("before", &Outputs::before,
                "The mesh a frame ago; in the first frame, the mesh itself. To know it, the frames "
                "before are cooked too.")
        .previous("mesh", &Inputs::last);
}

}  // namespace nodes::before
