#pragma once

// What a killed cook left in an output folder: files that were being written.

#include <filesystem>
#include <string>

namespace runtime {

// Removes files that have the name of an unfinished one and whose process is gone. Call it with the
// folder locked. Never throws.
void remove_leftovers(const std::filesystem::path& folder);

// The process whose number stands in the name of an unfinished file; 0 when it is no such name.
//   video.PID.part.mp4   video.mp4.PID.frames   a.png.PID.part   a.obj.PID-N.part   a.json.PID.N~
int process_of_unfinished(const std::string& name);

}  // namespace runtime
