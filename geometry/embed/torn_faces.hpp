#pragma once

// Which faces of a mesh pass through cubes that are torn, or parted.

#include "geometry/base/no_index.hpp"
#include "geometry/cells/cell_set.hpp"
#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cubes/cubes.hpp"
#include "geometry/embed/bind.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// Which faces of a mesh at rest, bound like this, pass through cubes that have lost a link between
// two corners. Links are named 3 * corner + axis, ascending, by the lower of their corners. F.
// Pieces of the mesh that share cells with cubes of another component count as well.
std::vector<std::uint8_t> torn_faces(const Binding& binding, const TriMesh& rest,
                                     const Cubes& cubes, std::span<const std::uint32_t> broken);

// Some cells of cubes, and the empty ones around them: what lies there goes with the nearest cube.
class CellsAround {
public:
    // `cells` in the order of cubes.
    CellsAround(const Cubes& cubes, std::vector<Vec3i> cells);

    const std::vector<Vec3i>& cells() const { return cells_; }
    const Box& box() const { return box_; }  // of all, lattice coordinates
    // Which of the cells a piece of a face in `cell` goes with, or no_index. What goes `alone`,
    // with one cube for all of it, is in no empty one.
    std::uint32_t find(const Vec3i& cell, const Polygon& piece, bool alone) const;

private:
    std::vector<Vec3i> cells_, around_;
    CellIndex cubes_;
    Box box_;
};

// The faces of pieces of a mesh that lie in no cube at all: each such piece goes with one.
class FacesAlone {
public:
    FacesAlone(const Binding& binding, const TriMesh& rest);
    bool operator[](std::size_t face) const;

private:
    const std::vector<Triangle>& triangles_;
    std::vector<std::uint8_t> vertices_;  // V, or none
};

// Those that pass through some of these cells. F.
std::vector<std::uint8_t> faces_through(const TriMesh& rest, const Cubes& cubes,
                                        const CellsAround& cells, const FacesAlone& alone);

// A face of a mesh at rest in lattice coordinates. Vertices that are all but in a plane between
// cubes or their parts are in it: slivers would be cut off else. On a plane, whose axis without
// extent is `flat`, it may lie above or below, as high as it likes, and counts as in it: its
// heights are small there, and in proportion.
Polygon lattice_face(const TriMesh& rest, const Cubes& cubes, std::size_t face, int flat);

// The order of cubes, by their cells.
bool in_front(const Vec3i& a, const Vec3i& b);

// The mesh without the faces that are named (F). Vertices and all that belongs to them stay.
TriMesh without_faces(TriMesh mesh, const std::vector<std::uint8_t>& gone);

}  // namespace geometry
