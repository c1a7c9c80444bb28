#pragma once

// The energy of rigid parts that pins or joints hold, and that touch nothing.
//
// Implicit Euler loses 1/2 |w - v0|^2 in M with each step in which a constraint that does no work
// changes the velocity from v0 to w: a pendulum of 1 m that is let go level loses 59 % of its
// energy in half a swing at 24 steps a second. Parts that joints link, and pins that stay hold, are
// a group; with T its kinetic energy and W the work of the forces from outside, T - W is what it
// was before the step; what springs that hold points of the material take up counts in W. The
// velocities of a group that is held are multiplied by what makes it so, which keeps v = 0 at every
// pin and v_a = v_b at every joint; along axes that no pin holds, as of a roller, those against the
// mean. Of one that is free, those against its motion as one rigid body are, which keeps both
// momenta. (Energy kept by a factor on the
// velocities: LaBudde, Greenspan. Energy and momentum conserving methods of arbitrary order.
// Numerische Mathematik 1976.)
//
// A step that lost more than half of what it had is an impact, as of a slack chain that is pulled
// tight, and stays as it is.

#include "physics/bricks/stage.hpp"

#include <vector>

namespace physics {

// Places of the parts of groups that are held. The velocities at the end of a step take them too
// far, as implicit Euler does, by tau^2 a / 2. As T - W of these places is kept, they become ever
// faster too: a body that is let go is a step ahead after four steps, and two after 64. The means
// of the velocities before and after a step take them where a constant acceleration does.
class HeldPlaces {
public:
    // Places them by the means of what the stage began and was solved with. Returns whether there
    // are any: then it is to be solved again.
    bool take_means(Stage& stage);
    // Solved so, takes those that touch something or were hit back to where their velocities at the
    // end place them, or all of them. Likewise.
    enum class Which { struck, all };
    bool take_ends(Stage& stage, Which which);

private:
    // J, what the group of each rigid part lost before its place changed, where that is as much as
    // an impact takes; else infinity. What an impact took, it loses again; what the place made, it
    // does not.
    std::vector<double> impact_;
};

// v of such groups, which went from x0, v0 to x in the stage.
void keep_rigid_energy(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0,
                       const Aligned<double>& x, Aligned<double>& v);

}  // namespace physics
