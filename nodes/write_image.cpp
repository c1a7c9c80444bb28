#include "graph/frame_path.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "render/png.hpp"

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
    render::write_png(path, *in.image);
    return {{path.string()}};
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteImage", 1, run)
        .summary("Writes a picture as a PNG file, one a frame.")
        .input("image", &Inputs::image, "The picture to write.")
        .path_out("path", &Inputs::path,
                  "Where it goes, below the output folder; #### stands for the frame's number with "
                  "at least as many digits, and is needed when several frames are cooked.")
        .reads(graph::Variable::frame)
        .sink()
        .output("file", &Outputs::file, "The file that was written.");
}

}  // namespace nodes::write_image
