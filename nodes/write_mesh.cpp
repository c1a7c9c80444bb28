#include "geometry/export_mesh.hpp"
#include "geometry/point_cache.hpp"

#include "graph/frame_path.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <algorithm>

namespace nodes::write_mesh {

enum class Format { automatic, obj, ply, stl, glb, gltf, dae, fbx, x3d, pc2 };

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    std::filesystem::path path = "mesh.####.obj";
    Format format = Format::automatic;
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

// "2-8, 10-16, 18-24 and 21 more".
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

// Of a mesh that gets more vertices the file would keep one frame.
static void require_as_many_points(const Inputs& in, const graph::Context& context)
{
    if (!context.cook) return;
    const std::size_t points = in.mesh->positions.size();
    const std::size_t before = context.cook->first_said("points of " + in.path.string(), points);
    if (points == before) return;
    std::filesystem::path better = in.path;
    better.replace_extension(".####.obj");
    throw std::invalid_argument(
        "a pc2 holds one number of points for all frames: expected the " + std::to_string(before) +
        " vertices of the frames before, found " + std::to_string(points) +
        " (a mesh that tears gets more where Embed cuts it). Let Embed hide or stretch what is "
        "torn (torn: hide), which keeps them, or write a file a frame, parameter 'path': " +
        better.string());
}

static void warn_of_missing(const std::vector<int>& missing, const std::filesystem::path& path,
                            const graph::Context& context)
{
    if (missing.empty()) return;
    context.warn(path.string() + " lacks frames " + some_of(missing) + " of " +
                 std::to_string(context.range().first) + "-" +
                 std::to_string(context.range().last) +
                 ", which were never cooked: each holds the nearest cooked one before it, or else "
                 "the first. Cook them to fill them in");
}

// One file for all frames, in which each has its own place.
static Outputs run_cache(const Inputs& in, const graph::Context& context)
{
    const graph::FrameRange& range = context.range();
    const auto path = context.output_folder / in.path;
    if (in.path.string().find('#') != std::string::npos) {
        throw std::invalid_argument("a point cache holds all frames in one file: its path, " +
                                    in.path.string() + ", must not have a #");
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
    std::vector<int> missing;
    for (const std::uint32_t s : geometry::write_sample(path, cache, sample_of(context.frame()),
                                                        in.mesh->positions, coming)) {
        if (std::binary_search(coming.begin(), coming.end(), s)) continue;
        missing.push_back(range.first + static_cast<int>(s));
    }
    warn_of_missing(missing, path, context);
    return {{path.string(), {}, true}};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (is_cache(in)) return run_cache(in, context);
    const auto format = in.format == Format::automatic
                            ? geometry::mesh_format(in.path)
                            : static_cast<geometry::MeshFormat>(static_cast<int>(in.format) - 1);
    const auto path = graph::frame_file(in.path, context);
    const auto files =
        geometry::is_written_here(format) && !in.assimp
            ? geometry::write_mesh(path, format, *in.mesh)
            : geometry::export_mesh(path, format, *in.mesh, {}, [stop = context.stop] {
                  if (stop.stop_requested()) throw graph::Cancelled();
              });
    Outputs out{{path.string()}};
    for (const auto& file : files) out.file.beside.push_back(file.string());
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteMesh", 1, run)
        .summary("Writes a mesh a frame, or one point cache that Blender's Mesh Cache plays.")
        .input("mesh", &Inputs::mesh, "The mesh to write.")
        .path_out("path", &Inputs::path,
                  "Where it goes, below the output folder; #### stands for the frame's number with "
                  "at least as many digits. A pc2 has none, all others need it when several "
                  "frames are cooked. The materials of an OBJ go beside it: mesh.0001.mtl.")
        .choice("format", &Inputs::format,
                {"auto", "obj", "ply", "stl", "glb", "gltf", "dae", "fbx", "x3d", "pc2"},
                "The kind of file; auto goes by the path's ending. A pc2 is one file for all "
                "frames, of one number of vertices; gltf, dae (COLLADA), fbx (its form in text) "
                "and x3d are written by assimp.")
        .param("assimp", &Inputs::assimp,
               "Write obj, ply, stl and glb by assimp too. It welds vertices that coincide in a "
               "frame, drops attributes, and takes 6 to 50 times as long.",
               {}, {"format", {"auto", "obj", "ply", "stl", "glb"}})
        .reads(graph::Variable::frame | graph::Variable::range)
        .sink()
        .output("file", &Outputs::file, "The file that was written.");
}

}  // namespace nodes::write_mesh
