#include "geometry/mesh/copies.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::copies {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    int count_x = 2, count_y = 1, count_z = 2;
    geometry::Vec3 step{1, 1, 1};
    geometry::Vec3 stagger{0, 0, 0};
    double hue_degrees = 0;
    bool number_groups = false;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context&)
{
    return {geometry::copies(*in.mesh, {{in.count_x, in.count_y, in.count_z},
                                        in.step,
                                        in.stagger,
                                        in.hue_degrees,
                                        in.number_groups})};
}

void add_to(graph::Registry& registry)
{
    registry.add("Copies", 1, run)
        .summary("Copies a mesh in rows, columns and layers, as one mesh: the bodies of a heap or "
                 "a wall.",
                 {"array", "duplicate", "instance", "copy", "scatter copies", "clone"})
        .input("mesh", &Inputs::mesh, "The mesh to copy.")
        .param("count_x", &Inputs::count_x, "Number of copies along x.", {.min = 1, .max = 100'000})
        .param("count_y", &Inputs::count_y, "Number of layers along y.", {.min = 1, .max = 100'000})
        .param("count_z", &Inputs::count_z, "Number of copies along z.", {.min = 1, .max = 100'000})
        .param("step", &Inputs::step,
               "Distance from one copy to the next along each axis. The centre of all copies stays "
               "where the mesh is.",
               {.unit = "m"})
        .param("stagger", &Inputs::stagger, "Offset of every second layer.", {.unit = "m"})
        .param("hue_degrees", &Inputs::hue_degrees,
               "Rotation of the hue from each copy to the next: 72 gives five colours.",
               {.unit = "deg"})
        .param("number_groups", &Inputs::number_groups,
               "Whether each copy has groups of its own, with its number after their names: those "
               "of leg are \"leg 1\", \"leg 2\". Voxelize (pieces = groups) and rules for "
               "materials then tell copies apart.")
        .output("mesh", &Outputs::mesh, "All copies as one mesh.");
}

}  // namespace nodes::copies
