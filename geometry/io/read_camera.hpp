#pragma once

// Cameras of the files that assimp reads: glTF, FBX, COLLADA and others.

#include "geometry/io/read_options.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace geometry {

// In metres, y up, as it stands at one time.
struct FileCamera {
    std::string name;
    Vec3 eye = Vec3::Zero(), ahead{0, 0, -1}, up{0, 1, 0};  // m; unit, unit
    double angle = 0;   // rad, of the picture's height; 0: it is parallel
    double height = 0;  // m, of the picture where it is parallel
    std::vector<std::filesystem::path> side_files;  // others that were opened or looked for
};

// The camera `name` of the file, or its first where that is empty, `time` seconds after the file's
// start. Before and after its motion it stands still. Of `options` the unit, the axis and the
// limits count. `aspect` (width / height) is that of pictures of files that say none. Throws
// std::runtime_error for files that cannot be read, that have no camera or none of that name.
FileCamera read_camera(const std::filesystem::path& path, const std::string& name, double time,
                       double aspect, const ReadOptions& options);

}  // namespace geometry
