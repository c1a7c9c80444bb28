#pragma once

// What aspic-openvdb makes of a grid of a VDB file. All lengths are in the file's unit.

#include "geometry/base/vec.hpp"

#include <string>
#include <vector>

namespace geometry {

struct ImportedVolume {
    std::string grid;  // its name
    bool level_set = false;
    std::vector<Vec3f> positions;     // V, of the surface
    std::vector<Triangle> triangles;  // counter-clockwise outside
    std::vector<Vec3f> points;        // P, the middles of the voxels inside
    std::vector<float> values;        // P, of the grid there
    std::string error;                // why nothing was made; empty on success
};

// As geometry/io/assimp_messages.hpp has it of scenes.
template <class T> std::string pack(const T& value);
template <class T> T unpack(const char* bytes, std::size_t size);

}  // namespace geometry
