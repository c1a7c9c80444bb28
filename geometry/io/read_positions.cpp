#include "geometry/io/read_positions.hpp"

#include "geometry/base/whole_file.hpp"
#include "geometry/io/file_vertices.hpp"
#include "geometry/io/point_cache.hpp"
#include "geometry/io/read_ply.hpp"
#include "geometry/io/read_points.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace geometry {
namespace {

std::vector<Vec3f> positions_in(const std::string& bytes, const std::string& ending,
                                const std::filesystem::path& path)
{
    if (ending == ".obj") return obj_vertices(bytes);
    ImportedScene scene;
    if (ending == ".ply") {
        scene = read_ply(bytes);
    } else if (is_points_file(path)) {
        scene = read_points(bytes);
    } else {
        throw std::runtime_error("expected a .ply, .obj, .xyz, .pts, .asc or .pc2");
    }
    return scene.meshes.at(0).own_positions();
}

}  // namespace

std::vector<Vec3f> read_positions(const std::filesystem::path& path, int frame)
{
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (ending == ".pc2") return read_sample(path, frame);
    const auto bytes = read_whole_file(path);
    if (!bytes) throw std::runtime_error(path.string() + " cannot be read");
    try {
        return positions_in(*bytes, ending, path);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

}  // namespace geometry
