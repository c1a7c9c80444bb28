#pragma once

// What aspic-assimp does. What is wrong with a file is an error in what is made; memory that runs
// out is std::bad_alloc.

#include "geometry/io/assimp_messages.hpp"

#include <string>

namespace geometry::assimp {

// The mesh file at `path`. Files beside it that it names must lie below `root`, unless empty.
void read(const std::string& path, const std::string& root, ImportedScene& out);

// The binary glTF file that descriptor `input` holds, in the format that assimp calls `format`;
// files beside it are called `name`.
void write(int input, const std::string& format, const std::string& name, ExportedFiles& out);

}  // namespace geometry::assimp
