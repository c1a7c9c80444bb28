#include "render/contact_sheet.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"
#include "render/png.hpp"

#include <cstdio>

namespace nodes::contact_sheet {

struct Inputs {
    std::vector<graph::Wire<render::Image>> image;
    int count = 12, columns = 4, width = 1600;
    std::filesystem::path path = "contact_sheet.png";
};
struct Outputs {
    render::Image image;
    graph::WrittenFile file;
};

static std::vector<int> some_frames(const Inputs& in, const graph::FrameRange& range)
{
    return render::spread_frames(range.first, range.last, in.count);
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const std::vector<int>& frames = context.gathered;
    std::vector<render::Tile> tiles;
    for (std::size_t i = 0; i < in.image.size(); ++i) {
        if (i > 0 && frames[i] == frames[i - 1]) continue;  // stands for one that was not cooked
        std::array<char, 64> label{};
        std::snprintf(label.data(), label.size(), "frame %d   %.2f s", frames[i],
                      context.range().time(frames[i]));
        tiles.push_back({in.image[i].get(), label.data()});
    }
    const auto path = context.output_folder / in.path;
    Outputs out{render::contact_sheet(tiles, in.columns, in.width), {path.string()}};
    render::write_png(path, out.image);
    return out;
}

static graph::Faults check(const Inputs& in, const graph::Setting&)
{
    return wrong_path(in.path, {".png"}, 1);
}

void add_to(graph::Registry& registry)
{
    registry.add("ContactSheet", 1, run)
        .summary("Writes the pictures of evenly spaced frames side by side into one PNG file.",
                 {"montage", "thumbnails", "overview"})
        .gather("image", &Inputs::image, some_frames, "The picture, read at the chosen frames.")
        .param("count", &Inputs::count, "Number of frames, including the first and the last.",
               {1, 1000})
        .param("columns", &Inputs::columns, "Number of pictures in a row.", {1, 100})
        .param("width", &Inputs::width, "Width of the sheet.", {64, 8192, "px"})
        .path_out("path", &Inputs::path, "Path of the file, below the output folder.")
        .reads(graph::Variable::range)
        .check(check)
        .sink()
        .output("image", &Outputs::image, "The sheet.")
        .output("file", &Outputs::file, "The written file.");
}

}  // namespace nodes::contact_sheet
