#pragma once

// What parts that hit something leave with (bounce.hpp), once a stage was solved.
//
// The speeds of parts before and after are told at the same place, with the arms that it has where
// the stage begins, and an impulse acts there: what turns within the stage would otherwise differ
// in speed from itself. Rigid parts then turn on from there with the momentum that they have got,
// and what they get adds no energy (impact_energy.hpp).

#include "physics/bricks/impact_energy.hpp"

#include <map>
#include <set>

namespace physics {

// Who meets: part, whether the other is a part, and which.
struct Meeting {
    std::uint32_t part = 0;
    bool parts = false;
    std::uint32_t other = 0;

    auto operator<=>(const Meeting&) const = default;
};
// Of each that bounces, how much it is a rigid body by the end of a stage: 1 where it has a third
// of the speed that it is to leave with by then, or more, 0 where it does not rise yet.
using Risen = std::map<Meeting, double>;
// Those that are followed while they are squashed.
using Squashed = std::set<Meeting>;

Risen risen(const Stage& stage, const SolvedStage& solved);

// Where the error chooses the steps: 0 for what is better followed while it is squashed, since
// steps of that error, `finest` seconds at least, leave it more speed than its bounce; 1 for what
// bounces; rigid_yet for what bounces unless a shorter stage tells more of it.
inline constexpr double rigid_yet = 2;
Risen risen_by_error(const Stage& stage, const SolvedStage& solved, double finest);

// Gives parts that rise again the rest of the speed that they are to leave with, and takes off what
// impacts add to the energy of rigid parts: w changes, and x0 of rigid parts. `risen`: of a longer
// stage; what is not in it does not rise.
void finish_impacts(Stage& stage, const SolvedStage& solved, const Risen& risen);

}  // namespace physics
