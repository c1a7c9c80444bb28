#pragma once

// Distance to a triangle mesh, and which side of it a point is on.
//
// Closest point: branch and bound over a box tree; point to triangle by Voronoi regions:
//   Ericson. Real-time collision detection. Morgan Kaufmann 2005, 5.1.5.
// Side, two ways. By the angle-weighted normal at the closest point, exact for closed manifolds:
//   Baerentzen, Aanaes. Signed distance computation using the angle weighted pseudonormal.
//   IEEE TVCG 11(3), 2005.
// By the generalized winding number, which degrades gracefully on open, overlapping and broken
// meshes; far clusters of triangles by their first two moments:
//   Barill, Dickson, Schmidt, Levin, Jacobson. Fast winding numbers for soups and clouds.
//   SIGGRAPH 2018.
//   w(q) = sum_t solid angle of t from q / 4 pi;   1 inside, 0 outside a closed mesh

#include "geometry/base/box_tree.hpp"
#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <optional>
#include <span>

namespace geometry {

class TriangleBvh {
public:
    struct Hit {
        double distance = std::numeric_limits<double>::infinity();  // m, >= 0
        std::uint32_t triangle = no_index;  // into the mesh; no_index: nothing within max_distance
        Vec3 point = Vec3::Zero();          // m, the closest point
        Vec3 barycentric = Vec3::Zero();    // of `point` in the triangle
        Vec3 normal = Vec3::Zero();         // unit, angle-weighted at `point`; outward
        bool behind = false;                // the query lies on the inner side of `normal`

        explicit operator bool() const { return triangle != no_index; }
        double signed_distance() const { return behind ? -distance : distance; }
    };

    TriangleBvh() = default;  // of no triangles

    // Triangles that name a vertex that is not there, or a vertex that is not finite, are left
    // out; those without area still count as segments or points. Cost O(F log F).
    explicit TriangleBvh(const TriMesh& mesh);

    // The nearest point of the mesh that is nearer than `max_distance`. A query that is not finite
    // finds nothing.
    Hit closest(const Vec3& p, double max_distance = std::numeric_limits<double>::infinity()) const;

    // The same for many points, on all threads. hits.size() == points.size().
    void closest(std::span<const Vec3> points, double max_distance, std::span<Hit> hits) const;

    // Which sides of triangles a segment can go in through.
    enum class Faces { front, both };
    // A mesh that moves while a point goes along a segment: each vertex along a line.
    struct Motion {
        std::span<const Vec3f> before, after;  // m, of each vertex; the tree is of `after`
        std::span<const Triangle> triangles;
        double begin = 0, end = 1;  // shares of the mesh's way where the point starts and ends
        double longest = 0;         // m, way of a vertex

        // From before to after, of a place on a triangle.
        Vec3 way(std::uint32_t triangle, const Vec3& barycentric) const;
    };

    // Where the segment from one point to the other first goes in through the front of a triangle,
    // or through either side; a triangle's plane counts as its front. The hit's normal is the
    // triangle's own, towards `from`; its distance is from there. Where the mesh moves, each
    // triangle is taken to move as its place nearest to `to` does, and the hit's place is where the
    // mesh has come to in the end. A segment that is not finite finds nothing.
    Hit entry(const Vec3& from, const Vec3& to, Faces faces = Faces::front,
              const Motion* motion = nullptr) const;

    // How often the segment from one point to the other goes in through the fronts of triangles
    // less how often it comes out: what the winding number of a closed mesh gains along it. None
    // where an end or a side lies too near to tell.
    std::optional<int> crossings(const Vec3& from, const Vec3& to) const;

    // The generalized winding number, within 1e-2; triangles nearby count exactly.
    double winding_number(const Vec3& p) const;

    // Inside by the rule |w| > 1/2: also right for a piece whose faces all look inward.
    bool inside(const Vec3& p) const { return std::abs(winding_number(p)) > 0.5; }

    // The triangles of the mesh near a box, ascending: at least those whose boxes meet it.
    std::vector<std::uint32_t> triangles_in(const Box3f& box) const;

    std::size_t triangle_count() const { return corners_.size(); }
    const BoxTree& tree() const { return tree_; }
    std::size_t bytes() const;

private:
    // Moments of the triangles below a node, about their area's centre c:
    //   dipole = sum A n,  quadrupole = sum A (c_t - c) n^T
    struct Moments {
        Vec3 centre = Vec3::Zero();
        Vec3 dipole = Vec3::Zero();
        Mat3 quadrupole = Mat3::Zero();
        double radius = 0;  // m, of the ball about `centre` that holds all
    };

    void find_normals(const TriMesh& mesh);
    void find_moments();

    BoxTree tree_;
    std::vector<std::uint32_t> triangle_;        // of the mesh, by leaf order
    std::vector<std::array<Vec3f, 3>> corners_;  // by leaf order
    std::vector<std::array<Vec3f, 7>> normals_;  // by leaf order: face, 3 sides, 3 corners
    std::vector<Moments> moments_;               // by node
};

}  // namespace geometry
