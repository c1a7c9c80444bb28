#pragma once

// Skeletons: the primitives that carry an implicit field, and the distance to each.
//   r(P)  distance from P to the skeleton, m; negative inside solids (box, ellipsoid, plane, mesh,
//         torus, cylinder, cone), so that the field keeps a slope there
//   n(P)  grad r, unit
//   H(P)  Hessian of r: (I - n n^T) / r about a corner, (I - n n^T - t t^T) / r about an edge of
//         direction t, 0 over a face, (I + r S)^-1 S over a curved surface of shape operator S
// Wherever the nearest point is unique, |grad r| = 1: r is 1-Lipschitz, and all bounds rest on it.
// Where a skeleton has a stretch A, its field is anisotropic: r(P) = min |A^-1 (P - Q)| over its
// points Q, so that a layer of thickness e about a point is the ellipsoid of semi-axes e A. As no
// eigenvalue of A is below 1, r is 1-Lipschitz still; |grad r| is between 1 / max A and 1.

#include "geometry/base/vec.hpp"

#include <memory>
#include <span>
#include <vector>

namespace geometry {

enum class SkeletonKind : std::uint8_t {
    point,
    segment,
    polyline,
    triangle,
    box,
    ellipsoid,
    plane,
    mesh,
    curve,  // curve_skeleton.hpp
    torus,  // round_skeleton.hpp
    cylinder,
    cone,
    sheet  // a mesh, open or not, that has two sides and no inside
};

struct SkeletonMesh;  // geometry/fields/skeleton_mesh.hpp

// A skeleton in the local frame that it rides on.
struct Skeleton {
    SkeletonKind kind = SkeletonKind::point;
    std::vector<Vec3> points{Vec3::Zero()};  // m: 1 for point, 2, 2 or more, 3; unused by solids
    // m: half edges of a box, semi-axes of an ellipsoid, radii of what is round
    // (round_skeleton.hpp)
    Vec3 half_size{0.5, 0.5, 0.5};
    // The own frame of a solid or a sheet, rigid; a plane is solid where its y < 0.
    Transform place = Transform::Identity();
    std::shared_ptr<const SkeletonMesh> mesh = nullptr;
    // A, of a skeleton drawn by points: how many times as thick its layer is along each axis.
    // Symmetric, its eigenvalues 1 or above.
    Mat3 stretch = Mat3::Identity();

    bool stretches() const { return stretch != Mat3::Identity(); }
};

// A skeleton's stretch made ready, in a frame.
struct FieldStretch {
    Mat3 wide = Mat3::Identity();    // A
    Mat3 narrow = Mat3::Identity();  // A^-1
    double most = 1;                 // its largest eigenvalue: as many times as wide is the layer

    // The same along a unit direction from the skeleton's points.
    double along(const Vec3& direction) const
    {
        return most == 1 ? 1 : 1 / (narrow * direction).norm();
    }
};
FieldStretch stretch_of(const Skeleton& skeleton, const Mat3& turn = Mat3::Identity());

// Where a point stands to a skeleton.
struct Foot {
    double r = 0;                 // m, in narrowed space where it has a stretch
    Vec3 n = Vec3::Zero();        // grad r, unit without a stretch; zero on what has no inside
    Mat3 hessian = Mat3::Zero();  // 1/m
};

Foot foot_on_polyline(std::span<const Vec3> points, const Vec3& p);        // one point or more
double distance_to_polyline(std::span<const Vec3> points, const Vec3& p);  // the foot's r, alone
Foot foot_on_triangle(std::span<const Vec3, 3> corners, const Vec3& p);
Foot foot_on_box(const Vec3& half_size, const Vec3& p);        // centred on the origin
Foot foot_on_ellipsoid(const Vec3& semi_axes, const Vec3& p);  // centred on the origin
Foot foot_on_plane(const Vec3& p);                             // y = 0
Foot foot_on_mesh(const SkeletonMesh& mesh, const Vec3& p);    // closed, faces outward
Foot foot_on_sheet(const SkeletonMesh& mesh, const Vec3& p);   // any; no inside

// Throws std::invalid_argument, saying what is wrong, for a skeleton that none of these accepts:
// the wrong number of points, a size that is not positive, a place that is not rigid, not a number.
void check(const Skeleton& skeleton);

// Whether a transform only turns and moves.
bool is_rigid(const Transform& transform);

}  // namespace geometry
