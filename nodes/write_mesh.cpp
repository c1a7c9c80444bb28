#include "geometry/export_mesh.hpp"

#include "graph/frame_path.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

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

// One file for all frames, in which each has its own place.
static Outputs run_cache(const Inputs& in, const graph::Context& context)
{
    const graph::FrameRange& range = context.range();
    const auto path = context.output_folder / in.path;
    if (in.path.string().find('#') != std::string::npos) {
        throw std::invalid_argument("a point cache holds all frames in one file: its path, " +
                                    in.path.string() + ", must not have a #");
    }
    const geometry::PointCache cache{static_cast<std::uint32_t>(in.mesh->positions.size()),
                                     float(range.first), 1,
                                     static_cast<std::uint32_t>(range.count())};
    const bool anew = geometry::write_sample(
        path, cache, static_cast<std::uint32_t>(context.frame() - range.first), in.mesh->positions);
    if (anew) {
        context.warn(
            "began " + path.string() + " anew at frame " + std::to_string(context.frame()) +
            ": it was of another number of points or other frames. (A mesh that tears gets "
            "more points from frame to frame where Embed cuts it; let Embed hide what is "
            "torn.)");
    }
    return {{path.string(), {}, true}};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (is_cache(in)) return run_cache(in, context);
    const auto format = in.format == Format::automatic
                            ? geometry::mesh_format(in.path)
                            : static_cast<geometry::MeshFormat>(static_cast<int>(in.format) - 1);
    const auto path = context.output_folder / graph::frame_path(in.path, context.frame());
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
                  "at least as many digits. The materials of an OBJ go beside it: mesh.0001.mtl.")
        .choice(
            "format", &Inputs::format,
            {"auto", "obj", "ply", "stl", "glb", "gltf", "dae", "fbx", "x3d", "pc2"},
            "The kind of file; auto goes by the path's ending. A pc2 is one file for all "
            "frames; gltf, dae (COLLADA), fbx (its form in text) and x3d are written by assimp.")
        .param("assimp", &Inputs::assimp,
               "Write obj, ply, stl and glb by assimp too. It welds vertices that coincide in a "
               "frame, drops attributes, and takes 6 to 50 times as long.",
               {}, {"format", {"auto", "obj", "ply", "stl", "glb"}})
        .reads(graph::Variable::frame | graph::Variable::range)
        .sink()
        .output("file", &Outputs::file, "The file that was written.");
}

}  // namespace nodes::write_mesh
