#pragma once

// Where the world touches a body of cubes: contact points and bits of area, embedded in the cubes
// with trilinear weights. They are the vertices and triangles of the original surface, with points
// a cube apart on triangles that are wider, or the outside corners and faces of the cubes
// themselves.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/body/body_models.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace physics {

using geometry::Vec3;
using geometry::Vec3f;

// What lies on one cube, as seen from the cube: ranges of ContactSurface::point and
// ContactSurface::area.
struct SurfacePatch {
    std::array<float, 8> share{};  // of what the wind does to each corner
    float reach = 1;  // how far its points lie out, in half diagonals of the cube; >= 1
    std::uint32_t point = 0, points_end = 0;
    std::uint32_t within = 0;  // from there on: corners that only a tear lays open
    std::uint32_t area = 0, areas_end = 0;
};

// The slots of cubes' corners, one cube after another. Where a cube has those of the cube before
// it, each one further, as along the rows of a lattice, nothing is kept.
class CornerRuns {
public:
    using Corners = std::array<std::uint32_t, 8>;

    void push_back(const Corners& corners);
    std::size_t size() const { return size_; }
    Corners operator[](std::size_t cube) const;  // finds its run first; for_each() does so once
    // Calls with(cube, corners) for the cubes begin .. end, in their order.
    template <class With> void for_each(std::size_t begin, std::size_t end, const With& with) const
    {
        if (begin == end) return;
        for (auto run = holder_of(begin); begin < end; ++run) {
            const bool last = run + 1 == runs_.end();
            const std::size_t stop = last ? end : std::min<std::size_t>(end, run[1].first);
            for (Corners corners = run->at(begin); begin < stop; ++begin) {
                with(begin, std::as_const(corners));
                for (auto& k : corners) ++k;
            }
        }
    }
    std::size_t bytes() const { return runs_.size() * sizeof(Run); }

private:
    struct Run {
        std::uint32_t first;
        Corners corners;  // of the first

        Corners at(std::size_t cube) const
        {
            Corners out = corners;
            for (auto& k : out) k += static_cast<std::uint32_t>(cube) - first;
            return out;
        }
    };
    std::vector<Run>::const_iterator holder_of(std::size_t cube) const;

    std::vector<Run> runs_;
    std::size_t size_ = 0;
};

// By the cubes that hold it. Cubes of a plane, or in the middle of a face, hold the same: they
// share a patch.
struct ContactSurface {
    double body_mass = 0;                 // kg, of all cubes
    CornerRuns corners;                   // S
    std::vector<std::uint32_t> patch_of;  // S, into patch
    std::vector<float> stiffness;         // S, Pa, Young's modulus times fill
    std::vector<float> mass;              // S, kg, of the cube
    // S, m: half of a sheet's thickness, by which it lies before its points; empty: of cubes. A
    // point has that of the cell that it is counted with.
    std::vector<float> half_thickness;
    double thickest = 0;  // m, the largest of these
    std::vector<std::uint32_t>
        first_point;  // S, its points are numbered from there: over all cubes

    std::vector<SurfacePatch> patch;
    std::vector<std::array<float, 8>> point;  // P, weight of each corner, as the point is embedded
    std::vector<float> point_area;            // P, m^2, of the surface around it
    std::vector<Vec3f> area;  // m^2, normal times area at rest; either side may be out
    std::vector<std::array<Vec3f, 3>> piece;  // of each area: a corner of the triangle, in the cube
                                              // from 0 to 1, and the two sides that start there

    const SurfacePatch& on(std::size_t cube) const { return patch[patch_of[cube]]; }
    // What a gap from `thickest` before a point is too small by.
    double thinner_by(std::size_t cube) const
    {
        return half_thickness.empty() ? 0 : thickest - double(half_thickness[cube]);
    }
    // From here on a sheet is as thick as its points.
    void leave_thickness()
    {
        half_thickness.clear();
        thickest = 0;
    }
    std::size_t bytes() const;
};

// `slot` of each corner is what ContactSurface::corners holds; empty: the corner itself. Vertices
// are embedded as geometry::bind does it. Of those crowded into one place, a quarter of a cube
// wide, the one farthest out along their mean normal stands for all: corners and edges stay. A
// sheet of triangles is touched at its own vertices, whatever its surface. A body that `tears` is
// touched at its other corners too, where they come to lie open.
ContactSurface make_contact_surface(const BodyModels& models,
                                    const std::vector<std::uint32_t>& slot, bool tears = false);

// Of one model; a null surface: the outside of the cubes.
ContactSurface make_contact_surface(const geometry::Cubes& cubes,
                                    const std::vector<std::uint32_t>& slot,
                                    const geometry::TriMesh* surface, bool tears = false);

}  // namespace physics
