#include "geometry/cubes/mean_attributes.hpp"
#include "geometry/cubes/sample_points.hpp"
#include "geometry/cubes/sample_surface.hpp"
#include "geometry/cubes/sample_volume.hpp"
#include "geometry/mesh/doubled_faces.hpp"

#include "graph/document/json.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/doubled_faces.hpp"
#include "nodes/filled_shell.hpp"
#include "nodes/material_rules.hpp"
#include "nodes/orientation.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace nodes::sample {

enum class Where { surface, volume };
enum class Pattern { even, blue };

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    Where where = Where::surface;
    Pattern pattern = Pattern::even;
    geometry::Inside inside = geometry::Inside::winding;
    int count = 100000;
    double spacing = 0;
    double cube_size = 0;
    std::uint32_t seed = 0;
    geometry::SampleMass::By mass = geometry::SampleMass::By::density;
    double total_mass = 1;
    double thickness = 0;
    double surface_density = 1;
    ChosenMatter matter;
    std::vector<MaterialRule> materials;
    std::string attributes;
};
struct Outputs {
    geometry::Samples points;
};

// Samples per cube edge with which an even pattern leaves few cubes without a sample.
constexpr double samples_per_edge = 6;
constexpr double most = 100'000'000;

static std::size_t count_of(const Inputs& in, const geometry::TriMesh& mesh)
{
    const double spacing = in.spacing > 0 ? in.spacing : in.cube_size / samples_per_edge;
    if (!(spacing > 0)) return static_cast<std::size_t>(in.count);
    const double count =
        in.where == Where::surface
            ? geometry::sampled_area(mesh) / (spacing * spacing)
            : geometry::volume_inside(mesh, in.inside) / (spacing * spacing * spacing);
    if (!(count <= most)) {
        throw std::invalid_argument(fmt::format("a spacing of {:g} m gives more than 100,000,000 "
                                                "samples, which is the limit: use a larger spacing",
                                                spacing));
    }
    return static_cast<std::size_t>(std::max(1.0, std::ceil(count)));
}

static geometry::Samples on_faces(const Inputs& in, const geometry::TriMesh& mesh,
                                  const geometry::FaceMatter& matter,
                                  const geometry::SampleMass& mass)
{
    const auto sample =
        in.pattern == Pattern::blue ? geometry::sample_surface_blue : geometry::sample_surface;
    return sample(mesh, matter, count_of(in, mesh), in.seed, mass);
}

// On the surface, where what is there twice is one face.
static geometry::Samples of_surface(const Inputs& in, const geometry::FaceMatter& matter,
                                    const geometry::SampleMass& mass, const graph::Context& context)
{
    const auto once = geometry::without_doubled(*in.mesh, matter.face);
    if (!once) return on_faces(in, *in.mesh, matter, mass);
    warn_of_doubled_faces(once->doubled, in.mesh->triangles().size(), context);
    geometry::Samples out =
        on_faces(in, once->mesh, geometry::matter_of_some(matter, once->faces), mass);
    for (auto& t : out.triangle) t = once->faces[t];
    return out;
}

static geometry::Samples samples_of(const Inputs& in, const graph::Context& context)
{
    if (in.mesh->triangles().empty() && !in.mesh->positions.empty()) {
        if (!in.materials.empty()) {
            context.warn("materials have no effect, because the mesh is a point cloud: it has no "
                         "faces that a rule could match");
        }
        return geometry::sample_points(*in.mesh, matter_of(in.matter),
                                       {in.mass, in.total_mass, in.thickness, in.surface_density});
    }
    const geometry::FaceMatter matter =
        face_matter(*in.mesh, matter_of(in.matter), in.materials, context);
    const geometry::SampleMass mass{in.mass, in.total_mass, in.thickness, in.surface_density};
    if (in.where == Where::volume) {
        // What is left of almost nothing takes minutes to fill, and is not what was asked for.
        constexpr double almost_all = 0.98;
        const LostInside lost = lost_inside(*in.mesh, in.inside);
        if (lost.share > almost_all) throw std::invalid_argument(lost.text);
        if (!lost.text.empty()) context.warn(lost.text);
        warn_of_filled_shell(*in.mesh, in.inside, in.thickness, "where = volume", "where = surface",
                             context);
    }
    if (in.where == Where::surface) return of_surface(in, matter, mass, context);
    return geometry::sample_volume(*in.mesh, matter, in.inside, count_of(in, *in.mesh), in.seed,
                                   mass);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const auto attributes = geometry::chosen_attributes(in.attributes, in.mesh->attributes);
    Outputs out{samples_of(in, context)};
    geometry::add_attributes(out.points, *in.mesh, attributes);
    return out;
}

// Version 1: mass was total (1 kg) by default.
static void say_old_defaults(graph::Json& node)
{
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object());
    if (!params) return;
    const graph::Json* const mass = graph::put_missing(*params, "mass", std::string("total"));
    if (mass && mass->text() && *mass->text() == "density") {
        graph::put_missing(*params, "thickness", 0.01);
    }
}

void add_to(graph::Registry& registry)
{
    registry.add("Sample", 2, run)
        .summary("Distributes near-uniform points over a mesh or through it; each carries mass and "
                 "material.",
                 {"scatter", "points", "particles", "pointcloud"})
        .upgrade(1, "the default of mass was total, and faces of mass = density were 0.01 m thick",
                 say_old_defaults)
        .input("mesh", &Inputs::mesh,
               "The mesh to sample. Of a point cloud every point is a sample.")
        .choice("where", &Inputs::where, {"surface", "volume"},
                "surface: points lie on the faces, a face and its back counting once. volume: "
                "points lie inside the mesh.")
        .choice("pattern", &Inputs::pattern, {"even", "blue"},
                "even: equal areas get equal numbers of points. blue: blue noise; in addition, no "
                "two points are close to each other. Slower.",
                {"where", {"surface"}})
        .choice("inside", &Inputs::inside, {"winding", "parity"},
                "How inside is decided. winding: by the orientation of the faces. parity: by an "
                "odd number of faces crossed. See Voxelize.",
                {"where", {"volume"}})
        .param("count", &Inputs::count,
               "Number of points, if neither spacing nor cube_size is set.", {1, most, "points"})
        .param("spacing", &Inputs::spacing, "Approximate distance between points; 0: use `count`.",
               {0, 1e9, "m"})
        .param("cube_size", &Inputs::cube_size,
               "Size of the cubes that the points are for: six points lie along an edge, so that "
               "few cubes that a face crosses have none. Only Voxelize's method surface never "
               "misses one. 0: use `count`.",
               {0, 1e9, "m"})
        .param("seed", &Inputs::seed, "Random seed. The same seed gives the same points.")
        .choice("mass", &Inputs::mass, {"total", "density", "surface_density"},
                "How points get their mass. density: from the density of each material, 1000 "
                "kg/m^3 by default. total: the same shares, scaled to total_mass; the stiffness "
                "does not change. surface_density: from the area alone.")
        .param("total_mass", &Inputs::total_mass, "Total mass of all points.", {1e-12, 1e15, "kg"},
               {"mass", {"total"}})
        .param("thickness", &Inputs::thickness,
               "Thickness of the faces, for sheets and shells whose cubes are mostly air. 0: a "
               "cube that holds a sample counts as full.",
               {0, 1e6, "m"}, {"mass", {"density", "total"}})
        .param("surface_density", &Inputs::surface_density, "Mass per area.",
               {1e-12, 1e12, "kg/m^2"}, {"mass", {"surface_density"}})
        .block("matter", &Inputs::matter, describe_matter<ChosenMatter>,
               "Material of the model where no rule of `materials` matches.")
        .list("materials", &Inputs::materials, describe_rule,
              "Materials of parts of the model. If several rules match, the last one counts.")
        .param("attributes", &Inputs::attributes,
               "Attributes of the mesh that points get where they lie, and Voxelize averages by "
               "volume: names, with commas between them, where * stands for any text and ? for "
               "any character. Empty: none.")
        .output("points", &Outputs::points, "The samples.");
}

}  // namespace nodes::sample
