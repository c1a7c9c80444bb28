#pragma once

// One stage of an implicit time step: its unknowns, and what its equations leave over for a guess
// of them. This is the state that step_solver, step_newton and step_descent work on.
//
// A stage goes tau seconds ahead from (x0, v0). Its unknowns are the velocities w at its end:
//   x = x0 + tau w
//   r = M (v0 - w) + tau (f(x) + f_ext + f_wind + f_contact - (D + drag) w) - tau C (w - b)
// with f the elastic forces, C = Rayleigh's damping with the stiffness, D that with the mass, and
// drag that of the wind. f_wind is that at x0, v0, and holds loads that follow the body, taken
// where it is about to be, and radial forces (radial_on_way.hpp). The stage is solved where r = 0.
// A round of Newton's method solves
//   A delta = r,   A = M + tau (D + drag) + tau^2 K + tau C + tau^2 k + tau c
// for the change of w, with K = -df/dx, and k and c the same of the contacts by place and speed.
// In the first round f is linear about x0 + tau b: f(x) = f(x0 + tau b) - tau K (w - b), with b the
// motion of parts that turn freely (free_parts.hpp), else 0.

#include "physics/body/collider_contact.hpp"
#include "physics/body/corner_body.hpp"
#include "physics/body/following_forces.hpp"
#include "physics/body/part_contact.hpp"
#include "physics/body/pin_paths.hpp"
#include "physics/body/posed_solids.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/bricks/rigid_bodies.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"
#include "physics/state/step_options.hpp"

#include <vector>

namespace physics {

// What stays as it is while a frame is stepped. Vectors hold four numbers a slot, the fourth 0.
struct StepFrame {
    StepFrame(const CornerBody& body, const Loads& loads, double seconds,
              const StepOptions& options);  // not started
    StepFrame(const StepFrame&) = delete;   // `following` points into `forces`
    StepFrame& operator=(const StepFrame&) = delete;

    // Begins where corners are at x.
    void start_at(const Aligned<double>& x);
    // Takes forces as they are at a share of the frame. They start as at its end.
    void take_forces(double share);

    const CornerBody& body;
    const Loads& loads;
    double seconds;
    StepOptions options;

    std::size_t n;              // numbers in a vector
    Aligned<double> start;      // m, x at the start of the frame
    PinPaths pin_paths;         // of each pin, from there
    std::vector<Force> forces;  // of the loads, at `forces_at` of the frame
    double forces_at = 1;
    Aligned<double> steady;  // N, gravity and point forces of these that do not follow
    FollowingForces following;
    Aligned<double> mass, damping;  // kg, kg/s: M, D as lumped on corners
    Aligned<double> fixed;          // 1: pinned
    HeldCorners held;
    std::vector<std::uint32_t> held_along;  // numbers that are fixed, of corners with free ones
    std::vector<double> part_mass;          // kg, of each part
    bool windy = false;                     // wind, a radial force, or what follows the body
    bool first = false;                     // step of a shot

private:
    void use_forces();
};

struct Stage {
    Stage(const StepFrame& frame, Elasticity& elasticity);  // with room; not started yet

    const StepFrame& frame;
    Elasticity& elasticity;

    double tau = 0;    // s
    double span = 0;   // s, from its start to where its step ends: 2 tau at the midpoint
    double share = 0;  // of the frame that has gone by at the end of the stage
    int halvings = 0;  // of the step that was asked for

    Aligned<double> began;       // m: where it starts from
    Aligned<double> began_v;     // m/s: likewise
    Aligned<double> x0, v0;      // the same and how fast, as its equations have them
    bool turns_start = false;    // x0 and v0 are moved on (free_parts.hpp)
    Aligned<double> lifted;      // m: by which x0 is moved of what falls (free_fall.hpp); empty: 0
    Aligned<double> base;        // m/s: b; empty: 0
    Aligned<double> w, x;        // at its end, as guessed
    Aligned<double> wind, drag;  // N, N s/m: f_wind, drag
    Aligned<double> radial;      // N: of f_wind, radial forces; empty: none
    Aligned<double> force, product;  // N: f as last linearised; room for products with K
    Aligned<double> jump, momentum;  // m/s, N s: v0 - w, and M of it
    Aligned<double> r, delta;        // N s, m/s: the residual, and the change of w that answers it
    Aligned<double> linear_at;       // m: where f and K were last evaluated; empty: nowhere
    bool at_start = true;            // f is linear about x0 + tau b, not evaluated at x
    bool wary = false;               // of friction in contacts to be found
    bool struck = false;             // something hits within the stage (bounce.hpp)

    RigidBodies rigid;  // parts that keep their shape

    std::vector<PosedCollider> colliders;    // and solids behind them, where sheets touch these
    PosedSolids solids;                      // where those are
    std::vector<PartPair> near;              // parts that may touch each other
    std::vector<PlaneTouch> touches, holds;  // of parts, of colliders; found by find_touches()
    std::vector<Grip> grips, held;           // those that the step began with
    std::vector<Aligned<double>> looked_at;  // m: x where touches of parts were looked for
    std::vector<std::uint32_t> looked;       // of each of near: into these, where theirs were last
    Aligned<double> sheets_at;               // m: x where touches of sheets were looked for last
    Aligned<double> holds_at;                // m: the same of holds
    std::vector<PointContact> contacts;
};

// What went wrong in the stages of a frame, and what they cost.
struct StepRecord {
    Report report;
    // What stopped a solve before its tolerance was met.
    bool short_of_iterations = false, unsettled = false, violent = false;
    bool gained = false;         // steps of the midpoint rule were taken otherwise
    bool touched = false;        // a stage was solved with something that the body might touch
    std::vector<Vec3> reaction;  // N, of each pin, as the last stage left it
    double left = 0;  // share of the forces at work that rounds of contact left unbalanced
};

// visit(pin, axis, number) for each axis that a pin holds; `number` is that of its corner's slot.
template <class Visit> void for_held_axes(const StepFrame& frame, const Visit& visit)
{
    const Pins& pins = frame.loads.pins;
    for (std::size_t p = 0; p < pins.corner.size(); ++p) {
        const std::size_t at = 4 * frame.body.slot_of(pins.corner[p]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if ((held_axes(pins, p) >> axis & 1) != 0) visit(p, axis, at + axis);
        }
    }
}
// Whether no pin, or no collider, moves in the frame. Meshes are compared by what is in them:
// whether a cook made one once or for each frame must not show.
bool pins_stay(const Stage& stage);
bool colliders_stay(const StepFrame& frame);

// Whether some of the body is sheets, whether or not they touch each other.
inline bool has_sheets(const CornerBody& body)
{
    return body.sheets || body.skin.thickest > 0;
}
// Whether parts of the body, or sheets of it, may touch each other.
inline bool touches_itself(const Stage& stage)
{
    const CornerBody& body = stage.frame.body;
    return !stage.near.empty() || body.sheets || body.solids;
}
// Whether there is anything that the body might touch, or parts are joined.
inline bool may_touch(const Stage& stage)
{
    return !stage.colliders.empty() || !stage.frame.loads.joints.empty() || touches_itself(stage);
}

// out = M v, with the masses of the method (elasticity.hpp); D v likewise.
void times_mass(const Stage& stage, const Aligned<double>& v, Aligned<double>& out);
void times_damping(const Stage& stage, const Aligned<double>& v, Aligned<double>& out);

// x = x0 + tau w
void place(Stage& stage);
// f and K at x, which may be x0 or stage.x. Where they were evaluated there last, they are kept.
void linearise(Stage& stage, const Aligned<double>& x);
// r of w and of the contacts as they were found last, evened out over rigid parts.
void find_residual(Stage& stage);

// The forces that a stage's residual is told as a share of, N s by slot: those that act from
// outside, and those of the body, elastic and of inertia, as f was evaluated last.
struct AtWork {
    Aligned<double> outside, elastic, inertia;
};
AtWork at_work(const Stage& stage);

// Sums in the order of the numbers.
double dot(const Aligned<double>& a, const Aligned<double>& b);
bool all_finite(const Aligned<double>& v);

}  // namespace physics
