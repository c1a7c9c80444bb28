#pragma once

// A frame of one body under way: what the phases of its steps share. Plain data; who does what:
//
//   lattice.cpp        one frame          use_regions() once, then each substep:
//     match_shapes     find_goals()       sums over regions -> rotations -> where particles want
//                                         to go
//     step_pull        pull()             the lattice's own impulses: goals, damping, membrane
//     step_motion      push_from_outside  gravity, point forces, wind, drag
//                      collide()          colliders, balls, other bodies   (lattice_contact)
//                      move()             particles, pins, balls
//     tear_links       tear_links()       breaks what is too long; then use_regions() again
//   step_report        what is told of the frame
//   step_weights       use_regions(): the regions of the links that hold, and their weights
//   plastic_flow       rest shapes that give way

#include "geometry/base/parallel.hpp"
#include "physics/body/pin_paths.hpp"
#include "physics/lattice/lattice_body.hpp"
#include "physics/lattice/lattice_contact.hpp"
#include "physics/regions/region_sums.hpp"
#include "physics/state/loads.hpp"

#include <algorithm>
#include <optional>

namespace physics {

// What rounding leaves of the pull of a piece, which has no momentum: v = drift + spin x (x -
// pivot).
struct RigidRest {
    Vec3 drift = Vec3::Zero(), spin = Vec3::Zero(), pivot = Vec3::Zero();  // m/s, rad/s, m
};

// In double precision: the motion and what acts on it.
struct FrameState {
    FrameState(const LatticeBody& of, State& stepped, const Loads& given, double seconds,
               const LatticeOptions& with)
        : body(of), state(stepped), loads(given), options(with), frame(seconds),
          dt(seconds / with.substeps), n(of.base.corners), flat(of.flat_axis >= 0),
          in_plane(of.options.plane == PlaneMotion::in_plane)
    {}

    const LatticeBody& body;
    State& state;
    const Loads& loads;
    const LatticeOptions& options;
    double frame, dt;  // s, of the frame and of a substep
    std::size_t n;     // particles
    bool flat, in_plane, plastic = false;

    // What acts on it.
    std::vector<Force> forces;  // of the loads, at a share of the frame
    Vec3 gravity = Vec3::Zero();
    Aligned<double> steady;  // point forces, N, four numbers a corner; empty without
    bool windy = false, damped = false;
    bool touches = false;  // there is something to touch; if not, forces and motion are one pass
    std::vector<double> inverse_mass;  // 1/kg, 0 of pins; where there can be contact
    PinPaths pin_paths;                // of pins, from where the frame starts
    Pushes pushes;                     // of the last step

    // The regions of the links that hold.
    std::shared_ptr<const MatchedRegions> held_regions;  // null: the body's own
    const MatchedRegions* matched = nullptr;             // those, or the body's own
    std::optional<TornSkin> torn_skin;                   // where links are broken and it touches
    const float* inverse_spread = nullptr;   // 6 a slot, B^-1 as regions weigh it; where plastic
    PinnedSpread::Found pinned_spread;       // that of the body with pins
    std::vector<std::uint8_t> torn_corners;  // C, while links of a membrane are broken
    double stiffness = 0, damping = 0;       // alpha with the membrane's share, beta
    double tau = 0, tau_acts = 0;  // s, of damping: as asked for, and what steps can bear of it
    double damped_by = 0;          // 1/s, beta = 1 - exp(-damped_by tau), where steps can bear it
    double resolved = 0;           // s dt, at most 1 where steps can bear the stiffness
    double resolved_volume = 0;    // likewise with the volume's
    double poisson = 0, poisson_acts = 0;  // means over regions: the material's, and what is borne

    bool has_before = false;     // d of the step before is known
    Vec3 origin = Vec3::Zero();  // what single precision measures from

    // The rigid motion of each piece that pull() leaves, and push_from_outside() takes out again.
    std::shared_ptr<const LinkedPieces> torn_pieces;  // null: the body's own
    const LinkedPieces* pieces = nullptr;             // those, or the body's own
    std::vector<double> piece_mass;                   // kg
    std::vector<std::uint8_t> is_pinned;              // of each piece
    std::vector<RigidRest> rest;                      // of each piece
};

// And the sums over regions, in T: float or double.
template <class T> struct StepState : FrameState {
    StepState(const LatticeBody& of, State& stepped, const Loads& given, double seconds,
              const LatticeOptions& with)
        : FrameState(of, stepped, given, seconds, with), sums(of.whole.regions)
    {}

    RegionSums<T> sums;
    std::vector<T> weight;                    // slots, alpha of `stiffness`
    std::vector<T> volume_share;              // slots, K / k; empty where no volume is kept
    std::vector<T> stretch_share;             // slots, S / k; empty where regions have none
    std::vector<T> held_weight;               // N, their sums over the regions of each
    std::vector<float> with_pins;             // kg, M_i, as regions weigh it; where there are pins
    const RegionTwist<T>* twist = nullptr;    // slots, of a plane in space
    std::vector<RegionTwist<T>> own_twist;    // where it is not the body's
    const RegionVolume<T>* volume = nullptr;  // slots, where volume is kept
    std::vector<RegionVolume<T>> own_volume;  // where it is not the body's
    PinnedVolume::Found pinned_volume;        // that of the body with pins
    std::vector<T> membrane_share;            // C, kg of `stiffness`; empty where there is none
    std::vector<float> membrane_rest;         // 3 C, as MembraneState wants it; where plastic
    MembranePull<T> stretched;
};

// Makes ready for the first step what does not change within a frame. Then use_regions().
void begin_frame(FrameState& step);
// Takes forces as they are at a share of the frame; begin_frame() took those at its end.
void find_forces(FrameState& step, double share);

inline bool bends_in_space(const FrameState& step)
{
    return step.flat && !step.in_plane;
}

// alpha of a rate s over dt.
inline double share_of(double rate_sq, double dt)
{
    return std::min(1.0, rate_sq * dt * dt);
}

inline constexpr std::size_t particles_a_task = 2048;
inline constexpr std::size_t membrane_strips_a_task = 32;  // up to 64 cells each

// Calls with(i) for i below n, on all threads.
template <class With> void for_each_below(std::size_t n, const With& with)
{
    geometry::parallel_for(n, particles_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) with(i);
    });
}

// The largest of(i) for i below n, or 0; `piece` of them a task.
template <class Of>
double largest_of(std::size_t n, const Of& of, std::size_t piece = particles_a_task)
{
    struct Largest {
        double value = 0;
        Largest operator+(const Largest& o) const { return {std::max(value, o.value)}; }
    };
    const auto of_piece = [&](std::size_t begin, std::size_t end) {
        Largest most;
        for (std::size_t i = begin; i < end; ++i) most.value = std::max(most.value, of(i));
        return most;
    };
    return geometry::ordered_sum<Largest>(n, piece, {}, of_piece).value;
}

}  // namespace physics
