#include "geometry/mesh/primitive.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

namespace nodes::primitive {

using geometry::Vec3;

struct BoxShape {
    Vec3 size{1, 1, 1};
    int divisions_x = 1, divisions_y = 1, divisions_z = 1;
};
struct BeamShape {
    double length = 8, height = 1, width = 1;
    int divisions = 8;
};
struct SphereShape {
    double radius = 0.5;
    int subdivisions = 4;
};
struct UvSphereShape {
    double radius = 0.5;
    int segments = 48, rings = 24;
};
struct GridShape {
    double size_x = 1, size_z = 1;
    int divisions_x = 10, divisions_z = 10;
};
struct CylinderShape {
    double radius = 0.5, height = 1;
    int segments = 48, rings = 1;
};
struct TorusShape {
    double radius = 0.5, tube = 0.2;
    int segments = 64, tube_segments = 24;
};

enum class Shape { box, beam, sphere, uv_sphere, grid, cylinder, torus };

struct Inputs {
    Shape shape = Shape::box;
    BoxShape box;
    BeamShape beam;
    SphereShape sphere;
    UvSphereShape uv_sphere;
    GridShape grid;
    CylinderShape cylinder;
    TorusShape torus;
    Vec3 centre{0, 0, 0};
    std::string material = "default";
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};
    double roughness = 0.6;
    double opacity = 1;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static geometry::TriMesh shape(const Inputs& in)
{
    switch (in.shape) {
    case Shape::box:
        return geometry::box(in.box.size,
                             {in.box.divisions_x, in.box.divisions_y, in.box.divisions_z});
    case Shape::beam:
        return geometry::box({in.beam.length, in.beam.height, in.beam.width},
                             {in.beam.divisions, 1, 1});
    case Shape::sphere:
        return geometry::icosphere(in.sphere.radius, in.sphere.subdivisions);
    case Shape::uv_sphere:
        return geometry::uv_sphere(in.uv_sphere.radius, in.uv_sphere.segments, in.uv_sphere.rings);
    case Shape::grid:
        return geometry::grid(in.grid.size_x, in.grid.size_z, in.grid.divisions_x,
                              in.grid.divisions_z);
    case Shape::cylinder:
        return geometry::cylinder(in.cylinder.radius, in.cylinder.height, in.cylinder.segments,
                                  in.cylinder.rings);
    case Shape::torus:
        return geometry::torus(in.torus.radius, in.torus.tube, in.torus.segments,
                               in.torus.tube_segments);
    }
    throw std::invalid_argument("Primitive: a shape without a case");
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{shape(in)};
    for (geometry::Vec3f& p : out.mesh.positions) p += in.centre.cast<float>();
    auto topology = std::make_shared<geometry::MeshTopology>(*out.mesh.topology);
    topology->materials = {{in.material, in.colour, float(in.opacity), float(in.roughness), 0.f}};
    out.mesh.topology = std::move(topology);
    return out;
}

// Limits that several shapes share.
constexpr double most_metres = 1e6;
static const graph::Limits metres{1e-9, most_metres, "m"};
static graph::Limits counts(double least)
{
    return {least, 100'000, {}};
}

static void describe_box(graph::ParamsOf<BoxShape>& params)
{
    params.param("size", &BoxShape::size, "Size along x, y and z.", metres)
        .param("divisions_x", &BoxShape::divisions_x, "Segments along x.", counts(1))
        .param("divisions_y", &BoxShape::divisions_y, "Segments along y.", counts(1))
        .param("divisions_z", &BoxShape::divisions_z, "Segments along z.", counts(1));
}
static void describe_beam(graph::ParamsOf<BeamShape>& params)
{
    params.param("length", &BeamShape::length, "Size along x.", metres)
        .param("height", &BeamShape::height, "Size along y.", metres)
        .param("width", &BeamShape::width, "Size along z.", metres)
        .param("divisions", &BeamShape::divisions, "Segments along x.", counts(1));
}
static void describe_sphere(graph::ParamsOf<SphereShape>& params)
{
    params.param("radius", &SphereShape::radius, "Radius.", metres)
        .param("subdivisions", &SphereShape::subdivisions,
               "How many times the 20 faces of an icosahedron are split in four.",
               {.min = 0, .max = 10});
}
static void describe_uv_sphere(graph::ParamsOf<UvSphereShape>& params)
{
    params.param("radius", &UvSphereShape::radius, "Radius.", metres)
        .param("segments", &UvSphereShape::segments, "Segments around the y axis.", counts(3))
        .param("rings", &UvSphereShape::rings, "Segments from pole to pole.", counts(2));
}
static void describe_grid(graph::ParamsOf<GridShape>& params)
{
    params.param("size_x", &GridShape::size_x, "Size along x.", metres)
        .param("size_z", &GridShape::size_z, "Size along z.", metres)
        .param("divisions_x", &GridShape::divisions_x, "Segments along x.", counts(1))
        .param("divisions_z", &GridShape::divisions_z, "Segments along z.", counts(1));
}
static void describe_cylinder(graph::ParamsOf<CylinderShape>& params)
{
    params.param("radius", &CylinderShape::radius, "Radius.", metres)
        .param("height", &CylinderShape::height, "Size along y.", metres)
        .param("segments", &CylinderShape::segments, "Segments around the y axis.", counts(3))
        .param("rings", &CylinderShape::rings, "Segments along the y axis.", counts(1));
}
static void describe_torus(graph::ParamsOf<TorusShape>& params)
{
    params
        .param("radius", &TorusShape::radius, "Distance from the centre to the middle of the tube.",
               metres)
        .param("tube", &TorusShape::tube, "Radius of the tube.", metres)
        .param("segments", &TorusShape::segments, "Segments around the y axis.", counts(3))
        .param("tube_segments", &TorusShape::tube_segments, "Segments around the tube.", counts(3));
}

void add_to(graph::Registry& registry)
{
    registry.add("Primitive", 1, run)
        .summary("Makes a simple shape: a box, beam, sphere, grid, cylinder or torus.",
                 {"sphere", "box", "cube", "cylinder", "torus", "grid", "shape", "geometry"})
        .choice("shape", &Inputs::shape,
                {"box", "beam", "sphere", "uv_sphere", "grid", "cylinder", "torus"},
                "The shape. Each has a block of parameters of its own.")
        .block("box", &Inputs::box, describe_box, "A box.", {"shape", {"box"}})
        .block("beam", &Inputs::beam, describe_beam, "A long box along x.", {"shape", {"beam"}})
        .block("sphere", &Inputs::sphere, describe_sphere,
               "A sphere of nearly equal triangles: a subdivided icosahedron.",
               {"shape", {"sphere"}})
        .block("uv_sphere", &Inputs::uv_sphere, describe_uv_sphere,
               "A sphere of segments and rings, with texture coordinates.",
               {"shape", {"uv_sphere"}})
        .block("grid", &Inputs::grid, describe_grid, "A flat grid that faces up.",
               {"shape", {"grid"}})
        .block("cylinder", &Inputs::cylinder, describe_cylinder, "A capped cylinder along y.",
               {"shape", {"cylinder"}})
        .block("torus", &Inputs::torus, describe_torus, "A torus around the y axis.",
               {"shape", {"torus"}})
        .param("centre", &Inputs::centre, "Position of the centre.", {.unit = "m"})
        .param("material", &Inputs::material, "Name of the material.")
        .colour("colour", &Inputs::colour, "Colour of the material.")
        .param("roughness", &Inputs::roughness,
               "Roughness of the material: 0 for a mirror, 1 for chalk.", {.min = 0, .max = 1})
        .param("opacity", &Inputs::opacity,
               "Opacity of the material: 0 for invisible, 1 for opaque.", {.min = 0, .max = 1})
        .output("mesh", &Outputs::mesh, "The shape.");
}

}  // namespace nodes::primitive
