#include "physics/lattice_contact.hpp"

#include "geometry/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace physics {

namespace {

// The impulse that `push` wants added, when its point moves at v.
Vec3 change_of(Push& push, Vec3 v, double dt)
{
    const double ahead = push.gap + dt * (v.dot(push.normal) - push.approach);
    const double before = push.impulse;
    push.impulse = std::max(0.0, before - ahead / (dt * push.inverse));
    Vec3 change = (push.impulse - before) * push.normal;
    v += push.inverse * change;
    const Vec3 slip = v - push.surface_velocity;
    const Vec3 wanted =
        push.drag - (slip - slip.dot(push.normal) * push.normal) / push.inverse_across;
    const double most = push.friction * push.impulse, size = wanted.norm();
    const Vec3 drag = size > most ? Vec3(most / size * wanted) : wanted;
    change += drag - push.drag;
    push.drag = drag;
    return change;
}

// What was inside already comes out by a fifth a step, not with a jump.
double softened(double gap, double closing, double dt)
{
    const double inside = gap - dt * closing;
    return gap - 0.8 * std::min(0.0, inside);
}

void look(const ContactScene& scene, const std::vector<PosedCollider>& colliders, std::size_t c,
          std::vector<SkinPush>& out)
{
    const Skin& skin = scene.body.skin;
    const std::vector<Vec3>& x = scene.state.x;
    const std::vector<Vec3>& speed = scene.state.v;
    const double dt = scene.dt;
    const auto& corners = skin.corners[c];
    const auto next = [&](std::uint32_t i) -> Vec3 { return x[i] + dt * speed[i]; };
    Vec3 centre = Vec3::Zero();
    for (const auto k : corners) centre += next(k) / 8;
    double radius = 0;
    for (const auto k : corners) radius = std::max(radius, (next(k) - centre).norm());
    for (const PosedCollider& collider : colliders) {
        // Points may lie outside their cube; a distance changes no faster than a place.
        const bool mesh = collider.kind == Collider::Kind::mesh;
        if (!mesh && touch(collider, centre).gap > double(skin.reach[c]) * radius) continue;
        for (std::uint32_t i = skin.point_at[c]; i < skin.point_at[c + 1]; ++i) {
            SkinPush push{};
            push.corners = corners;
            Vec3 now = Vec3::Zero(), v = now;
            for (std::size_t a = 0; a < 8; ++a) {
                const double weight = push.weight[a] = double(skin.point[i][a]);
                now += weight * x[corners[a]];
                v += weight * speed[corners[a]];
                push.inverse += weight * weight * scene.inverse_mass(corners[a]);
            }
            const Touch t = touch(collider, now + dt * v);
            if (!(t.gap < 0) || !(push.inverse > 0)) continue;
            push.inverse_across = push.inverse;
            push.normal = t.normal;
            push.surface_velocity = t.velocity;
            push.approach = v.dot(t.normal);
            push.friction = collider.friction;
            push.gap = softened(t.gap, push.approach - t.velocity.dot(t.normal), dt);
            out.push_back(push);
        }
    }
}

// Places sorted into cells of a hashed grid: those of bucket k are order[at[k] .. at[k + 1]].
struct Buckets {
    std::vector<std::uint32_t> at, order;
    std::uint32_t mask = 0;

    static std::uint32_t hash(const Eigen::Array3i& cell)
    {
        return std::uint32_t(cell[0]) * 73856093u ^ std::uint32_t(cell[1]) * 19349663u ^
               std::uint32_t(cell[2]) * 83492791u;
    }
};

Buckets sort_into_buckets(const std::vector<Eigen::Array3i>& cells)
{
    Buckets out;
    std::uint32_t size = 16;
    while (size < cells.size()) size *= 2;
    out.mask = size - 1;
    out.at.assign(size + 1, 0);
    for (const auto& cell : cells) ++out.at[(Buckets::hash(cell) & out.mask) + 1];
    for (std::uint32_t k = 0; k < size; ++k) out.at[k + 1] += out.at[k];
    out.order.resize(cells.size());
    std::vector<std::uint32_t> next(out.at.begin(), out.at.end() - 1);
    for (std::uint32_t i = 0; i < cells.size(); ++i) {
        out.order[next[Buckets::hash(cells[i]) & out.mask]++] = i;
    }
    return out;
}

template <class Found> std::vector<Found> joined(const std::vector<std::vector<Found>>& parts)
{
    std::vector<Found> all;
    for (const auto& some : parts) all.insert(all.end(), some.begin(), some.end());
    return all;
}

}  // namespace

std::vector<SkinPush> find_skin_pushes(const ContactScene& scene,
                                       const std::vector<PosedCollider>& colliders)
{
    if (colliders.empty()) return {};
    const Skin& skin = scene.body.skin;
    constexpr std::size_t piece = 256;
    std::vector<std::vector<SkinPush>> found((skin.corners.size() + piece - 1) / piece);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const std::size_t last = std::min(skin.corners.size(), (g + 1) * piece);
            for (std::size_t c = g * piece; c < last; ++c) look(scene, colliders, c, found[g]);
        }
    });
    return joined(found);
}

std::vector<PairPush> find_pair_pushes(const ContactScene& scene,
                                       const std::vector<std::uint32_t>& side,
                                       const std::vector<std::uint32_t>& piece, double distance,
                                       double friction)
{
    const double dt = scene.dt;
    constexpr std::size_t grain = 1024;
    std::vector<Vec3> next(side.size());
    std::vector<Eigen::Array3i> cells(side.size());
    geometry::parallel_for(side.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            next[i] = scene.state.x[side[i]] + dt * scene.state.v[side[i]];
            const Eigen::Array3d cell = (next[i] / distance).array().floor();
            cells[i] = cell.max(-1e9).min(1e9).cast<int>();
        }
    });
    const Buckets buckets = sort_into_buckets(cells);
    std::vector<std::vector<PairPush>> found((side.size() + grain - 1) / grain);
    const auto look_at = [&](std::uint32_t i, std::vector<PairPush>& out) {
        for (int z = -1; z <= 1; ++z) {
            for (int y = -1; y <= 1; ++y) {
                for (int x = -1; x <= 1; ++x) {
                    const Eigen::Array3i cell = cells[i] + Eigen::Array3i(x, y, z);
                    const std::uint32_t k = Buckets::hash(cell) & buckets.mask;
                    for (std::uint32_t at = buckets.at[k]; at < buckets.at[k + 1]; ++at) {
                        const std::uint32_t j = buckets.order[at];
                        if (j <= i || piece[side[i]] == piece[side[j]]) continue;
                        const Vec3 apart = next[i] - next[j];
                        const double apart_sq = apart.squaredNorm();
                        if (!(apart_sq < distance * distance)) continue;
                        // Two cells may share a bucket: each pair counts in its own cell.
                        if ((cells[j] != cell).any()) continue;
                        PairPush push;
                        push.a = side[i];
                        push.b = side[j];
                        push.inverse_a = scene.inverse_mass(push.a);
                        push.inverse_b = scene.inverse_mass(push.b);
                        push.inverse = push.inverse_a + push.inverse_b;
                        if (!(push.inverse > 0)) continue;
                        push.inverse_across = push.inverse;
                        const double length = std::sqrt(apart_sq);
                        push.normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
                        push.approach =
                            (scene.state.v[push.a] - scene.state.v[push.b]).dot(push.normal);
                        push.friction = friction;
                        push.gap = softened(length - distance, push.approach, dt);
                        out.push_back(push);
                    }
                }
            }
        }
    };
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const std::size_t last = std::min(side.size(), (g + 1) * grain);
            for (std::size_t i = g * grain; i < last; ++i) look_at(std::uint32_t(i), found[g]);
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

void touch_skin(const ContactScene& scene, std::uint32_t b, std::vector<BallPush>& out)
{
    const Ball& ball = scene.balls[b];
    const BallState& at = scene.state.balls[b];
    const Skin& skin = scene.body.skin;
    const double dt = scene.dt;
    const Vec3 centre = at.x + dt * at.v;
    for (std::size_t c = 0; c < skin.corners.size(); ++c) {
        const auto& corners = skin.corners[c];
        const Vec3 some = scene.state.x[corners[0]] + dt * scene.state.v[corners[0]];
        double size_sq = 0;  // of the cube, from that corner
        for (const auto k : corners) {
            size_sq =
                std::max(size_sq, (scene.state.x[k] + dt * scene.state.v[k] - some).squaredNorm());
        }
        const double reach = ball.radius + 2 * double(skin.reach[c]) * std::sqrt(size_sq);
        if ((some - centre).squaredNorm() > reach * reach) continue;
        for (std::uint32_t i = skin.point_at[c]; i < skin.point_at[c + 1]; ++i) {
            BallPush push;
            push.ball = b;
            push.corners = corners;
            Vec3 now = Vec3::Zero(), v = now;
            for (std::size_t a = 0; a < 8; ++a) {
                const double weight = push.weight[a] = double(skin.point[i][a]);
                now += weight * scene.state.x[corners[a]];
                v += weight * scene.state.v[corners[a]];
                push.inverse += weight * weight * scene.inverse_mass(corners[a]);
            }
            const Vec3 apart = centre - (now + dt * v);
            const double length = apart.norm();
            if (!(length < ball.radius)) continue;
            push.normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
            push.inverse_across = push.inverse + across(ball);
            push.inverse += 1 / ball.mass;
            push.arm = -ball.radius * push.normal;
            push.approach = (at.v - v).dot(push.normal);
            push.friction = ball.friction;
            push.gap = softened(length - ball.radius, push.approach, dt);
            out.push_back(push);
        }
    }
}

void touch_colliders(const ContactScene& scene, std::uint32_t b,
                     const std::vector<PosedCollider>& colliders, std::vector<BallPush>& out)
{
    const Ball& ball = scene.balls[b];
    const BallState& at = scene.state.balls[b];
    for (const PosedCollider& collider : colliders) {
        const Touch t = touch(collider, at.x + scene.dt * at.v);
        if (!(t.gap < ball.radius)) continue;
        BallPush push;
        push.ball = b;
        push.corners.fill(0);
        push.normal = t.normal;
        push.surface_velocity = t.velocity;
        push.inverse = 1 / ball.mass;
        push.inverse_across = across(ball);
        push.arm = -ball.radius * t.normal;
        push.approach = at.v.dot(t.normal);
        push.friction = collider.friction;
        push.gap =
            softened(t.gap - ball.radius, push.approach - t.velocity.dot(t.normal), scene.dt);
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
        push.inverse = 1 / ball.mass + 1 / other.mass;
        push.inverse_across = across(ball) + across(other);
        push.arm = -ball.radius * push.normal;
        push.other_arm = other.radius * push.normal;
        push.approach = (at.v - from.v).dot(push.normal);
        push.friction = std::sqrt(ball.friction * other.friction);
        push.gap = softened(length - sum, push.approach, scene.dt);
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
            v[p.corners[a]] += p.weight[a] * scene.inverse_mass(p.corners[a]) * impulse;
        }
    };
    for (int round = 0; round < rounds; ++round) {
        for (PairPush& p : pushes.pairs) {
            const Vec3 change = change_of(p, v[p.a] - v[p.b], scene.dt);
            v[p.a] += p.inverse_a * change;
            v[p.b] -= p.inverse_b * change;
        }
        for (BallPush& p : pushes.balls) {
            Vec3 relative = at_surface(balls[p.ball], p.arm) - at(p);
            if (p.other != none) relative -= at_surface(balls[p.other], p.other_arm);
            const Vec3 change = change_of(p, relative, scene.dt);
            kick(balls[p.ball], scene.balls[p.ball], p.arm, change);
            if (p.other != none) {
                kick(balls[p.other], scene.balls[p.other], p.other_arm, -change);
            }
            add(p, -change);
        }
        for (SkinPush& p : pushes.skin) add(p, change_of(p, at(p), scene.dt));
    }
}

}  // namespace physics
