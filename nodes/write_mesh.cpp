#include "geometry/io/export_mesh.hpp"
#include "geometry/io/point_cache.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/transform.hpp"
#include "graph/document/frame_path.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace nodes::write_mesh {

enum class Format { automatic, obj, ply, stl, glb, gltf, dae, fbx, x3d, pc2 };

enum class Up { y, z };
enum class Unit { metre, centimetre, millimetre, inch, foot, custom };

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    std::filesystem::path path = "mesh.####.obj";
    Format format = Format::automatic;
    Up up = Up::y;
    Unit unit = Unit::metre;
    double custom_unit = 1;
    bool assimp = false;
};
struct Outputs {
    graph::WrittenFile file;
};

static bool is_cache(const Inputs& in)
{
    return in.format == Format::pc2 ||
           (in.format == Format::automatic && in.path.extension() == ".pc2");
}

// Of one that is no cache. Throws std::invalid_argument for endings that are no format's.
static geometry::MeshFormat format_of(const Inputs& in)
{
    return in.format == Format::automatic
               ? geometry::mesh_format(in.path)
               : static_cast<geometry::MeshFormat>(static_cast<int>(in.format) - 1);
}

// The frames as text: "2-8, 10-16, 18-24 and 21 more".
static std::string some_of(const std::vector<int>& frames)
{
    std::string text;
    std::size_t i = 0;
    for (int runs = 0; i < frames.size() && runs < 4; ++runs) {
        const std::size_t first = i++;
        while (i < frames.size() && frames[i] == frames[i - 1] + 1) ++i;
        if (runs > 0) text += ", ";
        text += std::to_string(frames[first]);
        if (i - first > 1) text += "-" + std::to_string(frames[i - 1]);
    }
    if (i < frames.size()) text += " and " + std::to_string(frames.size() - i) + " more";
    return text;
}

// Refuses a change of the number of vertices: it would start the file anew and lose all other
// frames.
static void require_as_many_points(const Inputs& in, const graph::Context& context)
{
    if (!context.cook) return;
    const std::size_t points = in.mesh->positions.size();
    const std::size_t before = context.cook->first_said("points of " + in.path.string(), points);
    if (points == before) return;
    std::filesystem::path better = in.path;
    better.replace_extension(".####.obj");
    throw std::invalid_argument(
        "a pc2 file needs the same number of vertices in all frames: expected " +
        std::to_string(before) + " as in the frames before, found " + std::to_string(points) +
        ". If the mesh tears, set torn = hide or stretch in Embed, because cutting adds vertices; "
        "or write a file per frame: set the parameter 'path' to " +
        better.string());
}

static void warn_of_missing(const std::vector<int>& missing, const std::filesystem::path& path,
                            const graph::Context& context)
{
    if (missing.empty()) return;
    context.warn(path.string() + " lacks frames " + some_of(missing) + " of " +
                 std::to_string(context.range().first) + "-" +
                 std::to_string(context.range().last) +
                 ", which were not cooked: each repeats the nearest cooked frame before it, or "
                 "else the first. Cook them to fill them in");
}

static void warn_of_outdated(const std::vector<int>& outdated, const std::filesystem::path& path,
                             const graph::Context& context)
{
    if (outdated.empty()) return;
    context.warn("frames " + some_of(outdated) + " of " + path.string() +
                 " are of an earlier cook with other settings, by frames that both wrote: the file "
                 "holds two motions. Cook all of its frames, or write to another path");
}

static std::string numbered_cache(const Inputs& in)
{
    return "a pc2 holds all frames in one file: expected a path without #, found " +
           in.path.string();
}

// Writes one frame to its place in the one file for all frames.
static Outputs run_cache(const Inputs& in, const graph::Context& context)
{
    const graph::FrameRange& range = context.range();
    const auto path = context.output_folder / in.path;
    if (in.path.string().find('#') != std::string::npos) {
        throw std::invalid_argument(numbered_cache(in));
    }
    require_as_many_points(in, context);
    const auto sample_of = [&](int f) { return static_cast<std::uint32_t>(f - range.first); };
    std::vector<std::uint32_t> coming;
    if (context.cook) {
        for (const int f : context.cook->frames) coming.push_back(sample_of(f));
    }
    const geometry::PointCache cache{static_cast<std::uint32_t>(in.mesh->positions.size()),
                                     float(range.first), 1,
                                     static_cast<std::uint32_t>(range.count())};
    const geometry::SampleWritten written =
        geometry::write_sample(path, cache, sample_of(context.frame()), in.mesh->positions, coming);
    std::vector<int> missing, outdated;
    for (const std::uint32_t s : written.missing) {
        if (std::binary_search(coming.begin(), coming.end(), s)) continue;
        missing.push_back(range.first + static_cast<int>(s));
    }
    for (const std::uint32_t s : written.outdated) {
        outdated.push_back(range.first + static_cast<int>(s));
    }
    warn_of_missing(missing, path, context);
    warn_of_outdated(outdated, path, context);
    return {{path.string(), {}, true}};
}

static double metres_of(const Inputs& in)
{
    constexpr std::array metres{1.0, 0.01, 0.001, 0.0254, 0.3048};
    return in.unit == Unit::custom ? in.custom_unit : metres[static_cast<std::size_t>(in.unit)];
}

// Why the file's format leaves no choice of axis and unit; empty where it does.
static std::string why_as_it_is(const Inputs& in)
{
    if (in.up == Up::y && in.unit == Unit::metre) return {};
    if (is_cache(in)) return {};
    using enum geometry::MeshFormat;
    const auto format = format_of(in);
    if (format == obj || format == ply || format == stl) return {};
    return "files of this format are read as y up and in metres, whatever they hold: expected up = "
           "y and unit = m. Choose those for obj, ply, stl and pc2 alone";
}

// In the file's axes and unit.
static graph::Wire<geometry::TriMesh> turned_for_file(const Inputs& in)
{
    if (in.up == Up::y && in.unit == Unit::metre) return in.mesh;
    auto mesh = std::make_shared<geometry::TriMesh>(*in.mesh);
    geometry::Mat3 turn = geometry::Mat3::Identity();
    if (in.up == Up::z) turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    geometry::Transform T = geometry::Transform::Identity();
    T.linear() = turn / metres_of(in);
    geometry::move(*mesh, T);
    return mesh;
}

static Outputs run(const Inputs& linked, const graph::Context& context)
{
    Inputs in = linked;
    if (const std::string why = why_as_it_is(in); !why.empty()) throw std::invalid_argument(why);
    in.mesh = turned_for_file(in);
    if (const std::string what = geometry::what_is_not_finite(*in.mesh); !what.empty()) {
        throw std::invalid_argument("the mesh can't be written, because " + what +
                                    ": look for the first node with huge numbers");
    }
    if (is_cache(in)) return run_cache(in, context);
    const auto format = format_of(in);
    const auto path = graph::frame_file(in.path, context);
    const auto files =
        geometry::is_written_here(format) && !in.assimp
            ? geometry::write_mesh(path, format, *in.mesh, {metres_of(in), in.up == Up::z})
            : geometry::export_mesh(path, format, *in.mesh, {}, [stop = context.stop] {
                  if (stop.stop_requested()) throw graph::Cancelled();
              });
    Outputs out{{path.string()}};
    for (const auto& file : files) out.file.beside.push_back(file.string());
    return out;
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    if (is_cache(in)) {
        if (in.path.string().find('#') != std::string::npos) return {{"path", numbered_cache(in)}};
        return wrong_path(in.path, {}, 1);
    }
    graph::Faults faults =
        in.format != Format::automatic
            ? wrong_path(in.path, {}, setting.frames)
            : wrong_path(in.path, {".obj", ".ply", ".stl", ".glb", ".gltf", ".dae", ".fbx", ".x3d"},
                         setting.frames);
    if (!faults.empty()) return faults;
    const std::string why = why_as_it_is(in);
    if (!why.empty()) faults.push_back({in.up == Up::y ? "unit" : "up", why});
    if (why.empty() && in.assimp && (in.up != Up::y || metres_of(in) != 1)) {
        faults.push_back({"assimp",
                          "assimp does not write the axis and the unit into the file: set `up` and "
                          "`unit` of the ReadMesh that reads it",
                          true});
    }
    return faults;
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteMesh", 1, run)
        .summary("Writes a mesh as a file per frame, or as one point cache for Blender's Mesh "
                 "Cache modifier.",
                 {"export", "save", "output", "rop", "cache", "filecache", "obj export"})
        .input("mesh", &Inputs::mesh, "The mesh to write.")
        .path_out(
            "path", &Inputs::path,
            "Path of the file, below the output folder. #### stands for the frame number, with at "
            "least as many digits. A pc2 takes none; all other formats require it if several "
            "frames are cooked. The materials of an OBJ are written beside it: mesh.0001.mtl. "
            "So are textures and normal maps, once for all frames; their names hold a digest of "
            "their "
            "content: wood.1f6e02a9.png. glb, gltf and fbx contain them. "
            "A ply names one texture at most and no normal map, stl and x3d none. Quads and other "
            "polygons of the file that ReadMesh read are written as polygons; stl, glb and gltf "
            "hold triangles only. A polygon that is cut, or lacks one of its triangles, is written "
            "as triangles.")
        .choice("format", &Inputs::format,
                {"auto", "obj", "ply", "stl", "glb", "gltf", "dae", "fbx", "x3d", "pc2"},
                "File format. auto: from the ending of the path. pc2: one file for all frames, "
                "with a constant number of vertices. gltf, dae (COLLADA), fbx (in text form, "
                "which Blender does not read) and "
                "x3d are written by assimp.")
        .choice("up", &Inputs::up, {"y", "z"},
                "Axis of the file that points up; z for programs that take files as they are, as "
                "CAD and Blender's import of PLY and STL do. Of obj, ply, stl and pc2; the other "
                "formats are y up by what they are.",
                {"format", {"auto", "obj", "ply", "stl", "pc2"}})
        .choice("unit", &Inputs::unit, {"m", "cm", "mm", "inch", "foot", "custom"},
                "Unit of length of the file, of the same formats. Attributes stay as they are.",
                {"format", {"auto", "obj", "ply", "stl", "pc2"}})
        .param("custom_unit", &Inputs::custom_unit, "Length of the file's unit.",
               {.min = 1e-12, .max = 1e12, .unit = "m"}, {"unit", {"custom"}})
        .param("assimp", &Inputs::assimp,
               "Whether assimp writes obj, ply, stl and glb too. It welds vertices that coincide "
               "in a frame, drops attributes, and takes 6 to 50 times as long.",
               {}, {"format", {"auto", "obj", "ply", "stl", "glb"}})
        .check(check)
        .reads(graph::Variable::frame | graph::Variable::range)
        .sink()
        .output("file", &Outputs::file, "The written file.");
}

}  // namespace nodes::write_mesh
