#include "geometry/measure.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/measure.hpp"
#include "render/measure.hpp"

namespace nodes::measure {

enum class What {
    vertices,
    triangles,
    area,
    volume,
    lowest,
    highest,
    displacement_max,
    displacement_mean,
    displacement_at,
    stretch_max,
    mesh_finite,
    cubes,
    components,
    mass,
    speed_max,
    kinetic_energy,
    converged,
    iterations,
    brightness,
    coverage,
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh, rest;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    graph::Wire<render::Image> image;
    What what = What::displacement_max;
    geometry::Vec3 point{0, 0, 0};
    geometry::Vec3 direction{0, 1, 0};
};
struct Outputs {
    double value = 0;
};

// The linked input, or an error that names it.
template <class T> static const T& linked(const graph::Wire<T>& wire, const char* port)
{
    if (!wire) {
        throw std::invalid_argument(std::string("this measure needs the input `") + port +
                                    "`, which is not linked");
    }
    return *wire;
}

static double measure(const Inputs& in)
{
    const auto mesh = [&]() -> const auto&
    {
        return linked(in.mesh, "mesh");
    };
    const auto rest = [&]() -> const auto&
    {
        return linked(in.rest, "rest");
    };
    const auto cubes = [&]() -> const auto&
    {
        return linked(in.cubes, "cubes");
    };
    const auto state = [&]() -> const auto&
    {
        return linked(in.state, "state");
    };
    const auto image = [&]() -> const auto&
    {
        return linked(in.image, "image");
    };
    const auto along = [&] { return in.direction.normalized(); };

    switch (in.what) {
    case What::vertices:
        return static_cast<double>(mesh().positions.size());
    case What::triangles:
        return static_cast<double>(mesh().triangles().size());
    case What::area:
        return geometry::surface_area(mesh());
    case What::volume:
        return geometry::enclosed_volume(mesh());
    case What::lowest:
        return geometry::extent(mesh(), along())[0];
    case What::highest:
        return geometry::extent(mesh(), along())[1];
    case What::displacement_max:
        return geometry::displacement(mesh(), rest()).largest;
    case What::displacement_mean:
        return geometry::displacement(mesh(), rest()).mean;
    case What::displacement_at:
        return geometry::displacement_at(mesh(), rest(), in.point).dot(along());
    case What::stretch_max:
        return geometry::largest_stretch(mesh(), rest());
    case What::mesh_finite:
        return geometry::all_finite(mesh()) ? 1 : 0;
    case What::cubes:
        return static_cast<double>(cubes().count());
    case What::components:
        return static_cast<double>(geometry::component_count(cubes()));
    case What::mass:
        return geometry::total_mass(cubes());
    case What::speed_max:
        return physics::largest_speed(state());
    case What::kinetic_energy:
        return physics::kinetic_energy(state(), cubes());
    case What::converged:
        return state().report.converged ? 1 : 0;
    case What::iterations:
        return state().report.iterations;
    case What::brightness:
        return render::mean_brightness(image());
    case What::coverage:
        return render::coverage(image());
    }
    throw std::logic_error("a measure without a case");
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    return {measure(in)};
}

void add_to(graph::Registry& registry)
{
    registry.add("Measure", 1, run)
        .summary("Turns a mesh, cubes, a state or an image into one number, for `expect` blocks "
                 "and studies.")
        .input("mesh", &Inputs::mesh, "The mesh to measure.", graph::Need::optional)
        .input("rest", &Inputs::rest, "The same mesh before it moved, for displacements.",
               graph::Need::optional)
        .input("cubes", &Inputs::cubes, "The cubes to measure.", graph::Need::optional)
        .input("state", &Inputs::state, "The simulation's state to measure.", graph::Need::optional)
        .input("image", &Inputs::image, "The image to measure.", graph::Need::optional)
        .choice("what", &Inputs::what,
                {"vertices",
                 "triangles",
                 "area",
                 "volume",
                 "lowest",
                 "highest",
                 "displacement_max",
                 "displacement_mean",
                 "displacement_at",
                 "stretch_max",
                 "mesh_finite",
                 "cubes",
                 "components",
                 "mass",
                 "speed_max",
                 "kinetic_energy",
                 "converged",
                 "iterations",
                 "brightness",
                 "coverage"},
                "The quantity: of `mesh` vertices, triangles, area (m^2), volume (m^3), lowest and "
                "highest along `direction` (m), mesh_finite (1 or 0); of `mesh` against `rest` "
                "displacement_max, _mean, _at (m), stretch_max (largest edge length over its rest "
                "length); of `cubes` their number, components, mass (kg); of `state` speed_max "
                "(m/s), kinetic_energy (J, needs `cubes`), converged (1 or 0), iterations; of "
                "`image` brightness (mean luma, 0 to 1), coverage (share of pixels that differ "
                "from their row's first).")
        .param("point", &Inputs::point, "Where, in the rest shape: the nearest vertex counts.",
               {.unit = "m"}, {"what", {"displacement_at"}})
        .param("direction", &Inputs::direction, "Which way counts as positive.", {},
               {"what", {"displacement_at", "lowest", "highest"}})
        .output("value", &Outputs::value, "The number.");
}

}  // namespace nodes::measure
