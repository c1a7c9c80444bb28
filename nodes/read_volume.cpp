#include "geometry/io/read_volume.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/import_limits.hpp"
#include "nodes/wire_types.hpp"

#include <memory>

namespace nodes::read_volume {

using geometry::LengthUnit;
using geometry::UpAxis;

enum class Unit { metre, centimetre, millimetre, inch, foot, custom };
enum class Up { y, z, x };

struct Inputs {
    std::filesystem::path path;
    std::string grid;
    geometry::VolumeParts make = geometry::VolumeParts::both;
    std::string attribute;
    double iso = 0;
    double fog_iso = 0.5;
    Unit unit = Unit::metre;
    double custom_unit = 1;
    Up up = Up::y;
    int max_voxels = 50'000'000;
    geometry::ProcessLimits limits;
};
// Null where it is not made, so that a link to it is told to be empty.
struct Outputs {
    graph::Wire<geometry::TriMesh> mesh, points;
};

static LengthUnit unit_of(Unit unit)
{
    switch (unit) {
    case Unit::metre:
        return LengthUnit::metre;
    case Unit::centimetre:
        return LengthUnit::centimetre;
    case Unit::millimetre:
        return LengthUnit::millimetre;
    case Unit::inch:
        return LengthUnit::inch;
    case Unit::foot:
        return LengthUnit::foot;
    case Unit::custom:
        return LengthUnit::custom;
    }
    throw std::invalid_argument("no such unit");
}

static geometry::VolumeOptions options(const Inputs& in, const graph::Context& context)
{
    geometry::VolumeOptions o;
    o.limits = in.limits;
    o.check = [stop = context.stop] {
        if (stop.stop_requested()) throw graph::Cancelled();
    };
    o.grid = in.grid;
    o.attribute = in.attribute;
    o.iso = in.iso;
    o.fog_iso = in.fog_iso;
    o.make = in.make;
    o.max_voxels = static_cast<std::uint64_t>(in.max_voxels);
    o.unit = unit_of(in.unit);
    o.custom_unit = in.custom_unit;
    o.up = in.up == Up::y ? UpAxis::y : in.up == Up::z ? UpAxis::z : UpAxis::x;
    return o;
}

constexpr const char* no_path = "expected the path of a VDB file, found none";

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    if (in.path.empty()) return {{"path", no_path}};
    const std::string why = geometry::why_no_volumes();
    return why.empty() ? graph::Faults{} : graph::Faults{{"path", why}};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.path.empty()) throw std::invalid_argument(no_path);
    geometry::ReadVolume read = geometry::read_volume(in.path, options(in, context));
    using geometry::TriMesh, geometry::VolumeParts;
    Outputs out;
    if (in.make != VolumeParts::points) {
        out.mesh = std::make_shared<const TriMesh>(std::move(read.mesh));
    }
    if (in.make != VolumeParts::mesh) {
        out.points = std::make_shared<const TriMesh>(std::move(read.points));
    }
    return out;
}

static void add_parameters(graph::NodeBuilder<Inputs, Outputs>& node)
{
    node.path_in("path", &Inputs::path,
                 "The file (.vdb). #### stands for the frame number, for a sequence of one file "
                 "per frame.")
        .param("grid", &Inputs::grid,
               "Name of the grid, whose values must be floats. Empty: `surface`, or else "
               "`density`, or else the first grid of floats by name.")
        .choice("make", &Inputs::make, {"both", "mesh", "points"},
                "Which outputs are made. An output that is not made is empty.")
        .param("iso", &Inputs::iso,
               "Signed distance at which the surface of a level set lies, as in Houdini. More than "
               "0: the body grows. It must lie within the band of voxels that the file has.",
               {.min = -1e6, .max = 1e6, .unit = "m"})
        .param("fog_iso", &Inputs::fog_iso,
               "Value at which the surface of any other grid lies: inside is what is as much or "
               "more. Houdini uses 0.5, Blender 0.1.",
               {.min = -1e9, .max = 1e9})
        .param("attribute", &Inputs::attribute,
               "Name of the attribute of `points` that holds the grid's values. Empty: the grid's "
               "name. Cubes have a `density` of their own, so that a grid of this name needs "
               "another one there.")
        .choice("unit", &Inputs::unit, {"m", "cm", "mm", "inch", "foot", "custom"},
                "Unit of length of the file.")
        .param("custom_unit", &Inputs::custom_unit, "Length of the file's unit.",
               {.min = 1e-12, .max = 1e12, .unit = "m"}, {"unit", {"custom"}})
        .choice("up", &Inputs::up, {"y", "z", "x"},
                "Axis of the file that points up. Files of Houdini have y, of Blender z.")
        .param("max_voxels", &Inputs::max_voxels,
               "Most voxels that a grid may have: active ones, and for `points` inner ones. A "
               "grid with more is refused before it fills the memory.",
               {.min = 1, .max = 2e9, .unit = "voxels"})
        .block("limits", &Inputs::limits, describe_import_limits,
               "Limits on reading a file. A file that exceeds one is reported as damaged.");
}

void add_to(graph::Registry& registry)
{
    auto node = registry.add("ReadVolume", 1, run);
    node.summary("Reads a grid of voxels from a VDB file, as the mesh of its surface and as the "
                 "points inside of it.",
                 {"vdb", "openvdb", "volume", "voxels", "level set", "sdf", "fog", "import"});
    add_parameters(node);
    node.check(check)
        .output("mesh", &Outputs::mesh,
                "The surface in metres, y up, its faces outwards, with computed normals.")
        .output("points", &Outputs::points,
                "A point in the middle of each voxel inside, and as an attribute the grid's value "
                "there, of a level set in metres. Sample makes samples of them and keeps the "
                "attribute, Voxelize averages it per cube, and LocalMatter can use it there.");
}

}  // namespace nodes::read_volume
