#pragma once

// Functions of the drawing library that the program's own commands need: `aspic doctor` checks
// OpenGL with opengl(), `aspic sweep` and `aspic study` write picture sheets with write_sheet().
// `aspic study` draws its plot and `aspic farm` runs its tasks with run_program(). runtime/main.cpp
// passes them on, because runtime/ does not see render/ and geometry/.

#include "geometry/base/run_program.hpp"
#include "geometry/io/library_process.hpp"
#include "nodes/wire_types.hpp"
#include "render/contact_sheet.hpp"
#include "render/gl_context.hpp"
#include "render/png.hpp"

#include <sys/wait.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace nodes {

// The version of OpenGL that pictures are drawn with. Throws std::runtime_error if it is missing or
// too old.
inline std::string opengl()
{
    return render::gl_version();
}

// Mesa fills pictures with a thread for each core of the machine beside the one that draws. It
// takes another number from the environment, where the user's own comes first; 0: the thread that
// draws. The pictures are the same.
inline void limit_libraries(int threads)
{
    ::setenv("LP_NUM_THREADS", std::to_string(threads > 1 ? threads : 0).c_str(), 0);
}

// Libraries that are loaded when a node first needs them.
inline constexpr std::array late_libraries{render::opengl_library};

// Programs that nodes run to read and write files, as far as they are installed.
inline std::vector<std::filesystem::path> file_programs()
{
    std::vector<std::filesystem::path> paths;
    for (const auto& program : {geometry::assimp_program, geometry::openvdb_program}) {
        const std::filesystem::path path = geometry::path_of(program);
        if (!path.empty()) paths.push_back(path);
    }
    return paths;
}

// Writes pictures with their labels side by side as one PNG and returns their number. Values that
// are not pictures are skipped.
inline std::size_t write_sheet(const std::vector<std::pair<graph::Value, std::string>>& pictures,
                               int columns, const std::filesystem::path& path)
{
    std::vector<graph::Wire<render::Image>> images;
    std::vector<render::Tile> tiles;
    for (const auto& [value, label] : pictures) {
        if (!value || *value.type()->type != typeid(render::Image)) continue;
        images.push_back(value.as<render::Image>());
        tiles.push_back({images.back().get(), label});
    }
    if (!tiles.empty()) render::write_png(path, render::contact_sheet(tiles, columns, 1600));
    return tiles.size();
}

// Runs a program without a shell and waits for its end, or kills it when it is to stop; what it
// prints is not shown. Its exit status; 128 and the signal's number of one that a signal ended, -1
// of one that is not there.
inline int run_program(const std::vector<std::string>& words, const std::stop_token& stop)
{
    struct Stopped {};
    geometry::ProgramCall call;
    call.words = words;
    geometry::ProgramRun run;
    try {
        run = geometry::run_program(call, [&stop] {
            if (stop.stop_requested()) throw Stopped();
        });
    } catch (const Stopped&) {
        return 128 + SIGKILL;
    }
    if (!run.found) return -1;
    return WIFEXITED(run.status) ? WEXITSTATUS(run.status) : 128 + WTERMSIG(run.status);
}

}  // namespace nodes
