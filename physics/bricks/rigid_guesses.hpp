#pragma once

// The guesses of where rigid parts end in a stage, that joints link.
//
// A solve finds where rigid parts go along lines about a guess, with arms that stay. What is pulled
// at its joints turns back by less than the solve has it, as its arms turn with it: of a chain that
// hangs, guesses that follow the solves jump to and fro, ever farther where tau^2 T L / I > 1 (T
// the pull, L the arm). The next guess is therefore a share of the way from the last one to what
// the solve found, by Aitken's rule for vectors (Irons, Tuck. A version of the Aitken accelerator
// for computer iteration. IJNME 1, 1969).

#include "physics/bricks/rigid_bodies.hpp"

#include <vector>

namespace physics {

class RigidGuesses {
public:
    // The motion of `rigid` is the guess that a solve starts with.
    void begin(const RigidBodies& rigid);
    // It is what the solve found: makes it the next guess.
    void aim(RigidBodies& rigid);

private:
    std::vector<Vec3> from_;   // v and s of each
    std::vector<double> way_;  // found less guessed, m/s, the last time
    double share_ = 1;
};

}  // namespace physics
