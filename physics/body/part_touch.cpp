#include "physics/body/part_touch.hpp"

#include <algorithm>
#include <limits>

namespace physics {
namespace {

// The sum of the corners' weights times a field: the way from the place to the point, or how fast
// they part.
Vec3 between(const PartTouch& touch, const double* field)
{
    Vec3 sum = Vec3::Zero();
    for (std::size_t a = 0; a < PointContact::most; ++a) {
        const double* at = field + 4 * std::size_t{touch.corners[a]};
        sum += double(touch.weight[a]) * Eigen::Map<const Vec3>(at);
    }
    return sum;
}

Vec3 along(const Vec3& normal, const Vec3& way)
{
    return way - way.dot(normal) * normal;
}

}  // namespace

double PartTouch::gap(const double* x) const
{
    return offset + normal.dot(between(*this, x));
}

std::vector<PointContact> press(const std::vector<PartTouch>& touches, const double* x,
                                const double* v, double dt, double tangent)
{
    std::vector<PointContact> out;
    for (const PartTouch& touch : touches) {
        const double gap = touch.gap(x);
        if (!(gap < 0)) continue;
        // Friction as contact_at() has it, of the stretch in place of the slip.
        const Vec3 velocity = between(touch, v) + touch.stretch / dt;
        const double load = touch.load < 0 ? touch.stiffness * -gap : touch.load;
        const double yields = touch.friction * load / (touch.stiffness * dt);  // m/s
        auto& contact = out.emplace_back(contact_at(
            {gap, touch.normal, velocity, load}, touch.stiffness,
            {touch.friction, std::max(yields, std::numeric_limits<double>::min()), tangent}));
        contact.count = PointContact::most;
        contact.corners = touch.corners;
        contact.weight = touch.weight;
    }
    return out;
}

void hold_loads(std::vector<PartTouch>& touches, const double* x)
{
    for (PartTouch& touch : touches) touch.load = touch.stiffness * std::max(0.0, -touch.gap(x));
}

std::vector<Grip> grips_of(const std::vector<PartTouch>& touches, const double* x0,
                           const double* x1)
{
    std::vector<Grip> out;
    for (const PartTouch& touch : touches) {
        const double gap = touch.gap(x1);
        if (!(gap < 0)) continue;
        const Vec3 way = touch.stretch + between(touch, x1) - between(touch, x0);
        Vec3 stretch = along(touch.normal, way);
        const double most = touch.friction * -gap;
        if (stretch.norm() > most) stretch *= most / stretch.norm();
        if (!stretch.allFinite()) continue;
        out.push_back({touch.point, touch.part, stretch.cast<float>()});
    }
    return out;
}

void take_grips(std::vector<PartTouch>& touches, const std::vector<Grip>& grips)
{
    auto grip = grips.begin();
    for (PartTouch& touch : touches) {
        while (grip != grips.end() && in_order(*grip, touch)) ++grip;
        const bool known = grip != grips.end() && !in_order(touch, *grip);
        touch.stretch = known ? along(touch.normal, grip->stretch.cast<double>()) : Vec3::Zero();
    }
}

bool add_found(std::vector<PartTouch>& touches, const std::vector<PartTouch>& found,
               const double* x, double much)
{
    std::vector<PartTouch> out;
    bool pushes = false;
    auto old = touches.begin();
    for (const PartTouch& touch : found) {
        while (old != touches.end() && in_order(*old, touch)) out.push_back(*old++);
        if (old != touches.end() && !in_order(touch, *old)) continue;
        out.push_back(touch);
        pushes |= touch.gap(x) < -much;
    }
    out.insert(out.end(), old, touches.end());
    touches.swap(out);
    return pushes;
}

}  // namespace physics
