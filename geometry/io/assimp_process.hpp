#pragma once

// assimp runs in a process of its own, aspic-assimp, under limits of memory and time: some damaged
// files make it abort, crash, allocate or loop without end, and then only that process is lost. And
// this program starts without loading it.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace geometry {

struct ProcessLimits {
    double seconds = 120;
    double gigabytes = 8;  // of that process, 2^30 bytes each
};

// How the process ended.
struct AssimpRun {
    enum class End { fine, out_of_memory, out_of_time, crashed, gave_up, not_understood };
    End end = End::fine;
    std::string said;  // the last line of what it said, and of a crash, the signal
};

// Runs aspic-assimp with `words` and the limits as its arguments and `input` to read, and hands
// what it made to `use`; a std::runtime_error of that means that it is not understood. `check` is
// called now and then while waiting; what it throws ends the process. Throws std::runtime_error
// when aspic-assimp is missing or cannot be started: it is looked for at $ASPIC_ASSIMP, beside the
// running program, and one folder above it.
AssimpRun run_assimp(std::vector<std::string> words, std::string_view input,
                     const ProcessLimits& limits, const std::function<void()>& check,
                     const std::function<void(const char* bytes, std::size_t size)>& use);

// A number as messages give it.
std::string shorter(double number);

}  // namespace geometry
