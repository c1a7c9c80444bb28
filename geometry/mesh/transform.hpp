#pragma once

// Moves, turns and scales meshes.

#include "geometry/mesh/mesh_fwd.hpp"

namespace geometry {

// The rotation by `degrees` about x, then y, then z, all fixed axes: R = Rz Ry Rx.
Mat3 rotation_xyz(const Vec3& degrees);

// T with p -> pivot + translate + R S (p - pivot), S = diag(scale), R = rotation_xyz.
Transform placement(const Vec3& translate, const Vec3& rotate_degrees, const Vec3& scale,
                    const Vec3& pivot);

// Whether `linear` turns a right hand into a left one.
bool mirrors(const Mat3& linear);

// The same faces seen from the other side: every triangle wound the other way.
MeshTopology turned_inside_out(MeshTopology topology);

// Positions by T, normals by the inverse transpose of its linear part (the matrix of cofactors,
// which stays meaningful when T flattens the mesh). The topology is not touched: under a T that
// mirrors, the caller winds the faces the other way with turned_inside_out.
void move(TriMesh& mesh, const Transform& T);

}  // namespace geometry
