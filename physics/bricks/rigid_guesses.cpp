#include "physics/bricks/rigid_guesses.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

void RigidGuesses::begin(const RigidBodies& rigid)
{
    from_.clear();
    for (const RigidMotion& m : rigid.motion) {
        from_.push_back(m.v);
        from_.push_back(m.s);
    }
}

void RigidGuesses::aim(RigidBodies& rigid)
{
    constexpr double least = 0.02;
    std::vector<double> way;
    for (std::size_t i = 0; i < rigid.count(); ++i) {
        const RigidMotion& m = rigid.motion[i];
        const double size = std::sqrt(0.5 * m.began.inertia.trace() / m.began.mass);
        const Vec3 v = m.v - from_[2 * i], s = size * (m.s - from_[2 * i + 1]);
        way.insert(way.end(), {v.x(), v.y(), v.z(), s.x(), s.y(), s.z()});
    }
    if (!way_.empty()) {
        double along = 0, change_sq = 0;
        for (std::size_t i = 0; i < way.size(); ++i) {
            const double change = way[i] - way_[i];
            along += way_[i] * change, change_sq += change * change;
        }
        if (change_sq > 0) share_ = std::clamp(-share_ * along / change_sq, least, 1.0);
    }
    for (std::size_t i = 0; i < rigid.count(); ++i) {
        RigidMotion& m = rigid.motion[i];
        m.v = from_[2 * i] + share_ * (m.v - from_[2 * i]);
        m.s = from_[2 * i + 1] + share_ * (m.s - from_[2 * i + 1]);
    }
    way_ = std::move(way);
}

}  // namespace physics
