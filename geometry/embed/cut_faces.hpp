#pragma once

// The faces of a mesh at rest, cut along the planes between the parts of parted cubes, and the new
// faces that close what is cut where the mesh is a solid.
//
//      +----:----+        A face across a parted cube, whose parts are left and right of the
//      |   /:\   |        dotted plane, becomes pieces: each lies in one part, or in no parted
//      |  / : \  |        cube at all. Pieces have corners of their own, which cut_torn() makes
//      +-/--:--\-+        one again where they stay together.

#include "geometry/base/no_index.hpp"
#include "geometry/embed/bind.hpp"
#include "geometry/embed/parted_cubes.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

namespace geometry {

struct CutFaces {
    struct Corner {
        std::uint32_t face;           // of the mesh, that it lies in or is nearest to
        std::uint32_t part;           // 8 * parted cube + part; no_index: in no parted cube
        Vec3 at;                      // lattice coordinates
        std::array<double, 3> share;  // of the face's corners
        // Of faces that close what is cut, unit; of others zero.
        Vec3 outward = Vec3::Zero();
        // One number for all that meet at rest, by split_at_t_junctions().
        std::uint32_t place = 0;

        bool closes() const { return !outward.isZero(0); }
    };

    std::vector<std::uint8_t> cut;  // F, the mesh's faces that `faces` replace
    std::vector<Corner> corners;
    std::vector<Triangle> faces;  // into corners; those that close come last
};

// Closed where it is inside `solid`, the mesh at rest; null: nowhere.
CutFaces cut_faces(const Binding& binding, const TriMesh& rest, const Cubes& cubes,
                   std::span<const PartedCube> parted, const TriangleBvh* solid);

}  // namespace geometry
