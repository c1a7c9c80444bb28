#include "render/video.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace render {
namespace {

struct Outcome {
    bool found = true;
    int status = 0;      // as the program exited; -1 when a signal ended it
    std::string errors;  // what it said
};

// Ends a file descriptor's life.
struct Descriptor {
    int is = -1;
    ~Descriptor()
    {
        if (is >= 0) ::close(is);
    }
};

// Runs a program of the PATH without a shell, its standard output thrown away.
Outcome run_program(const std::vector<std::string>& words, const std::stop_token& stop)
{
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
        throw std::system_error(errno, std::generic_category(), "pipe");
    }
    const Descriptor listening{ends[0]};
    Descriptor speaking{ends[1]};

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, speaking.is, 2);
    std::vector<char*> argv;
    for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    pid_t child = 0;
    const int failed = posix_spawnp(&child, argv[0], &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed == ENOENT) return {false, 0, {}};
    if (failed != 0) throw std::system_error(failed, std::generic_category(), words[0]);
    ::close(speaking.is);
    speaking.is = -1;

    Outcome outcome;
    std::array<char, 4096> text{};
    bool ended = false;
    while (true) {
        pollfd listen{listening.is, POLLIN, 0};
        if (::poll(&listen, 1, 100) > 0) {
            const ssize_t count = ::read(listening.is, text.data(), text.size());
            if (count == 0) break;
            if (count > 0) outcome.errors.append(text.data(), std::size_t(count));
        }
        if (stop.stop_requested() && !ended) {
            ::kill(child, SIGTERM);
            ended = true;
        }
    }
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return outcome;
}

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
    std::FILE* file = std::fopen(list.c_str(), "wb");
    if (!file)
        throw std::runtime_error("cannot write " + list.string() + ": " + std::strerror(errno));
    const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
    if (std::fclose(file) != 0 || !written) {
        throw std::runtime_error("cannot write " + list.string() + ": " + std::strerror(errno));
    }
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

}  // namespace

bool write_video(const std::filesystem::path& path,
                 const std::vector<std::filesystem::path>& pictures, double fps, int quality,
                 const std::stop_token& stop)
{
    if (pictures.empty()) throw std::invalid_argument("a video needs at least one picture");
    if (!(fps > 0 && fps <= 1000)) {
        throw std::invalid_argument("a video needs more than 0 and at most 1000 frames a second, "
                                    "got " +
                                    std::to_string(fps));
    }
    std::error_code error;
    if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
    if (error) {
        throw std::runtime_error("cannot write " + path.string() + ": " + error.message());
    }
    std::string mine(1, '.');
    mine += std::to_string(::getpid());
    const Temporary list{path.string() + mine + ".frames"};
    const Temporary part{path.parent_path() /
                         (path.stem().string() + mine + ".part" + path.extension().string())};
    write_list(list.path, pictures, fps);

    std::array<char, 32> rate{};
    std::snprintf(rate.data(), rate.size(), "%.9g", fps);
    const Outcome outcome = run_program({"ffmpeg",
                                         "-hide_banner",
                                         "-loglevel",
                                         "error",
                                         "-nostdin",
                                         "-y",
                                         "-f",
                                         "concat",
                                         "-safe",
                                         "0",
                                         "-i",
                                         list.path.string(),
                                         "-vf",
                                         "scale=trunc(iw/2)*2:trunc(ih/2)*2:flags=lanczos",
                                         "-r",
                                         rate.data(),
                                         "-frames:v",
                                         std::to_string(pictures.size()),
                                         "-c:v",
                                         "libx264",
                                         "-preset",
                                         "veryfast",
                                         "-crf",
                                         std::to_string(quality),
                                         "-pix_fmt",
                                         "yuv420p",
                                         "-colorspace",
                                         "bt709",
                                         "-color_primaries",
                                         "bt709",
                                         "-color_trc",
                                         "iec61966-2-1",
                                         "-movflags",
                                         "+faststart",
                                         part.path.string()},
                                        stop);
    if (!outcome.found || stop.stop_requested()) return false;
    if (outcome.status != 0) {
        std::string said = outcome.errors;
        while (!said.empty() && said.back() == '\n') said.pop_back();
        throw std::runtime_error("ffmpeg could not make " + path.string() + ": " +
                                 (said.empty() ? "it did not say why" : said));
    }
    std::filesystem::rename(part.path, path, error);
    if (error) throw std::runtime_error("cannot write " + path.string() + ": " + error.message());
    return true;
}

}  // namespace render
