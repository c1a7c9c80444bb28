#include "geometry/cubes/solid_matter.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/cubes/closed_parts.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geometry {
namespace {

// A volume in a cube of the face nearest to its middle, of a part or of all faces.
struct Wanted {
    std::uint32_t part, cube;  // part: or no_index
    double volume;
};

struct Sharing {
    const Solid& solid;
    std::vector<ClosedPart> parts;
    std::vector<std::uint32_t> part_of;  // of each lattice triangle, or no_index
    std::vector<Deposit> deposits;
    std::vector<Wanted> wanted;
};

std::vector<FaceInCube> by_cube(std::vector<FaceInCube> faces)
{
    std::stable_sort(faces.begin(), faces.end(),
                     [](const auto& a, const auto& b) { return a.cube < b.cube; });
    return faces;
}

// Shares a volume between the faces that are asked for, by area. False where there are none.
template <class Is>
bool share_by_area(Sharing& sharing, std::span<const FaceInCube> faces, double volume, const Is& is)
{
    double sum = 0;
    for (const FaceInCube& f : faces) sum += is(f) ? f.area : 0;
    if (!(sum > 0)) return false;
    for (const FaceInCube& f : faces) {
        if (!is(f)) continue;
        const std::uint32_t source = sharing.solid.lattice.source_of(f.triangle);
        sharing.deposits.push_back(
            {f.cube, sharing.solid.matter.of(source), f.area * (volume / sum)});
    }
    return true;
}

void share_cube(Sharing& sharing, std::uint32_t cube, std::span<const FaceInCube> faces,
                std::span<const PartShare> shares, double volume)
{
    const auto any = [](const FaceInCube&) { return true; };
    const auto loose = [&](const FaceInCube& f) { return sharing.part_of[f.triangle] == no_index; };
    double loose_area = 0, inside = 0;
    for (const FaceInCube& f : faces) loose_area += loose(f) ? f.area : 0;
    for (const PartShare& s : shares) inside += s.share;
    const double thickness = sharing.solid.thickness;
    if (shares.empty() || (loose_area > 0 && !(thickness > 0))) {
        if (!share_by_area(sharing, faces, volume, any)) {
            sharing.wanted.push_back({no_index, cube, volume});
        }
        return;
    }
    const double sheet = std::min(volume, loose_area * thickness);
    if (sheet > 0) share_by_area(sharing, faces, sheet, loose);
    for (const PartShare& s : shares) {
        const double own = (volume - sheet) * s.share / inside;
        const ClosedPart& part = sharing.parts[s.part];
        if (part.one_matter) {
            const std::uint32_t source = sharing.solid.lattice.source_of(part.triangles[0]);
            sharing.deposits.push_back({cube, sharing.solid.matter.of(source), own});
            continue;
        }
        const auto of_part = [&](const FaceInCube& f) {
            return sharing.part_of[f.triangle] == s.part;
        };
        if (!share_by_area(sharing, faces, own, of_part)) {
            sharing.wanted.push_back({s.part, cube, own});
        }
    }
}

// The faces of a closed part as a mesh; `source`: which of the solid's each of them is.
TriMesh mesh_of(const Solid& solid, const ClosedPart& part, std::vector<std::uint32_t>& source)
{
    TriMesh out;
    auto topology = std::make_shared<MeshTopology>();
    source.clear();
    for (const auto t : part.triangles) {
        source.push_back(solid.lattice.source_of(t));
        topology->triangles.push_back(solid.lattice.triangles[t]);  // turned out
    }
    std::vector<std::uint32_t> used;  // vertices of a few triangles among many
    for (const Triangle& t : topology->triangles) used.insert(used.end(), t.begin(), t.end());
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (const std::uint32_t v : used) out.positions.push_back(solid.mesh.positions[v]);
    for (Triangle& t : topology->triangles) {
        for (auto& v : t) {
            v = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) -
                                           used.begin());
        }
    }
    out.topology = std::move(topology);
    return out;
}

void deposit_nearest(Sharing& sharing, const Cubes& cubes)
{
    auto& wanted = sharing.wanted;
    std::stable_sort(wanted.begin(), wanted.end(),
                     [](const Wanted& a, const Wanted& b) { return a.part < b.part; });
    for (std::size_t i = 0; i < wanted.size();) {
        std::size_t end = i;
        std::vector<Vec3> centres;
        for (; end < wanted.size() && wanted[end].part == wanted[i].part; ++end) {
            centres.push_back(
                cubes.origin +
                cubes.size * (cubes.cell[wanted[end].cube].cast<double>() + Vec3::Constant(0.5)));
        }
        std::vector<TriangleBvh::Hit> nearest(centres.size());
        const double far = std::numeric_limits<double>::infinity();
        std::vector<std::uint32_t> source;  // of the part's triangles
        if (wanted[i].part == no_index) {
            TriangleBvh(sharing.solid.mesh).closest(centres, far, nearest);
        } else {
            const TriMesh part = mesh_of(sharing.solid, sharing.parts[wanted[i].part], source);
            TriangleBvh(part).closest(centres, far, nearest);
        }
        for (std::size_t k = i; k < end; ++k) {
            const std::uint32_t hit = nearest[k - i].triangle;
            const std::uint32_t triangle = source.empty() ? hit : source[hit];
            sharing.deposits.push_back(
                {wanted[k].cube, sharing.solid.matter.of(triangle), wanted[k].volume});
        }
        i = end;
    }
}

}  // namespace

std::vector<Deposit> matter_of_solid(const Solid& solid, const Cubes& cubes,
                                     const std::vector<FaceInCube>& all,
                                     std::span<const double> volume)
{
    const std::vector<FaceInCube> faces = by_cube(all);
    Sharing sharing{solid, find_closed_parts(solid.lattice, solid.matter), {}, {}, {}};
    sharing.part_of.assign(solid.lattice.triangles.size(), no_index);
    for (std::uint32_t p = 0; p < sharing.parts.size(); ++p) {
        for (const auto t : sharing.parts[p].triangles) sharing.part_of[t] = p;
    }
    std::vector<std::uint8_t> cut(cubes.count(), 0);
    for (const FaceInCube& f : faces) cut[f.cube] = 1;
    const auto shares = part_shares(solid.lattice, sharing.parts, solid.rule, cubes, cut);
    sharing.deposits.reserve(cubes.count() + faces.size());
    std::size_t face = 0, share = 0;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const std::size_t first_face = face, first_share = share;
        while (face < faces.size() && faces[face].cube == c) ++face;
        while (share < shares.size() && shares[share].cube == c) ++share;
        share_cube(sharing, c, std::span(faces).subspan(first_face, face - first_face),
                   std::span(shares).subspan(first_share, share - first_share), volume[c]);
    }
    deposit_nearest(sharing, cubes);
    return sharing.deposits;
}

std::vector<std::uint16_t> matter_at(const Solid& solid, std::span<const Vec3> points)
{
    std::vector<std::uint16_t> out(points.size(), 0);
    std::vector<std::uint8_t> found(points.size(), 0);
    // The largest part first: what lies in a smaller one is written over, unless that is a hollow.
    for (const ClosedPart& part : find_closed_parts(solid.lattice, solid.matter)) {
        std::vector<std::uint32_t> source;
        const TriMesh part_mesh = mesh_of(solid, part, source);
        const TriangleBvh tree(part_mesh);
        const Box box = triangle_bounds(part_mesh);
        parallel_for(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                const Vec3& p = points[i];
                if ((p.array() < box.lo.array()).any() || (p.array() > box.hi.array()).any()) {
                    continue;
                }
                const double winding = tree.winding_number(p);
                const bool hollow = solid.rule == Inside::winding && winding < 0;
                if (std::abs(winding) <= 0.5 || (hollow && found[i] != 0)) continue;
                out[i] = solid.matter.of(source[part.one_matter ? 0 : tree.closest(p).triangle]);
                found[i] = 1;
            }
        });
    }
    if (std::find(found.begin(), found.end(), 0) == found.end()) return out;
    const TriangleBvh all(solid.mesh);
    parallel_for(points.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (found[i] != 0) continue;
            if (const auto hit = all.closest(points[i])) out[i] = solid.matter.of(hit.triangle);
        }
    });
    return out;
}

}  // namespace geometry
