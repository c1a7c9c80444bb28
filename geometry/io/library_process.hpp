#pragma once

// Libraries that read and write files of many formats run in processes of their own, under limits
// of memory and time: assimp in aspic-assimp, OpenVDB in aspic-openvdb. Some damaged files make
// them abort, crash, allocate or loop without end, and then only that process is lost. And this
// program starts without loading them.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace geometry {

struct ProcessLimits {
    double seconds = 120;
    double gigabytes = 8;  // of that process, 2^30 bytes each
};

// A program that runs a library. It is looked for where the environment variable says, beside the
// running program, one folder above it, and in ../libexec/aspic.
struct LibraryProgram {
    const char* name;
    const char* variable;
    const char* does;     // "the program that ..."
    const char* missing;  // what to do where it is not there
};

inline constexpr LibraryProgram assimp_program{"aspic-assimp", "ASPIC_ASSIMP",
                                               "the program that reads and writes mesh files",
                                               "build it there, or set ASPIC_ASSIMP to its path"};

inline constexpr LibraryProgram openvdb_program{
    "aspic-openvdb", "ASPIC_OPENVDB", "the program that reads VDB files",
    "builds that do not find OpenVDB have none. Install libopenvdb-dev and libboost-iostreams-dev, "
    "then configure and build again, or set ASPIC_OPENVDB to its path"};

// Where it is, and empty where it is not there. What the variable names is taken as it is.
std::filesystem::path path_of(const LibraryProgram& program);

// How the process ended.
struct LibraryRun {
    enum class End { fine, out_of_memory, out_of_time, crashed, gave_up, not_understood };
    End end = End::fine;
    std::string said;  // the last line of what it said, and of a crash, the signal
};

// Runs `program` with `words` and the limits as its arguments and `input` to read, and hands what
// it made to `use`; a std::runtime_error of that means that it is not understood. `check` is called
// now and then while waiting; what it throws ends the process. Throws std::runtime_error when the
// program is missing or cannot be started.
LibraryRun run_library(const LibraryProgram& program, std::vector<std::string> words,
                       std::string_view input, const ProcessLimits& limits,
                       const std::function<void()>& check,
                       const std::function<void(const char* bytes, std::size_t size)>& use);

// What run_library() would throw where the program is not there; else empty.
std::string why_missing(const LibraryProgram& program);

// A number as messages give it.
std::string shorter(double number);

}  // namespace geometry
