#include "geometry/mesh/transform.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"

#include <numbers>

namespace geometry {

Mat3 rotation_xyz(const Vec3& degrees)
{
    const Vec3 angle = degrees * (std::numbers::pi / 180);
    return (Eigen::AngleAxisd(angle.z(), Vec3::UnitZ()) *
            Eigen::AngleAxisd(angle.y(), Vec3::UnitY()) *
            Eigen::AngleAxisd(angle.x(), Vec3::UnitX()))
        .toRotationMatrix();
}

Transform placement(const Vec3& translate, const Vec3& rotate_degrees, const Vec3& scale,
                    const Vec3& pivot)
{
    Transform T = Transform::Identity();
    T.linear() = rotation_xyz(rotate_degrees) * scale.asDiagonal();
    T.translation() = pivot + translate - T.linear() * pivot;
    return T;
}

bool mirrors(const Mat3& linear)
{
    return linear.determinant() < 0;
}

MeshTopology turned_inside_out(MeshTopology topology)
{
    for (auto* triangles :
         {&topology.triangles, &topology.normal_triangles, &topology.uv_triangles}) {
        for (Triangle& t : *triangles) std::swap(t[1], t[2]);
    }
    return topology;
}

void move(TriMesh& mesh, const Transform& T)
{
    constexpr std::size_t grain = 16384;
    const Mat3 A = T.linear();
    const Vec3 t = T.translation();
    parallel_for(mesh.positions.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            mesh.positions[i] = (A * mesh.positions[i].cast<double>() + t).cast<float>();
        }
    });

    // A^-T = cof(A) / det(A); only its direction counts. Scaled first: products of tiny or huge
    // scales must not leave the range of a double.
    const double size = A.cwiseAbs().maxCoeff();
    if (!(size > 0)) return;
    const Mat3 B = A / size;
    Mat3 cofactors;
    for (int i = 0; i < 3; ++i) {
        cofactors.col(i) = B.col((i + 1) % 3).cross(B.col((i + 2) % 3));
    }
    if (mirrors(B)) cofactors = -cofactors;
    parallel_for(mesh.normals.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3 n = cofactors * mesh.normals[i].cast<double>();
            const double length = n.norm();
            if (length > 0) mesh.normals[i] = (n / length).cast<float>();
        }
    });
}

}  // namespace geometry
