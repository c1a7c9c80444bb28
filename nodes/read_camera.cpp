#include "geometry/io/read_camera.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"

#include <cmath>

namespace nodes::read_camera {

struct Inputs {
    std::filesystem::path path;
    std::string name;
    double start = 0;
    geometry::LengthUnit unit = geometry::LengthUnit::automatic;
    double custom_unit = 1;
    geometry::UpAxis up = geometry::UpAxis::automatic;
};
struct Outputs {
    ::render::Camera camera;
};

constexpr const char* no_path = "expected the path of a file with a camera, found none";
constexpr double usual_aspect = 16.0 / 9;

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    return in.path.empty() ? graph::Faults{{"path", no_path}} : graph::Faults{};
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    if (in.path.empty()) throw std::invalid_argument(no_path);
    geometry::ReadOptions o;
    o.import.root = context.root;
    o.import.check = [stop = context.stop] {
        if (stop.stop_requested()) throw graph::Cancelled();
    };
    o.unit = in.unit;
    o.custom_unit = in.custom_unit;
    o.up = in.up;
    const auto read =
        geometry::read_camera(in.path, in.name, in.start + context.time(), usual_aspect, o);
    for (const auto& file : read.side_files) context.opened(file);
    ::render::Camera camera{read.eye, read.eye + read.ahead, read.up, read.angle};
    if (read.height > 0) {
        camera.field_of_view = 2 * std::atan(0.5 * read.height);
        camera = ::render::parallel_from(camera);
    }
    return {camera};
}

void add_to(graph::Registry& registry)
{
    registry.add("ReadCamera", 1, run)
        .summary("Reads a camera and its motion from a file of a modelling program.",
                 {"camera", "import", "gltf", "fbx", "collada", "shot", "view"})
        .path_in("path", &Inputs::path,
                 "The file: glTF, FBX, COLLADA or another that assimp reads. It is read anew for "
                 "each frame: export the camera alone, its motion baked to a key a frame. Keys "
                 "between which the file steps or curves are joined straight; of several "
                 "animations the first that moves the camera counts, and of FBX perspective "
                 "cameras only.")
        .param("name", &Inputs::name, "Name of the camera; empty: the first of the file.")
        .param("start", &Inputs::start,
               "Time of the file at the first frame of the graph. Blender's glTF begins at frame "
               "0, so that its frame 1 is at 1/24.",
               {-1e6, 1e6, "s"})
        .choice("unit", &Inputs::unit, {"auto", "m", "cm", "mm", "inch", "foot", "custom"},
                "Unit of length of the file. auto: the unit that the file states, or else metres.")
        .param("custom_unit", &Inputs::custom_unit, "Length of the file's unit.",
               {.min = 1e-12, .max = 1e12, .unit = "m"}, {"unit", {"custom"}})
        .choice("up", &Inputs::up, {"auto", "y", "z", "x"},
                "Axis of the file that points up. auto: the axis that the file states, or else y.")
        .check(check)
        .reads(graph::Variable::frame)
        .output("camera", &Outputs::camera,
                "The camera at this frame, for `view` of Render. It keeps the height of the "
                "file's picture; where the file says no shape, that of 16:9.");
}

}  // namespace nodes::read_camera
