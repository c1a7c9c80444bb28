#include "physics/body/flat_faces.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/mesh_edges.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace physics {
namespace {

using geometry::no_index;
using geometry::Triangle;
using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;

// Of each vertex, the first one at its place.
std::vector<std::uint32_t> first_at_place(const std::vector<Vec3f>& positions)
{
    std::vector<std::uint32_t> order(positions.size()), out(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t v) {
        const Vec3f& p = positions[v];
        return std::make_tuple(p.x(), p.y(), p.z());
    };
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
        out[order[i]] = same ? out[order[i - 1]] : order[i];
    }
    return out;
}

// Of each side of a triangle, the triangle beyond it; no_index: a border.
using Neighbours = std::vector<std::array<std::uint32_t, 3>>;

Neighbours find_neighbours(const std::vector<Triangle>& triangles, std::size_t vertices)
{
    Neighbours out(triangles.size(), {no_index, no_index, no_index});
    const std::vector<geometry::EdgeUse> uses = geometry::edge_uses(triangles, vertices);
    for (std::size_t i = 0; i < uses.size();) {
        std::size_t end = i;
        while (end < uses.size() && uses[end].a == uses[i].a && uses[end].b == uses[i].b) ++end;
        if (end == i + 2) {
            out[uses[i].triangle][uses[i].side] = uses[i + 1].triangle;
            out[uses[i + 1].triangle][uses[i + 1].side] = uses[i].triangle;
        }
        i = end;
    }
    return out;
}

class Faces {
public:
    Faces(const TriMesh& mesh, std::vector<Triangle> triangles, double off)
        : positions_(mesh.positions), triangles_(std::move(triangles)),
          beyond_(find_neighbours(triangles_, positions_.size())),
          face_(triangles_.size(), no_index), off_(off)
    {
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
            if (face_[t] == no_index) grow(t);
        }
    }

    std::vector<Rims> rims() const
    {
        std::vector<char> on_rim(positions_.size(), 0);
        std::vector<Rims> out(triangles_.size());
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t other = beyond_[t][i];
                if (other != no_index && face_[other] == face_[t]) continue;
                out[t].side[i] = true;
                on_rim[triangles_[t][i]] = on_rim[triangles_[t][(i + 1) % 3]] = 1;
            }
        }
        for (std::size_t t = 0; t < triangles_.size(); ++t) {
            for (std::size_t i = 0; i < 3; ++i) {
                out[t].corner[i] = on_rim[triangles_[t][i]] != 0;
            }
        }
        return out;
    }

private:
    Vec3 place(std::uint32_t t, std::size_t i) const
    {
        return positions_[triangles_[t][i]].cast<double>();
    }
    Vec3 normal(std::uint32_t t) const
    {
        return (place(t, 1) - place(t, 0)).cross(place(t, 2) - place(t, 0)).normalized();
    }

    // The face of a triangle and of all that lie in its plane and hang together with it.
    void grow(std::uint32_t first)
    {
        constexpr double steep = 0.999;  // cosine: a sliver within `off` may stand on the plane
        const Vec3 up = normal(first), origin = place(first, 0);
        const auto fits = [&](std::uint32_t t) {
            for (std::size_t i = 0; i < 3; ++i) {
                if (!(std::abs(up.dot(place(t, i) - origin)) <= off_)) return false;
            }
            return up.dot(normal(t)) > steep;
        };
        face_[first] = first;
        std::vector<std::uint32_t> open{first};
        while (!open.empty()) {
            const std::uint32_t t = open.back();
            open.pop_back();
            for (const std::uint32_t other : beyond_[t]) {
                if (other == no_index || face_[other] != no_index || !fits(other)) continue;
                face_[other] = first;
                open.push_back(other);
            }
        }
    }

    const std::vector<Vec3f>& positions_;
    std::vector<Triangle> triangles_;
    Neighbours beyond_;
    std::vector<std::uint32_t> face_;  // of each triangle, by its first one
    double off_;
};

}  // namespace

std::vector<Rims> rims_of_flat_faces(const TriMesh& mesh, double off)
{
    const std::vector<std::uint32_t> first = first_at_place(mesh.positions);
    std::vector<Triangle> triangles(mesh.triangles().begin(), mesh.triangles().end());
    for (Triangle& t : triangles) {
        for (auto& v : t) v = first[v];
    }
    return Faces(mesh, std::move(triangles), off).rims();
}

}  // namespace physics
