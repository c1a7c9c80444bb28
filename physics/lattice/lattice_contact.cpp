#include "physics/lattice/lattice_contact.hpp"

// In this order: what one push wants (change_of); points of the skin (place_of, for_places,
// for_bare) and colliders (find_skin_pushes); rigid balls (find_ball_pushes); and all of them
// solved (solve_pushes).

#include "geometry/base/parallel.hpp"
#include "physics/lattice/ball_faces.hpp"
#include "physics/math/joined.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {

namespace {

// The impulse that `push` wants added, when its point moves at v seen from the surface.
Vec3 change_of(Push& push, const Vec3& v)
{
    const double along = v.dot(push.normal), before = push.impulse;
    push.impulse = std::max(0.0, before - (along + push.bias) * push.mass);
    if (push.impulse == 0 && before == 0) return Vec3::Zero();
    Vec3 drag = push.drag - push.mass_across * (v - along * push.normal);
    // Without a branch: whether it slides is hard to foresee.
    const double most = push.friction * push.impulse, size = drag.norm();
    drag *= most / std::max({most, size, std::numeric_limits<double>::min()});
    const Vec3 change = (push.impulse - before) * push.normal + (drag - push.drag);
    push.drag = drag;
    return change;
}

// Where a point of the skin is, how fast, and whom a push there moves.
struct SkinPlace {
    std::array<double, 8> weight;
    Vec3 at = Vec3::Zero(), v = Vec3::Zero();  // m, m/s
    double inverse = 0;                        // 1/kg
    double out = usual_way_out;                // share of its depth that it comes out by in a step
    double thinner = 0;                        // m, ContactSurface::thinner_by()
    std::uint32_t point = none;                // of the skin
};

SkinPlace place_at(const ContactScene& scene, const CornerRuns::Corners& corners,
                   const std::array<double, 8>& weight)
{
    SkinPlace out{weight};
    for (std::size_t a = 0; a < 8; ++a) {
        out.at += weight[a] * scene.state.x[corners[a]];
        out.v += weight[a] * scene.state.v[corners[a]];
        out.inverse += weight[a] * weight[a] * scene.inverse_mass[corners[a]];
    }
    return out;
}

SkinPlace place_of(const ContactScene& scene, const CornerRuns::Corners& corners, std::uint32_t i)
{
    std::array<double, 8> weight;
    std::ranges::copy(scene.body.skin.point[i], weight.begin());
    return place_at(scene, corners, weight);
}

// Of a cube in parts: it goes with the corners of the part whose octant holds it, from each of
// those as far as the links there point.
SkinPlace place_of(const ContactScene& scene, const CornerRuns::Corners& corners, std::uint32_t i,
                   const TornSkin::Parts& parts)
{
    const auto& given = scene.body.skin.point[i];
    const auto bits = [](std::size_t a) {
        return Vec3(double(a & 1), double(a >> 1 & 1), double(a >> 2 & 1));
    };
    Vec3 local = Vec3::Zero();  // 0 .. 1
    for (std::size_t a = 0; a < 8; ++a) local += double(given[a]) * bits(a);
    double total = 0;
    const std::uint8_t part = part_of(given, parts);
    for (std::size_t a = 0; a < 8; ++a) {
        if (parts[a] == part) total += double(given[a]);
    }
    SkinPlace out;
    for (std::size_t a = 0; a < 8; ++a) {
        out.weight[a] = parts[a] == part ? double(given[a]) / total : 0;
        if (out.weight[a] == 0) continue;
        const std::uint32_t k = corners[a];
        out.at += out.weight[a] * (scene.state.x[k] +
                                   scene.torn->frames().at(k, scene.state.x) * (local - bits(a)));
        out.v += out.weight[a] * scene.state.v[k];
        out.inverse += out.weight[a] * out.weight[a] * scene.inverse_mass[k];
    }
    return out;
}

// A shot may begin with the middle of a sheet on a collider, half of its thickness inside: it comes
// out slowly, and not at all beside pins, where little of the point could be moved and would fly.
double share_out(const ContactScene& scene, const CornerRuns::Corners& corners,
                 const SkinPlace& place)
{
    constexpr double slowly = 0.05;  // s
    if (scene.body.skin.half_thickness.empty()) return usual_way_out;
    for (std::size_t a = 0; a < 8; ++a) {
        if (place.weight[a] != 0 && scene.inverse_mass[corners[a]] == 0) return 0;
    }
    return std::min(usual_way_out, scene.dt / slowly);
}

// Calls touch(place) with the points of cube c of the skin that lie open. What a tear laid open may
// have been deep in a collider before: driven out, it would fly off.
template <class Touch>
void for_places(const ContactScene& scene, std::size_t c, const CornerRuns::Corners& corners,
                const Touch& touch)
{
    const SurfacePatch& patch = scene.body.skin.on(c);
    const bool open = scene.torn && scene.torn->is_open(c);
    const TornSkin::Parts* const parts = open ? scene.torn->parts_of(c) : nullptr;
    for (std::uint32_t i = patch.point; i < (open ? patch.points_end : patch.within); ++i) {
        SkinPlace place = parts ? place_of(scene, corners, i, *parts) : place_of(scene, corners, i);
        place.out = i >= patch.within ? 0 : share_out(scene, corners, place);
        place.thinner = scene.body.skin.thinner_by(c);
        place.point = scene.body.skin.first_point[c] + (i - patch.point);
        touch(place);
    }
}

// The same with the corners that a tear leaves bare.
template <class Touch> void for_bare(const ContactScene& scene, const Touch& touch)
{
    if (!scene.torn) return;
    for (const std::uint32_t k : scene.torn->bare()) {
        CornerRuns::Corners corners;
        corners.fill(k);
        touch(corners,
              SkinPlace{{1}, scene.state.x[k], scene.state.v[k], scene.inverse_mass[k], 0});
    }
}

// Whether all of that lies within `corners`, as far out as the patch reaches; what is torn may not.
bool is_bounded(const ContactScene& scene, std::size_t c)
{
    return !scene.torn || !scene.torn->parts_of(c);
}

// A push, where that place comes to lie in the collider.
void push_out(const ContactScene& scene, const std::vector<PosedCollider>& colliders,
              std::uint32_t collider, const CornerRuns::Corners& corners, const SkinPlace& place,
              std::vector<SkinPush>& out)
{
    const Grip* const held = find_grip(scene.state.holds, place.point, collider);
    Touch t = touch(colliders[collider], place.at + scene.dt * place.v, place.v, scene.dt, held);
    t.gap += place.thinner;
    // Points before a sheet are to stay on their side of it, wherever others push them.
    const double near = crease_of(colliders[collider]);
    if (!(t.gap < near) || !(place.inverse > 0)) return;
    SkinPush push;
    push.near = near;
    push.corners = corners;
    push.weight = place.weight;
    push.mass = push.mass_across = 1 / place.inverse;
    push.normal = t.normal;
    push.surface_velocity = t.velocity;
    push.bias = bias_of(t.gap, (place.v - t.velocity).dot(t.normal), scene.dt, place.out);
    push.friction = colliders[collider].friction;
    push.point = place.point;
    push.collider = collider;
    push.gap = t.gap;
    push.velocity = place.v;
    out.push_back(push);
}

// What cube c of the skin, of these corners, has in the colliders. No point is held deeper in one
// than `deepest`.
void look(const ContactScene& scene, const std::vector<PosedCollider>& colliders, double deepest,
          std::size_t c, const CornerRuns::Corners& corners, std::vector<SkinPush>& out)
{
    const ContactSurface& skin = scene.body.skin;
    const std::vector<Vec3>& x = scene.state.x;
    const std::vector<Vec3>& speed = scene.state.v;
    const double dt = scene.dt;
    const SurfacePatch& patch = skin.on(c);
    if (patch.point == patch.within && !(scene.torn && scene.torn->is_open(c))) return;
    const auto next = [&](std::uint32_t i) -> Vec3 { return x[i] + dt * speed[i]; };
    Vec3 centre = Vec3::Zero();
    for (const auto k : corners) centre += next(k) / 8;
    double radius = 0;
    for (const auto k : corners) radius = std::max(radius, (next(k) - centre).norm());
    double fastest = 0;
    for (const auto k : corners) fastest = std::max(fastest, speed[k].norm());
    for (std::uint32_t i = 0; i < colliders.size(); ++i) {
        // Points may lie outside their cube.
        if (is_bounded(scene, c) &&
            !may_touch(colliders[i], centre, double(patch.reach) * radius + deepest, fastest, dt)) {
            continue;
        }
        for_places(scene, c, corners, [&](const SkinPlace& place) {
            push_out(scene, colliders, i, corners, place, out);
        });
    }
}

}  // namespace

std::vector<SkinPush> find_skin_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders)
{
    if (colliders.empty()) return {};
    const ContactSurface& skin = scene.body.skin;
    constexpr std::size_t piece = 256;
    const double deepest = deepest_of(scene.state.holds);
    std::vector<std::vector<SkinPush>> found((skin.corners.size() + piece - 1) / piece);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const std::size_t last = std::min(skin.corners.size(), (g + 1) * piece);
            skin.corners.for_each(g * piece, last, [&](std::size_t c, const auto& corners) {
                look(scene, colliders, deepest, c, corners, found[g]);
            });
        }
    });
    found.emplace_back();
    for_bare(scene, [&](const CornerRuns::Corners& corners, const SkinPlace& place) {
        for (std::uint32_t i = 0; i < colliders.size(); ++i) {
            push_out(scene, colliders, i, corners, place, found.back());
        }
    });
    return joined(found);
}

namespace {

// A solid ball's 1/m and, for impulses at its surface across the normal, 1/m + r^2 / I.
double across(const Ball& ball)
{
    return 3.5 / ball.mass;
}

// A push at a place of the skin.
BallPush push_at(const ContactScene& scene, std::uint32_t b, const CornerRuns::Corners& corners,
                 const SkinPlace& place, const Vec3& normal, double gap)
{
    const Ball& ball = scene.balls[b];
    BallPush push;
    push.ball = b;
    push.corners = corners;
    push.weight = place.weight;
    push.normal = normal;
    push.mass_across = 1 / (place.inverse + across(ball));
    push.mass = 1 / (place.inverse + 1 / ball.mass);
    push.arm = -ball.radius * normal;
    push.friction = ball.friction;
    const double speed = (scene.state.balls[b].v - place.v).dot(normal);
    push.bias = bias_of(gap, speed, scene.dt, place.out);
    return push;
}

void touch_skin(const ContactScene& scene, std::uint32_t b, std::vector<BallPush>& out)
{
    const Ball& ball = scene.balls[b];
    const ContactSurface& skin = scene.body.skin;
    const double dt = scene.dt;
    const Vec3 centre = scene.state.balls[b].x + dt * scene.state.balls[b].v;
    const auto push_out = [&](const CornerRuns::Corners& corners, const SkinPlace& place) {
        const Vec3 apart = centre - (place.at + dt * place.v);
        const double length = apart.norm();
        const double touching = ball.radius + skin.thickest - place.thinner;
        if (!(length < touching)) return;
        const Vec3 normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
        out.push_back(push_at(scene, b, corners, place, normal, length - touching));
    };
    const bool by_points = touches_points(scene, ball);
    skin.corners.for_each(0, skin.corners.size(), [&](std::size_t c, const auto& corners) {
        if (!by_points && !(scene.torn && scene.torn->is_open(c))) return;
        const SurfacePatch& patch = skin.on(c);
        const Vec3 some = scene.state.x[corners[0]] + dt * scene.state.v[corners[0]];
        double size_sq = 0;  // of the cube, from that corner
        for (const auto k : corners) {
            size_sq =
                std::max(size_sq, (scene.state.x[k] + dt * scene.state.v[k] - some).squaredNorm());
        }
        const double reach =
            ball.radius + skin.thickest + 2 * double(patch.reach) * std::sqrt(size_sq);
        if (is_bounded(scene, c) && (some - centre).squaredNorm() > reach * reach) return;
        for_places(scene, c, corners, [&](const SkinPlace& place) { push_out(corners, place); });
    });
    for_bare(scene, push_out);
    if (!touches_faces(scene, ball)) return;
    for (const FaceTouch& touch : find_face_touches(scene, b)) {
        SkinPlace place = place_at(scene, touch.corners, touch.weight);
        place.out = share_out(scene, touch.corners, place);
        out.push_back(push_at(scene, b, touch.corners, place, touch.normal, touch.gap));
    }
}

void touch_colliders(const ContactScene& scene, std::uint32_t b,
                     const std::vector<PosedCollider>& colliders, std::vector<BallPush>& out)
{
    const Ball& ball = scene.balls[b];
    const BallState& at = scene.state.balls[b];
    for (const PosedCollider& collider : colliders) {
        Touch t = touch(collider, at.x + scene.dt * at.v, at.v, scene.dt);
        t.gap += scene.body.skin.thickest;  // the collider stands off for the sheet
        if (!(t.gap < ball.radius)) continue;
        BallPush push;
        push.ball = b;
        push.corners.fill(0);
        push.normal = t.normal;
        push.surface_velocity = t.velocity;
        push.mass = ball.mass;
        push.mass_across = 1 / across(ball);
        push.arm = -ball.radius * t.normal;
        push.friction = collider.friction;
        push.bias = bias_of(t.gap - ball.radius, (at.v - t.velocity).dot(t.normal), scene.dt);
        out.push_back(push);
    }
}

void touch_balls(const ContactScene& scene, std::uint32_t b, std::vector<BallPush>& out)
{
    for (std::uint32_t o = 0; o < b; ++o) {
        const Ball &ball = scene.balls[b], &other = scene.balls[o];
        const BallState &at = scene.state.balls[b], &from = scene.state.balls[o];
        const Vec3 apart = at.x - from.x + scene.dt * (at.v - from.v);
        const double length = apart.norm(), sum = ball.radius + other.radius;
        if (!(length < sum)) continue;
        BallPush push;
        push.ball = b;
        push.other = o;
        push.corners.fill(0);
        push.normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
        push.mass = 1 / (1 / ball.mass + 1 / other.mass);
        push.mass_across = 1 / (across(ball) + across(other));
        push.arm = -ball.radius * push.normal;
        push.other_arm = other.radius * push.normal;
        push.friction = std::sqrt(ball.friction * other.friction);
        push.bias = bias_of(length - sum, (at.v - from.v).dot(push.normal), scene.dt);
        out.push_back(push);
    }
}

// Velocity of the ball's surface where it touches.
Vec3 at_surface(const BallState& ball, const Vec3& arm)
{
    return ball.v + ball.spin.cross(arm);
}

void kick(BallState& state, const Ball& ball, const Vec3& arm, const Vec3& impulse)
{
    state.v += impulse / ball.mass;
    state.spin += arm.cross(impulse) / (0.4 * ball.mass * ball.radius * ball.radius);
}

}  // namespace

std::vector<BallPush> find_ball_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders)
{
    std::vector<BallPush> out;
    for (std::uint32_t b = 0; b < scene.balls.size(); ++b) {
        touch_skin(scene, b, out);
        touch_colliders(scene, b, colliders, out);
        touch_balls(scene, b, out);
    }
    return out;
}

void solve_pushes(const ContactScene& scene, Pushes& pushes, int rounds, std::vector<Vec3>& v,
                  std::vector<BallState>& balls)
{
    const auto at = [&](const auto& p) {
        Vec3 sum = Vec3::Zero();
        for (std::size_t a = 0; a < 8; ++a) sum += p.weight[a] * v[p.corners[a]];
        return sum;
    };
    const auto add = [&](const auto& p, const Vec3& impulse) {
        for (std::size_t a = 0; a < 8; ++a) {
            v[p.corners[a]] += p.weight[a] * scene.inverse_mass[p.corners[a]] * impulse;
        }
    };
    PairPushes& pairs = pushes.pairs;
    const auto solve_bunches = [&](std::size_t begin, std::size_t end) {
        const std::uint32_t first = pairs.bunch_at[begin], last = pairs.bunch_at[end];
        solve_rows({pairs.row.data() + first, last - first}, pairs.friction, scene.inverse_mass, v);
    };
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t c = 0; c < pairs.colours(); ++c) {
            const std::size_t first = pairs.colour_at[c], last = pairs.colour_at[c + 1];
            const bool alone = pairs.last_alone && c + 1 == pairs.colours();
            geometry::parallel_for(last - first, alone ? last - first : 1,
                                   [&](std::size_t begin, std::size_t end) {
                                       solve_bunches(first + begin, first + end);
                                   });
        }
        for (BallPush& p : pushes.balls) {
            Vec3 relative = at_surface(balls[p.ball], p.arm) - at(p) - p.surface_velocity;
            if (p.other != none) relative -= at_surface(balls[p.other], p.other_arm);
            const Vec3 change = change_of(p, relative);
            kick(balls[p.ball], scene.balls[p.ball], p.arm, change);
            if (p.other != none) {
                kick(balls[p.other], scene.balls[p.other], p.other_arm, -change);
            }
            add(p, -change);
        }
        for (SkinPush& p : pushes.skin) add(p, change_of(p, Vec3(at(p) - p.surface_velocity)));
    }
}

std::vector<Grip> holds_of(const std::vector<SkinPush>& pushes, const std::vector<Vec3>& v,
                           double dt)
{
    std::vector<Grip> out;
    for (const SkinPush& push : pushes) {
        Vec3 change = -push.velocity;
        for (std::size_t a = 0; a < 8; ++a) change += push.weight[a] * v[push.corners[a]];
        const double gap = push.gap + dt * change.dot(push.normal);
        // What is pushed ends on the surface: by rounding, on either side of it.
        if (!(gap < push.near || push.impulse > 0) || push.point == none) continue;
        out.push_back({push.point, push.collider, Eigen::Vector3f::Zero(),
                       push.normal.cast<float>(), static_cast<float>(std::max(0.0, -gap))});
    }
    std::sort(out.begin(), out.end(), in_order<Grip, Grip>);
    return out;
}

}  // namespace physics
