#include "physics/layers/velocity_at.hpp"

#include "geometry/fields/skeleton_mesh.hpp"

namespace physics {

Vec3 velocity_at(const MovingMesh& mesh, const Vec3& p)
{
    if (!(mesh.seconds > 0)) return Vec3::Zero();
    const geometry::TriangleBvh::Hit hit = mesh.now->tree.closest(p);
    if (!hit) return Vec3::Zero();
    Vec3 moved = Vec3::Zero();
    const geometry::Triangle& t = mesh.now->mesh.triangles()[hit.triangle];
    for (std::size_t k = 0; k < 3; ++k) {
        const geometry::Vec3f way = mesh.now->mesh.positions[t[k]] - mesh.before->positions[t[k]];
        moved += hit.barycentric[static_cast<int>(k)] * way.cast<double>();
    }
    return moved / mesh.seconds;
}

Vec3 velocity_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p)
{
    if (body.moving) return velocity_at(*body.moving, p);
    const std::uint32_t f = body.frame_of[skeleton];
    return body.twists[f].linear + body.twists[f].angular.cross(p - body.frames[f].translation());
}

}  // namespace physics
