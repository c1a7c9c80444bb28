#include "graph/frame_path.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "render/video.hpp"

namespace nodes::write_video {

struct Inputs {
    std::vector<graph::Wire<graph::WrittenFile>> frames;
    std::filesystem::path path = "video.mp4";
    int quality = 18;
};
struct Outputs {
    graph::WrittenFile file;
};

static std::vector<int> every_frame(const Inputs&, const graph::FrameRange& range)
{
    std::vector<int> frames;
    for (int f = range.first; f <= range.last; ++f) frames.push_back(f);
    return frames;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    std::vector<std::filesystem::path> pictures;
    for (const auto& frame : in.frames) pictures.emplace_back(frame->path);
    const auto path = context.output_folder / in.path;
    if (!render::write_video(path, pictures, context.fps(), in.quality, context.stop)) {
        if (context.stop.stop_requested()) throw graph::Cancelled();
        context.warn("no video was made, as the program ffmpeg was not found: install the Debian "
                     "package ffmpeg and cook again; the pictures are there");
        return {};
    }
    return {{path.string()}};
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteVideo", 1, run)
        .summary("Makes a video of the pictures that WriteImage wrote, with ffmpeg.")
        .gather("frames", &Inputs::frames, every_frame,
                "The picture of every frame: `file` of a WriteImage.")
        .path_out("path", &Inputs::path,
                  "Where it goes, below the output folder: H.264 in an .mp4, .mov or .mkv.")
        .param("quality", &Inputs::quality,
               "H.264's constant rate factor: 0 keeps everything, 18 looks the same to the eye, "
               "each 6 more halve the file.",
               {0, 51})
        .reads(graph::Variable::fps | graph::Variable::range)
        .sink()
        .output("file", &Outputs::file, "The video; empty when there is no ffmpeg.");
}

}  // namespace nodes::write_video
