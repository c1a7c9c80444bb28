#pragma once

// Grids of voxels in VDB files, as Houdini and Blender write them, made into a surface and a cloud
// of points. OpenVDB reads them, in a process of its own (library_process.hpp).

#include "geometry/io/library_process.hpp"
#include "geometry/io/read_options.hpp"
#include "geometry/mesh/mesh.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace geometry {

enum class VolumeParts { both, mesh, points };

struct VolumeOptions {
    ProcessLimits limits;
    // Called now and then while waiting; what it throws ends the reading.
    std::function<void()> check = [] {};
    std::string grid;       // empty: surface or density, or else the first of floats
    double iso = 0;         // m, of level sets: inside is what is less
    double fog_iso = 0.5;   // of all others: inside is what is as much or more
    std::string attribute;  // name of the points' attribute; empty: that of the grid
    VolumeParts make = VolumeParts::both;
    std::uint64_t max_voxels = 50'000'000;  // active ones, and inner ones where these become points
    LengthUnit unit = LengthUnit::automatic;  // metres
    double custom_unit = 1;                   // m
    UpAxis up = UpAxis::automatic;            // y
};

struct ReadVolume {
    // The isosurface, with normals that are computed.
    TriMesh mesh;
    // The middles of the voxels inside, and as an attribute the grid's value there, in metres of a
    // level set.
    TriMesh points;
};

// Throws std::runtime_error that names the file where it has no such grid, the grid is not of
// finite floats on affine voxels, nothing or everything is inside, or it goes beyond a limit; and
// where aspic-openvdb is missing.
ReadVolume read_volume(const std::filesystem::path& path, const VolumeOptions& options = {});

// Why no volume can be read by this build; empty where it can.
std::string why_no_volumes();

}  // namespace geometry
