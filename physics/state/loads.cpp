#include "physics/state/loads.hpp"

#include <algorithm>

namespace physics {

ForceNumbers Force::numbers() const
{
    return {acceleration, velocity, force,       position, torque, swirl,
            outward,      pressure, air_density, drag,     radius, gusts};
}

void Force::began_as(const Force& last)
{
    before = last.numbers();
    if (*before == numbers()) before.reset();
}

Force Force::at(double share) const
{
    Force out = *this;
    if (share == 1 || !before) return out;
    const auto between = [share](const auto& from, auto& to) { to = from + share * (to - from); };
    between(before->acceleration, out.acceleration);
    between(before->velocity, out.velocity);
    between(before->force, out.force);
    between(before->position, out.position);
    between(before->torque, out.torque);
    between(before->swirl, out.swirl);
    between(before->outward, out.outward);
    between(before->pressure, out.pressure);
    between(before->air_density, out.air_density);
    between(before->drag, out.drag);
    between(before->radius, out.radius);
    between(before->gusts.speed, out.gusts.speed);
    between(before->gusts.size, out.gusts.size);
    between(before->gusts.carried, out.gusts.carried);
    between(before->gusts.time, out.gusts.time);
    return out;
}

void Collider::began_as(const Collider& last)
{
    before = last.pose;
    size_before = last.size();
    if (*size_before == size()) size_before.reset();
}

bool any_change(std::span<const Force> forces)
{
    return std::any_of(forces.begin(), forces.end(),
                       [](const Force& f) { return f.before.has_value(); });
}

}  // namespace physics
