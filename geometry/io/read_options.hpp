#pragma once

// How a mesh file is to be read, and what reading gives.

#include "geometry/io/import_scene.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polylines.hpp"

namespace geometry {

enum class LengthUnit { automatic, metre, centimetre, millimetre, inch, foot, custom };
enum class UpAxis { automatic, y, z, x };
enum class ColourSpace { automatic, srgb, linear };
enum class FileNormals { file, computed, none };
enum class Placement {
    keep,
    centre,  // the centre of the bounds at the origin
    ground,  // the lowest point at y = 0, the centre above the origin
};

enum class Weld { all, groups };  // which vertices at one place are one

struct ReadOptions {
    ImportOptions import;
    LengthUnit unit = LengthUnit::automatic;  // what the file says, else metres
    double custom_unit = 1;                   // m
    UpAxis up = UpAxis::automatic;            // what the file says, else y
    ColourSpace colours = ColourSpace::automatic;
    double line_thickness = 0;  // m, of the tubes that lines become; 0: they are left out
    double fit = 0;             // m, the bounds' largest side after scaling; 0: as the unit gives
    Placement place = Placement::keep;
    Weld weld = Weld::all;
    bool keep_order = false;  // all vertices of the file, in its order (OBJ, PLY)
    FileNormals normals = FileNormals::file;
    double crease = 0.7;  // rad, for normals that the file does not give
};

struct ReadMesh {
    TriMesh mesh;
    Polylines lines;                    // m, moved and scaled with the mesh
    double unit = 0;                    // m, as the file states it; 0: it does not
    bool converted_unit = false;        // from the one that the file states, by the importer
    std::vector<std::string> textures;  // named by materials, as the file writes them
    std::vector<std::string> warnings;  // each a sentence
    std::vector<std::filesystem::path> side_files;  // others that were opened or looked for
};

}  // namespace geometry
