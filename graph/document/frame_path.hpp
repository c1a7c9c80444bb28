#pragma once

// File names with a frame number in them: "walk.####.obj" and "frames/####.png".

#include "graph/types/context.hpp"

namespace graph {

// `pattern` with the first run of # in its file name replaced by the number of the frame, filled
// up with zeros to the run's length: ("frames/####.png", 7) gives "frames/0007.png". Without a #
// the pattern itself.
std::filesystem::path frame_path(const std::filesystem::path& pattern, int frame);

// A sentence where a cook of so many frames would write one over the other, as the file name has no
// #; else empty.
std::string why_one_file(const std::filesystem::path& pattern, std::size_t frames);

// The path of the file that a sink writes at this frame, below the output folder. Throws
// std::invalid_argument when frames of one cook would write over each other for want of a #.
std::filesystem::path frame_file(const std::filesystem::path& pattern, const Context& context);

// The frames of which there are files; none when the folder can't be read. In order.
std::vector<int> frames_on_disk(const std::filesystem::path& pattern);

// The same as frame_path() for any text that is to show the number of the frame.
std::string frame_text(std::string pattern, int frame);

}  // namespace graph
