#include "geometry/base/whole_file.hpp"
#include "graph/document/frame_path.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"
#include "physics/layered_bodies/scene_record.hpp"

namespace nodes::write_scene {

struct Inputs {
    graph::Wire<physics::LayeredScene> scene;
    std::filesystem::path path = "scene.####.layers";
};
struct Outputs {
    graph::WrittenFile file;
};

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    return wrong_path(in.path, {}, setting.frames);
}

// What the names of all frames' files begin with: "walk" of walk.####.layers.
static std::string stem_of(const std::filesystem::path& path)
{
    const std::string name = path.filename().string();
    const std::string stem = name.substr(0, name.find_first_of(".#"));
    return stem.empty() ? "scene" : stem;
}

// What is written lies below the output folder, and no link may lead it elsewhere.
static void refuse_link(const std::filesystem::path& path)
{
    if (!std::filesystem::is_symlink(path)) return;
    throw std::runtime_error(path.string() +
                             " leads elsewhere by a symbolic link; remove the link, "
                             "or use --out DIR");
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const auto path = graph::frame_file(in.path, context);
    const physics::SceneRecord record = physics::record(*in.scene, stem_of(in.path));
    Outputs out{{path.string()}};
    refuse_link(path.parent_path() / (stem_of(in.path) + ".bodies"));
    for (const auto& [name, bytes] : record.bodies) {
        const auto file = path.parent_path() / name;
        refuse_link(file);
        if (geometry::read_whole_file(file) != bytes) geometry::write_whole_file(file, bytes);
        out.file.beside.push_back(file.string());
    }
    geometry::write_whole_file(path, record.frame);
    return out;
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteScene", 1, run)
        .summary("Writes a Layered scene as a small file per frame, from which ReadScene makes the "
                 "same pictures and surfaces without simulating.",
                 {"export", "cache", "filecache", "record", "implicit"})
        .input("scene", &Inputs::scene, "The scene at this frame, from Layered.")
        .path_out(
            "path", &Inputs::path,
            "Path of the file, below the output folder. #### stands for the frame number. The "
            "bodies are written once, into the folder scene.bodies beside the frames. Copy both "
            "together.")
        .check(check)
        .reads(graph::Variable::frame | graph::Variable::range)
        .sink()
        .output("file", &Outputs::file, "The written file.");
}

}  // namespace nodes::write_scene
