#include "geometry/mesh/normals.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/mesh/mesh.hpp"

#include <cmath>

namespace geometry {
namespace {

constexpr std::size_t vertices_a_task = 4096;

// A vertex with more faces than this (the tip of a fan) gets one smooth normal: comparing every
// face with every other would take quadratic time.
constexpr std::size_t most_compared = 512;

// The angle at each corner of each face, 0 for a face without area. 3F, radians.
std::vector<float> corner_angles(const TriMesh& mesh, const std::vector<Vec3>& area)
{
    const auto& triangles = mesh.triangles();
    std::vector<float> angle(3 * triangles.size());
    parallel_for(triangles.size(), vertices_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 p = mesh.positions[triangles[f][k]].cast<double>();
                const Vec3 to = mesh.positions[triangles[f][(k + 1) % 3]].cast<double>() - p;
                const Vec3 from = mesh.positions[triangles[f][(k + 2) % 3]].cast<double>() - p;
                angle[3 * f + k] = float(std::atan2(area[f].norm(), to.dot(from)));
            }
            if (area[f].isZero(0)) angle[3 * f] = angle[3 * f + 1] = angle[3 * f + 2] = 0;
        }
    });
    return angle;
}

}  // namespace

std::vector<Vec3> area_vectors(const TriMesh& mesh)
{
    const auto& triangles = mesh.triangles();
    std::vector<Vec3> area(triangles.size());
    parallel_for(triangles.size(), vertices_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t f = begin; f < end; ++f) {
            const Vec3 a = mesh.positions[triangles[f][0]].cast<double>();
            area[f] = (mesh.positions[triangles[f][1]].cast<double>() - a)
                          .cross(mesh.positions[triangles[f][2]].cast<double>() - a);
        }
    });
    return area;
}

VertexCorners vertex_corners(const TriMesh& mesh)
{
    const auto& triangles = mesh.triangles();
    VertexCorners out;
    out.begin.assign(mesh.positions.size() + 1, 0);
    out.corner.resize(3 * triangles.size());
    for (const Triangle& t : triangles) {
        for (const auto v : t) ++out.begin[v + 1];
    }
    for (std::size_t v = 1; v < out.begin.size(); ++v) out.begin[v] += out.begin[v - 1];
    std::vector<std::uint32_t> next(out.begin.begin(), out.begin.end() - 1);
    for (std::size_t f = 0; f < triangles.size(); ++f) {
        for (std::size_t k = 0; k < 3; ++k) {
            out.corner[next[triangles[f][k]]++] = static_cast<std::uint32_t>(3 * f + k);
        }
    }
    return out;
}

void compute_normals(TriMesh& mesh, double crease)
{
    const std::vector<Vec3> area = area_vectors(mesh);
    const std::vector<float> angle = corner_angles(mesh, area);
    const VertexCorners corners = vertex_corners(mesh);
    const std::size_t faces = area.size();

    std::vector<Vec3f> face_normal(faces);
    for (std::size_t f = 0; f < faces; ++f) {
        const double length = area[f].norm();
        face_normal[f] =
            length > 0 ? Vec3f((area[f] / length).cast<float>()) : Vec3f(Vec3f::Zero());
    }

    // The normal at every corner. A face without area takes all faces around the vertex as they
    // are: it has no direction of its own to compare with.
    const float same_side = float(std::cos(std::min(crease, 3.141592653589793))) - 1e-6f;
    std::vector<Vec3f> wanted(3 * faces);
    parallel_for(mesh.positions.size(), vertices_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const auto around = corners.around(v);
            const auto mean_like = [&](const Vec3f& own) {
                Vec3f sum = Vec3f::Zero();
                for (const auto c : around) {
                    const Vec3f& n = face_normal[c / 3];
                    if (own.isZero(0) || own.dot(n) >= same_side) sum += angle[c] * n;
                }
                if (sum.norm() > 1e-6f) return Vec3f(sum.normalized());
                return own.isZero(0) ? Vec3f(Vec3f::UnitY()) : own;
            };
            if (around.size() > most_compared) {
                const Vec3f smooth = mean_like(Vec3f::Zero());
                for (const auto c : around) wanted[c] = smooth;
            } else {
                for (const auto c : around) wanted[c] = mean_like(face_normal[c / 3]);
            }
        }
    });

    // Corners of one vertex with equal normals share an entry.
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    topology->normal_triangles.assign(faces, Triangle{});
    mesh.normals.clear();
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        const std::size_t first = mesh.normals.size();
        for (const auto c : corners.around(v)) {
            std::size_t i = first;
            while (i < mesh.normals.size() && mesh.normals[i] != wanted[c]) ++i;
            if (i == mesh.normals.size()) mesh.normals.push_back(wanted[c]);
            topology->normal_triangles[c / 3][c % 3] = static_cast<std::uint32_t>(i);
        }
    }
    mesh.topology = std::move(topology);
}

}  // namespace geometry
