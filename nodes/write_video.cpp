#include "graph/document/frame_path.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "nodes/written_path.hpp"
#include "render/video.hpp"

#include <fmt/format.h>

#include <stdexcept>

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

// A video of fewer frames than the document has does not replace that of all: "video.3-8.mp4".
static std::filesystem::path named_by_frames(const Inputs& in, const graph::Context& context)
{
    const std::vector<int>& frames = context.gathered;
    if (frames.empty() || frames == every_frame(in, context.range())) return in.path;
    const int first = frames.front(), last = frames.back();
    const std::string held =
        first == last ? fmt::format(".{}", first) : fmt::format(".{}-{}", first, last);
    const std::string name = in.path.stem().string() + held + in.path.extension().string();
    return in.path.parent_path() / name;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    std::vector<std::filesystem::path> pictures;
    for (const auto& frame : in.frames) {
        pictures.emplace_back(frame->path);
        if (has_ending(pictures.back(), ".png")) continue;
        throw std::invalid_argument("a video takes PNG files, found " +
                                    pictures.back().filename().string() +
                                    ": link a WriteImage whose path ends in .png");
    }
    const auto path = context.output_folder / named_by_frames(in, context);
    if (!render::write_video(path, pictures, context.fps(), in.quality, context.stop)) {
        if (context.stop.stop_requested()) throw graph::Cancelled();
        context.warn("no video was made, as the program ffmpeg was not found: install the Debian "
                     "package ffmpeg and cook again; the pictures are there");
        return {};
    }
    return {{path.string()}};
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    graph::Faults faults = wrong_path(in.path, {".mp4", ".m4v", ".mov", ".mkv"}, 1);
    for (const graph::LinkedNode& source : setting.sources) {
        if (source.type->name != "WriteImage" || !has_ending(source.text("path"), ".exr")) continue;
        faults.push_back({"frames", fmt::format("a video takes PNG files, and '{}' writes EXR: "
                                                "link a WriteImage whose path ends in .png",
                                                source.node)});
    }
    return faults;
}

void add_to(graph::Registry& registry)
{
    registry.add("WriteVideo", 1, run)
        .summary("Encodes the pictures of WriteImage as a video, with ffmpeg.",
                 {"video", "movie", "mp4", "ffmpeg", "animation"})
        .gather(
            "frames", &Inputs::frames, every_frame,
            "The picture files of all frames: `file` of a WriteImage. Of an odd width or height "
            "the last column or row is left out, as H.264 needs even ones.")
        .path_out("path", &Inputs::path,
                  "Path of the file, below the output folder: H.264 in an .mp4, .m4v, .mov or "
                  ".mkv. A cook of some of the document's frames leaves that file as it is, and "
                  "writes one that is named by its first and last frame: video.3-8.mp4.")
        .param("quality", &Inputs::quality,
               "Constant rate factor of H.264: 0 is lossless, 18 looks lossless, and each 6 more "
               "halve the file size.",
               {0, 51})
        .check(check)
        .reads(graph::Variable::fps | graph::Variable::range)
        .sink()
        .output("file", &Outputs::file, "The video; empty if ffmpeg is missing.");
}

}  // namespace nodes::write_video
