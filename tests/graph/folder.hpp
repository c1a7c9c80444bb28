#pragma once

// Folders for tests that write files.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace toys {

// A new empty folder for a test, removed with it.
struct Folder {
    std::filesystem::path path;

    Folder()
    {
        std::string name = (std::filesystem::temp_directory_path() / "graph_XXXXXX").string();
        path = std::filesystem::canonical(::mkdtemp(name.data()));
    }
    ~Folder() { std::filesystem::remove_all(path); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::filesystem::path write(const std::string& name, const std::string& text) const
    {
        std::filesystem::create_directories((path / name).parent_path());
        std::ofstream(path / name) << text;
        return path / name;
    }
};

}  // namespace toys
