#include "geometry/primitive.hpp"
#include "graph/node_type.hpp"
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
    throw std::invalid_argument("no such shape");
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

// The declarations that several shapes share.
constexpr double most_metres = 1e6;
static const graph::Limits metres{1e-9, most_metres, "m"};
static graph::Limits counts(double least)
{
    return {least, 100'000, {}};
}

static void describe_box(graph::ParamsOf<BoxShape>& params)
{
    params.param("size", &BoxShape::size, "Its size along x, y and z.", metres)
        .param("divisions_x", &BoxShape::divisions_x, "Pieces along x.", counts(1))
        .param("divisions_y", &BoxShape::divisions_y, "Pieces along y.", counts(1))
        .param("divisions_z", &BoxShape::divisions_z, "Pieces along z.", counts(1));
}
static void describe_beam(graph::ParamsOf<BeamShape>& params)
{
    params.param("length", &BeamShape::length, "Its size along x.", metres)
        .param("height", &BeamShape::height, "Its size along y.", metres)
        .param("width", &BeamShape::width, "Its size along z.", metres)
        .param("divisions", &BeamShape::divisions, "Pieces along x.", counts(1));
}
static void describe_sphere(graph::ParamsOf<SphereShape>& params)
{
    params.param("radius", &SphereShape::radius, "Its radius.", metres)
        .param("subdivisions", &SphereShape::subdivisions,
               "How often the 20 faces of an icosahedron are split in four.",
               {.min = 0, .max = 10});
}
static void describe_uv_sphere(graph::ParamsOf<UvSphereShape>& params)
{
    params.param("radius", &UvSphereShape::radius, "Its radius.", metres)
        .param("segments", &UvSphereShape::segments, "Pieces around the y axis.", counts(3))
        .param("rings", &UvSphereShape::rings, "Pieces from pole to pole.", counts(2));
}
static void describe_grid(graph::ParamsOf<GridShape>& params)
{
    params.param("size_x", &GridShape::size_x, "Its size along x.", metres)
        .param("size_z", &GridShape::size_z, "Its size along z.", metres)
        .param("divisions_x", &GridShape::divisions_x, "Pieces along x.", counts(1))
        .param("divisions_z", &GridShape::divisions_z, "Pieces along z.", counts(1));
}
static void describe_cylinder(graph::ParamsOf<CylinderShape>& params)
{
    params.param("radius", &CylinderShape::radius, "Its radius.", metres)
        .param("height", &CylinderShape::height, "Its size along y.", metres)
        .param("segments", &CylinderShape::segments, "Pieces around the y axis.", counts(3))
        .param("rings", &CylinderShape::rings, "Pieces along the y axis.", counts(1));
}
static void describe_torus(graph::ParamsOf<TorusShape>& params)
{
    params
        .param("radius", &TorusShape::radius, "From its centre to the middle of its tube.", metres)
        .param("tube", &TorusShape::tube, "The radius of its tube.", metres)
        .param("segments", &TorusShape::segments, "Pieces around the y axis.", counts(3))
        .param("tube_segments", &TorusShape::tube_segments, "Pieces around the tube.", counts(3));
}

void add_to(graph::Registry& registry)
{
    registry.add("Primitive", 1, run)
        .summary("Makes a simple shape: a box, beam, sphere, grid, cylinder or torus.")
        .choice("shape", &Inputs::shape,
                {"box", "beam", "sphere", "uv_sphere", "grid", "cylinder", "torus"},
                "Which shape; each has a block of its own below.")
        .block("box", &Inputs::box, describe_box, "A box.", {"shape", {"box"}})
        .block("beam", &Inputs::beam, describe_beam, "A long box along x.", {"shape", {"beam"}})
        .block("sphere", &Inputs::sphere, describe_sphere,
               "A sphere of nearly equal triangles: a subdivided icosahedron.",
               {"shape", {"sphere"}})
        .block("uv_sphere", &Inputs::uv_sphere, describe_uv_sphere,
               "A sphere of segments and rings, with texture coordinates.",
               {"shape", {"uv_sphere"}})
        .block("grid", &Inputs::grid, describe_grid, "A flat sheet that faces up.",
               {"shape", {"grid"}})
        .block("cylinder", &Inputs::cylinder, describe_cylinder, "A capped cylinder along y.",
               {"shape", {"cylinder"}})
        .block("torus", &Inputs::torus, describe_torus, "A ring around y.", {"shape", {"torus"}})
        .param("centre", &Inputs::centre, "Where its centre lies.", {.unit = "m"})
        .param("material", &Inputs::material, "The name of its one material.")
        .colour("colour", &Inputs::colour, "The colour of its material.")
        .param("roughness", &Inputs::roughness, "From 0, a mirror, to 1, chalk.",
               {.min = 0, .max = 1})
        .param("opacity", &Inputs::opacity, "From 0, invisible, to 1, opaque.",
               {.min = 0, .max = 1})
        .output("mesh", &Outputs::mesh, "The shape.");
}

}  // namespace nodes::primitive
