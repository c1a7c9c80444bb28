#include "geometry/sample_surface.hpp"
#include "geometry/sample_volume.hpp"

#include "graph/json.hpp"
#include "graph/node_type.hpp"
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
    geometry::Matter matter;
    std::vector<MaterialRule> materials;
};
struct Outputs {
    geometry::Samples points;
};

// Samples to a cube's edge such that an even pattern leaves few cubes without one.
constexpr double samples_per_edge = 6;
constexpr double most = 100'000'000;

static std::size_t count_of(const Inputs& in)
{
    const double spacing = in.spacing > 0 ? in.spacing : in.cube_size / samples_per_edge;
    if (!(spacing > 0)) return static_cast<std::size_t>(in.count);
    const double count =
        in.where == Where::surface
            ? geometry::sampled_area(*in.mesh) / (spacing * spacing)
            : geometry::volume_inside(*in.mesh, in.inside) / (spacing * spacing * spacing);
    if (!(count <= most)) {
        throw std::invalid_argument(fmt::format(
            "samples {:g} m apart would be more than 100,000,000: use a larger spacing", spacing));
    }
    return static_cast<std::size_t>(std::max(1.0, std::ceil(count)));
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const geometry::FaceMatter matter = face_matter(*in.mesh, in.matter, in.materials, context);
    const geometry::SampleMass mass{in.mass, in.total_mass, in.thickness, in.surface_density};
    const std::size_t count = count_of(in);
    if (in.where == Where::volume) {
        warn_of_disagreeing_faces(*in.mesh, in.inside, context);
        return {geometry::sample_volume(*in.mesh, matter, in.inside, count, in.seed, mass)};
    }
    if (in.pattern == Pattern::blue) {
        return {geometry::sample_surface_blue(*in.mesh, matter, count, in.seed, mass)};
    }
    return {geometry::sample_surface(*in.mesh, matter, count, in.seed, mass)};
}

// Version 1 made a model of 1 kg unless it said otherwise.
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
        .summary("Spreads near-uniform points over a mesh or through it; each carries mass and "
                 "material.")
        .upgrade(1, "unless said, mass was total and faces of a density 0.01 m thick",
                 say_old_defaults)
        .input("mesh", &Inputs::mesh, "What to sample.")
        .choice("where", &Inputs::where, {"surface", "volume"},
                "On the faces, or in what they enclose.")
        .choice("pattern", &Inputs::pattern, {"even", "blue"},
                "even: the same number on equal areas. blue: besides, no two near each other; "
                "slower.",
                {"where", {"surface"}})
        .choice("inside", &Inputs::inside, {"winding", "parity"},
                "When a point is inside: by the faces' orientation, or by an odd number of faces "
                "crossed; see Voxelize.",
                {"where", {"volume"}})
        .param("count", &Inputs::count, "How many points, where neither of the next two is given.",
               {1, most, "points"})
        .param("spacing", &Inputs::spacing, "About how far apart points lie; 0: by `count`.",
               {0, 1e9, "m"})
        .param("cube_size", &Inputs::cube_size,
               "For cubes of this size: six points to an edge, so that few cubes that a face "
               "crosses are left without one. Only Voxelize's method surface is sure to leave "
               "none. 0: by `count`.",
               {0, 1e9, "m"})
        .param("seed", &Inputs::seed, "Same seed, same points.")
        .choice("mass", &Inputs::mass, {"total", "density", "surface_density"},
                "density: each matter's own, 1000 kg/m^3 when none is said. total: so shared out, "
                "then scaled to a given mass; the stiffness stays. surface_density: by area "
                "alone.")
        .param("total_mass", &Inputs::total_mass, "Mass of all points together.",
               {1e-12, 1e15, "kg"}, {"mass", {"total"}})
        .param("thickness", &Inputs::thickness,
               "How thick faces are taken to be: for sheets and shells whose cubes are mostly air. "
               "0: a cube that a sample falls in counts as full of its matter.",
               {0, 1e6, "m"}, {"mass", {"density", "total"}})
        .param("surface_density", &Inputs::surface_density, "Mass of a square metre.",
               {1e-12, 1e12, "kg/m^2"}, {"mass", {"surface_density"}})
        .block("matter", &Inputs::matter, describe_matter<geometry::Matter>,
               "What the model is made of where no rule says otherwise.")
        .list("materials", &Inputs::materials, describe_rule,
              "What parts of it are made of; where several rules match, the last one counts.")
        .output("points", &Outputs::points, "The samples.");
}

}  // namespace nodes::sample
