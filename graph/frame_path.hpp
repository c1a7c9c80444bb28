#pragma once

#include <filesystem>
#include <string>

namespace graph {

// `pattern` with the first run of # in its file name replaced by the number of the frame, filled
// up with zeros to the run's length: ("frames/####.png", 7) gives "frames/0007.png". Without a #
// the pattern itself.
std::filesystem::path frame_path(const std::filesystem::path& pattern, int frame);

// The same for any text that is to show the number of the frame.
std::string frame_text(std::string pattern, int frame);

}  // namespace graph
