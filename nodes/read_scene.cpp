#include "geometry/base/whole_file.hpp"
#include "graph/document/path_rules.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/layered_bodies/scene_record.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace nodes::read_scene {

struct Inputs {
    std::filesystem::path path;
};
struct Outputs {
    physics::LayeredScene scene;
};

constexpr const char* no_path = "expected the path of a file of WriteScene, found none";

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    return in.path.empty() ? graph::Faults{{"path", no_path}} : graph::Faults{};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.path.empty()) throw std::invalid_argument(no_path);
    const auto frame = geometry::read_whole_file(in.path);
    if (!frame) throw std::runtime_error(in.path.string() + " cannot be read");
    try {
        std::vector<std::string> bodies;
        for (const std::string& name : physics::bodies_of_record(*frame)) {
            const auto file = in.path.parent_path() / name;
            context.opened(file);
            const auto real = std::filesystem::weakly_canonical(file);
            if (!context.root.empty() && !graph::lies_in(real, context.root)) {
                throw std::runtime_error(fmt::format(
                    "its body {} lies outside the folder of the graph, by a symbolic link: remove "
                    "the link, or use --allow-outside",
                    file.string()));
            }
            auto bytes = geometry::read_whole_file(file);
            if (!bytes) {
                throw std::runtime_error(fmt::format(
                    "expected a body in {}, found no such file: copy the folder of bodies together "
                    "with the frames",
                    file.string()));
            }
            bodies.push_back(std::move(*bytes));
        }
        return {physics::read_record(*frame, bodies)};
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(in.path.string() + ": " + error.what());
    }
}

void add_to(graph::Registry& registry)
{
    registry.add("ReadScene", 1, run)
        .summary("Reads a scene that WriteScene wrote, to draw and mesh it without simulating.",
                 {"import", "cache", "filecache", "record", "implicit", "playback"})
        .path_in("path", &Inputs::path,
                 "The file; #### stands for the frame number. The folder of bodies that it names "
                 "lies beside it.")
        .check(check)
        .output("scene", &Outputs::scene,
                "The scene, for Render, Polygonize and Skin, which give the same bytes as in the "
                "live cook. It holds no cubes for Carried.");
}

}  // namespace nodes::read_scene
