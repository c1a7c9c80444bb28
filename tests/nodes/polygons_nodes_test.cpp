// A model of quads through nodes that keep its faces, to a file of quads.

#include "tests/geometry/files.hpp"
#include "tests/nodes/scene.hpp"

#include <sstream>

namespace {

// Vertices in the order in which faces name them, which is that of assimp.
const char* const cube = "o cube\nv 0 2 0\nv 1 2 0\nv 1 1 0\nv 0 1 0\nv 0 1 1\nv 1 1 1\nv 1 2 1\n"
                         "v 0 2 1\nf 1 2 3 4\nf 5 6 7 8\nf 4 3 6 5\nf 3 2 7 6\nf 1 4 5 8\n"
                         "f 2 1 8 7\n";

// The vertices of each face of an OBJ.
std::vector<std::vector<int>> faces_in(const std::string& obj)
{
    std::vector<std::vector<int>> faces;
    std::istringstream lines(obj);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("f ")) continue;
        std::istringstream words(line.substr(2));
        auto& face = faces.emplace_back();
        for (std::string word; words >> word;) face.push_back(std::stoi(word));
    }
    return faces;
}

TEST(PolygonNodes, QuadsAreWrittenAsQuadsAfterTheyWereSimulated)
{
    const files::Folder folder;
    folder.write("cube.obj", cube);
    fixtures::Scene scene(R"(
        "read": { "type": "ReadMesh@1", "params": { "path": "cube.obj" } },
        "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "read.mesh" },
                   "params": { "method": "solid", "size": 0.5 } },
        "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes", "surface": "read.mesh" } },
        "shape": { "type": "Embed@3", "inputs": { "mesh": "read.mesh", "cubes": "cubes", "state": "sim" } },
        "mirrored": { "type": "Transform@1", "inputs": { "mesh": "shape" },
                      "params": { "scale": [-1, 1, 1] } },
        "two": { "type": "Copies@1", "inputs": { "mesh": "mirrored" },
                 "params": { "count_x": 2, "count_z": 1, "step": [2, 0, 0] } },
        "file": { "type": "WriteMesh@1", "inputs": { "mesh": "two" },
                  "params": { "path": "two.##.obj" } })",
                          folder.path, 3);
    const auto file = scene.at<graph::WrittenFile>("file", 3);
    const std::string obj = files::bytes_of(file->path);
    std::vector<std::vector<int>> faces = faces_in(obj);
    ASSERT_EQ(faces.size(), 12u) << obj;
    // The original's, turned over by the mirror, and once more.
    std::vector<std::vector<int>> expected;
    for (const int first : {0, 8}) {
        for (std::vector<int> face : faces_in(cube)) {
            std::reverse(face.begin(), face.end());
            for (int& v : face) v += first;
            expected.push_back(face);
        }
    }
    for (auto* list : {&faces, &expected}) {
        for (auto& face : *list)
            std::rotate(face.begin(), std::ranges::min_element(face), face.end());
    }
    EXPECT_EQ(faces, expected);
}

}  // namespace
