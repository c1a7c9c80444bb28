#pragma once

// The files that assimp opens for a mesh.

#include "geometry/io/assimp/collada_lenses.hpp"
#include "geometry/io/assimp_messages.hpp"

#include <assimp/DefaultIOSystem.h>

#include <filesystem>

namespace geometry::assimp {

// Opens files for assimp as it can read them, remembers which, and refuses those outside the root.
class RememberingFiles : public Assimp::DefaultIOSystem {
public:
    RememberingFiles(std::filesystem::path mesh, const std::filesystem::path& root,
                     std::vector<ImportedFile>& files);
    bool Exists(const char* path) const override;
    Assimp::IOStream* Open(const char* path, const char* mode) override;

    // Where those of a COLLADA file go, which assimp is then given numbered; null: nowhere.
    std::vector<ColladaLens>* lenses = nullptr;

private:
    bool allowed(const std::filesystem::path& path) const;
    void remember(const std::string& path, bool found) const;

    std::filesystem::path mesh_;
    bool is_obj_;
    std::filesystem::path root_;
    std::vector<ImportedFile>& files_;
};

// Stands for a blank in the name of an OBJ's object, which assimp 5.2 reads up to the first blank.
constexpr char kept_blank = '\x1f';

std::string lower(std::string text);

}  // namespace geometry::assimp
