#include "geometry/embed/plane_detail.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

namespace nodes::patch {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh, rest, carried;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    double distance = 0.1;
    std::shared_ptr<const geometry::PlaneDetail> binding;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static geometry::PlaneDetail bind(const Inputs& in)
{
    return geometry::bind_plane_detail(*in.rest, *in.cubes, in.distance);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.mesh->positions.size() != in.rest->positions.size()) {
        throw std::invalid_argument(
            fmt::format("`mesh` has {} vertices, expected {} as in `rest`: link the same surface "
                        "before and after Embed. If it tears, set torn = hide or stretch in Embed, "
                        "because cutting adds vertices",
                        in.mesh->positions.size(), in.rest->positions.size()));
    }
    if (in.binding->vertices.empty()) {
        context.warn(
            "no vertex of the mesh lies within `distance` of the plane: no motion is added");
    }
    return {geometry::add_plane_detail(*in.binding, *in.mesh, *in.cubes,
                                       physics::state_of(in.state, *in.cubes)->x,
                                       in.carried->positions)};
}

void add_to(graph::Registry& registry)
{
    registry.add("Patch", 1, run)
        .summary("Adds the motion of a small elastic plane to the surface of a large object along "
                 "which it lies: fine motion where it is seen, at the cost of the plane.")
        .input("mesh", &Inputs::mesh, "The surface as the object carries it at this frame.")
        .input("rest", &Inputs::rest, "The same surface at rest.")
        .input("cubes", &Inputs::cubes, "The plane's cells, from Plane.")
        .input("state", &Inputs::state, "State of the plane, from its own Simulate.")
        .input("carried", &Inputs::carried,
               "The plane's mesh as the object alone carries it: embed it in the object's cubes. "
               "Pin uses the same mesh to let the plane's rim follow the object. To leave no "
               "crease where the object's cubes meet, let a whole number of the plane's cells lie "
               "along each, on one grid.")
        .param("distance", &Inputs::distance,
               "Distance from the plane at which its effect on vertices has faded to zero.",
               {1e-9, 1e6, "m"})
        .prepare("binding", &Inputs::binding, bind, {"rest", "cubes", "distance"})
        .output("mesh", &Outputs::mesh, "The surface with the plane's motion added.");
}

}  // namespace nodes::patch
