#include "geometry/io/read_mesh.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/far_vertex.hpp"
#include "nodes/import_limits.hpp"
#include "nodes/wire_types.hpp"

#include <numbers>

namespace nodes::read_mesh {

struct Inputs {
    std::filesystem::path path;
    geometry::LengthUnit unit = geometry::LengthUnit::automatic;
    double custom_unit = 1;
    geometry::UpAxis up = geometry::UpAxis::automatic;
    double line_thickness = 0;
    double fit = 0;
    geometry::Placement place = geometry::Placement::keep;
    geometry::Weld weld = geometry::Weld::all;
    bool keep_order = false;
    geometry::FileNormals normals = geometry::FileNormals::file;
    double crease_degrees = 40;
    geometry::ColourSpace colours = geometry::ColourSpace::automatic;
    geometry::ProcessLimits limits;
};
struct Outputs {
    geometry::TriMesh mesh;
    geometry::Polylines lines;
};

static geometry::ReadOptions options(const Inputs& in, const graph::Context& context)
{
    geometry::ReadOptions o;
    o.import.limits = in.limits;
    o.import.root = context.root;
    o.import.check = [stop = context.stop] {
        if (stop.stop_requested()) throw graph::Cancelled();
    };
    o.unit = in.unit;
    o.custom_unit = in.custom_unit;
    o.up = in.up;
    o.colours = in.colours;
    o.line_thickness = in.line_thickness;
    o.fit = in.fit;
    o.place = in.place;
    o.weld = in.weld;
    o.keep_order = in.keep_order;
    o.normals = in.normals;
    o.crease = in.crease_degrees * (std::numbers::pi / 180);
    return o;
}

constexpr const char* no_path = "expected the path of a mesh file, found none";

constexpr const char* about_unit =
    "Unit of length of the file. auto: the unit that the file states (FBX, glTF, COLLADA, and OBJ, "
    "PLY and STL of WriteMesh), or else metres.";
constexpr const char* about_up =
    "Axis of the file that points up. auto: the axis that the file states, or else y.";
constexpr const char* about_lines =
    "Diameter of the tubes that the file's lines become (OBJ, glTF): before `fit` scales the mesh. "
    "0: lines are left out.";
constexpr const char* about_weld =
    "Which vertices at one place become one. all: those of the whole file. groups: those of one "
    "group (an object or a named part of the file), so that objects that touch stay pieces of "
    "their own, for `pieces` of Voxelize.";

constexpr const char* about_order =
    "The mesh has all vertices of the file in its order (OBJ and PLY), those that no face uses and "
    "doubles too, so that a point cache of WriteMesh fits the file itself where another program "
    "has read it, for instance Blender with Keep Vertex Order. false: vertices are numbered anew, "
    "and those without a face are left out. With weld = groups, objects that touch need vertices "
    "of their own, one each at a place.";

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    if (in.path.empty()) return {{"path", no_path}};
    if (in.path.extension() == ".vdb") {
        return {{"path", "expected a mesh file, found a volume: read it with ReadVolume"}};
    }
    return {};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.path.empty()) throw std::invalid_argument(no_path);
    geometry::ReadMesh read = geometry::read_mesh(in.path, options(in, context));
    for (const auto& file : read.side_files) context.opened(file);
    for (const std::string& warning : read.warnings) context.warn(warning);
    const std::string far = told_of_far_vertex(read.mesh);
    if (!far.empty()) context.warn(far);
    return {std::move(read.mesh), std::move(read.lines)};
}

void add_to(graph::Registry& registry)
{
    registry.add("ReadMesh", 1, run)
        .summary("Reads a mesh or a point cloud from a file of any format that assimp supports, "
                 "or from text.",
                 {"file", "import", "load", "mesh", "obj", "fbx", "alembic", "object"})
        .path_in(
            "path", &Inputs::path,
            "The file: OBJ with its materials, PLY, STL, glTF, FBX, COLLADA, AC3D, 3DS and "
            "others; or points as text (XYZ, PTS, ASC), a line each, with colours where they "
            "have any. #### stands for the frame number, for a sequence of one file per frame. "
            "Pictures of base colours and normal maps (PNG, JPEG, BMP, TGA) are read with it, from "
            "the file itself or from the path that it names. One that isn't there is looked for by "
            "its name beside the file and in `textures` below it. A bump map of an OBJ is taken "
            "for a normal map where its colours are directions.")
        .choice("unit", &Inputs::unit, {"auto", "m", "cm", "mm", "inch", "foot", "custom"},
                about_unit)
        .param("custom_unit", &Inputs::custom_unit, "Length of the file's unit.",
               {.min = 1e-12, .max = 1e12, .unit = "m"}, {"unit", {"custom"}})
        .choice("up", &Inputs::up, {"auto", "y", "z", "x"}, about_up)
        .param("line_thickness", &Inputs::line_thickness, about_lines,
               {.min = 0, .max = 1e6, .unit = "m"})
        .param("fit", &Inputs::fit,
               "Length to which the mesh's longest side is scaled; 0: no scaling.",
               {.min = 0, .max = 1e9, .unit = "m"})
        .choice("place", &Inputs::place, {"keep", "centre", "ground"},
                "Where the mesh is placed. keep: as in the file. centre: its centre at the origin. "
                "ground: its lowest point at y = 0, and its centre above the origin. Like `fit`, "
                "it applies to each file of a sequence separately: use keep for a mesh that moves.")
        .choice("weld", &Inputs::weld, {"all", "groups"}, about_weld)
        .param("keep_order", &Inputs::keep_order, about_order)
        .choice("normals", &Inputs::normals, {"file", "computed", "none"},
                "Source of the normals. file: those of the file, computed where it has none. "
                "computed: all computed. none: no normals.")
        .param(
            "crease_degrees", &Inputs::crease_degrees,
            "Computed normals are smooth across edges whose faces differ by less than this angle.",
            {.min = 0, .max = 180, .unit = "deg"}, {"normals", {"file", "computed"}})
        .choice("colours", &Inputs::colours, {"auto", "srgb", "linear"},
                "Colour space of the file's colours. auto: linear for glTF, sRGB for all others.")
        .block("limits", &Inputs::limits, describe_import_limits,
               "Limits on reading a file. A file that exceeds one is reported as damaged.")
        .check(check)
        .output(
            "mesh", &Outputs::mesh,
            "The mesh in metres, y up, welded by position (see `weld`), with the materials and "
            "their "
            "textures, groups, normals, texture coordinates and vertex colours that the file "
            "has. Polygons are cut into triangles, and WriteMesh writes them as polygons again. "
            "Two faces that meet at a seam of the texture share their vertices. Further "
            "numbers of vertices are attributes, in single precision and not scaled: those of "
            "PLY by their names; columns of text by the names in a first line, or column4, "
            "column5 and so on. Attributes of other formats, such as _NAME of glTF, are not "
            "read: assimp does not hand them on.")
        .output("lines", &Outputs::lines,
                "Lines of the file (OBJ, glTF), for Skeletons: moved and scaled with the mesh.");
}

}  // namespace nodes::read_mesh
