#include "physics/body/plane_touch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace physics {
namespace {

constexpr double most_firmness = 20;
constexpr double firming_time = 0.2;  // s, in which what rests becomes e times stiffer
constexpr double slack_time = 0.1;    // s, in which slack falls to 1 / e

// The sum of the corners' weights times a field: the way from the place to the point, or how fast
// they part.
Vec3 between(const PlaneTouch& touch, const double* field)
{
    std::array<double, 4> sum{};  // with the fourth, compilers take two at a time
    for (std::size_t a = 0; a < touch.count; ++a) {
        const double* at = field + 4 * std::size_t{touch.corners[a]};
        const auto weight = double(touch.weight[a]);
        for (std::size_t i = 0; i < 4; ++i) sum[i] += weight * at[i];
    }
    return {sum[0], sum[1], sum[2]};
}

Vec3 along(const Vec3& normal, const Vec3& way)
{
    return way - way.dot(normal) * normal;
}

}  // namespace

double stopping(double least, double mass, double way, double dt, double h)
{
    constexpr double deep = 0.1;  // cubes
    return least + mass / (dt * dt) * std::max(1.0, way / (deep * h));
}

double PlaneTouch::gap(const double* x) const
{
    return offset + normal.dot(between(*this, x));
}

Vec3 PlaneTouch::velocity(const double* v) const
{
    return between(*this, v) - drift;
}

double PlaneTouch::depth(const double* x) const
{
    return std::max(0.0, (rebound > 0 ? rebound : -slack) - gap(x));
}

std::vector<PlaneTouch> put_in_order(const std::vector<std::vector<PlaneTouch>>& lists)
{
    // Touches are large: keys are sorted in their place.
    std::vector<std::pair<std::uint64_t, const PlaneTouch*>> keys;
    for (const auto& list : lists) {
        for (const PlaneTouch& touch : list) {
            keys.emplace_back(std::uint64_t{touch.point} << 32 | touch.other, &touch);
        }
    }
    std::sort(keys.begin(), keys.end(), [](auto& a, auto& b) { return a.first < b.first; });
    std::vector<PlaneTouch> out;
    out.reserve(keys.size());
    for (const auto& [key, touch] : keys) out.push_back(*touch);
    return out;
}

std::vector<std::uint32_t> first_of_points(const std::vector<PlaneTouch>& touches,
                                           std::size_t points)
{
    std::vector<std::uint32_t> out(points + 1, 0);
    for (const PlaneTouch& touch : touches) {
        if (touch.point >= points) break;  // of sheets, which are numbered behind
        ++out[touch.point + 1];
    }
    for (std::size_t p = 0; p < points; ++p) out[p + 1] += out[p];
    return out;
}

std::vector<PointContact> press(const std::vector<PlaneTouch>& touches, const double* x,
                                const double* v, double dt, double tangent)
{
    std::vector<PointContact> out;
    for (const PlaneTouch& touch : touches) {
        const double gap = -touch.depth(x);
        const double load = touch.load < 0 ? touch.stiffness * -gap : touch.load;
        if (!(gap < 0) && !(load > 0)) continue;
        // Friction as contact_at() has it, of the stretch in place of the slip.
        const Vec3 velocity = touch.velocity(v) + touch.stretch / dt;
        const double yields = touch.friction * load / (touch.stiffness * dt);  // m/s
        auto& contact = out.emplace_back(contact_at(
            {gap, touch.normal, velocity, load}, gap < 0 ? touch.stiffness : 0,
            {touch.friction, std::max(yields, std::numeric_limits<double>::min()), tangent}));
        contact.count = touch.count;
        contact.corners = touch.corners;
        contact.weight = touch.weight;
    }
    return out;
}

void hold_loads(std::vector<PlaneTouch>& touches, const double* x)
{
    for (PlaneTouch& touch : touches) touch.load = touch.stiffness * touch.depth(x);
}

void hold_first_loads(std::vector<PlaneTouch>& touches, const double* x, double times)
{
    for (PlaneTouch& touch : touches) {
        const double began = touch.stiffness * std::max(0.0, touch.began - touch.slack);
        touch.load = std::min(touch.stiffness * touch.depth(x), times * began);
    }
}

HeldFriction held_friction(const std::vector<PlaneTouch>& touches, const double* x)
{
    HeldFriction out;
    for (const PlaneTouch& touch : touches) {
        const double push = touch.stiffness * touch.depth(x);
        out.all += touch.friction * push;
        if (touch.load >= 0) out.off += touch.friction * std::abs(touch.load - push);
    }
    return out;
}

// What its springs hold where the step began stays as it is.
static void make_firmer(PlaneTouch& touch, double by, const Firming& firming)
{
    const double here =
        -touch.gap(firming.x0) - firming.dt * touch.drift.dot(touch.normal);  // on its new plane
    const double began = std::min(touch.began, here);
    touch.firmness *= by;
    touch.stiffness *= by;
    if (began > touch.slack) touch.slack = began - (began - touch.slack) / std::sqrt(by);
    touch.stretch /= std::sqrt(by);
}

bool firm_up(std::vector<PlaneTouch>& touches, const Firming& firming)
{
    bool changed = false;
    for (PlaneTouch& touch : touches) {
        const double depth = -touch.gap(firming.x), deep = firming.deep * touch.size;
        if (!(depth > deep && touch.depth(firming.before) > 0) || touch.rebound > 0) continue;
        const double by = std::min(depth / deep, most_firmness / touch.firmness);
        if (!(by > 1)) continue;
        make_firmer(touch, by, firming);
        changed = true;
    }
    return changed;
}

const Grip* find_grip(const std::vector<Grip>& grips, std::uint32_t point, std::uint32_t other)
{
    Grip wanted;
    wanted.point = point, wanted.other = other;
    const auto at = std::lower_bound(grips.begin(), grips.end(), wanted, in_order<Grip, Grip>);
    return at == grips.end() || in_order(wanted, *at) ? nullptr : &*at;
}

double deepest_of(const std::vector<Grip>& grips)
{
    float deepest = 0;
    for (const Grip& grip : grips) deepest = std::max(deepest, grip.depth);
    return double(deepest);
}

double slack_speed(double way)
{
    return std::sqrt(9.81 * way);
}

// How firm a touch is after a step that left it so deep, m.
static double firmness_after(const PlaneTouch& touch, double depth, const StepEnd& end)
{
    if (!(depth > 0)) return 1;
    if (!(depth > end.deep * touch.size)) return touch.firmness;
    return std::min(most_firmness, touch.firmness * std::exp(end.dt / firming_time));
}

// The slots of the corners that have most of it, and most of what it touches.
static std::array<std::uint32_t, 2> corners_beside(const PlaneTouch& touch)
{
    const auto end = touch.weight.begin() + touch.count;
    const auto [low, high] = std::minmax_element(touch.weight.begin(), end);
    const auto slot = [&](auto at) {
        return touch.corners[static_cast<std::size_t>(at - touch.weight.begin())];
    };
    return {slot(high), *low < 0 && touch.count > 8 ? slot(low) : Grip::no_corner};
}

std::vector<Grip> grips_of(const std::vector<PlaneTouch>& touches, const StepEnd& end)
{
    std::vector<Grip> out;
    for (const PlaneTouch& touch : touches) {
        const double gap = touch.gap(end.x1) - end.late * touch.drift.dot(touch.normal);
        if (!(gap < end.near)) continue;
        const Vec3 way =
            touch.stretch + between(touch, end.x1) - between(touch, end.x0) - end.dt * touch.drift;
        const double depth = std::max(0.0, -gap);
        const double pressed = std::max(0.0, depth - touch.slack);
        Vec3 stretch = pressed > 0 ? along(touch.normal, way) : Vec3(Vec3::Zero());
        const double most = touch.friction * pressed;
        if (stretch.norm() > most) stretch *= most / stretch.norm();
        if (!stretch.allFinite()) continue;
        Grip grip;
        grip.point = touch.point, grip.other = touch.other;
        grip.stretch = stretch.cast<float>();
        grip.normal = touch.normal.cast<float>();
        grip.depth = static_cast<float>(depth);
        grip.firmness = static_cast<float>(firmness_after(touch, depth, end));
        grip.slack = static_cast<float>(depth > 0 ? touch.slack : 0);
        grip.at_rest = static_cast<float>(touch.at_rest);
        grip.force = (touch.stiffness * (pressed * touch.normal - stretch)).cast<float>();
        grip.corners = corners_beside(touch);
        out.push_back(grip);
    }
    return out;
}

// The push and the friction that it had in a step of another length.
static void keep_push(PlaneTouch& touch, const Grip& grip)
{
    const auto now = static_cast<float>(touch.at_rest);
    if (!(now > 0 && grip.at_rest > 0) || now == grip.at_rest) return;
    const double by = double(now) / double(grip.at_rest);
    const double pressed = std::max(0.0, touch.began - touch.slack) / by;
    touch.slack = std::max(0.0, touch.began - pressed);
    touch.stretch /= by;
}

double slack_left(double slack, double size, SlackTime time)
{
    // Above 0.1 m it would go faster than slack_speed. Sheets may be much thinner than a cell.
    const double most = 9.81 * slack_time * slack_time;
    const double little = time.solid ? std::min(0.05 * size, most) : most;
    // At slack_speed(slack) all along, its root falls evenly.
    const double rate = 0.5 * slack_speed(1);
    const double until = std::max(0.0, std::sqrt(slack) - std::sqrt(little)) / rate;  // s
    if (time.dt < until) return std::pow(std::sqrt(slack) - time.dt * rate, 2);
    return std::min(slack, little) * std::exp((until - time.dt) / slack_time);
}

void take_grips(std::vector<PlaneTouch>& touches, const std::vector<Grip>& grips, SlackTime time)
{
    auto grip = grips.begin();
    for (PlaneTouch& touch : touches) {
        while (grip != grips.end() && in_order(*grip, touch)) ++grip;
        const bool known = grip != grips.end() && !in_order(touch, *grip);
        touch.firmness = known ? double(grip->firmness) : 1;
        touch.stiffness *= touch.firmness;
        touch.began = known ? double(grip->depth) : 0;
        touch.slack = known ? double(grip->slack) : 0;
        touch.stretch = known ? along(touch.normal, grip->stretch.cast<double>()) : Vec3::Zero();
        if (!known) continue;
        keep_push(touch, *grip);
        touch.slack = slack_left(touch.slack, touch.size, time);
    }
}

bool add_found(std::vector<PlaneTouch>& touches, const std::vector<PlaneTouch>& found,
               const double* x, double much)
{
    std::vector<const PlaneTouch*> fresh;
    bool pushes = false;
    auto old = touches.begin();
    for (const PlaneTouch& touch : found) {
        old = std::lower_bound(old, touches.end(), touch, in_order<PlaneTouch, PlaneTouch>);
        if (old != touches.end() && !in_order(touch, *old)) continue;
        fresh.push_back(&touch);
        pushes |= touch.gap(x) < -much;
    }
    // From the end, so that each moves once.
    std::size_t from = touches.size();
    touches.resize(from + fresh.size());
    for (std::size_t to = touches.size(); !fresh.empty();) {
        if (from > 0 && in_order(*fresh.back(), touches[from - 1])) {
            touches[--to] = touches[--from];
        } else {
            touches[--to] = *fresh.back();
            fresh.pop_back();
        }
    }
    return pushes;
}

bool renew(std::vector<PlaneTouch>& touches, const std::vector<PlaneTouch>& found, const double* x,
           double much)
{
    std::vector<PlaneTouch> out;
    bool changed = false;
    auto old = touches.begin();
    const auto leave = [&] {
        const bool pressed = old->gap(x) < -much;
        if (!pressed) out.push_back(*old);
        changed |= pressed;
        ++old;
    };
    for (const PlaneTouch& touch : found) {
        while (old != touches.end() && in_order(*old, touch)) leave();
        if (old == touches.end() || in_order(touch, *old)) {
            out.push_back(touch);
            changed |= touch.gap(x) < -much;
            continue;
        }
        const double before = old->gap(x), now = touch.gap(x);
        const bool other = std::abs(now - before) > much;
        out.push_back(other ? touch : *old);
        // A plane that was found at a higher speed is stiffer, to stop that; what has become firm
        // stays so.
        const double firmness = std::max(old->firmness, touch.firmness);
        out.back().stiffness =
            firmness * std::max(old->stiffness / old->firmness, touch.stiffness / touch.firmness);
        out.back().firmness = firmness;
        out.back().at_rest = std::max(old->at_rest, touch.at_rest);
        out.back().slack = std::max(old->slack, touch.slack);
        changed |= other && std::min(now, before) < -much;
        ++old;
    }
    while (old != touches.end()) leave();
    touches.swap(out);
    return changed;
}

}  // namespace physics
