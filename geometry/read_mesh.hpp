#pragma once

// Mesh files of every format that assimp reads, made into one clean TriMesh in metres, y up.

#include "geometry/import_scene.hpp"
#include "geometry/mesh.hpp"

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

struct ReadOptions {
    ImportOptions import;
    LengthUnit unit = LengthUnit::automatic;  // what the file says, else metres
    double custom_unit = 1;                   // m
    UpAxis up = UpAxis::automatic;            // what the file says, else y
    ColourSpace colours = ColourSpace::automatic;
    double fit = 0;  // m, the bounds' largest side after scaling; 0: as the unit gives
    Placement place = Placement::keep;
    FileNormals normals = FileNormals::file;
    double crease = 0.7;  // rad, for normals that the file does not give
};

struct ReadMesh {
    TriMesh mesh;
    std::vector<std::string> warnings;              // each a sentence
    std::vector<std::filesystem::path> side_files;  // others that were opened or looked for
};

// The mesh in `path`: vertices welded where their positions agree in every bit, instances placed,
// mirrored ones wound to face outwards still, groups named after the file's nodes. Faces that use a
// vertex which is not finite or not there, or one vertex twice, are left out with a warning, and so
// are lines. Without faces, the points. Throws std::runtime_error when nothing is left, and what
// import_scene throws.
ReadMesh read_mesh(const std::filesystem::path& path, const ReadOptions& options = {});

// The same from a scene that was read already.
ReadMesh assemble(const ImportedScene& scene, const ReadOptions& options = {});

}  // namespace geometry
