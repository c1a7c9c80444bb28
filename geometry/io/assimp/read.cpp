#include "geometry/io/assimp/jobs.hpp"
#include "geometry/io/assimp/remembering_files.hpp"
#include "geometry/mesh/polygons.hpp"
#include "geometry/mesh/triangulate.hpp"

#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/ObjMaterial.h>
#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>

namespace geometry::assimp {
namespace {

namespace fs = std::filesystem;

std::string text(const aiString& s)
{
    return {s.data, std::min<std::size_t>(s.length, sizeof(s.data) - 1)};
}

template <class V> Vec3f vec3(const V& v)
{
    return {float(v.x), float(v.y), float(v.z)};
}

// Of `type`, or no path where there is none; and which texture coordinates it lies at.
ImportedPicture picture_of(const aiScene& scene, const aiMaterial& in, aiTextureType type,
                           unsigned& coordinates)
{
    ImportedPicture out;
    aiString path;
    std::array<aiTextureMapMode, 2> wrap{aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    if (in.GetTexture(type, 0, &path, nullptr, &coordinates, nullptr, nullptr, wrap.data()) !=
        AI_SUCCESS) {
        return out;
    }
    out.path = text(path);
    for (std::size_t k = 0; k < 2; ++k) {
        out.wrap[k] = wrap[k] == aiTextureMapMode_Wrap     ? 0
                      : wrap[k] == aiTextureMapMode_Mirror ? 2
                                                           : 1;
    }
    const auto [texture, index] = scene.GetEmbeddedTextureAndIndex(path.C_Str());
    if (texture) out.embedded = index;
    return out;
}

// The picture of a material's colour.
ImportedPicture colour_picture(const aiScene& scene, const aiMaterial& in, unsigned& coordinates)
{
    coordinates = 0;
    ImportedPicture out = picture_of(scene, in, aiTextureType_BASE_COLOR, coordinates);
    if (out.path.empty()) out = picture_of(scene, in, aiTextureType_DIFFUSE, coordinates);
    return out;
}

// That of its normals, or of what OBJ calls bumps: in practice that is either.
ImportedPicture normal_picture(const aiScene& scene, const aiMaterial& in, unsigned& coordinates)
{
    coordinates = 0;
    ImportedPicture out = picture_of(scene, in, aiTextureType_NORMALS, coordinates);
    if (out.path.empty()) out = picture_of(scene, in, aiTextureType_HEIGHT, coordinates);
    return out;
}

// How a material moves and scales a picture (KHR_texture_transform); false where it does not.
bool moved(const aiMaterial& in, bool colour, aiUVTransform& out)
{
    const auto is_there = [&](aiTextureType type) {
        return in.Get(AI_MATKEY_UVTRANSFORM(type, 0), out) == AI_SUCCESS;
    };
    if (!colour) return is_there(aiTextureType_NORMALS);
    return is_there(aiTextureType_BASE_COLOR) || is_there(aiTextureType_DIFFUSE);
}

// Which picture lays the texture coordinates of a mesh: that of the colour, or else of the normals.
struct Laid {
    bool colour = true;
    unsigned coordinates = 0;
};
Laid laid_by(const aiScene& scene, const aiMaterial& in)
{
    Laid by;
    by.colour = !colour_picture(scene, in, by.coordinates).path.empty();
    if (by.colour || !normal_picture(scene, in, by.coordinates).path.empty()) return by;
    return {};
}

// What is done to the coordinates; false where nothing is, or the picture is turned too. Applied
// here: assimp's own step moves before it scales.
bool placing(const aiMaterial& in, bool colour, aiUVTransform& out)
{
    return moved(in, colour, out) && out.mRotation == 0;
}

// One that holds pixels and no file is given a file: TGA.
EmbeddedPicture embedded_picture(const aiTexture& in, std::size_t number)
{
    EmbeddedPicture out;
    out.name = fs::path(text(in.mFilename)).filename().string();
    if (in.mHeight == 0) {
        out.file.assign(reinterpret_cast<const char*>(in.pcData), in.mWidth);
    } else if (in.mWidth < 65536 && in.mHeight < 65536) {
        out.file.assign(18, '\0');
        out.file[2] = 2;
        for (unsigned k = 0; k < 2; ++k) {
            out.file[12 + k] = static_cast<char>(in.mWidth >> 8 * k & 255);
            out.file[14 + k] = static_cast<char>(in.mHeight >> 8 * k & 255);
        }
        out.file[16] = 32;
        out.file[17] = 0x28;  // eight bits of alpha, rows from the top
        out.file.append(reinterpret_cast<const char*>(in.pcData),
                        sizeof(aiTexel) * in.mWidth * in.mHeight);
    }
    if (out.name.empty() || out.name[0] == '*') out.name = "picture" + std::to_string(number);
    // The names of glTF mostly have no ending, by which readers of other formats go.
    const std::string ending = lower(fs::path(out.name).extension().string());
    const std::array known{".png", ".jpg", ".jpeg", ".bmp", ".tga"};
    if (std::find(known.begin(), known.end(), ending) == known.end()) {
        const bool jpeg = out.file.starts_with("\xff\xd8"), bmp = out.file.starts_with("BM");
        const bool png = out.file.starts_with("\x89PNG");
        out.name += jpeg ? ".jpg" : png ? ".png" : bmp ? ".bmp" : ".tga";
    }
    return out;
}

ImportedMesh mesh_of(const aiScene& scene, const aiMesh& in)
{
    ImportedMesh out;
    out.name = text(in.mName);
    out.material = in.mMaterialIndex;
    if (!in.mVertices) return out;
    const std::size_t n = in.mNumVertices;
    out.positions.reserve(n);
    for (std::size_t i = 0; i < n; ++i) out.positions.push_back(vec3(in.mVertices[i]));
    if (in.mNormals) {
        out.normals.reserve(n);
        for (std::size_t i = 0; i < n; ++i) out.normals.push_back(vec3(in.mNormals[i]));
    }
    unsigned coordinates = 0;
    aiUVTransform placed;
    bool is_placed = false;
    if (in.mMaterialIndex < scene.mNumMaterials) {
        const aiMaterial& material = *scene.mMaterials[in.mMaterialIndex];
        const Laid by = laid_by(scene, material);
        coordinates = by.coordinates;
        is_placed = placing(material, by.colour, placed);
    }
    if (!in.HasTextureCoords(coordinates)) coordinates = 0;
    if (const aiVector3D* uvs = in.mTextureCoords[coordinates]) {
        out.uvs.reserve(n);
        for (std::size_t i = 0; i < n; ++i) out.uvs.emplace_back(float(uvs[i].x), float(uvs[i].y));
        for (Vec2f& uv : out.uvs) {
            if (!is_placed) break;
            uv = {float(placed.mScaling.x) * uv.x() + float(placed.mTranslation.x),
                  float(placed.mScaling.y) * uv.y() + float(placed.mTranslation.y)};
        }
    }
    if (const aiColor4D* colours = in.mColors[0]) {
        out.colours.reserve(n);
        for (std::size_t i = 0; i < n; ++i) {
            out.colours.emplace_back(float(colours[i].r), float(colours[i].g), float(colours[i].b));
        }
    }
    // Cut here: assimp's own triangulation takes some concave polygons for convex.
    out.triangles.reserve(in.mNumFaces);
    for (std::size_t f = 0; f < in.mNumFaces; ++f) {
        const aiFace& face = in.mFaces[f];
        if (face.mNumIndices >= 3) {
            const std::size_t before = out.triangles.size();
            triangulate({face.mIndices, face.mNumIndices}, out.positions, out.triangles);
            add_polygon(out.polygon, out.triangles.size() - before);
        } else if (face.mNumIndices == 1) {
            out.points.push_back(face.mIndices[0]);
        } else if (face.mNumIndices == 2) {
            ++out.lines;
            out.segments.push_back({face.mIndices[0], face.mIndices[1]});
        }
    }
    if (has_triangles_only(out.polygon)) out.polygon.clear();
    return out;
}

// What glTF says of a material's alpha.
void read_alpha(const aiMaterial& in, ImportedMaterial& out)
{
    aiString mode;
    if (in.Get(AI_MATKEY_GLTF_ALPHAMODE, mode) != AI_SUCCESS) return;
    using Alpha = ImportedMaterial::Alpha;
    const std::string name = text(mode);
    out.alpha = name == "MASK" ? Alpha::cutout : name == "BLEND" ? Alpha::blended : Alpha::ignored;
    float cutoff = 0;
    if (in.Get(AI_MATKEY_GLTF_ALPHACUTOFF, cutoff) == AI_SUCCESS) out.cutoff = cutoff;
}

void read_pictures(const aiScene& scene, const aiMaterial& in, ImportedMaterial& out)
{
    unsigned coordinates = 0, own = 0;
    const Laid by = laid_by(scene, in);
    out.picture = colour_picture(scene, in, coordinates);
    aiUVTransform placed, own_placed;
    out.picture.turned = !placing(in, by.colour, placed) && placed.mRotation != 0;
    out.opacity_picture = picture_of(scene, in, aiTextureType_OPACITY, coordinates).path;

    out.normals = normal_picture(scene, in, own);
    if (out.normals.path.empty()) return;
    out.bump_map = in.GetTextureCount(aiTextureType_NORMALS) == 0;
    moved(in, false, own_placed);
    const auto numbers = [](const aiUVTransform& t) {
        return std::array{t.mScaling.x, t.mScaling.y, t.mTranslation.x, t.mTranslation.y,
                          t.mRotation};
    };
    out.normals_elsewhere = own != by.coordinates || numbers(own_placed) != numbers(placed);
    float bump = 1;
    if (in.Get(AI_MATKEY_GLTF_TEXTURE_SCALE(aiTextureType_NORMALS, 0), bump) == AI_SUCCESS ||
        in.Get(AI_MATKEY_OBJ_BUMPMULT_NORMALS(0), bump) == AI_SUCCESS ||
        in.Get(AI_MATKEY_OBJ_BUMPMULT_HEIGHT(0), bump) == AI_SUCCESS) {
        out.bump = bump;
    }
}

ImportedMaterial material_of(const aiScene& scene, const aiMaterial& in)
{
    ImportedMaterial out;
    aiString name;
    if (in.Get(AI_MATKEY_NAME, name) == AI_SUCCESS) out.name = text(name);
    aiColor4D base;
    aiColor3D diffuse;
    if (in.Get(AI_MATKEY_BASE_COLOR, base) == AI_SUCCESS) {
        out.colour = {float(base.r), float(base.g), float(base.b)};
        out.opacity = float(base.a);
    } else if (in.Get(AI_MATKEY_COLOR_DIFFUSE, diffuse) == AI_SUCCESS) {
        out.colour = {float(diffuse.r), float(diffuse.g), float(diffuse.b)};
    }
    // What assimp makes up where a file says nothing is the grey of our floor: Material's instead,
    // 0.7 by the sRGB curve.
    const bool made_up =
        out.name == AI_DEFAULT_MATERIAL_NAME && out.colour == Vec3f(0.6f, 0.6f, 0.6f);
    if (made_up) out.colour = {0.852f, 0.852f, 0.852f};
    float opacity = 1;
    if (in.Get(AI_MATKEY_OPACITY, opacity) == AI_SUCCESS) out.opacity = opacity;

    float roughness = 0, shininess = 0, metallic = 0;
    if (in.Get(AI_MATKEY_ROUGHNESS_FACTOR, roughness) == AI_SUCCESS) {
        out.roughness = roughness;
    } else if (in.Get(AI_MATKEY_SHININESS, shininess) == AI_SUCCESS && shininess > 0) {
        // The Blinn-Phong exponent of a microfacet distribution of width roughness^2.
        out.roughness = std::pow(2 / (shininess + 2), 0.25f);
    }
    if (in.Get(AI_MATKEY_METALLIC_FACTOR, metallic) == AI_SUCCESS) out.metallic = metallic;
    read_alpha(in, out);
    read_pictures(scene, in, out);
    return out;
}

void add_textures(const aiMaterial& in, std::vector<std::string>& out)
{
    for (int type = aiTextureType_NONE + 1; type <= AI_TEXTURE_TYPE_MAX; ++type) {
        const auto of = static_cast<aiTextureType>(type);
        for (unsigned i = 0; i < in.GetTextureCount(of); ++i) {
            aiString path;
            if (in.GetTexture(of, i, &path) != AI_SUCCESS || path.length == 0) continue;
            std::string name = text(path);
            if (std::find(out.begin(), out.end(), name) == out.end()) out.push_back(name);
        }
    }
}

// Every use of a mesh in the tree, without recursion: a file may nest as deep as it likes.
void add_nodes(const aiScene& in, ImportedScene& out)
{
    using Matrix = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
    std::vector<std::pair<const aiNode*, Matrix>> todo;
    if (in.mRootNode) todo.emplace_back(in.mRootNode, Matrix::Identity());
    std::uint32_t count = 0;
    while (!todo.empty()) {
        const aiNode& node = *todo.back().first;
        const Matrix local = Eigen::Map<const Eigen::Matrix<ai_real, 4, 4, Eigen::RowMajor>>(
                                 &node.mTransformation.a1)
                                 .cast<double>();
        const Matrix world = todo.back().second * local;
        todo.pop_back();
        ++count;
        for (std::size_t i = 0; i < node.mNumMeshes; ++i) {
            auto& use = out.nodes.emplace_back();
            use.name = text(node.mName);
            std::replace(use.name.begin(), use.name.end(), kept_blank, ' ');
            use.node = count;
            use.mesh = node.mMeshes[i];
            std::copy_n(world.data(), 12, use.to_world.begin());
        }
        for (std::size_t i = node.mNumChildren; i-- > 0;) {
            if (node.mChildren[i]) todo.emplace_back(node.mChildren[i], world);
        }
    }
}

bool number(const aiMetadata* data, const char* key, double& out)
{
    if (!data) return false;
    for (unsigned i = 0; i < data->mNumProperties; ++i) {
        if (std::strcmp(data->mKeys[i].C_Str(), key) != 0) continue;
        const aiMetadataEntry& e = data->mValues[i];
        if (e.mType == AI_INT32) return out = *static_cast<std::int32_t*>(e.mData), true;
        if (e.mType == AI_FLOAT) return out = *static_cast<float*>(e.mData), true;
        if (e.mType == AI_DOUBLE) return out = *static_cast<double*>(e.mData), true;
    }
    return false;
}

// FBX says which of its axes points right, up and to the front, and how many centimetres a unit is.
void read_fbx_settings(const aiMetadata* data, ImportedScene& out)
{
    double unit = 0;
    if (number(data, "UnitScaleFactor", unit) && unit > 0) out.unit = 0.01 * unit;

    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> M = Eigen::Matrix3d::Zero();
    const std::array<std::array<const char*, 2>, 3> rows{
        {{"CoordAxis", "CoordAxisSign"}, {"UpAxis", "UpAxisSign"}, {"FrontAxis", "FrontAxisSign"}}};
    for (int row = 0; row < 3; ++row) {
        double axis = 0, sign = 0;
        const auto& [key, sign_key] = rows[std::size_t(row)];
        if (!number(data, key, axis) || !number(data, sign_key, sign)) return;
        if (axis != 0 && axis != 1 && axis != 2) return;
        M(row, int(axis)) = sign < 0 ? -1 : 1;
    }
    if (std::abs(std::abs(M.determinant()) - 1) > 1e-9) return;
    out.has_axes = true;
    std::copy_n(M.data(), 9, out.to_y_up.begin());
}

}  // namespace

void read(const std::string& path, const std::string& root, Wanted wanted, ImportedScene& out)
{
    // Never destroyed: the process ends when its work is done, and taking millions of faces apart
    // takes time.
    auto* importer = new Assimp::Importer;
    std::vector<ColladaLens> lenses;
    const std::string extension = lower(fs::path(path).extension().string());
    auto* files = new RememberingFiles(path, root, out.files);
    if (wanted == Wanted::cameras && extension == ".dae") files->lenses = &lenses;
    importer->SetIOHandler(files);
    importer->SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
    importer->SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_USE_COLLADA_NAMES, true);
    importer->SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
    const aiScene* scene = importer->ReadFile(path, 0);
    if (!scene) {
        out.error = importer->GetErrorString();
        if (out.error.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
        if (out.error.empty()) out.error = "assimp gave no reason";
        return;
    }

    if (extension == ".gltf" || extension == ".glb") {
        out.linear_colours = true;
        out.unit = 1;
        out.has_axes = true;
    } else if (extension == ".dae") {
        out.unit = 1;  // assimp has turned and scaled the root as the file says
        out.has_axes = true;
    } else if (extension == ".fbx") {
        read_fbx_settings(scene->mMetaData, out);
    }
    if (wanted == Wanted::cameras) {
        return read_cameras(*scene, out.linear_colours, lenses, out);
    }
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        out.meshes.push_back(mesh_of(*scene, *scene->mMeshes[i]));
    }
    for (unsigned i = 0; i < scene->mNumMaterials; ++i) {
        out.materials.push_back(material_of(*scene, *scene->mMaterials[i]));
        add_textures(*scene->mMaterials[i], out.textures);
    }
    for (unsigned i = 0; i < scene->mNumTextures; ++i) {
        out.embedded.push_back(embedded_picture(*scene->mTextures[i], i));
    }
    add_nodes(*scene, out);
    // Faces of an OBJ are of the group of that name wherever it is named; assimp makes a node each
    // time.
    if (extension == ".obj") {
        for (ImportedNode& node : out.nodes) node.node = 0;
    }
}

}  // namespace geometry::assimp
