#include "geometry/plane.hpp"

#include "graph/node_type.hpp"
#include "nodes/material_rules.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace nodes::plane {

using geometry::Vec3;

enum class Outline { rectangle, ellipse, image, mesh };
enum class Across { x, y, z };

struct Sides {
    double u = 1, v = 1;
};
struct Picture {
    std::filesystem::path path;
    geometry::MaskInk ink = geometry::MaskInk::dark;
    double threshold = 0.5;
    double width = 1;
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    Outline outline = Outline::rectangle;
    Across across = Across::y;
    Sides sides;
    Picture image;
    double size = 0.05;
    double thickness = 0.002;
    Vec3 centre{0, 0, 0};
    geometry::Matter matter{"default", 300, 1e6, 0, 0, 0};
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};
};
struct Outputs {
    geometry::Cubes cubes;
    geometry::TriMesh mesh;
};

static int pieces(double length, double size)
{
    return static_cast<int>(std::clamp(std::round(length / size), 1.0, 1e7));
}

// The grid on which ni by nj cells have their middle at `centre`.
static geometry::PlaneGrid grid_about(const Inputs& in, const Vec3& centre, double size, int ni,
                                      int nj)
{
    const int axis = static_cast<int>(in.across);
    const auto [u, v] = geometry::plane_axes(axis);
    geometry::PlaneGrid grid{axis, size, centre};
    grid.origin[u] -= size * ni / 2;
    grid.origin[v] -= size * nj / 2;
    return grid;
}

static constexpr std::array ink_names{"dark", "bright", "opaque"};  // as MaskInk

static geometry::Cubes cubes_of(const Inputs& in)
{
    const int axis = static_cast<int>(in.across);
    const auto [u, v] = geometry::plane_axes(axis);
    switch (in.outline) {
    case Outline::rectangle:
    case Outline::ellipse: {
        const int ni = pieces(in.sides.u, in.size), nj = pieces(in.sides.v, in.size);
        const auto cells = in.outline == Outline::rectangle ? geometry::rectangle_cells(ni, nj)
                                                            : geometry::ellipse_cells(ni, nj);
        return geometry::plane_cubes(cells, grid_about(in, in.centre, in.size, ni, nj),
                                     in.thickness, in.matter);
    }
    case Outline::image: {
        if (in.image.path.empty()) {
            throw std::invalid_argument("outline = image needs a picture: give image.path a file");
        }
        const geometry::Mask mask = geometry::read_mask(in.image.path, in.image.ink);
        const int ni = pieces(in.image.width, in.size);
        const auto cells = geometry::mask_cells(mask, axis, ni, in.image.threshold);
        if (cells.empty()) {
            throw std::invalid_argument(fmt::format(
                "{}: expected a picture with cells at least {:g} {}, found none of {} across: "
                "choose another image.ink, lower image.threshold or take smaller cells",
                in.image.path.filename().string(), in.image.threshold,
                ink_names[size_t(in.image.ink)], ni));
        }
        const double size = in.image.width / ni;
        const int nj = pieces(in.image.width * mask.height / mask.width, size);
        return geometry::plane_cubes(cells, grid_about(in, in.centre, size, ni, nj), in.thickness,
                                     in.matter);
    }
    case Outline::mesh: {
        if (!in.mesh) {
            throw std::invalid_argument("outline = mesh needs the input 'mesh': link the mesh "
                                        "whose footprint the plane is to have");
        }
        const geometry::Box box = geometry::bounds(*in.mesh);
        if (box.empty()) throw std::invalid_argument("the mesh has no vertices");
        const auto count = [&](int d) {
            return static_cast<int>(
                std::clamp(std::ceil(box.size()[d] / in.size - 1e-6), 1.0, 1e7));
        };
        const geometry::PlaneGrid grid = grid_about(in, box.centre(), in.size, count(u), count(v));
        return geometry::plane_cubes(geometry::footprint_cells(*in.mesh, grid), grid, in.thickness,
                                     in.matter);
    }
    }
    throw std::logic_error("Plane: an outline without a case");
}

static Outputs run(const Inputs& in, const graph::Context&)
{
    Outputs out{cubes_of(in), {}};
    out.mesh = geometry::plane_mesh(out.cubes);
    auto topology = std::make_shared<geometry::MeshTopology>(*out.mesh.topology);
    topology->materials = {{"sheet", in.colour}};
    out.mesh.topology = std::move(topology);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("Plane", 1, run)
        .summary("Makes an elastic sheet: a grid of particles of any outline, with holes, as cubes "
                 "of no thickness for Simulate's method lattice.")
        .input("mesh", &Inputs::mesh, "For outline = mesh: whose footprint along the flat axis.",
               graph::Need::optional)
        .choice("outline", &Inputs::outline, {"rectangle", "ellipse", "image", "mesh"},
                "Which cells there are: all of a rectangle, those in the ellipse that fills it, "
                "those that a picture covers, or those that a mesh covers.")
        .choice("across", &Inputs::across, {"x", "y", "z"},
                "The axis that the sheet lies across: y lays it flat, z stands it up facing you.")
        .block<Sides>("sides", &Inputs::sides,
                      [](graph::ParamsOf<Sides>& p) {
                          p.param("u", &Sides::u,
                                  "Along x; along z for a sheet across x. Rounded to whole cells.",
                                  {1e-9, 1e6, "m"})
                              .param("v", &Sides::v,
                                     "Along y; along z for a sheet across y. Rounded to whole "
                                     "cells.",
                                     {1e-9, 1e6, "m"});
                      },
                      "The rectangle's sides.", {"outline", {"rectangle", "ellipse"}})
        .block<Picture>(
            "image", &Inputs::image,
            [](graph::ParamsOf<Picture>& p) {
                p.path_in("path", &Picture::path, "The picture: PNG, JPEG, BMP or TGA.")
                    .choice("ink", &Picture::ink, {ink_names[0], ink_names[1], ink_names[2]},
                            "Where the sheet is: where the picture is dark, bright or opaque. What "
                            "is transparent is never.")
                    .param("threshold", &Picture::threshold,
                           "How much of a cell must be ink, on average.", {0, 1, ""})
                    .param("width", &Picture::width, "How wide the whole picture is.",
                           {1e-9, 1e6, "m"});
            },
            "The picture whose ink is the outline.", {"outline", {"image"}})
        .param("size", &Inputs::size,
               "The edge of a cell: the distance of particles. A picture's cells are rounded so "
               "that whole ones fill its width.",
               {1e-9, 1e6, "m"})
        .param("thickness", &Inputs::thickness,
               "How thick the sheet is: it weighs and resists stretch by it, and bending by its "
               "cube.",
               {1e-12, 1e6, "m"})
        .param("centre", &Inputs::centre,
               "Where the middle of the rectangle or picture lies. A mesh's footprint stays "
               "under it.",
               {.unit = "m"}, {"outline", {"rectangle", "ellipse", "image"}})
        .block("matter", &Inputs::matter, describe_matter<geometry::Matter>,
               "What the sheet is made of (Poisson's ratio acts as 0).")
        .colour("colour", &Inputs::colour, "Of the mesh.")
        .output("cubes", &Outputs::cubes, "The cells, for Pin, Simulate and Embed.")
        .output("mesh", &Outputs::mesh,
                "The sheet at rest as triangles, for Embed and Render. Any other mesh can be "
                "embedded in the cells instead; it keeps its height above them.");
}

}  // namespace nodes::plane
