#pragma once

// Where a stage starts, and what the body touches on its way.

#include "physics/bricks/stage.hpp"

#include <vector>

namespace physics {

// Starts it at x0, v0 over tau seconds up to a share of the frame: poses the colliders, takes the
// wind, and guesses w = v0, or what takes a pin to its target.
void start_stage(Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0, double tau,
                 double share);

// How deep a point was where the stage began, in what it touches as that was then, m.
double depth_at_start(const Stage& stage, const PlaneTouch& touch);

// What a stage has found that it touches, and where it looked for that.
struct FoundTouches {
    std::vector<PlaneTouch> touches, holds;
    std::vector<Aligned<double>> looked_at;
    std::vector<std::uint32_t> looked;
    Aligned<double> sheets_at, holds_at;
    bool struck = false;
};
FoundTouches found_so_far(const Stage& stage);
void go_back_to(const FoundTouches& found, Stage& stage);

// Grips as states keep them: with the corners in place of their slots.
std::vector<Grip> with_corners(const CornerBody& body, std::vector<Grip> grips);

enum class Known { kept, renewed };
// Finds which points are in other parts and in colliders where w leads, or before them, where that
// is far from where they were looked for last. Planes of colliders that are known already are kept,
// or become those found now. Returns whether a push has changed.
bool find_touches(Stage& stage, Known known = Known::renewed);
// Where a round has taken what it pressed at `before` too deep, the next one presses harder.
// Returns whether it does.
bool firm_up(Stage& stage, const Aligned<double>& before);
// m/s, of corners from where the stage began to x. Those of rigid parts go along arcs, and are at w
// at its end alone: friction that took w for the whole way would draw a part that turns together.
Aligned<double> mean_velocities(const Stage& stage);
// The contacts of x, w, of what find_touches() found, and the joints.
std::vector<PointContact> touching(const Stage& stage);
// The contacts that w would lead to. The stage stays as it is.
std::vector<PointContact> contacts_ahead(Stage& stage, const Aligned<double>& w);
// Friction of all that touches yields from now on by the push at x.
void hold_loads(Stage& stage);
void hold_first_loads(Stage& stage);
// By what share the friction that yields by held loads differs from that by the push at x.
double friction_off(const Stage& stage);

}  // namespace physics
