#include "physics/layered_bodies/mean_value_rings.hpp"

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/normals.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace physics {

using geometry::TriMesh;
using geometry::Vec3;
using geometry::Vec3f;

namespace {

// At each vertex the mean, by area, of its faces' normals.
std::vector<Vec3> vertex_normals(const TriMesh& mesh)
{
    const std::vector<Vec3> area = geometry::area_vectors(mesh);
    std::vector<Vec3> normal(mesh.positions.size(), Vec3::Zero());
    for (std::size_t t = 0; t < area.size(); ++t) {
        for (const std::uint32_t v : mesh.triangles()[t]) normal[v] += area[t];
    }
    for (Vec3& n : normal) n.normalize();
    return normal;
}

// What one triangle adds to a neighbour's weight at a vertex.
struct CornerShare {
    std::uint32_t vertex, neighbour;
    double weight;
    int side;  // 1: the neighbour is the triangle's next corner, -1: the one before
};

// By vertex, then by neighbour.
std::vector<CornerShare> shares_of(const TriMesh& mesh, const std::vector<Vec3>& at)
{
    const std::vector<Vec3> normal = vertex_normals(mesh);
    std::vector<CornerShare> shares;
    for (const geometry::Triangle& t : mesh.triangles()) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t v = t[k], p = t[(k + 1) % 3], q = t[(k + 2) % 3];
            const auto flat = [&](std::uint32_t w) {
                const Vec3 d = at[w] - at[v];
                return Vec3(d - d.dot(normal[v]) * normal[v]);
            };
            const Vec3 a = flat(p), b = flat(q);
            const double angle = std::atan2(a.cross(b).dot(normal[v]), a.dot(b));
            const double half = std::tan(0.5 * angle);
            shares.push_back({v, p, half / a.norm(), 1});
            shares.push_back({v, q, half / b.norm(), -1});
        }
    }
    std::sort(shares.begin(), shares.end(), [](const CornerShare& a, const CornerShare& b) {
        return std::tuple(a.vertex, a.neighbour, a.side) <
               std::tuple(b.vertex, b.neighbour, b.side);
    });
    return shares;
}

// Appends the ring of vertex v from its shares, which begin at `s`; returns where they end.
std::size_t add_ring(std::span<const CornerShare> shares, std::size_t s, std::uint32_t v,
                     MeanValueRings& rings)
{
    const std::size_t begin = rings.ring.size();
    bool held = true;
    double sum = 0;
    while (s < shares.size() && shares[s].vertex == v) {
        // An edge within a surface: one triangle on each side.
        const bool pair = s + 1 < shares.size() && shares[s + 1].vertex == v &&
                          shares[s + 1].neighbour == shares[s].neighbour &&
                          shares[s].side + shares[s + 1].side == 0 &&
                          !(s + 2 < shares.size() && shares[s + 2].vertex == v &&
                            shares[s + 2].neighbour == shares[s].neighbour);
        const double weight = shares[s].weight + (pair ? shares[s + 1].weight : 0);
        held = held && pair && weight > 0 && std::isfinite(weight);
        sum += weight;
        rings.ring.push_back(shares[s].neighbour);
        rings.weight.push_back(static_cast<float>(weight));
        s += pair ? 2 : 1;
    }
    if (!held) {
        rings.ring.resize(begin);
        rings.weight.resize(begin);
    }
    for (std::size_t i = begin; i < rings.ring.size(); ++i) {
        rings.weight[i] /= static_cast<float>(sum);
    }
    rings.ring_at.push_back(static_cast<std::uint32_t>(rings.ring.size()));
    return s;
}

}  // namespace

MeanValueRings mean_value_rings(const TriMesh& mesh)
{
    std::vector<Vec3> at;
    for (const Vec3f& p : mesh.positions) at.push_back(p.cast<double>());
    const std::vector<CornerShare> shares = shares_of(mesh, at);
    MeanValueRings rings;
    rings.ring_at.assign(1, 0);
    double edges = 0;
    std::size_t s = 0;
    for (std::uint32_t v = 0; v < at.size(); ++v) {
        s = add_ring(shares, s, v, rings);
        Vec3 offset = Vec3::Zero();
        for (std::uint32_t i = rings.ring_at[v]; i < rings.ring_at[v + 1]; ++i) {
            const Vec3 to = at[rings.ring[i]] - at[v];
            offset += static_cast<double>(rings.weight[i]) * to;
            edges += to.norm();
        }
        rings.offset.push_back(offset.cast<float>());
    }
    if (!rings.ring.empty()) rings.edge = edges / static_cast<double>(rings.ring.size());
    return rings;
}

}  // namespace physics
