// The integrals of 1, x and x x^T over the tetrahedra between an apex and each triangle:
// Tonon. Explicit exact formulas for the 3-D tetrahedron inertia tensor in terms of its vertex
// coordinates. Journal of Mathematics and Statistics 1(1), 2004. With v = a . (b x c) / 6:
//   int 1 = v,   int x = v (a + b + c) / 4,   int x x^T = v / 20 (s s^T + a a^T + b b^T + c c^T),
//   s = a + b + c

#include "geometry/mesh/mass_properties.hpp"

#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"

namespace geometry {
namespace {

// From the integrals of 1, x and x x^T about a place near the body.
MassProperties about_centre(double mass, const Vec3& first, const Mat3& second, const Vec3& place)
{
    MassProperties out;
    out.mass = mass;
    if (mass == 0) return out;
    const Vec3 centre = first / mass;
    const Mat3 central = second - mass * centre * centre.transpose();
    out.centre = place + centre;
    out.inertia = central.trace() * Mat3::Identity() - central;
    return out;
}

}  // namespace

MassProperties mass_properties(const TriMesh& mesh)
{
    const Vec3 apex = bounds(mesh).centre();
    double volume = 0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (const Triangle& t : mesh.triangles()) {
        if (!is_finite(mesh, t)) continue;
        const Vec3 a = mesh.positions[t[0]].cast<double>() - apex,
                   b = mesh.positions[t[1]].cast<double>() - apex,
                   c = mesh.positions[t[2]].cast<double>() - apex;
        const double v = a.dot(b.cross(c)) / 6;
        const Vec3 sum = a + b + c;
        volume += v;
        first += v / 4 * sum;
        second +=
            v / 20 *
            (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    }
    return about_centre(volume, first, second, apex);
}

}  // namespace geometry
