#include "geometry/embed/cut_faces.hpp"

#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/embed/cut_caps.hpp"
#include "geometry/embed/torn_faces.hpp"

#include <algorithm>
#include <limits>

namespace geometry {
namespace {

// Cuts one face after the other.
struct FaceCutter {
    std::span<const PartedCube> parted;
    const CellsAround& around;  // the parted cubes
    const Cubes& cubes;
    const TriangleBvh* solid;  // the mesh, or null
    CutFaces& out;
    std::vector<CutEdge> edges;  // where faces cross the planes between parts

    std::uint32_t f = 0;  // the face that is being cut
    Polygon face;         // itself, lattice coordinates
    bool beyond = false;  // the piece that is being cut lies outside of all cubes
};

std::array<double, 3> shares(const Polygon& face, const Vec3& p)
{
    const Vec3 a = face.p[1] - face.p[0], b = face.p[2] - face.p[0], to = p - face.p[0];
    const Vec3 n = a.cross(b);
    const double sq = n.squaredNorm();
    const double one = to.cross(b).dot(n) / sq, two = a.cross(to).dot(n) / sq;
    return {1 - one - two, one, two};
}

void add(FaceCutter& cutter, const Polygon& piece, std::uint32_t part)
{
    if (piece.n < 3 || !(piece.area() > 0)) return;
    const auto first = std::uint32_t(cutter.out.corners.size());
    for (std::size_t k = 0; k < piece.n; ++k) {
        cutter.out.corners.push_back({cutter.f, part, piece.p[k], shares(cutter.face, piece.p[k])});
    }
    for (std::uint32_t k = 2; k < piece.n; ++k) {
        cutter.out.faces.push_back({first, first + k - 1, first + k});
    }
}

// Where what was cut meets the plane it was cut by, unless it lies in that. Points that are one
// but for rounding may be several.
void add_edge(FaceCutter& cutter, std::uint32_t parted, int axis, const Polygon& below)
{
    const double plane = cutter.around.cells()[parted][axis] + 0.5;
    Polygon on;
    for (std::size_t k = 0; k < below.n; ++k) {
        if (below.p[k][axis] == plane) on.add(below.p[k]);
    }
    if (on.n < 2 || (on.n > 2 && on.n == below.n)) return;
    CutEdge longest{parted, axis, on.p[0], on.p[1]};
    for (std::size_t i = 0; i < on.n; ++i) {
        for (std::size_t j = i + 1; j < on.n; ++j) {
            const double length = (on.p[j] - on.p[i]).squaredNorm();
            if (length <= (longest.to - longest.from).squaredNorm()) continue;
            longest.from = on.p[i];
            longest.to = on.p[j];
        }
    }
    cutter.edges.push_back(longest);
}

bool lies_in_plane(const Polygon& piece, int axis, double at)
{
    return std::all_of(piece.p.begin(), piece.p.begin() + std::ptrdiff_t(piece.n),
                       [&](const Vec3& p) { return p[axis] == at; });
}

// Whether a piece that lies in a plane between parts goes with the part below it: with the solid
// that it bounds.
bool is_of_below(const FaceCutter& cutter, const Polygon& piece, int axis)
{
    const auto& p = cutter.face.p;
    if (!cutter.solid) return (p[1] - p[0]).cross(p[2] - p[0])[axis] > 0;
    Vec3 middle = Vec3::Zero();
    for (std::size_t k = 0; k < piece.n; ++k) middle += piece.p[k] / double(piece.n);
    const auto [under, over] = winding_beside(cutter.cubes, *cutter.solid, middle, axis);
    return std::abs(under) > 0.5 || std::abs(over) <= 0.5;
}

// Cuts a piece by the planes between parts, an axis at a time: `octant` says which side along
// those before.
void add_parts(FaceCutter& cutter, const Polygon& piece, std::uint32_t parted, unsigned axis,
               unsigned octant)
{
    const PartedCube& cube = cutter.parted[parted];
    bool one = true, alike = true;  // of all octants left, of those beside each other
    for (unsigned o = octant; o < 8; o += 1u << axis) {
        one &= cube.part[o] == cube.part[octant];
        if (axis < 3) alike &= cube.part[o] == cube.part[o ^ 1u << axis];
    }
    if (one) return add(cutter, piece, 8 * parted + cube.part[octant]);
    if (alike) return add_parts(cutter, piece, parted, axis + 1, octant);
    const double middle = cutter.around.cells()[parted][Eigen::Index(axis)] + 0.5;
    if (lies_in_plane(piece, int(axis), middle)) {
        const unsigned side = is_of_below(cutter, piece, int(axis)) ? 0 : 1u << axis;
        return add_parts(cutter, piece, parted, axis + 1, octant | side);
    }
    Polygon below, above;
    cut(piece, int(axis), middle, below, above);
    if (!cutter.beyond) add_edge(cutter, parted, int(axis), below);  // cubes are closed themselves
    if (below.n > 2) add_parts(cutter, below, parted, axis + 1, octant);
    if (above.n > 2) add_parts(cutter, above, parted, axis + 1, octant | 1u << axis);
}

// `alone`: the face is of a piece of the mesh that goes with one cube (FacesAlone).
void cut_face(FaceCutter& cutter, bool alone)
{
    const Polygon& face = cutter.face;
    const Vec3 a = face.p[1] - face.p[0], b = face.p[2] - face.p[0];
    if (!(a.cross(b).norm() > 1e-10 * a.norm() * b.norm())) return;  // a line: nothing to see
    // What lies beyond all parted cubes stays in large pieces.
    Polygon inside = face, below, above;
    for (int d = 0; d < 3; ++d) {
        cut(inside, d, cutter.around.box().lo[d], below, above);
        add(cutter, below, no_index);
        cut(above, d, cutter.around.box().hi[d], inside, below);
        add(cutter, below, no_index);
    }
    clip_polygon_to_cells(inside, [&](const Vec3i& cell, const Polygon& piece) {
        const std::uint32_t parted = cutter.around.find(cell, piece, alone);
        cutter.beyond = parted != no_index && cutter.around.cells()[parted] != cell;
        if (parted == no_index) {
            add(cutter, piece, no_index);
        } else {
            add_parts(cutter, piece, parted, 0, 0);
        }
    });
}

// Adds the faces that close what was cut.
void close(const Cubes& cubes, std::span<const PartedCube> parted, std::vector<CutEdge> edges,
           const TriangleBvh& solid, CutFaces& out)
{
    const std::vector<Cap> caps = find_caps(cubes, parted, std::move(edges), solid);
    std::vector<Vec3> places;
    for (const Cap& cap : caps) {
        for (const Vec3& at : cap.corners) places.push_back(cubes.origin + cubes.size * at);
    }
    std::vector<TriangleBvh::Hit> nearest(places.size());
    solid.closest(places, std::numeric_limits<double>::infinity(), nearest);
    auto hit = nearest.begin();
    for (const Cap& cap : caps) {
        const auto first = std::uint32_t(out.corners.size());
        for (const Vec3& at : cap.corners) {
            const Vec3& share = hit->barycentric;
            out.corners.push_back(
                {hit->triangle, cap.part, at, {share[0], share[1], share[2]}, cap.outward});
            ++hit;
        }
        for (std::uint32_t k = 2; k < cap.corners.size(); ++k) {
            out.faces.push_back({first, first + k - 1, first + k});
        }
    }
}

}  // namespace

CutFaces cut_faces(const Binding& binding, const TriMesh& rest, const Cubes& cubes,
                   std::span<const PartedCube> parted, const TriangleBvh* solid)
{
    const CellsAround around(cubes, cells_of(cubes, parted));
    const FacesAlone alone(binding, rest);
    const int flat = flat_axis(cubes);
    CutFaces out;
    out.cut = faces_through(rest, cubes, around, alone);
    FaceCutter cutter{parted, around, cubes, solid, out, {}, 0, {}, false};
    for (std::uint32_t f = 0; f < out.cut.size(); ++f) {
        if (!out.cut[f]) continue;
        cutter.f = f;
        cutter.face = lattice_face(rest, cubes, f, flat);
        cut_face(cutter, alone[f]);
    }
    if (solid && flat < 0) close(cubes, parted, std::move(cutter.edges), *solid, out);
    return out;
}

}  // namespace geometry
