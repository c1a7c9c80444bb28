#include "geometry/patch.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

namespace nodes::patch {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh, rest, carried;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    double distance = 0.1;
    std::shared_ptr<const geometry::PatchBinding> binding;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static geometry::PatchBinding bind(const Inputs& in)
{
    return geometry::bind_patch(*in.rest, *in.cubes, in.distance);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.mesh->positions.size() != in.rest->positions.size()) {
        throw std::invalid_argument(
            fmt::format("expected `mesh` to be `rest` moved, with its {} vertices, found {}: link "
                        "the one surface before and after Embed; if that is torn, let Embed hide "
                        "or stretch it (torn: hide), as cutting it adds vertices",
                        in.rest->positions.size(), in.mesh->positions.size()));
    }
    if (in.binding->vertices.empty()) {
        context.warn("no vertex of the mesh lies over the patch within `distance`: nothing is "
                     "added");
    }
    return {
        geometry::add_detail(*in.binding, *in.mesh, *in.cubes, in.state->x, in.carried->positions)};
}

void add_to(graph::Registry& registry)
{
    registry.add("Patch", 1, run)
        .summary("Adds what a small elastic plane does to the part of a large object's surface "
                 "that it lies along: fine motion where it is seen, at the cost of the plane.")
        .input("mesh", &Inputs::mesh, "The surface as the object carries it at this frame.")
        .input("rest", &Inputs::rest, "The same surface at rest.")
        .input("cubes", &Inputs::cubes, "The plane's cells, from Plane.")
        .input("state", &Inputs::state, "How the plane moves, from its own Simulate.")
        .input("carried", &Inputs::carried,
               "The plane's mesh as the object alone carries it: embed it in the object's cubes. "
               "The same mesh is what Pin lets the plane's rim follow. No crease is left where the "
               "object's cubes meet if a whole number of the plane's cells lies along each, on "
               "one grid.")
        .param("distance", &Inputs::distance,
               "How far from the plane vertices feel it, fading out.", {1e-9, 1e6, "m"})
        .prepare("binding", &Inputs::binding, bind, {"rest", "cubes", "distance"})
        .output("mesh", &Outputs::mesh, "The surface with the plane's motion on it.");
}

}  // namespace nodes::patch
