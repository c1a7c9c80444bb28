#include "geometry/mesh/merge.hpp"
#include "graph/types/node_builder.hpp"
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
        .summary("Merges meshes into one, with the materials and groups of all.",
                 {"join", "combine", "append", "attach", "glue", "weld"})
        .inputs("meshes", &Inputs::meshes, "The meshes to merge, in this order.")
        .output("mesh", &Outputs::mesh, "The merged mesh.");
}

}  // namespace nodes::merge
