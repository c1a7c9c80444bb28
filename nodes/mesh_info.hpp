#pragma once

// What `aspic info` says of a mesh file: what it holds, and which cubes would suit it.

#include "geometry/io/read_options.hpp"
#include "geometry/mesh/mass_properties.hpp"

#include <array>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace nodes {

// A unit of length that a mesh file may be in.
struct FileUnit {
    std::string name;   // "cm"
    double metres = 1;  // of one
};

// The largest unit of m, cm and mm in which a model whose longest side has this length in the file
// is at most 50 m long; else mm.
FileUnit guess_unit(double longest);

// Cubes for the model.
struct CubeAdvice {
    double size = 0;   // m
    double count = 0;  // about
};

struct MeshInfo {
    geometry::Box box;       // m
    double stated_unit = 0;  // m, as the file states it; 0: it does not
    bool converted = false;  // from another one, which is not known
    FileUnit unit;           // stated, or guessed from the size
    double read_unit = 1;    // m, of the file's unit, as the lengths here take it
    std::size_t vertices = 0, triangles = 0;
    // Faces of the file that WriteMesh writes as such, by their corners: 3, 4, more.
    std::array<std::size_t, 3> polygons{};
    std::size_t turned = 0;       // triangles wound against the rest; what follows is without that
    std::size_t doubled = 0;      // triangles that lie on others
    bool closed = false;          // and encloses something; then `body` is known
    bool two_sided = false;       // open, both sides of a surface: it has no rims
    std::size_t holes = 0;        // rims
    double longest_rim = 0;       // m
    bool shell = false;           // open as a bowl is: method = solid of Voxelize would fill it
    std::size_t between = 0;      // open pieces whose gaps method = solid would fill
    std::size_t disagreeing = 0;  // edges between faces of which one looks in
    std::size_t pieces = 0;
    double area = 0;                // m^2
    geometry::MassProperties body;  // at 1 kg/m^3
    std::vector<std::string> materials, groups;
    struct Texture {
        std::string name;
        bool found = true;
    };
    std::vector<Texture> textures;
    struct Wall {
        double thickness = 0;  // m
        std::string part;      // empty: the whole mesh
        geometry::Vec3 where = geometry::Vec3::Zero();
    };
    std::optional<Wall> thinnest;
    CubeAdvice cubes;  // a size to begin with
    CubeAdvice fine;   // cubes that bend the thinnest wall rightly; size 0: those of `cubes`
    std::vector<std::string> warnings;
};

// Throws what geometry::read_mesh throws. Textures are looked for from the file's folder.
MeshInfo mesh_info(const std::filesystem::path& file, const geometry::ReadOptions& options);

// A table for people, and one line of JSON for programs.
std::string info_text(const std::string& file, const MeshInfo& info);
std::string info_json(const std::string& file, const MeshInfo& info);

// For the command line: the text or the JSON of a file whose lengths are in `unit`, as ReadMesh
// calls it. Throws graph::Cancelled when told to stop.
std::string describe_mesh(const std::string& file, const std::string& unit, bool json,
                          const std::stop_token& stop);

}  // namespace nodes
