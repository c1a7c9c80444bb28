#include "geometry/torn_faces.hpp"

#include "geometry/clip_to_cells.hpp"
#include "geometry/parallel.hpp"
#include "geometry/plane.hpp"

#include <algorithm>

namespace geometry {

namespace {

bool is_torn(const std::array<std::uint32_t, 8>& corners, std::span<const std::uint32_t> broken)
{
    for (std::uint32_t a = 0; a < 8; ++a) {
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            if (a >> axis & 1u) continue;
            if (std::binary_search(broken.begin(), broken.end(), 3 * corners[a] + axis))
                return true;
        }
    }
    return false;
}

// What of a polygon lies in the box: a face may be very much larger than what is torn.
Polygon clipped(Polygon polygon, const Vec3& low, const Vec3& high)
{
    Polygon below, above;
    for (int d = 0; d < 3 && polygon.n > 2; ++d) {
        cut(polygon, d, low[d], below, above);
        cut(above, d, high[d], polygon, below);
    }
    return polygon;
}

}  // namespace

bool in_front(const Vec3i& a, const Vec3i& b)
{
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

Polygon lattice_face(const TriMesh& rest, const Cubes& cubes, std::size_t face, int flat)
{
    Polygon out;
    for (const auto v : rest.triangles()[face]) {
        Vec3 p = (rest.positions[v].cast<double>() - cubes.origin) / cubes.size;
        if (flat >= 0) p[flat] = cubes.cell[0][flat] + 0.5;
        out.add(p);
    }
    return out;
}

Box bounds_of(std::span<const Vec3i> cells)
{
    Box box;
    for (const Vec3i& cell : cells) {
        box.add(Vec3(cell.cast<double>()));
        box.add(Vec3(cell.cast<double>() + Vec3::Ones()));
    }
    return box;
}

std::vector<std::uint8_t> faces_through(const TriMesh& rest, const Cubes& cubes,
                                        std::span<const Vec3i> cells)
{
    std::vector<std::uint8_t> through(rest.triangles().size(), 0);
    if (cells.empty()) return through;
    const Box box = bounds_of(cells);
    const int flat = flat_axis(cubes);
    parallel_for(through.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const Polygon face = lattice_face(rest, cubes, f, flat);
            if (!std::all_of(face.p.begin(), face.p.begin() + 3,
                             [](const Vec3& p) { return p.allFinite(); })) {
                continue;
            }
            const auto note = [&](const Vec3i& cell, const Polygon& piece) {
                if (piece.area() > 0 &&
                    std::binary_search(cells.begin(), cells.end(), cell, in_front)) {
                    through[f] = 1;
                }
            };
            clip_polygon_to_cells(clipped(face, box.lo, box.hi), note);
        }
    });
    return through;
}

std::vector<std::uint8_t> torn_faces(const TriMesh& rest, const Cubes& cubes,
                                     std::span<const std::uint32_t> broken)
{
    std::vector<Vec3i> torn;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (is_torn(cubes.corners[c], broken)) torn.push_back(cubes.cell[c]);
    }
    return faces_through(rest, cubes, torn);
}

TriMesh without_faces(TriMesh mesh, const std::vector<std::uint8_t>& gone)
{
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    const auto keep = [&](auto& per_face) {
        if (per_face.size() != gone.size()) return;
        std::size_t kept = 0;
        for (std::size_t f = 0; f < gone.size(); ++f) {
            if (!gone[f]) per_face[kept++] = per_face[f];
        }
        per_face.resize(kept);
    };
    keep(topology->triangles);
    keep(topology->normal_triangles);
    keep(topology->uv_triangles);
    keep(topology->material);
    keep(topology->group);
    mesh.topology = std::move(topology);
    return mesh;
}

}  // namespace geometry
