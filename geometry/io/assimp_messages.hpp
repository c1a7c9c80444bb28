#pragma once

// What travels between this program and aspic-assimp, the process that runs assimp (geometry/
// io/library_process.hpp).

#include "geometry/base/vec.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace geometry {

// A number of the file's own at each vertex.
struct ImportedAttribute {
    std::string name;
    std::vector<float> values;  // V
};

struct ImportedMesh {
    std::string name;
    std::uint32_t material = 0;         // into ImportedScene::materials
    std::vector<Vec3f> positions;       // V, in the file's unit; not welded, maybe not finite
    std::vector<Vec3f> normals;         // V or 0
    std::vector<Vec3f> colours;         // V or 0, as the file has them
    std::vector<Vec2f> uvs;             // V or 0
    std::vector<Triangle> triangles;    // into positions, not yet checked
    std::vector<std::uint32_t> points;  // vertices that the file calls points
    std::uint64_t lines = 0;            // line segments left out
    std::vector<std::array<std::uint32_t, 2>> segments = {};  // those of them with both ends known
    std::vector<std::uint32_t> polygon = {};  // of triangles, as MeshTopology has it
    // These are not sent, as only readers of our own have any.
    std::vector<ImportedAttribute> attributes = {};  // each name once
    std::size_t copies = 0;  // the last positions, which are no vertices of the file's own

    std::vector<Vec3f> own_positions() const
    {
        return {positions.begin(), positions.end() - static_cast<std::ptrdiff_t>(copies)};
    }
};

// A picture that a material names.
struct ImportedPicture {
    std::string path;            // as the file has it; empty: none
    std::int32_t embedded = -1;  // into ImportedScene::embedded, where the file holds it itself
    std::array<std::uint8_t, 2> wrap{};  // TextureUse::Wrap along u and v
    bool turned = false;                 // the material turns it, which is not done here
};

struct ImportedMaterial {
    enum class Alpha : std::uint8_t { unsaid, ignored, cutout, blended };

    std::string name;
    Vec3f colour{0.7f, 0.7f, 0.7f};  // as the file has it
    float opacity = 1, roughness = 0.6f, metallic = 0;
    ImportedPicture picture = {};  // of the colour
    std::string opacity_picture = {};
    Alpha alpha = Alpha::unsaid;
    float cutoff = 0.5f;
    // Of normals in the frame of the surface.
    ImportedPicture normals = {};
    bool bump_map = false;           // it is named as one of bumps, which may be heights
    bool normals_elsewhere = false;  // it lies at other coordinates than that of the colour
    float bump = 1;
};

// A picture that lies in the mesh file.
struct EmbeddedPicture {
    std::string name;
    std::string file;  // the bytes of a picture file
};

// One use of a mesh in the file's tree of nodes.
struct ImportedNode {
    std::string name;
    std::uint32_t mesh = 0;
    std::array<double, 12> to_world{};  // rows of a 3 x 4 matrix
    std::uint32_t node = 0;  // which one: several meshes may hang at it, and names need not differ
};

// Its vectors are those of the node that it hangs at.
struct ImportedCamera {
    static constexpr double samples_a_second = 120;

    std::string name;
    Vec3f position{0, 0, 0}, ahead{0, 0, -1}, up{0, 1, 0};
    float width_angle = 0;  // rad, of the picture's width
    float half_width = 0;   // in the file's unit, of a parallel one's picture; 0: it is none
    float aspect = 0;       // width / height; 0: the file does not say
    // Rows of 3 x 4 matrices: one, or a sample of its motion each 120th of a second.
    std::vector<std::array<double, 12>> to_world;
};

struct ImportedFile {
    std::string path;
    bool found = false;
};

struct ImportedScene {
    std::vector<ImportedMesh> meshes;
    std::vector<ImportedMaterial> materials;
    std::vector<EmbeddedPicture> embedded;
    std::vector<ImportedNode> nodes;
    std::vector<ImportedCamera> cameras;  // where these were asked for
    bool linear_colours = false;          // else they are display values, sRGB
    double unit = 0;                      // m, of one unit of length; 0 when the file does not say
    bool has_axes = false;                // whether the file says which axis is up
    std::array<double, 9> to_y_up{1, 0, 0, 0, 1, 0, 0, 0, 1};  // rows, when it says so
    std::vector<ImportedFile> files;    // that were opened or looked for, the mesh file first
    std::vector<std::string> textures;  // named by materials, each once; "*0" is in the file
    std::string error;                  // why nothing was read; empty on success

    // Sentences; not sent, as only readers of our own have any.
    std::vector<std::string> warnings;
};

struct ExportedFile {
    std::string name;  // as the others call it
    std::string bytes;
};

// A mesh in another format: the file itself, then those beside it that it names.
struct ExportedFiles {
    std::vector<ExportedFile> files;
    std::string error;  // why nothing was written; empty on success
};

// Of an ImportedScene or of ExportedFiles.
template <class T> std::string pack(const T& value);

// What `bytes` hold. Throws std::runtime_error unless they are exactly what pack() makes of a T.
template <class T> T unpack(const char* bytes, std::size_t size);

}  // namespace geometry
