#include "geometry/read_mesh.hpp"

#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <numbers>

namespace nodes::read_mesh {

struct Inputs {
    std::filesystem::path path;
    geometry::LengthUnit unit = geometry::LengthUnit::automatic;
    double custom_unit = 1;
    geometry::UpAxis up = geometry::UpAxis::automatic;
    double fit = 0;
    geometry::Placement place = geometry::Placement::keep;
    geometry::FileNormals normals = geometry::FileNormals::file;
    double crease_degrees = 40;
    geometry::ColourSpace colours = geometry::ColourSpace::automatic;
    geometry::ProcessLimits limits;
};
struct Outputs {
    geometry::TriMesh mesh;
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
    o.fit = in.fit;
    o.place = in.place;
    o.normals = in.normals;
    o.crease = in.crease_degrees * (std::numbers::pi / 180);
    return o;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.path.empty()) throw std::invalid_argument("path names no file: give it a mesh file");
    geometry::ReadMesh read = geometry::read_mesh(in.path, options(in, context));
    for (const auto& file : read.side_files) context.opened(file);
    for (const std::string& warning : read.warnings) context.warn(warning);
    return {std::move(read.mesh)};
}

static void describe_limits(graph::ParamsOf<geometry::ProcessLimits>& params)
{
    params
        .param("seconds", &geometry::ProcessLimits::seconds, "Give up after this long.",
               {.min = 0.1, .max = 86400, .unit = "s"})
        .param("gigabytes", &geometry::ProcessLimits::gigabytes,
               "Give up when the importer needs more memory than this.",
               {.min = 0.1, .max = 1024, .unit = "GiB"});
}

void add_to(graph::Registry& registry)
{
    registry.add("ReadMesh", 1, run)
        .summary("Reads a mesh or a point cloud from a file of any format that assimp knows.")
        .path_in(
            "path", &Inputs::path,
            "The file: OBJ with its materials, PLY, STL, glTF, FBX, COLLADA, AC3D, 3DS ... #### "
            "stands for the frame's number: a file a frame.")
        .choice("unit", &Inputs::unit, {"auto", "m", "cm", "mm", "inch", "foot", "custom"},
                "The file's unit of length; auto takes what the file says, else metres.")
        .param("custom_unit", &Inputs::custom_unit, "How long the file's unit is.",
               {.min = 1e-12, .max = 1e12, .unit = "m"}, {"unit", {"custom"}})
        .choice("up", &Inputs::up, {"auto", "y", "z", "x"},
                "The file's axis that points up; auto takes what the file says, else y.")
        .param("fit", &Inputs::fit,
               "Scale the mesh so that its largest side is this long; 0 keeps its size.",
               {.min = 0, .max = 1e9, .unit = "m"})
        .choice("place", &Inputs::place, {"keep", "centre", "ground"},
                "Where to put it: as in the file, its centre at the origin, or its lowest point at "
                "y = 0 with its centre above the origin. As `fit`, for each file by itself: keep "
                "what moves in place.")
        .choice("normals", &Inputs::normals, {"file", "computed", "none"},
                "Take normals from the file and compute those it lacks, compute all, or have none.")
        .param("crease_degrees", &Inputs::crease_degrees,
               "Computed normals are smooth across edges that turn by less than this.",
               {.min = 0, .max = 180, .unit = "deg"}, {"normals", {"file", "computed"}})
        .choice("colours", &Inputs::colours, {"auto", "srgb", "linear"},
                "How colours in the file are meant; auto takes glTF's as linear, others as sRGB.")
        .block("limits", &Inputs::limits, describe_limits,
               "What a file may cost to read before it is taken for damaged.")
        .output("mesh", &Outputs::mesh,
                "The mesh in metres, y up: welded by position, with materials, groups, normals, "
                "texture coordinates and vertex colours where the file has them.");
}

}  // namespace nodes::read_mesh
