#include "geometry/base/srgb.hpp"
#include "geometry/io/assimp/jobs.hpp"

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/scene.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string_view>

namespace geometry::assimp {
namespace {

std::string all_of(int input)
{
    std::string bytes;
    for (;;) {
        const std::size_t before = bytes.size();
        bytes.resize(before + (std::size_t{1} << 20));
        const ssize_t n = ::read(input, bytes.data() + before, bytes.size() - before);
        bytes.resize(before + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
        if (n < 0) throw std::runtime_error("the mesh to be written could not be read");
        if (n == 0) return bytes;
    }
}

void to_display(ai_real& r, ai_real& g, ai_real& b)
{
    for (ai_real* c : {&r, &g, &b}) *c = srgb_from_linear(*c);
}

// glTF holds light; the other formats hold what a display is sent.
void show_colours(aiScene& scene)
{
    for (unsigned m = 0; m < scene.mNumMaterials; ++m) {
        aiMaterial& material = *scene.mMaterials[m];
        aiColor4D colour;
        if (material.Get(AI_MATKEY_BASE_COLOR, colour) != AI_SUCCESS) continue;
        to_display(colour.r, colour.g, colour.b);
        material.AddProperty(&colour, 1, AI_MATKEY_COLOR_DIFFUSE);
        const ai_real opacity = colour.a;
        material.AddProperty(&opacity, 1, AI_MATKEY_OPACITY);
    }
    for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
        aiMesh& mesh = *scene.mMeshes[m];
        if (!mesh.mColors[0]) continue;
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            aiColor4D& c = mesh.mColors[0][i];
            to_display(c.r, c.g, c.b);
        }
    }
}

// Numbers of four bytes, as long as there are any.
class Words {
public:
    explicit Words(std::string_view bytes) : bytes_(bytes) {}

    bool is_at_end() const { return bytes_.empty(); }
    std::uint32_t next()
    {
        std::uint32_t word = 0;
        if (bytes_.size() < sizeof word) throw std::runtime_error("its polygons are cut short");
        std::memcpy(&word, bytes_.data(), sizeof word);
        bytes_.remove_prefix(sizeof word);
        return word;
    }

private:
    std::string_view bytes_;
};

// Its polygons in place of the triangles of a mesh.
void join_triangles(aiMesh& mesh, Words& words)
{
    const std::uint32_t count = words.next();
    if (count == 0 || count > mesh.mNumFaces) throw std::runtime_error("its polygons are others");
    auto* const faces = new aiFace[count];
    mesh.mPrimitiveTypes = 0;
    for (std::uint32_t p = 0; p < count; ++p) {
        const std::uint32_t corners = words.next();
        if (corners < 3 || corners > 3 * mesh.mNumFaces) {
            throw std::runtime_error("one of its polygons has a wrong number of corners");
        }
        faces[p].mNumIndices = corners;
        faces[p].mIndices = new unsigned[corners];
        for (std::uint32_t k = 0; k < corners; ++k) {
            const std::uint32_t corner = words.next();
            if (corner / 3 >= mesh.mNumFaces || mesh.mFaces[corner / 3].mNumIndices != 3) {
                throw std::runtime_error("its polygons are of other triangles");
            }
            faces[p].mIndices[k] = mesh.mFaces[corner / 3].mIndices[corner % 3];
        }
        mesh.mPrimitiveTypes |= static_cast<unsigned>(corners == 3 ? aiPrimitiveType_TRIANGLE
                                                                   : aiPrimitiveType_POLYGON);
    }
    delete[] mesh.mFaces;
    mesh.mFaces = faces;
    mesh.mNumFaces = count;
}

// The size of a binary glTF file, as its third number says.
std::size_t glb_size(const std::string& bytes)
{
    std::uint32_t size = 0;
    if (bytes.size() >= 12) std::memcpy(&size, bytes.data() + 8, sizeof size);
    return std::min<std::size_t>(size, bytes.size());
}

}  // namespace

void write(int input, const std::string& format, const std::string& name, ExportedFiles& out)
{
    const std::string given = all_of(input);
    const std::string_view glb = std::string_view(given).substr(0, glb_size(given));
    // Never destroyed: the process ends when its work is done.
    auto* importer = new Assimp::Importer;
    if (!importer->ReadFileFromMemory(glb.data(), glb.size(), 0, "glb")) {
        throw std::runtime_error(importer->GetErrorString());
    }
    aiScene& scene = *importer->GetOrphanedScene();
    Words polygons(std::string_view(given).substr(glb.size()));
    for (unsigned m = 0; m < scene.mNumMeshes && !polygons.is_at_end(); ++m) {
        join_triangles(*scene.mMeshes[m], polygons);
    }
    if (format != "gltf2" && format != "glb2") show_colours(scene);
    if (format.starts_with("fbx")) {
        // A unit of FBX is a centimetre unless it says otherwise.
        if (!scene.mMetaData) scene.mMetaData = new aiMetadata;
        scene.mMetaData->Add("UnitScaleFactor", 100.0);
    }
    auto* exporter = new Assimp::Exporter;
    Assimp::ExportProperties properties;
    properties.SetPropertyString(AI_CONFIG_EXPORT_BLOB_NAME, name);
    const aiExportDataBlob* blob = exporter->ExportToBlob(&scene, format, 0, &properties);
    if (!blob) {
        const std::string why = exporter->GetErrorString();
        throw std::runtime_error(why.empty() ? "assimp gave no reason" : why);
    }
    for (; blob; blob = blob->next) {
        out.files.push_back(
            {blob->name.C_Str(), {static_cast<const char*>(blob->data), blob->size}});
    }
}

}  // namespace geometry::assimp
