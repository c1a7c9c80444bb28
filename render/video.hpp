#pragma once

// Videos made of picture files by the program ffmpeg.

#include <filesystem>
#include <stop_token>
#include <vector>

namespace render {

// Makes a video (H.264, yuv420p, even width and height) of picture files of one size, shown in the
// order given at `fps` frames a second. The file appears whole or not at all. False when `stop` was
// set meanwhile, or when the program ffmpeg is not found. Throws std::runtime_error with ffmpeg's
// own words when it fails, std::invalid_argument without pictures or with an odd rate.
bool write_video(const std::filesystem::path& path,
                 const std::vector<std::filesystem::path>& pictures, double fps, int quality,
                 const std::stop_token& stop = {});

}  // namespace render
