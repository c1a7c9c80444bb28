#include "geometry/embed/torn_faces.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polygons.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geometry {

namespace {

constexpr double in_plane = 1e-5;  // cubes: what positions in single precision are off by, and more

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

// Calls visit(cell) with the 26 around one.
template <class Visit> void for_around(const Vec3i& cell, const Visit& visit)
{
    for (int k = 0; k < 27; ++k) {
        if (k != 13) visit(Vec3i(cell + Vec3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)));
    }
}

}  // namespace

bool in_front(const Vec3i& a, const Vec3i& b)
{
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

CellsAround::CellsAround(const Cubes& cubes, std::vector<Vec3i> cells)
    : cells_(std::move(cells)), cubes_(cubes.cell)
{
    for (const Vec3i& cell : cells_) {
        box_.add(Vec3(cell.cast<double>() - Vec3::Ones()));
        box_.add(Vec3(cell.cast<double>() + 2 * Vec3::Ones()));
        for_around(cell, [&](const Vec3i& next) {
            if (!cubes_.find(next)) around_.push_back(next);
        });
    }
    std::ranges::sort(around_, in_front);
    around_.erase(std::unique(around_.begin(), around_.end()), around_.end());
}

std::uint32_t CellsAround::find(const Vec3i& cell, const Polygon& piece, bool alone) const
{
    const auto number = [&](const Vec3i& of) {
        const auto at = std::ranges::lower_bound(cells_, of, in_front);
        return at != cells_.end() && *at == of ? std::uint32_t(at - cells_.begin()) : no_index;
    };
    if (alone || !std::ranges::binary_search(around_, cell, in_front)) return number(cell);
    Vec3 middle = Vec3::Zero();
    for (std::size_t k = 0; k < piece.n; ++k) middle += piece.p[k] / double(piece.n);
    double least = std::numeric_limits<double>::infinity();
    Vec3i nearest = cell;
    for_around(cell, [&](const Vec3i& next) {
        if (!cubes_.find(next)) return;
        const Vec3 low = next.cast<double>();
        const double away =
            (middle - middle.cwiseMax(low).cwiseMin(low + Vec3::Ones())).squaredNorm();
        if (away >= least) return;
        least = away;
        nearest = next;
    });
    return number(nearest);
}

FacesAlone::FacesAlone(const Binding& binding, const TriMesh& rest) : triangles_(rest.triangles())
{
    for (const Binding::Stray& stray : binding.strays) {
        if (stray.anchor != Vec3f::Constant(0.5f)) continue;
        if (vertices_.empty()) vertices_.resize(rest.positions.size(), 0);
        vertices_[stray.vertex] = 1;
    }
}

bool FacesAlone::operator[](std::size_t face) const
{
    if (vertices_.empty()) return false;
    return std::ranges::all_of(triangles_[face], [&](auto v) { return vertices_[v] != 0; });
}

Polygon lattice_face(const TriMesh& rest, const Cubes& cubes, std::size_t face, int flat)
{
    Polygon out;
    for (const auto v : rest.triangles()[face]) {
        Vec3 at = (rest.positions[v].cast<double>() - cubes.origin) / cubes.size;
        for (double& along : at) {
            const double plane = std::round(2 * along) / 2;
            if (std::abs(along - plane) < in_plane) along = plane;
        }
        out.add(at);
    }
    if (flat < 0) return out;
    const double middle = cubes.cell[0][flat] + 0.5;
    double highest = 1;
    for (std::size_t k = 0; k < out.n; ++k) {
        highest = std::max(highest, std::abs(out.p[k][flat] - middle));
    }
    for (std::size_t k = 0; k < out.n; ++k) {
        out.p[k][flat] = middle + (out.p[k][flat] - middle) / (4 * highest);
    }
    return out;
}

std::vector<std::uint8_t> faces_through(const TriMesh& rest, const Cubes& cubes,
                                        const CellsAround& cells, const FacesAlone& alone)
{
    std::vector<std::uint8_t> through(rest.triangles().size(), 0);
    if (cells.cells().empty()) return through;
    const int flat = flat_axis(cubes);
    parallel_for(through.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const Polygon face = lattice_face(rest, cubes, f, flat);
            if (!std::all_of(face.p.begin(), face.p.begin() + 3,
                             [](const Vec3& p) { return p.allFinite(); })) {
                continue;
            }
            const auto note = [&](const Vec3i& cell, const Polygon& piece) {
                if (piece.area() > 0 && cells.find(cell, piece, alone[f]) != no_index) {
                    through[f] = 1;
                }
            };
            clip_polygon_to_cells(clipped(face, cells.box().lo, cells.box().hi), note);
        }
    });
    return through;
}

std::vector<std::uint8_t> torn_faces(const Binding& binding, const TriMesh& rest,
                                     const Cubes& cubes, std::span<const std::uint32_t> broken)
{
    if (broken.empty()) return std::vector<std::uint8_t>(rest.triangles().size(), 0);
    std::vector<Vec3i> torn;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (is_torn(cubes.corners[c], broken)) torn.push_back(cubes.cell[c]);
    }
    return faces_through(rest, cubes, CellsAround(cubes, std::move(torn)), {binding, rest});
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
    topology->polygon = polygons_left(mesh.topology->polygon, gone);
    mesh.topology = std::move(topology);
    return mesh;
}

}  // namespace geometry
