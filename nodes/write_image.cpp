#include "graph/document/frame_path.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"
#include "render/exr.hpp"
#include "render/png.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace nodes::write_image {

struct Inputs {
    graph::Wire<render::Image> image;
    std::filesystem::path path = "frames/####.png";
};
struct Outputs {
    graph::WrittenFile file;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const auto path = graph::frame_file(in.path, context);
    if (has_ending(path, ".exr")) {
        render::write_exr(path, *in.image);
    } else {
        render::write_png(path, *in.image);
    }
    return {{path.string()}};
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults = wrong_path(in.path, {".png", ".exr"}, setting.frames);
    if (!has_ending(in.path, ".exr")) return faults;
    for (const graph::LinkedNode& source : setting.sources) {
        const bool drawn = source.type->name == "Render";
        if (drawn && source.text("linear") != "none") continue;
        if (!drawn && source.type->name != "ContactSheet") continue;
        faults.push_back(
            {"path",
             fmt::format("an .exr file holds linear light, and the picture of '{}' has "
                         "none: {}end the path in .png",
                         source.node, drawn ? "set its 'linear' to whole or cut_out, or " : "")});
    }
    return faults;
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteImage", 1, run)
        .summary("Writes a picture as a PNG or EXR file per frame.",
                 {"png", "exr", "openexr", "linear", "save picture", "export image", "image"})
        .input("image", &Inputs::image, "The picture to write.")
        .path_out("path", &Inputs::path,
                  "Path of the file, below the output folder. #### stands for the frame number, "
                  "with at least as many digits; it is required if several frames are cooked. One "
                  "that ends in .exr has the linear light of the picture, for which `linear` of "
                  "Render has to ask: half-float RGBA, premultiplied, and the depth Z of the "
                  "nearest opaque "
                  "thing in metres; with a parallel camera only its differences count.")
        .reads(graph::Variable::frame)
        .check(check)
        .sink()
        .output("file", &Outputs::file, "The written file.");
}

}  // namespace nodes::write_image
