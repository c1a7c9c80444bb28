#pragma once

// Where a point on its way meets the cubes of a part of a body (part_contact.hpp): in one of them,
// or before a face of the part.

#include "geometry/base/box_tree.hpp"
#include "physics/body/near_cubes.hpp"
#include "physics/body/part_gap.hpp"

#include <functional>
#include <optional>
#include <vector>

namespace physics {

// Where a point is looked for, at x moving at v for a step of dt seconds.
enum class Look {
    ahead,  // the step begins at x: where the point is, and which faces it comes near
    back    // the step ends at x: on the whole way there
};

// x and v are by slot, four numbers each.
struct StepOfParts {
    const PartShapes& shapes;
    const double* x;
    const double* v;
    double dt;  // s
    Look look;
};

// The cubes of a part that lie where something else may be, at x.
struct Target {
    std::uint32_t part = 0;
    geometry::Vec3 velocity = geometry::Vec3::Zero();  // m/s, the mean of its corners
    geometry::Box box;                                 // of all of its corners
    std::vector<std::uint32_t> cubes;
    std::vector<geometry::Box3f> boxes;  // of each, with room around it
    geometry::BoxTree tree;
};

// A part with its box and velocity, but no cubes yet.
Target target_of(const StepOfParts& step, std::uint32_t part);
// Takes its cubes that meet one of some regions.
void fill_target(const StepOfParts& step, const std::vector<geometry::Box>& regions,
                 Target& target);

// What comes to a place.
struct Arriving {
    geometry::Vec3 p, v;                      // m, m/s
    bool own = false;                         // it is of the same part
    double around = 0;                        // m, that it is told of what it is before earlier
    std::function<geometry::Vec3()> outward;  // the unit vector out of what the point is on; 0: any
};

// A place in a part, and how deep the point is there, or how far before it.
struct PartMeeting {
    std::uint32_t cube = 0;
    InCube in;
    Gap gap;
};

// The first place on its way where a point is in one of the target's cubes `near`; else where it
// is before them. `close` is room.
std::optional<PartMeeting> first_meeting(const StepOfParts& step, const Arriving& point,
                                         const Target& target, NearCubes& near,
                                         std::vector<NearCube>& close);

// How far ahead a point that goes `way` (m) is looked for, in cubes of h (m).
geometry::Vec3 way_ahead(const geometry::Vec3& way, double h);

inline geometry::Box wider(geometry::Box box, double by)
{
    box.lo.array() -= by;
    box.hi.array() += by;
    return box;
}

}  // namespace physics
