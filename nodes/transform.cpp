#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::transform {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    geometry::Vec3 translate{0, 0, 0};
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{*in.mesh};
    for (auto& p : out.mesh.positions) p += in.translate.cast<float>();
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Transform", 1, run)
        .summary("Moves a mesh.")
        .input("mesh", &Inputs::mesh, "What to move.")
        .param("translate", &Inputs::translate, "By how much.", {.unit = "m"})
        .output("mesh", &Outputs::mesh, "The moved mesh.");
}

}  // namespace nodes::transform
