#pragma once

// Points of a body's surface that touch something, while one time step is solved.
//
// A point that a search finds in another part (part_contact.hpp), in a sheet
// (sheet_contact.hpp) or in a collider (collider_contact.hpp), or before it, is kept behind a plane
// for the rest of the step: with the weights w of the point and of the place that it was found at,
// the normal n and the depth as they were there,
//   g(x) = g0 + n . sum w_a x_a
// is its signed distance wherever the corners go. The forces of such points are the slope of a
// convex function of x but for friction, so that rounds of Newton's method converge; a set that is
// found anew in each round comes and goes. The plane errs by the slip within a step times the turn
// of the normal along it, and a step starts with a new one. A collider's plane stands where it is
// at the end of the step.
//
// A point that bounces is pushed until g is its rebound, which is more than 0 (bounce.hpp).
//
// What rests, or is driven in deep, becomes stiffer than point_contact.hpp has it. A violent step
// takes the fewest iterations with soft contacts (iterations grow as the square root of the
// stiffness); what lies still needs few in any case:
//   - at the end of a step, by exp(dt / 0.2 s) as long as the point is deeper than StepEnd::deep.
//     That is slow against the swing of a body on its contacts, sqrt(depth / g), so that the body
//     rises without a push;
//   - within a step, while touches are still being looked for, by as much as a point is too deep.
//     That makes no energy: at the depth d0 and the stretch s0 with which the step began,
//       k' (d0 - b')^2 = k (d0 - b)^2,   k' s0'^2 = k s0^2
//     where b is its slack, the depth from which on it is pushed.
// A point keeps its firmness, 20 at most, until it leaves what it touches.
//
// What starts deep in something has as much slack. Slack goes in 0.1 s, and where there is more, at
//   slack_speed(b) = sqrt(g b)
// What follows it is braked by half of gravity: it comes out without a hop.
//
// What stops a mass within a step is stiffer in shorter steps. A point that touched before, in a
// longer step, starts with the push and the friction that it had then, lest it is thrown out:
//   k' (d0 - b') = k (d0 - b),   k' s0' = k s0
// and likewise, with less slack, where steps grow longer again.
//
// Friction is a spring along the plane, as stiff as the push, that yields at mu N, and that a point
// keeps from step to step for as long as it touches (Cundall, Strack. A discrete numerical model
// for granular assemblies. Geotechnique 1979):
//   F = -min(k |s|, mu N) s / |s|,   s = s0 + dt v_t
// What rests does not creep, and rounds converge as they do without friction. (Coulomb's law with a
// creep too slow to see leaves each point a kink far below the solver's tolerance, and of rounds
// that cross it none converges.)

#include "physics/body/part_shapes.hpp"
#include "physics/body/point_contact.hpp"
#include "physics/state/state.hpp"

#include <tuple>
#include <vector>

namespace physics {

// A point is told of what it is before by less than this, cubes.
constexpr double known_before = 0.3;

struct PlaneTouch {
    std::array<std::uint32_t, PointContact::most> corners{};  // slots, as in PointContact
    std::array<float, PointContact::most> weight{};
    std::uint32_t count = PointContact::most;  // of corners: 8 where what it touches has none
    std::uint32_t point = 0, other = 0;        // what it touches: part, collider, triangle, edge
    Vec3 normal = Vec3::UnitY();               // unit, out of that
    Vec3 drift = Vec3::Zero();                 // m/s, of that, where it has no corners
    double offset = 0;                         // m, g0
    double stiffness = 0;                      // N/m, k
    double at_rest = 0;                        // N/m, k of a point at rest, not firmer yet
    double friction = 0;                       // mu
    double bounce = 0;                         // share of the speed that it leaves with
    double rebound = 0;                        // m, gap that it is pushed to
    Vec3 stretch = Vec3::Zero();               // m, s0
    double firmness = 1;                       // factor that `stiffness` contains
    double size = 0;                           // m, of the smaller cubes, or the thickness
    double slack = 0;                          // m, how deep it may be without a push
    double began = 0;                          // m, how deep it was when the step began
    double load = -1;  // N, that it yields at a share of; below 0: as it is pushed

    // g at x, by slot, four numbers each.
    double gap(const double* x) const;
    // m/s, against what it touches, where corners move at v.
    Vec3 velocity(const double* v) const;
    // How deep it is in what pushes it, m: less its slack, or up to its rebound; 0 where it is not
    // pushed.
    double depth(const double* x) const;
};

// k of a point of `mass` (kg) that goes `way` (m) in within a step of dt seconds when nothing stops
// it: `least` (N/m), and what stops the mass within a step, at most a tenth of a cube of h (m)
// deep.
double stopping(double least, double mass, double way, double dt, double h);

// Whether `a` stands before `b` where touches or grips are in order: by point, then by what it
// touches.
template <class A, class B> bool in_order(const A& a, const B& b)
{
    return std::tie(a.point, a.other) < std::tie(b.point, b.other);
}

// The speed (m/s) at which what is `way` (m) deep comes out: that of a fall by half of it.
double slack_speed(double way);

// All of some lists, in_order().
std::vector<PlaneTouch> put_in_order(const std::vector<std::vector<PlaneTouch>>& lists);
// Which of some touches, in_order(), is the first of each point 0 .. points or of one behind it,
// and the end.
std::vector<std::uint32_t> first_of_points(const std::vector<PlaneTouch>& touches,
                                           std::size_t points);

// The contacts of all touches that are deep, or whose friction yields by a load, of corners
// at x moving at v, in their order, in a step of dt seconds. `tangent` is the a of
// point_contact.hpp.
std::vector<PointContact> press(const std::vector<PlaneTouch>& touches, const double* x,
                                const double* v, double dt, double tangent);

// Friction of all of them yields from now on by the push at x, whatever becomes of that: forces are
// then the slope of a convex function altogether.
void hold_loads(std::vector<PlaneTouch>& touches, const double* x);
// The same before what pushes is known: at most by `times` the push with which the step began.
void hold_first_loads(std::vector<PlaneTouch>& touches, const double* x, double times);

// By how much the friction that yields by loads that are held differs from that by the push at x,
// and how much the latter is: the sums over all, N.
struct HeldFriction {
    double off = 0, all = 0;
};
HeldFriction held_friction(const std::vector<PlaneTouch>& touches, const double* x);

// Makes those stiffer that press at `before` and are deeper than `deep` (sizes of the touch) at x,
// with the energy that they had at x0, where the step began. Those that bounce stay as they are.
// Returns whether any changed.
struct Firming {
    const double* before;
    const double* x;
    double deep = 0;
    const double* x0 = nullptr;
    double dt = 0;  // s, of the step
};
bool firm_up(std::vector<PlaneTouch>& touches, const Firming& firming);

// That of a point on something, among those in_order(); null where there is none.
const Grip* find_grip(const std::vector<Grip>& grips, std::uint32_t point, std::uint32_t other);
// m, 0 where there are none.
double deepest_of(const std::vector<Grip>& grips);

// What is known after a step in which corners went from x0 to x1.
struct StepEnd {
    const double* x0;
    const double* x1;
    double dt = 0;    // s
    double late = 0;  // s, that x1 is later than the planes
    double near = 0;  // m
    double deep = 0;  // sizes of the touch, that what rests is to be no deeper than
};
// The grip of each touch whose gap at the end is below `near`: stretched where it is below 0.
std::vector<Grip> grips_of(const std::vector<PlaneTouch>& touches, const StepEnd& end);
// The time in which slack goes. It is that of the step that begins, not of the one before: what
// comes out goes as fast where steps become shorter.
struct SlackTime {
    double dt = 0;       // s
    bool solid = false;  // what touches is no sheet
};
// What is left of it when that has gone, m. `size` is that of the touch.
double slack_left(double slack, double size, SlackTime time);
// Gives touches the stretch, firmness and slack that they have among `grips`, for the stiffness of
// this step.
void take_grips(std::vector<PlaneTouch>& touches, const std::vector<Grip>& grips,
                SlackTime time = {});

// Adds those found that are of other points. Both are in_order(), as is the result. Returns whether
// one that is new is deeper than `much` (m) at x.
bool add_found(std::vector<PlaneTouch>& touches, const std::vector<PlaneTouch>& found,
               const double* x, double much);
// The same, and those that are known get the plane found now where that differs from theirs by more
// than `much` at x; those that press by as much and are not found any more go. Returns whether a
// push changed.
bool renew(std::vector<PlaneTouch>& touches, const std::vector<PlaneTouch>& found, const double* x,
           double much);

}  // namespace physics
