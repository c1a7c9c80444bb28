#include "physics/body/surface_patches.hpp"

#include "geometry/cubes/body_finder.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/wound_out.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <unordered_map>
#include <utility>

// Map: which cube holds a place; thinning out; points and areas of a surface; those of the cubes'
// own outside; corners that a tear lays open.

namespace physics {
namespace {

using geometry::Cubes;
using geometry::Vec3;
using geometry::Vec3i;

struct CellHash {
    std::size_t operator()(const Vec3i& c) const
    {
        std::uint64_t h = 0;
        for (int i = 0; i < 3; ++i) {
            h = (h ^ static_cast<std::uint32_t>(c[i])) * 0x9e3779b97f4a7c15u;
            h ^= h >> 29;
        }
        return h;
    }
};
using CellMap = std::unordered_map<Vec3i, std::uint32_t, CellHash>;

// The cubes of a model, and the body that each vertex of its surface goes with.
struct BodiesOfSurface {
    BodiesOfSurface(const Cubes& model, const geometry::TriMesh& mesh)
        : cubes(model), finder(model), body(finder.bodies_of(mesh))
    {}

    std::uint32_t body_of(std::uint32_t vertex) const
    {
        return body.empty() ? geometry::no_index : body[vertex];
    }

    const Cubes& cubes;
    geometry::BodyFinder finder;
    std::vector<std::uint32_t> body;
};

// A place on the surface, m, of the piece that has a vertex.
struct SurfacePlace {
    Vec3 at;
    std::uint32_t vertex;
};

// The cube that holds it, or the nearest of its neighbours.
std::optional<std::uint32_t> cube_at(const BodiesOfSurface& bodies, const SurfacePlace& p)
{
    const Cubes& cubes = bodies.cubes;
    const Vec3 local = (p.at - cubes.origin) / cubes.size;
    if (!local.allFinite() || local.cwiseAbs().maxCoeff() > 1e9) return std::nullopt;
    const std::uint32_t found = bodies.finder.find_near(local, bodies.body_of(p.vertex));
    if (found == geometry::no_index) return std::nullopt;
    return found;
}

std::array<Vec3f, 3> piece_in(const Cubes& cubes, std::uint32_t c, const std::array<Vec3, 3>& p)
{
    const Vec3 first = (p[0] - cubes.origin) / cubes.size - cubes.cell[c].cast<double>();
    return {first.cast<float>(), ((p[1] - p[0]) / cubes.size).cast<float>(),
            ((p[2] - p[0]) / cubes.size).cast<float>()};
}

// The points of a sixty-fourth of a cube: how its faces look, and which point stands for all.
struct Crowd {
    Vec3f normal = Vec3f::Zero();  // m^2, sum
    float area = 0;                // m^2, of the faces' normals, whichever way they look
    std::optional<std::uint32_t> kept;
    float out = 0;  // how far out that one lies

    // Cubes: along the mean normal, so that corners and edges stay. On a flat face, or where faces
    // look all ways, as far from the cube's middle as can be: a wide foot stands.
    float how_far_out(const Vec3f& place) const
    {
        const float away = (place - Vec3f::Constant(0.5f)).norm();
        const float size = normal.norm();
        return size > 0.2f * area ? place.dot(normal) / size + 1e-3f * away : away;
    }
};

// One point for each sixty-fourth of the cube: the farthest out, with the area of all.
void thin_out(LoosePatch& patch)
{
    constexpr int across = 4;
    if (patch.points.size() <= 8) return;
    std::array<Crowd, across * across * across> crowds;
    const auto crowd_of = [&](const PatchPoint& point) -> Crowd& {
        const Vec3i at = (point.place * float(across)).cast<int>().cwiseMax(0).cwiseMin(across - 1);
        return crowds[static_cast<std::size_t>(at.x() + across * (at.y() + across * at.z()))];
    };
    for (const PatchPoint& point : patch.points) {
        Crowd& crowd = crowd_of(point);
        crowd.normal += point.normal;
        crowd.area += point.area;
    }
    std::vector<PatchPoint> out;
    for (const PatchPoint& point : patch.points) {
        Crowd& crowd = crowd_of(point);
        const float far = crowd.how_far_out(point.place);
        if (!crowd.kept) {
            crowd.kept = static_cast<std::uint32_t>(out.size());
            crowd.out = far;
            out.push_back(point);
            continue;
        }
        PatchPoint& best = out[*crowd.kept];
        const float sum = best.area + point.area;
        if (far > crowd.out) {
            crowd.out = far;
            best = point;
        }
        best.area = sum;
    }
    patch.points = std::move(out);
}

// Normal times area.
Vec3 area_of(const std::array<Vec3, 3>& v)
{
    return 0.5 * (v[1] - v[0]).cross(v[2] - v[0]);
}

// A triangle that is wider than a cube, in `cuts` rows of small ones. The places where those meet
// are numbered by row, 0 .. cuts, and along it, 0 .. row.
struct Subdivided {
    const std::array<Vec3, 3>& v;
    int cuts;
    double side;           // 1, or -1 where it is wound inwards
    double sides_out;      // 1, or 2 of an open surface on a plane
    std::uint32_t vertex;  // one of its own

    // Of the triangle, that each small one is.
    double share() const { return 1.0 / (cuts * cuts); }

    Vec3 at(int row, int along) const
    {
        return v[0] + (row * (v[1] - v[0]) + along * (v[2] - v[1])) / cuts;
    }
    // How many small ones meet there.
    int meeting(int row, int along) const
    {
        const int sides = int(along == 0) + int(along == row) + int(row == cuts);
        return sides == 0 ? 6 : sides == 1 ? 3 : 1;
    }
};

// Points on the faces of a surface, between its vertices: no two in the same sixty-fourth of a
// cube.
class FacePoints {
public:
    explicit FacePoints(const BodiesOfSurface& bodies) : bodies_(bodies) {}

    void add(const SurfacePlace& p, float area, const Vec3f& normal)
    {
        const Vec3 local = 4 / bodies_.cubes.size * (p.at - bodies_.cubes.origin);
        if (!local.allFinite() || local.cwiseAbs().maxCoeff() > 1e9) return;
        const Vec3i place = local.array().floor().cast<int>();
        CellMap& by_place = by_place_[bodies_.body_of(p.vertex)];
        const auto [found, fresh] = by_place.emplace(place, std::uint32_t(positions.size()));
        if (!fresh) {
            areas[found->second] += area;
            normals[found->second] += normal;
        } else if (cube_at(bodies_, p)) {
            positions.push_back(p.at.cast<float>());
            vertices.push_back(p.vertex);
            areas.push_back(area);
            normals.push_back(normal);
        } else {
            by_place.erase(found);
        }
    }
    std::vector<Vec3f> positions;
    std::vector<std::uint32_t> vertices;  // a vertex of the piece that each is on
    std::vector<float> areas;
    std::vector<Vec3f> normals;  // m^2, with the size of the area

private:
    const BodiesOfSurface& bodies_;
    std::map<std::uint32_t, CellMap> by_place_;  // of each body
};

// The corners of a triangle, where they are sound and span an area.
std::optional<std::array<Vec3, 3>> sound_triangle(const geometry::TriMesh& mesh,
                                                  const std::array<std::uint32_t, 3>& t)
{
    std::array<Vec3, 3> v;
    for (std::size_t i = 0; i < 3; ++i) {
        if (t[i] >= mesh.positions.size()) return std::nullopt;
        v[i] = mesh.positions[t[i]].cast<double>();
    }
    const Vec3 area = area_of(v);
    if (!area.allFinite() || area.squaredNorm() == 0) return std::nullopt;
    return v;
}

// Shares a triangle out by pieces a cube wide: their areas to the patches of the cubes that they
// lie in, and points where they meet.
void share_out(const BodiesOfSurface& bodies, const Subdivided& rows, FacePoints& between,
               std::vector<LoosePatch>& patches)
{
    const Vec3 area = area_of(rows.v);
    const double share = rows.share();
    for (int i = 0; i <= rows.cuts && rows.cuts > 1; ++i) {
        for (int k = 0; k <= i; ++k) {
            const int meeting = rows.meeting(i, k);
            if (meeting == 1) continue;  // a vertex
            between.add({rows.at(i, k), rows.vertex},
                        static_cast<float>(meeting * share * area.norm() / 3),
                        (rows.side * meeting * share / 3 * area).cast<float>());
        }
    }
    for (int i = 0; i < rows.cuts; ++i) {
        for (int j = 0; j < 2 * i + 1; ++j) {
            // Row i of cuts has 2 i + 1 small triangles; the j-th stands on its base or, where j is
            // odd, on its tip.
            const int k = j / 2;
            const std::array<Vec3, 3> small{rows.at(i, k), rows.at(i + 1, j % 2 ? k + 1 : k),
                                            j % 2 ? rows.at(i, k + 1) : rows.at(i + 1, k + 1)};
            const auto c = cube_at(bodies, {(small[0] + small[1] + small[2]) / 3, rows.vertex});
            if (!c) continue;
            patches[*c].areas.push_back((rows.sides_out * share * area).cast<float>());
            patches[*c].pieces.push_back(piece_in(bodies.cubes, *c, small));
        }
    }
}

// What belongs to each vertex of a surface.
struct VertexFaces {
    explicit VertexFaces(std::size_t count) : area(count, 0.0f), normal(count, Vec3f::Zero()) {}

    std::vector<float> area;    // m^2
    std::vector<Vec3f> normal;  // m^2, sum of the areas' normals
};

// Points at the vertices, with their areas, and between them.
void embed_points(const BodiesOfSurface& bodies, const geometry::TriMesh& mesh, VertexFaces at,
                  const FacePoints& between, std::vector<LoosePatch>& patches)
{
    geometry::TriMesh points;
    points.positions = mesh.positions;
    points.positions.insert(points.positions.end(), between.positions.begin(),
                            between.positions.end());
    at.area.insert(at.area.end(), between.areas.begin(), between.areas.end());
    at.normal.insert(at.normal.end(), between.normals.begin(), between.normals.end());
    if (!bodies.body.empty()) {  // each goes with the body of its piece
        geometry::MeshTopology joined;
        joined.triangles = mesh.triangles();
        for (std::uint32_t i = 0; i < between.positions.size(); ++i) {
            const auto own = static_cast<std::uint32_t>(mesh.positions.size() + i);
            joined.triangles.push_back({between.vertices[i], own, own});
        }
        points.topology = std::make_shared<const geometry::MeshTopology>(std::move(joined));
    }
    const geometry::Binding binding = geometry::bind(points, bodies.cubes);
    for (std::uint32_t i = 0; i < points.positions.size(); ++i) {
        if (!points.positions[i].allFinite()) continue;
        PatchPoint point{binding.local[i], {}, at.area[i], at.normal[i]};
        const auto weight = geometry::weights(binding, i);
        for (std::size_t a = 0; a < 8; ++a) point.weight[a] = static_cast<float>(weight[a]);
        patches[binding.used[binding.cube[i]]].points.push_back(point);
    }
}

// A plane's upper corners are its lower ones: one weight each.
void flatten(LoosePatch& patch, int flat)
{
    const std::size_t upper = std::size_t{1} << flat;
    for (PatchPoint& point : patch.points) {
        for (std::size_t a = 0; a < 8; ++a) {
            if (a & upper) point.weight[a & ~upper] += std::exchange(point.weight[a], 0.0f);
        }
    }
}

}  // namespace

std::vector<LoosePatch> patches_of_surface(const Cubes& cubes, const geometry::TriMesh& mesh)
{
    const BodiesOfSurface bodies(cubes, mesh);
    std::vector<LoosePatch> patches(cubes.count());
    VertexFaces faces(mesh.positions.size());
    FacePoints between(bodies);
    const std::vector<geometry::Triangle> out = geometry::wound_out(mesh).triangles;
    const int flat = geometry::flat_axis(cubes);
    const bool one_side = flat < 0 || geometry::is_closed(out, mesh.positions.size());
    const double sides_out = one_side ? 1 : 2;
    for (std::size_t i = 0; i < out.size(); ++i) {
        const geometry::Triangle& t = mesh.triangles()[i];
        const auto v = sound_triangle(mesh, t);
        if (!v) continue;
        const double longest = std::max(
            {((*v)[1] - (*v)[0]).norm(), ((*v)[2] - (*v)[1]).norm(), ((*v)[0] - (*v)[2]).norm()});
        const Subdivided rows{
            *v, static_cast<int>(std::clamp(std::ceil(longest / cubes.size), 1.0, 64.0)),
            out[i] == t ? 1.0 : -1.0, sides_out, t[0]};
        const Vec3 area = area_of(*v);
        for (const auto corner : t) {
            faces.area[corner] += static_cast<float>(rows.share() * area.norm() / 3);
            faces.normal[corner] += (rows.side * rows.share() / 3 * area).cast<float>();
        }
        share_out(bodies, rows, between, patches);
    }
    embed_points(bodies, mesh, std::move(faces), between, patches);
    for (LoosePatch& patch : patches) {
        thin_out(patch);
        if (flat >= 0) flatten(patch, flat);
    }
    return patches;
}

namespace {

PatchPoint corner_point(unsigned a, float area)
{
    PatchPoint point{Vec3f(float(a & 1), float(a >> 1 & 1), float(a >> 2 & 1)), {}, area};
    point.weight[a] = 1;
    return point;
}

std::array<std::uint32_t, 4> face_corners(const Cubes& cubes, std::uint32_t c, int axis, int side)
{
    std::array<std::uint32_t, 4> out;
    std::size_t n = 0;
    for (unsigned a = 0; a < 8; ++a) {
        if (int(a >> axis & 1) == side) out[n++] = cubes.corners[c][a];
    }
    return out;
}

// Which faces of which cubes others cover, as bits 2 axis + side: with any cube in the next cell,
// or of pieces with one that has the same corners.
std::vector<std::uint8_t> covered_faces(const Cubes& cubes, const geometry::CubeFinder& finder)
{
    std::vector<std::uint8_t> out(cubes.count(), 0);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (int f = 0; f < 6; ++f) {
            const int axis = f / 2, side = f % 2;
            Vec3i step = Vec3i::Zero();
            step[axis] = side ? 1 : -1;
            const auto found = finder.in_cell(cubes.cell[c] + step);
            bool covers = found && cubes.part.empty();
            for (std::uint32_t other = found.begin; !covers && other < found.end; ++other) {
                covers = face_corners(cubes, c, axis, side) ==
                         face_corners(cubes, other, axis, 1 - side);
            }
            if (covers) out[c] = static_cast<std::uint8_t>(out[c] | 1u << f);
        }
    }
    return out;
}

}  // namespace

std::vector<LoosePatch> patches_of_cubes(const Cubes& cubes)
{
    const geometry::CubeFinder finder(cubes);
    std::vector<LoosePatch> patches(cubes.count());
    const auto face = static_cast<float>(cubes.size * cubes.size);
    std::vector<float> area_at(cubes.corner_count(), 0.0f);
    const std::vector<std::uint8_t> covered = covered_faces(cubes, finder);
    const int flat = geometry::flat_axis(cubes);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (int f = 0; f < 6; ++f) {
            const int axis = f / 2, side = f % 2;
            if (flat >= 0 && axis != flat) continue;
            Vec3i step = Vec3i::Zero();
            step[axis] = side ? 1 : -1;
            if (covered[c] >> f & 1) continue;
            // Two triangles, from opposite corners of the face.
            for (const float end : {0.0f, 1.0f}) {
                Vec3f corner = Vec3f::Constant(end);
                corner[axis] = float(side);
                const float along = 1 - 2 * end;
                patches[c].areas.push_back(face / 2 * step.cast<float>());
                patches[c].pieces.push_back({corner, along * Vec3f::Unit((axis + 1) % 3),
                                             along * Vec3f::Unit((axis + 2) % 3)});
            }
            for (unsigned a = 0; a < 8; ++a) {
                if (int(a >> axis & 1) == side) area_at[cubes.corners[c][a]] += face / 4;
            }
        }
    }
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (unsigned a = 0; a < 8; ++a) {
            float& area = area_at[cubes.corners[c][a]];
            if (area == 0) continue;
            patches[c].points.push_back(corner_point(a, area));
            area = 0;  // taken
        }
    }
    return patches;
}

std::vector<LoosePatch> patches_of_sheet(const Cubes& cubes)
{
    std::vector<LoosePatch> patches(cubes.count());
    std::vector<float> area_at(cubes.corner_count(), 0.0f);
    const auto half = static_cast<float>(cubes.size * cubes.size / 2);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const float side : {-1.0f, 1.0f}) {
            // The cell is a square that has shrunk to the triangle; of its halves one ends at
            // either end of the side that is a point. So its corners have a third each.
            for (const float end : {0.0f, 1.0f}) {
                patches[c].areas.emplace_back(0, 0, side * half);
                patches[c].pieces.push_back({Vec3f::Zero(), Vec3f::Unit(0), Vec3f(end, 1, 0)});
            }
        }
        const auto area = static_cast<float>(geometry::cell_area(cubes, c));
        for (const auto k : geometry::sheet_triangle(cubes, c)) area_at[k] += 2 * area / 3;
    }
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (unsigned a = 0; a < 3; ++a) {
            const float area = std::exchange(area_at[cubes.corners[c][a]], 0.0f);
            if (area > 0) patches[c].points.push_back(corner_point(a, area));
        }
    }
    return patches;
}

void add_corners_within(const Cubes& cubes, std::vector<LoosePatch>& patches)
{
    std::vector<std::uint8_t> held(cubes.corner_count(), 0);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (const PatchPoint& point : patches[c].points) {
            for (std::size_t a = 0; a < 8; ++a) {
                if (point.weight[a] > 0) held[cubes.corners[c][a]] = 1;
            }
        }
    }
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        for (unsigned a = 0; a < 8; ++a) {
            if (std::exchange(held[cubes.corners[c][a]], std::uint8_t{1})) continue;
            patches[c].within.push_back(corner_point(a, 0));
        }
    }
}

}  // namespace physics
