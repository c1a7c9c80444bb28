#include "geometry/voxelize.hpp"

#include "graph/node_type.hpp"
#include "nodes/material_rules.hpp"
#include "nodes/orientation.hpp"
#include "nodes/wire_types.hpp"

#include <algorithm>
#include <stdexcept>

namespace nodes::voxelize {

enum class Method { samples, surface, solid };
enum class Align { fit, origin };

struct Inputs {
    graph::Wire<geometry::Samples> points;
    graph::Wire<geometry::TriMesh> mesh;
    Method method = Method::samples;
    double size = 0;
    int resolution = 32;
    Align align = Align::fit;
    geometry::Vec3 origin{0, 0, 0};
    geometry::Inside inside = geometry::Inside::winding;
    double thickness = 0;
    geometry::Matter matter;
    std::vector<MaterialRule> materials;
    double total_mass = 0;
    double min_fill = geometry::VoxelOptions{}.min_fill;
    std::int64_t max_cubes = static_cast<std::int64_t>(geometry::VoxelOptions{}.max_cubes);
};
struct Outputs {
    geometry::Cubes cubes;
};

static geometry::VoxelGrid grid_for(const Inputs& in)
{
    const geometry::Box box = in.mesh && !in.mesh->triangles().empty()
                                  ? geometry::triangle_bounds(*in.mesh)
                              : in.points ? geometry::finite_bounds(in.points->positions)
                                          : geometry::Box{};
    const double size =
        in.size > 0 || box.empty() ? in.size : geometry::size_for(box, in.resolution);
    if (in.align == Align::origin) return {size, in.origin, geometry::Vec3i::Zero()};
    return geometry::fit_grid(box, size);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const geometry::VoxelOptions options{static_cast<std::size_t>(in.max_cubes), in.min_fill,
                                         in.total_mass};
    if (in.method == Method::samples) {
        if (!in.points) {
            throw std::invalid_argument("method \"samples\" needs the input \"points\": link a "
                                        "Sample, or choose \"surface\" or \"solid\" for a mesh");
        }
        return {geometry::voxelize_samples(*in.points, grid_for(in), options)};
    }
    if (!in.mesh) {
        throw std::invalid_argument("methods \"surface\" and \"solid\" need the input \"mesh\": "
                                    "link one, or choose \"samples\" for points");
    }
    const geometry::FaceMatter matter = face_matter(*in.mesh, in.matter, in.materials, context);
    const geometry::VoxelGrid grid = grid_for(in);
    if (in.method == Method::surface) {
        return {geometry::voxelize_surface(*in.mesh, matter, in.thickness, grid, options)};
    }
    warn_of_disagreeing_faces(*in.mesh, in.inside, context);
    return {geometry::voxelize_solid(*in.mesh, matter, in.inside, in.thickness, grid, options)};
}

void add_to(graph::Registry& registry)
{
    const graph::ShownWhen of_mesh{"method", {"surface", "solid"}};
    registry.add("Voxelize", 1, run)
        .summary("Turns samples or a mesh into equal cubes with shared corners: the deformable "
                 "model. Memory follows the cubes, not the box around them.")
        .input("points", &Inputs::points,
               "Samples to hash into cubes (method samples). Their own masses and materials "
               "count.",
               graph::Need::optional)
        .input("mesh", &Inputs::mesh,
               "The mesh to fill (methods surface and solid). With method samples it only says "
               "where the grid lies, so that several models share one.",
               graph::Need::optional)
        .choice("method", &Inputs::method, {"samples", "surface", "solid"},
                "samples: a cube wherever a sample falls, so sparse samples leave holes. surface: "
                "a cube wherever a triangle passes, exactly; a face between two cubes belongs to "
                "the upper one. solid: those that a triangle passes and those whose centre is "
                "inside.")
        .param("size", &Inputs::size, "The edge of a cube; 0: as large as `resolution` makes them.",
               {0, 1e12, "m"})
        .param("resolution", &Inputs::resolution,
               "How many cubes lie along the model's longest side, where no size is given.",
               {1, 1'000'000, "cubes"})
        .choice("align", &Inputs::align, {"fit", "origin"},
                "fit: the grid is centred on the model. origin: cube 0 starts at a given point, "
                "so that grids of several models agree.")
        .param("origin", &Inputs::origin, "Where cube 0 starts.", {.unit = "m"},
               {"align", {"origin"}})
        .choice("inside", &Inputs::inside, {"winding", "parity"},
                "When a point is inside (method solid): six rays along the axes vote. winding: by "
                "the sum of faces crossed, outward less inward: right for closed, overlapping "
                "and doubled pieces. parity: by an odd number of faces crossed: for meshes whose "
                "faces disagree on what is outside.",
                {"method", {"solid"}})
        .param("thickness", &Inputs::thickness,
               "How thick the faces are taken to be: a cube holds the area in it times this. 0: "
               "method surface takes its cubes as full, method solid counts what is inside only: "
               "exactly, but by 4 x 4 x 4 points in cubes by holes and where pieces overlap.",
               {0, 1e6, "m"}, of_mesh)
        .block("matter", &Inputs::matter, describe_matter<geometry::Matter>,
               "What the model is made of where no rule says otherwise.", of_mesh)
        .list("materials", &Inputs::materials, describe_rule,
              "What parts of it are made of; where several rules match, the last one counts.",
              of_mesh)
        .param("total_mass", &Inputs::total_mass,
               "Masses are scaled to this sum; 0 keeps what densities (or samples) give.",
               {0, 1e15, "kg"})
        .param("min_fill", &Inputs::min_fill,
               "No cube is lighter or softer than one filled to this share, however little of the "
               "model it holds.",
               {0, 1, ""})
        .param("max_cubes", &Inputs::max_cubes,
               "More cubes than this are an error that names a size that would fit.",
               {1, 1e9, "cubes"})
        .output("cubes", &Outputs::cubes,
                "The cubes, with mass, fill and material. Materials in one cube are averaged by "
                "mass.");
}

}  // namespace nodes::voxelize
