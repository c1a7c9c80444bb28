#include "geometry/cubes/cubes_mesh.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/state_models.hpp"

namespace nodes::cube_mesh {

struct Inputs {
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    if (const auto state = physics::state_of(in.state, *in.cubes)) {
        return {geometry::cubes_mesh(*in.cubes, state->x)};
    }
    return {geometry::cubes_mesh(*in.cubes, geometry::corner_positions(*in.cubes))};
}

void add_to(graph::Registry& registry)
{
    registry.add("CubeMesh", 1, run)
        .summary("Makes a mesh of the cubes themselves, with a vertex for each of their corners: "
                 "for WriteMesh, so that another program can move them and ReadState can read them "
                 "back.",
                 {"cage", "lattice mesh", "export cubes", "corners"})
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input("state", &Inputs::state,
               "State of the cubes at this frame; without it they are at rest.",
               graph::Need::optional)
        .output("mesh", &Outputs::mesh,
                "The mesh: vertex i is corner i, faces are the outer sides of the cubes. Its "
                "attributes density, young, poisson, fill and the cubes' own (LocalMatter, "
                "Voxelize) are averaged at each corner.");
}

}  // namespace nodes::cube_mesh
