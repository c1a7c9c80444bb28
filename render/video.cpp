#include "render/video.hpp"

#include "geometry/base/run_program.hpp"
#include "geometry/base/whole_file.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <system_error>

namespace render {
namespace {

// The pictures as ffmpeg's concat demuxer wants them listed: any names, in any order.
void write_list(const std::filesystem::path& list,
                const std::vector<std::filesystem::path>& pictures, double fps)
{
    std::string text = "ffconcat version 1.0\n";
    std::array<char, 64> duration{};
    std::snprintf(duration.data(), duration.size(), "duration %.9f\n", 1 / fps);
    for (const auto& picture : pictures) {
        text += "file '";
        for (const char c : std::filesystem::absolute(picture).string()) {
            text += c == '\'' ? std::string("'\\''") : std::string(1, c);
        }
        text += "'\n";
        text += duration.data();
    }
    geometry::write_whole_file(list, text);
}

// Takes a file away at the end, whatever happens.
struct Temporary {
    std::filesystem::path path;
    ~Temporary()
    {
        std::error_code ignored;
        std::filesystem::remove(path, ignored);
    }
};

// What ffmpeg is to do: H.264 of even width and height, its colours named for players.
std::vector<std::string> ffmpeg_words(const std::filesystem::path& list,
                                      const std::filesystem::path& to, std::size_t frames,
                                      double fps, int quality)
{
    std::array<char, 32> rate{};
    std::snprintf(rate.data(), rate.size(), "%.9g", fps);
    // clang-format off
    return {"ffmpeg", "-hide_banner", "-loglevel", "error", "-nostdin", "-y",
            "-f", "concat", "-safe", "0", "-i", list.string(),
            // What is said of the colours below must also be done to them: without a matrix named
            // here, scale takes BT.601's.
            // Of an odd size the last column or row is left out: scaled, all pixels would be blurred.
            "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=out_color_matrix=bt709:out_range=tv",
            "-r", rate.data(), "-frames:v", std::to_string(frames),
            "-c:v", "libx264", "-preset", "veryfast", "-crf", std::to_string(quality),
            "-pix_fmt", "yuv420p", "-color_range", "tv", "-colorspace", "bt709", "-color_primaries", "bt709",
            "-color_trc", "iec61966-2-1", "-movflags", "+faststart", to.string()};
    // clang-format on
}

// Thrown while ffmpeg runs, to end it.
struct Stopped {};

}  // namespace

bool write_video(const std::filesystem::path& path,
                 const std::vector<std::filesystem::path>& pictures, double fps, int quality,
                 const std::stop_token& stop)
{
    if (pictures.empty()) throw std::invalid_argument("a video needs at least one picture");
    if (!(fps > 0 && fps <= 1000)) {
        throw std::invalid_argument("frames per second of a video: expected more than 0 and at "
                                    "most 1000, found " +
                                    std::to_string(fps));
    }
    std::error_code error;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
    if (error) {
        throw std::runtime_error("could not write " + path.string() + ": " + error.message());
    }
    std::string mine = ".aspic-";  // see runtime/commands/leftovers.hpp
    mine += std::to_string(::getpid());
    const Temporary list{path.string() + mine + ".frames"};
    const Temporary part{path.parent_path() /
                         (path.stem().string() + mine + ".part" + path.extension().string())};
    write_list(list.path, pictures, fps);

    geometry::ProgramCall ffmpeg;
    ffmpeg.words = ffmpeg_words(list.path, part.path, pictures.size(), fps, quality);
    geometry::ProgramRun run;
    try {
        run = geometry::run_program(ffmpeg, [&] {
            if (stop.stop_requested()) throw Stopped();
        });
    } catch (const Stopped&) {
        return false;
    }
    if (!run.found) return false;
    if (!WIFEXITED(run.status) || WEXITSTATUS(run.status) != 0) {
        std::string said = run.said;
        while (!said.empty() && said.back() == '\n') said.pop_back();
        throw std::runtime_error("ffmpeg failed on " + path.string() + ": " +
                                 (said.empty() ? "it gave no reason" : said));
    }
    std::filesystem::rename(part.path, path, error);
    if (error) {
        throw std::runtime_error("could not write " + path.string() + ": " + error.message());
    }
    return true;
}

}  // namespace render
