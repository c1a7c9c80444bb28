#include "graph/document/json.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/layered_mesh.hpp"

#include <fmt/format.h>

namespace nodes::polygonize {

using Options = physics::LayeredMeshOptions;

struct Inputs {
    graph::Wire<physics::LayeredScene> scene;
    Options::Surface surface = Options::Surface::exact;
    double cell = 0.02;
    int body = -1;
    bool deformed = true;
    Options::Cut cut = Options::Cut::none;
    double cut_at = 0;
    std::int64_t max_triangles = static_cast<std::int64_t>(Options{}.max_triangles);
};
struct Outputs {
    geometry::TriMesh mesh;
};

// Warns of bodies with hardly any triangles: the cells may be too coarse to show them.
static void warn_of_unseen(const geometry::TriMesh& mesh, double cell,
                           const graph::Context& context)
{
    std::vector<std::size_t> triangles(mesh.topology->groups.size(), 0);
    for (const std::uint16_t group : mesh.topology->group) ++triangles[group];
    for (std::size_t g = 0; g < triangles.size(); ++g) {
        if (triangles[g] >= 20) continue;
        context.warn(fmt::format("{} has {} triangles: its surface has vanished, or cell = {:g} m "
                                 "is too coarse for it; use smaller cells",
                                 mesh.topology->groups[g], triangles[g], cell));
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    Outputs out{
        physics::layered_mesh(*in.scene, {in.surface, in.cell, in.body, in.deformed, in.cut,
                                          in.cut_at, static_cast<std::size_t>(in.max_triangles)})};
    if (in.surface == Options::Surface::exact && in.cut == Options::Cut::none) {
        warn_of_unseen(out.mesh, in.cell, context);
    }
    return out;
}

// Version 1 could also mesh by OpenVDB.
static void one_mesher(graph::Json& node)
{
    graph::Json* const params = node.find("params");
    if (!params) return;
    graph::erase(*params, "mesher");
    graph::erase(*params, "adaptivity");
}

void add_to(graph::Registry& registry)
{
    registry.add("Polygonize", 2, run)
        .summary("Meshes the surfaces of a Layered scene, as contacts deform them.",
                 {"marching cubes", "isosurface", "metaballs", "surface"})
        .upgrade(1, "OpenVDB's mesher is gone: mesher and adaptivity have no effect", one_mesher)
        .input("scene", &Inputs::scene, "The bodies at this frame, from Layered.")
        .choice("surface", &Inputs::surface, {"exact", "seeds"},
                "exact: computes the surface on a grid. seeds: makes a quick preview from the "
                "samples of the bodies' surfaces.")
        .param("cell", &Inputs::cell, "Edge of a grid cell.", {.min = 1e-9, .unit = "m"},
               {"surface", {"exact"}})
        .param("body", &Inputs::body, "Index of the body to mesh, counted from 0; -1 for all.",
               {.min = -1})
        .param("deformed", &Inputs::deformed,
               "Whether contacts deform the surfaces; if off, each body is meshed as if it touched "
               "nothing.")
        .choice("cut", &Inputs::cut, {"none", "x", "y", "z"},
                "Removes everything beyond cut_at along this axis, to show the inside.",
                {"surface", {"exact"}})
        .param("cut_at", &Inputs::cut_at, "Position of the cut along the axis.", {.unit = "m"},
               {"cut", {"x", "y", "z"}})
        .param("max_triangles", &Inputs::max_triangles,
               "Limit on the triangles of one body. Exceeding it is an error that names a cell "
               "size that fits.",
               {.min = 1000, .max = 1e9, .unit = "triangles"}, {"surface", {"exact"}})
        .output("mesh", &Outputs::mesh,
                "One mesh in which each body is a group with its own material. The attribute "
                "`compression` is the depth to which contact presses each vertex.");
}

}  // namespace nodes::polygonize
