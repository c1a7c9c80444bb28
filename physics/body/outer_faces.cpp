#include "physics/body/outer_faces.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"
#include "geometry/mesh/winding_walk.hpp"
#include "physics/body/halved_triangle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace physics {
namespace {

using geometry::TriMesh;
using geometry::Vec3;

using Corners = std::array<Vec3, 3>;  // m

struct Cutter {
    geometry::WindingWalk walk;
    double size;  // m

    // Whether one side of a face is outside of all pieces at some place on it.
    bool is_outer(const Vec3& place, const Vec3& normal)
    {
        const Vec3 off = 1e-3 * size * normal;
        return !walk.inside(place + off) || !walk.inside(place - off);
    }

    // Of four places on a triangle, near the corners and in the middle, how many are outer ones.
    int outer_places(const Corners& t, const Vec3& normal)
    {
        constexpr double near = 0.9, far = 0.05;
        int out = is_outer((t[0] + t[1] + t[2]) / 3, normal) ? 1 : 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Vec3 place = near * t[i] + far * (t[(i + 1) % 3] + t[(i + 2) % 3]);
            out += is_outer(place, normal) ? 1 : 0;
        }
        return out;
    }

    // Adds what is on the outside. Returns whether that is all of the triangle.
    bool cut(const Corners& t, const Vec3& normal, std::vector<Corners>& out)
    {
        const HalvedTriangle halved(t);
        const Vec3 centre = (t[0] + t[1] + t[2]) / 3;
        const int outer = halved.longest <= size / 2 ? (is_outer(centre, normal) ? 4 : 0)
                          : halved.longest <= size   ? outer_places(t, normal)
                                                     : 0;
        if (halved.longest > size || (outer > 0 && outer < 4)) {
            const bool first = cut(halved.first, normal, out);
            const bool second = cut(halved.second, normal, out);
            return first && second;
        }
        if (outer > 0) out.push_back(t);
        return outer > 0;
    }
};

// Triangles as a mesh in which those that meet share vertices.
TriMesh welded(const std::vector<std::vector<Corners>>& triangles)
{
    TriMesh out;
    geometry::MeshTopology topology;
    std::map<std::array<float, 3>, std::uint32_t> number;
    for (const auto& some : triangles) {
        for (const Corners& t : some) {
            geometry::Triangle own;
            for (std::size_t i = 0; i < 3; ++i) {
                const geometry::Vec3f p = t[i].cast<float>();
                const auto [at, fresh] = number.try_emplace(
                    {p.x(), p.y(), p.z()}, static_cast<std::uint32_t>(out.positions.size()));
                if (fresh) out.positions.push_back(p);
                own[i] = at->second;
            }
            topology.triangles.push_back(own);
        }
    }
    out.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
    return out;
}

}  // namespace

std::optional<TriMesh> outer_faces(const TriMesh& mesh, const geometry::TriangleBvh& tree,
                                   double size)
{
    constexpr double most = 25'000;  // cut triangles, about
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    if (pieces.count() < 2) return std::nullopt;
    const double area = std::accumulate(pieces.area.begin(), pieces.area.end(), 0.0);
    const double longest = std::max(size, std::sqrt(area / most));
    const auto& triangles = mesh.triangles();
    std::vector<std::vector<Corners>> kept(triangles.size());
    std::vector<std::uint8_t> whole(triangles.size(), 1);
    geometry::parallel_for(triangles.size(), 64, [&](std::size_t begin, std::size_t end) {
        Cutter cutter{{tree, 2 * longest}, longest};
        for (std::size_t i = begin; i < end; ++i) {
            Corners t;
            for (std::size_t a = 0; a < 3; ++a) {
                t[a] = mesh.positions[triangles[i][a]].cast<double>();
            }
            const Vec3 normal = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
            if (cutter.cut(t, normal, kept[i])) {
                kept[i] = {t};
            } else {
                whole[i] = 0;
            }
        }
    });
    if (std::all_of(whole.begin(), whole.end(), [](auto w) { return w != 0; })) return std::nullopt;
    return welded(kept);
}

}  // namespace physics
