#include "geometry/mesh/clip.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <array>
#include <memory>
#include <unordered_map>

namespace geometry {
namespace {

class Clipper {
public:
    Clipper(const TriMesh& mesh, int axis, float at)
        : mesh_(mesh), axis_(axis), at_(at), smooth_(mesh.normals.size() == mesh.positions.size()),
          kept_(mesh.positions.size(), no_index)
    {}

    void add(const Triangle& t)
    {
        const bool whole = std::all_of(t.begin(), t.end(), [&](auto v) { return inside(v); });
        const bool touches_only = std::none_of(
            t.begin(), t.end(), [&](auto v) { return mesh_.positions[v][axis_] < at_; });
        if (!whole && touches_only) return;
        std::array<std::uint32_t, 4> corner{};
        std::size_t count = 0;
        const auto go_to = [&](std::uint32_t v) {  // a corner on the plane is a crossing too
            if (count == 0 || (corner[count - 1] != v && corner[0] != v)) corner[count++] = v;
        };
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (inside(a)) go_to(keep(a));
            if (inside(a) != inside(b)) go_to(inside(a) ? cross(a, b) : cross(b, a));
        }
        for (std::size_t k = 2; k < count; ++k) {
            triangles_.push_back({corner[0], corner[k - 1], corner[k]});
        }
    }

    TriMesh result() &&
    {
        auto topology = std::make_shared<MeshTopology>();
        topology->triangles = std::move(triangles_);
        out_.topology = std::move(topology);
        return std::move(out_);
    }

private:
    bool inside(std::uint32_t v) const { return mesh_.positions[v][axis_] <= at_; }

    std::uint32_t put(const Vec3f& position, const Vec3f& normal)
    {
        out_.positions.push_back(position);
        if (smooth_) out_.normals.push_back(normal);
        return static_cast<std::uint32_t>(out_.positions.size() - 1);
    }
    Vec3f normal(std::uint32_t v) const
    {
        return smooth_ ? mesh_.normals[v] : Vec3f(Vec3f::Zero());
    }
    std::uint32_t keep(std::uint32_t v)
    {
        if (kept_[v] == no_index) kept_[v] = put(mesh_.positions[v], normal(v));
        return kept_[v];
    }
    // Where the side from a, inside, to b, outside, meets the plane.
    std::uint32_t cross(std::uint32_t a, std::uint32_t b)
    {
        const Vec3f &p = mesh_.positions[a], &q = mesh_.positions[b];
        if (p[axis_] == at_) return keep(a);
        const auto [found, added] = crossing_.try_emplace(std::uint64_t{a} << 32 | b, 0u);
        if (!added) return found->second;
        const float share = (at_ - p[axis_]) / (q[axis_] - p[axis_]);
        Vec3f at = p + share * (q - p);
        at[axis_] = at_;
        return found->second = put(at, (normal(a) + share * (normal(b) - normal(a))).normalized());
    }

    const TriMesh& mesh_;
    int axis_;
    float at_;     // m
    bool smooth_;  // one normal a vertex
    TriMesh out_;
    std::vector<Triangle> triangles_;
    std::vector<std::uint32_t> kept_;  // V, in out_
    std::unordered_map<std::uint64_t, std::uint32_t> crossing_;
};

}  // namespace

TriMesh clipped(const TriMesh& mesh, int axis, float at)
{
    Clipper clipper(mesh, axis, at);
    for (const Triangle& t : mesh.triangles()) clipper.add(t);
    return std::move(clipper).result();
}

}  // namespace geometry
