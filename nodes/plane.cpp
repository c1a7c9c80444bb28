#include "geometry/cubes/plane.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/material_rules.hpp"
#include "nodes/sheet_texts.hpp"
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
    geometry::PictureInk ink = geometry::PictureInk::dark;
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
    ChosenMatter matter;
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

// The grid on which ni by nj cells are centred at `centre`.
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

static constexpr std::array ink_names{"dark", "bright", "opaque"};  // as PictureInk

constexpr const char* needs_picture =
    "outline = image needs a picture: set the parameter 'image.path'";
constexpr const char* needs_mesh =
    "outline = mesh needs the input 'mesh': link the mesh whose footprint is the outline";

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (in.outline == Outline::image && in.image.path.empty()) {
        return {{"image.path", needs_picture}};
    }
    if (in.outline == Outline::mesh && !setting.links("mesh")) return {{"outline", needs_mesh}};
    return {};
}

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
                                     in.thickness, matter_of(in.matter));
    }
    case Outline::image: {
        if (in.image.path.empty()) {
            throw std::invalid_argument(needs_picture);
        }
        const geometry::PlanePicture picture =
            geometry::read_plane_picture(in.image.path, in.image.ink);
        const int ni = pieces(in.image.width, in.size);
        const auto cells = geometry::picture_cells(picture, axis, ni, in.image.threshold);
        if (cells.empty()) {
            throw std::invalid_argument(
                fmt::format("{}: every cell has less than {:g} {} ink ({} cells across): change "
                            "image.ink, lower image.threshold, or use smaller cells",
                            in.image.path.filename().string(), in.image.threshold,
                            ink_names[size_t(in.image.ink)], ni));
        }
        const double size = in.image.width / ni;
        const int nj = pieces(in.image.width * picture.height / picture.width, size);
        return geometry::plane_cubes(cells, grid_about(in, in.centre, size, ni, nj), in.thickness,
                                     matter_of(in.matter));
    }
    case Outline::mesh: {
        if (!in.mesh) {
            throw std::invalid_argument(needs_mesh);
        }
        const geometry::Box box = geometry::bounds(*in.mesh);
        if (box.empty()) throw std::invalid_argument("the input 'mesh' has no vertices");
        const auto count = [&](int d) {
            return static_cast<int>(
                std::clamp(std::ceil(box.size()[d] / in.size - 1e-6), 1.0, 1e7));
        };
        const geometry::PlaneGrid grid = grid_about(in, box.centre(), in.size, count(u), count(v));
        return geometry::plane_cubes(geometry::footprint_cells(*in.mesh, grid), grid, in.thickness,
                                     matter_of(in.matter));
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

static void describe_sides(graph::ParamsOf<Sides>& p)
{
    p.param("u", &Sides::u,
            "Side length along x (along z for a sheet across x), rounded to whole cells.",
            {1e-9, 1e6, "m"})
        .param("v", &Sides::v,
               "Side length along y (along z for a sheet across y), rounded to whole "
               "cells.",
               {1e-9, 1e6, "m"});
}

static void describe_picture(graph::ParamsOf<Picture>& p)
{
    p.path_in("path", &Picture::path, "The picture: PNG, JPEG, BMP or TGA.")
        .choice("ink", &Picture::ink, {ink_names[0], ink_names[1], ink_names[2]},
                "Which pixels are ink, where the sheet is: dark, bright or opaque "
                "ones. Transparent pixels are never ink.")
        .param("threshold", &Picture::threshold,
               "Smallest share of ink in a cell of the sheet, on average.", {0, 1, ""})
        .param("width", &Picture::width, "Width of the whole picture.", {1e-9, 1e6, "m"});
}

void add_to(graph::Registry& registry)
{
    registry.add("Plane", 1, run)
        .summary("Makes an elastic sheet: a grid of particles of any outline, with holes, as flat "
                 "cubes for Simulate's methods shell and lattice, and beside solids for bricks.",
                 {"cloth", "sheet", "membrane", "fabric", "flag", "shell"})
        .input("mesh", &Inputs::mesh,
               "The mesh whose footprint along the flat axis is the outline, for outline = mesh.",
               graph::Need::optional)
        .choice("outline", &Inputs::outline, {"rectangle", "ellipse", "image", "mesh"},
                "Which cells the sheet has. rectangle: all. ellipse: those inside the ellipse that "
                "fills the rectangle. image: those that a picture covers. mesh: those that a mesh "
                "covers.")
        .choice(
            "across", &Inputs::across, {"x", "y", "z"},
            "Axis normal to the sheet: y for a level sheet, z for an upright one that faces you.")
        .block("sides", &Inputs::sides, describe_sides, "Sides of the rectangle.",
               {"outline", {"rectangle", "ellipse"}})
        .block("image", &Inputs::image, describe_picture, "The picture that gives the outline.",
               {"outline", {"image"}})
        .param("size", &Inputs::size,
               "Edge of a cell: the distance between particles. For a picture it is rounded so "
               "that whole cells fill the width.",
               {1e-9, 1e6, "m"})
        .param("thickness", &Inputs::thickness, sheet_thickness_text, {1e-12, 1e6, "m"})
        .param("centre", &Inputs::centre,
               "Centre of the rectangle or picture. With outline = mesh the sheet stays at the "
               "mesh's footprint.",
               {.unit = "m"}, {"outline", {"rectangle", "ellipse", "image"}})
        .block("matter", &Inputs::matter, describe_matter<ChosenMatter>,
               "Material of the sheet. With method lattice, Poisson's ratio acts as 0.")
        .colour("colour", &Inputs::colour, "Colour of the mesh.")
        .check(check)
        .output("cubes", &Outputs::cubes, "The cells, for Pin, Simulate and Embed.")
        .output("mesh", &Outputs::mesh,
                "The sheet at rest as triangles, for Embed and Render. Any other mesh can be "
                "embedded in the cells instead; it keeps its height above them.");
}

}  // namespace nodes::plane
