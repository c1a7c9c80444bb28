#pragma once

// Files for tests: a folder that goes away again, and where kept models lie.

#include <gtest/gtest.h>

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace files {

namespace fs = std::filesystem;

class Folder {
public:
    Folder()
    {
        std::string name = (fs::temp_directory_path() / "aspic-test-XXXXXX").string();
        if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
        path = name;
    }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;
    ~Folder()
    {
        std::error_code none;
        fs::remove_all(path, none);
    }
    fs::path write(const std::string& name, const std::string& bytes) const
    {
        fs::create_directories((path / name).parent_path());
        std::ofstream(path / name, std::ios::binary) << bytes;
        return path / name;
    }
    fs::path path;
};

inline std::string bytes_of(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// The folder of models by others: $ASPIC_SHARED, or `shared` beside the project; else empty.
inline fs::path shared()
{
    if (const char* named = std::getenv("ASPIC_SHARED"); named && *named) return named;
    const fs::path beside = fs::path(ASPIC_SOURCE_DIR) / "../shared";
    return fs::exists(beside) ? beside : fs::path();
}

// A process that misbehaves in place of aspic-assimp, as long as this lives.
class FakeAssimp {
public:
    explicit FakeAssimp(const std::string& script)
        : program_(folder_.write("fake", "#!/bin/sh\n" + script))
    {
        fs::permissions(program_, fs::perms::owner_all);
        if (const char* before = std::getenv("ASPIC_ASSIMP")) kept_ = before;
        setenv("ASPIC_ASSIMP", program_.c_str(), 1);
    }
    FakeAssimp(const FakeAssimp&) = delete;
    FakeAssimp& operator=(const FakeAssimp&) = delete;
    ~FakeAssimp()
    {
        if (kept_.empty()) {
            unsetenv("ASPIC_ASSIMP");
        } else {
            setenv("ASPIC_ASSIMP", kept_.c_str(), 1);
        }
    }

private:
    Folder folder_;
    fs::path program_;
    std::string kept_;
};

}  // namespace files
