#pragma once

// Which cube holds a place of a mesh, where cubes of several bodies may lie in one cell.
//
// Where bodies touch or overlap, a place is in cubes of several. Each piece of the mesh goes with
// the body that holds most points of it, its vertices and others up to a cube apart: its own holds
// them all. Of bodies that hold as many, it
// is the one of fewest cubes (a ball in a box), then the one that fewest pieces have so far (cards
// in one layer of cubes), then the first.

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <vector>

namespace geometry {

class BodyFinder {
public:
    // The cubes must outlive the finder.
    explicit BodyFinder(const Cubes& cubes);

    // The body of each vertex, V; no_index where no body holds a point of its piece, or no triangle
    // uses it. Triangles that share a vertex are of one piece. Empty where bodies cannot meet: no
    // cubes have a `part` (Cubes), or all are one body. The same for any number of threads.
    std::vector<std::uint32_t> bodies_of(const TriMesh& mesh) const;

    // As CubeFinder::find() and find_near() of the body's cubes alone, and of all where none of
    // these is within a thousandth of a cube, or the body is no_index.
    std::uint32_t find(const Vec3& at, std::uint32_t body) const;
    std::uint32_t find_near(const Vec3& at, std::uint32_t body) const;

    // Of a cube; no_index where bodies cannot meet.
    std::uint32_t body_of(std::uint32_t cube) const
    {
        return body_.empty() ? no_index : body_[cube];
    }

private:
    template <class Visit> void visit_holders(const Vec3& at, const Visit& visit) const;
    std::uint32_t holder(const Vec3& at, std::uint32_t body) const;

    const Cubes* cubes_;
    CubeFinder all_;
    std::vector<std::uint32_t> body_;  // C, or empty
    std::vector<std::size_t> size_;    // of each body, in cubes
};

}  // namespace geometry
