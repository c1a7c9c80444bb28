#pragma once

// The ways of what pins hold within a frame, from where it starts to where the pins take it.
//
// Pins of a part that move as one rigid body turn evenly about one axis, and so do all that they
// carry; along chords they would come nearer to each other in the middle of the frame, and move
// slower than they turn. Where several hold a part and move differently, those that move alike turn
// together. What else pins do is even along lines.
//   y(s) = c0 + s (c1 - c0) + R(s a) (y0 - c0) + s e,   e = y1 - c1 - R(a) (y0 - c0)
// with the turn a, what is left over, e, and the places c that they turn about: of the pivots that
// pins tell and the mean of their own places, what goes least far. A pin that swings what it holds
// about a pivot beside that moves it along an arc. One that takes hold of what has turned elsewhere
// puts it back by a turn in its place: about a pivot far off, that would sweep aside.

#include "geometry/base/vec.hpp"

#include <cstdint>
#include <vector>

namespace physics {

using geometry::Vec3;

class PinPaths {
public:
    PinPaths() = default;
    // `group`: of each point, the part that it moves with; no_index: none. `pivots`: as those of
    // Pins. `edge`: m, of a cube.
    PinPaths(std::vector<Vec3> from, std::vector<Vec3> to, const std::vector<std::uint32_t>& group,
             const std::vector<Vec3>& pivots, double edge);

    // m, of a point when a share of the frame has gone by.
    Vec3 at(std::size_t point, double share) const;
    // m a frame.
    Vec3 velocity(std::size_t point, double share) const;
    // Forces on the points then, N, as they are told at the end of the frame: those by which the
    // points of a group push against each other have turned with it. Their sum stays as it is, and
    // so does their moment about the mean place of the group.
    std::vector<Vec3> at_end(std::vector<Vec3> forces, double share) const;

    bool move() const { return from_ != to_; }
    std::size_t count() const { return to_.size(); }

private:
    struct Turn {
        Vec3 from = Vec3::Zero(), to = Vec3::Zero();  // m, what it turns about
        Vec3 axis = Vec3::Zero();                     // unit
        double angle = 0;                             // rad
    };
    // R(share a) (y0 - c0)
    Vec3 arm(const Turn& turn, std::size_t point, double share) const;
    // Gives each group's forces at the end of the frame more moment (N m) about its mean place.
    void add_moments(const std::vector<Vec3>& more, std::vector<Vec3>& forces) const;

    std::vector<Vec3> from_, to_;      // m
    std::vector<Turn> turns_;          // of groups that turn
    std::vector<std::uint32_t> turn_;  // of each point; no_index: none. Empty: of none
};

}  // namespace physics
