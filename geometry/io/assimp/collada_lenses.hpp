#pragma once

// What COLLADA says of the angle of view of cameras, which assimp 5.2 loses in part: of a height
// alone nothing is left, a width and a height together give a wrong aspect, parallel cameras are
// told as others, and those without a name have none.

#include "geometry/io/assimp_messages.hpp"

#include <string>
#include <vector>

namespace geometry::assimp {

// 0: not said.
struct ColladaLens {
    bool parallel = false;
    double width = 0, height = 0;  // degrees; of a parallel one half the picture, in its unit
    double aspect = 0;             // width / height
};

// The lenses of a COLLADA file. In `text` each is then a lens of which assimp keeps the number
// alone, for lens_number().
std::vector<ColladaLens> number_lenses(std::string& text);

// Which one a camera has whose far plane is that far; one that is not there, where it has none.
std::size_t lens_number(float far_plane);

void set_lens(const ColladaLens& lens, ImportedCamera& camera);

}  // namespace geometry::assimp
