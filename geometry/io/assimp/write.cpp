#include "geometry/base/srgb.hpp"
#include "geometry/io/assimp/jobs.hpp"

#include <assimp/Exporter.hpp>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/scene.h>
#include <unistd.h>

#include <new>
#include <stdexcept>

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

}  // namespace

void write(int input, const std::string& format, const std::string& name, ExportedFiles& out)
{
    const std::string glb = all_of(input);
    // Never destroyed: the process ends when its work is done.
    auto* importer = new Assimp::Importer;
    if (!importer->ReadFileFromMemory(glb.data(), glb.size(), 0, "glb")) {
        throw std::runtime_error(importer->GetErrorString());
    }
    aiScene& scene = *importer->GetOrphanedScene();
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
