#pragma once

// What a killed cook left in an output folder: files that were being written.

#include <filesystem>
#include <string>

namespace runtime {

// Removes files that have the name of an unfinished one and whose process is gone. Call it with the
// folder locked. Never throws.
void remove_leftovers(const std::filesystem::path& folder);

// The process whose number stands in the name of an unfinished file; 0 when it is no such name. All
// of these names have the mark .aspic-PID, as the folder may hold files of its user, too:
//   video.aspic-PID.part.mp4   video.mp4.aspic-PID.frames   render/video.cpp
//   a.obj.aspic-PID-N.part                                  geometry/base/whole_file.cpp
//   a.json.aspic-PID-N~                                     runtime/cache/whole_file.cpp
int process_of_unfinished(const std::string& name);

}  // namespace runtime
