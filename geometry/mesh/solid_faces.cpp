#include "geometry/mesh/solid_faces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/doubled_faces.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/wound_out.hpp"

namespace geometry {

SolidFaces solid_faces(const TriMesh& mesh, std::span<const std::uint16_t> kind)
{
    const DoubledFaces faces = doubled_faces(mesh, kind);
    TriMesh once;
    once.positions = mesh.positions;
    auto topology = std::make_shared<MeshTopology>();
    SolidFaces out;
    for (std::uint32_t t = 0; t < faces.triangles.size(); ++t) {
        const Doubled is = faces.is[t];
        if (adds_to_solid(is)) {
            topology->triangles.push_back(faces.triangles[t]);
            out.source.push_back(t);
        } else if (is != Doubled::unsound) {
            ++out.doubled;
        }
    }
    once.topology = std::move(topology);
    WoundOut wound = wound_out(once);
    out.triangles = std::move(wound.triangles);
    out.turned = wound.turned;
    return out;
}

TriMesh mesh_of(const TriMesh& mesh, const SolidFaces& faces)
{
    TriMesh out;
    std::vector<std::uint32_t> number(mesh.positions.size(), no_index);
    for (const Triangle& t : faces.triangles) {
        for (const std::uint32_t v : t) number[v] = 0;
    }
    for (std::size_t v = 0; v < number.size(); ++v) {
        if (number[v] == no_index) continue;
        number[v] = static_cast<std::uint32_t>(out.positions.size());
        out.positions.push_back(mesh.positions[v]);
    }
    auto topology = std::make_shared<MeshTopology>();
    for (const auto& [a, b, c] : faces.triangles) {
        topology->triangles.push_back({number[a], number[b], number[c]});
    }
    out.topology = std::move(topology);
    return out;
}

}  // namespace geometry
