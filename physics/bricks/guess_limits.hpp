#pragma once

// How near the guesses of where rigid bodies end are to be.

#include "physics/bricks/stage.hpp"

#include <algorithm>
#include <vector>

namespace physics {

// How far guesses of rigid parts may be off, cubes: what is joined to something shows it as a gap
// there.
class GuessLimits {
public:
    explicit GuessLimits(const Stage& stage) : joined_(stage.rigid.count(), 0)
    {
        const CornerBody& body = stage.frame.body;
        for (const JointPoint& joint : stage.frame.loads.joints) {
            for (const std::uint32_t k : {joint.corner[0], joint.corner[8]}) {
                const auto slot = static_cast<std::uint32_t>(body.slot_of(k));
                const auto i = stage.rigid.of_corner(slot);
                if (i != RigidBodies::not_rigid) joined_[i] = 1;
            }
        }
    }

    // The largest, in these.
    double most(const std::vector<double>& off) const
    {
        double out = 0;
        for (std::size_t i = 0; i < off.size(); ++i) {
            out = std::max(out, off[i] / (joined_[i] != 0 ? 1e-5 : 0.005));
        }
        return out;
    }
    bool too_far(const std::vector<double>& off) const
    {
        for (std::size_t i = 0; i < off.size(); ++i) {
            if (off[i] > (joined_[i] != 0 ? 0.02 : 0.1)) return true;
        }
        return false;
    }

private:
    std::vector<std::uint8_t> joined_;
};

}  // namespace physics
