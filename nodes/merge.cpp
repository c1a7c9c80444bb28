#include "geometry/merge.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::merge {

struct Inputs {
    std::vector<graph::Wire<geometry::TriMesh>> meshes;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    std::vector<const geometry::TriMesh*> meshes;
    for (const auto& mesh : in.meshes) meshes.push_back(mesh.get());
    return {geometry::merge(meshes)};
}

void add_to(graph::Registry& registry)
{
    registry.add("Merge", 1, run)
        .summary("Makes one mesh of many, with the materials and groups of all.")
        .inputs("meshes", &Inputs::meshes, "What to put together, in this order.")
        .output("mesh", &Outputs::mesh, "All of them in one.");
}

}  // namespace nodes::merge
