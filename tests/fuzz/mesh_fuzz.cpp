// Any bytes as what the importer hands over, or as a PLY file: a mesh that is consistent, or an
// exception, never a crash. (assimp itself runs in a process of its own, whose end is an error.)

#include "geometry/io/assemble_mesh.hpp"
#include "geometry/io/read_ply.hpp"
#include "geometry/mesh/polygons.hpp"

#include <cstdlib>

namespace {

void check(const geometry::ImportedScene& scene)
{
    const geometry::TriMesh mesh = geometry::assemble_mesh(scene).mesh;
    for (const geometry::Triangle& t : mesh.triangles()) {
        for (const auto v : t) {
            if (v >= mesh.positions.size()) std::abort();
        }
    }
    for (const auto& p : mesh.positions) {
        if (!p.allFinite()) std::abort();
    }
    const geometry::Outlines faces = geometry::outlines(*mesh.topology);
    std::size_t triangles = 0;
    for (std::size_t p = 0; p < faces.count(); ++p) {
        if (faces[p].size() < 3 || faces.first_triangle(p) != triangles) std::abort();
        triangles += faces[p].size() - 2;
        for (const std::uint32_t corner : faces[p]) {
            if (corner / 3 >= mesh.triangles().size()) std::abort();
        }
    }
    if (triangles != mesh.triangles().size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    if (size == 0) return 0;
    const char* const text = reinterpret_cast<const char*>(data);
    try {
        check(data[0] == 'p' ? geometry::read_ply({text, size})
                             : geometry::unpack<geometry::ImportedScene>(text + 1, size - 1));
    } catch (const std::runtime_error&) {
    } catch (const std::invalid_argument&) {
    }
    return 0;
}
