#pragma once

// What our own files say of their unit and axis, where the format has no field for these: a comment
// of OBJ and PLY, the 80 bytes of STL. "Aspic: millimetres, z up".

#include <optional>
#include <string>
#include <string_view>

namespace geometry {

struct FileFrame {
    double unit = 1;  // m
    bool z_up = false;
};

std::string own_header(const FileFrame& frame);

// Of the first bytes of a file; nothing where it is none of ours.
std::optional<FileFrame> frame_of_header(std::string_view bytes);

}  // namespace geometry
