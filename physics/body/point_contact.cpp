#include "physics/body/point_contact.hpp"

#include <algorithm>

namespace physics {
namespace {

// a I + b n n^T
std::array<double, 6> isotropic_about(const Vec3& n, double a, double b)
{
    return {a + b * n.x() * n.x(), b * n.x() * n.y(), b * n.x() * n.z(),
            a + b * n.y() * n.y(), b * n.y() * n.z(), a + b * n.z() * n.z()};
}

}  // namespace

PointContact contact_at(const Gap& gap, double stiffness, const ContactLaw& law)
{
    PointContact out{};
    const double push = stiffness * -gap.size;
    const Vec3 slip = gap.velocity - gap.velocity.dot(gap.normal) * gap.normal;
    const double speed = slip.norm();
    const double load = gap.load < 0 ? push : gap.load;
    const double drag = law.friction * load / std::max(speed, law.creep);
    out.force = push * gap.normal - drag * slip;
    out.stiffness = isotropic_about(gap.normal, 0, stiffness);
    out.drag = isotropic_about(gap.normal, drag, -drag);
    if (law.tangent > 0 && speed > law.creep) {
        const auto along = isotropic_about(slip / speed, 0, law.tangent * drag);
        for (std::size_t i = 0; i < 6; ++i) out.drag[i] -= along[i];
    }
    out.energy = -0.5 * push * gap.size;
    return out;
}

}  // namespace physics
