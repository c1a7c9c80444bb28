#include "geometry/copies.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::copies {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    int count_x = 2, count_y = 1, count_z = 2;
    geometry::Vec3 step{1, 1, 1};
    geometry::Vec3 stagger{0, 0, 0};
    double hue_degrees = 0;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    return {geometry::copies(
        *in.mesh, {{in.count_x, in.count_y, in.count_z}, in.step, in.stagger, in.hue_degrees})};
}

void add_to(graph::Registry& registry)
{
    registry.add("Copies", 1, run)
        .summary("Makes many of a mesh, in rows, columns and layers, as one mesh: the bodies of a "
                 "heap or a wall.")
        .input("mesh", &Inputs::mesh, "What to copy.")
        .param("count_x", &Inputs::count_x, "How many along x.", {.min = 1, .max = 100'000})
        .param("count_y", &Inputs::count_y, "How many layers along y.", {.min = 1, .max = 100'000})
        .param("count_z", &Inputs::count_z, "How many along z.", {.min = 1, .max = 100'000})
        .param("step", &Inputs::step,
               "From one to the next along each axis. The middle of all stays where the mesh is.",
               {.unit = "m"})
        .param("stagger", &Inputs::stagger, "By how much every second layer is moved.",
               {.unit = "m"})
        .param("hue_degrees", &Inputs::hue_degrees,
               "By how much the hue of each copy's colours is turned from that of the one before: "
               "72 gives five colours.",
               {.unit = "deg"})
        .output("mesh", &Outputs::mesh, "All of them.");
}

}  // namespace nodes::copies
