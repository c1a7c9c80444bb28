#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_mesh.hpp"

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
    Options::Mesher mesher = Options::Mesher::dual;
    double adaptivity = 0;
    std::int64_t max_triangles = static_cast<std::int64_t>(Options{}.max_triangles);
};
struct Outputs {
    geometry::TriMesh mesh;
};

// Cells may be too coarse to see a body at all.
static void warn_of_unseen(const geometry::TriMesh& mesh, double cell,
                           const graph::Context& context)
{
    std::vector<std::size_t> triangles(mesh.topology->groups.size(), 0);
    for (const std::uint16_t group : mesh.topology->group) ++triangles[group];
    for (std::size_t g = 0; g < triangles.size(); ++g) {
        if (triangles[g] >= 20) continue;
        context.warn(fmt::format("{} has {} triangles: its surface is gone, or cell = {:g} m is "
                                 "too coarse for it; use smaller cells",
                                 mesh.topology->groups[g], triangles[g], cell));
    }
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    Outputs out{physics::layered_mesh(*in.scene, {in.surface, in.cell, in.body, in.deformed, in.cut,
                                                  in.cut_at, in.mesher, in.adaptivity,
                                                  static_cast<std::size_t>(in.max_triangles)})};
    if (in.surface == Options::Surface::exact && in.cut == Options::Cut::none &&
        in.adaptivity == 0) {
        warn_of_unseen(out.mesh, in.cell, context);
    }
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Polygonize", 1, run)
        .summary("Meshes the surfaces of a Layered scene, deformed where bodies touch.")
        .input("scene", &Inputs::scene, "The bodies at this frame, from Layered.")
        .choice("surface", &Inputs::surface, {"exact", "seeds"},
                "exact finds the surface afresh on a grid; seeds is a quick preview from the "
                "bodies' own samples.")
        .param("cell", &Inputs::cell, "Edge of the grid's cells.", {.min = 1e-9, .unit = "m"},
               {"surface", {"exact"}})
        .param("body", &Inputs::body, "Which body, counted from 0; -1 for all.", {.min = -1})
        .param("deformed", &Inputs::deformed, "Off: each body as if it touched nothing.")
        .choice("cut", &Inputs::cut, {"none", "x", "y", "z"},
                "Leaves out what lies beyond cut_at along this axis, to look inside.",
                {"surface", {"exact"}})
        .param("cut_at", &Inputs::cut_at, "Where to cut.", {.unit = "m"}, {"cut", {"x", "y", "z"}})
        .choice("mesher", &Inputs::mesher, {"dual", "openvdb"},
                "dual marching cubes, which is quicker and makes better shaped triangles; or "
                "OpenVDB's, which can merge faces where the surface is flat "
                "(where the program was built with it).",
                {"surface", {"exact"}})
        .param("adaptivity", &Inputs::adaptivity,
               "How far OpenVDB merges faces where the surface is flat; 0: not at all.",
               {.min = 0, .max = 1}, {"mesher", {"openvdb"}})
        .param("max_triangles", &Inputs::max_triangles,
               "More on one body is an error, which says what cells would fit.",
               {.min = 1000, .max = 1e9, .unit = "triangles"}, {"surface", {"exact"}})
        .output("mesh", &Outputs::mesh,
                "One mesh; each body is a group with a material, attribute `compression` says how "
                "far each vertex is pressed.");
}

}  // namespace nodes::polygonize
