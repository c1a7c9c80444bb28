#include "physics/lattice_contact.hpp"

#include "geometry/parallel.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace physics {

namespace {

// The impulse that `push` wants added, when its point moves at v seen from the surface.
template <class T> Eigen::Matrix<T, 3, 1> change_of(Push<T>& push, const Eigen::Matrix<T, 3, 1>& v)
{
    using Vec = Eigen::Matrix<T, 3, 1>;
    const T along = v.dot(push.normal), before = push.impulse;
    push.impulse = std::max(T(0), before - (along + push.bias) * push.mass);
    if (push.impulse == 0 && before == 0) return Vec::Zero();
    Vec drag = push.drag - push.mass_across * (v - along * push.normal);
    const T most = push.friction * push.impulse, size_sq = drag.squaredNorm();
    if (size_sq > most * most) drag *= most / std::sqrt(size_sq);
    const Vec change = (push.impulse - before) * push.normal + (drag - push.drag);
    push.drag = drag;
    return change;
}

// Push::bias of a gap that is expected when the point goes on at `speed` along the normal. What was
// inside already comes out by a fifth a step, not with a jump.
double bias_of(double gap, double speed, double dt)
{
    const double inside = gap - dt * speed;
    return (gap - 0.8 * std::min(0.0, inside)) / dt - speed;
}

// What cube c of the skin, of these corners, has in the colliders.
void look(const ContactScene& scene, const std::vector<PosedCollider>& colliders, std::size_t c,
          const CornerRuns::Corners& corners, std::vector<SkinPush>& out)
{
    const Skin& skin = scene.body.skin;
    const std::vector<Vec3>& x = scene.state.x;
    const std::vector<Vec3>& speed = scene.state.v;
    const double dt = scene.dt;
    const SkinPatch& patch = skin.on(c);
    const auto next = [&](std::uint32_t i) -> Vec3 { return x[i] + dt * speed[i]; };
    Vec3 centre = Vec3::Zero();
    for (const auto k : corners) centre += next(k) / 8;
    double radius = 0;
    for (const auto k : corners) radius = std::max(radius, (next(k) - centre).norm());
    for (const PosedCollider& collider : colliders) {
        // Points may lie outside their cube; a distance changes no faster than a place.
        const bool mesh = collider.kind == Collider::Kind::mesh;
        if (!mesh && touch(collider, centre).gap > double(patch.reach) * radius) continue;
        for (std::uint32_t i = patch.point; i < patch.points_end; ++i) {
            SkinPush push;
            push.corners = corners;
            Vec3 now = Vec3::Zero(), v = now;
            double inverse = 0;
            for (std::size_t a = 0; a < 8; ++a) {
                const double weight = push.weight[a] = double(skin.point[i][a]);
                now += weight * x[corners[a]];
                v += weight * speed[corners[a]];
                inverse += weight * weight * scene.inverse_mass[corners[a]];
            }
            const Touch t = touch(collider, now + dt * v);
            if (!(t.gap < 0) || !(inverse > 0)) continue;
            push.mass = push.mass_across = 1 / inverse;
            push.normal = t.normal;
            push.surface_velocity = t.velocity;
            push.bias = bias_of(t.gap, (v - t.velocity).dot(t.normal), dt);
            push.friction = collider.friction;
            out.push_back(push);
        }
    }
}

// Places in a grid of cells as wide as contact reaches, a row of cells along x after the other.
// Rows are found by a hash; one bucket may hold several.
struct Entry {
    Eigen::Array3i cell;
    std::uint32_t particle, piece;
    Vec3 next;  // m, where it will be
};
struct Rows {
    std::vector<Entry> entries;
    std::vector<std::uint32_t> at;  // buckets + 1, into entries

    std::uint32_t bucket(int y, int z) const
    {
        const std::uint32_t h = std::uint32_t(y) * 0x9e3779b1u ^ std::uint32_t(z) * 0x85ebca77u;
        return (h ^ h >> 15) & std::uint32_t(at.size() - 2);
    }
};

bool in_front(const Eigen::Array3i& a, const Eigen::Array3i& b)
{
    return a[2] != b[2] ? a[2] < b[2] : a[1] != b[1] ? a[1] < b[1] : a[0] < b[0];
}

Rows sort_into_rows(const std::vector<Entry>& places)
{
    Rows rows;
    std::size_t buckets = 16;
    while (buckets < places.size() / 4) buckets *= 2;
    rows.at.assign(buckets + 1, 0);
    std::vector<std::uint32_t> bucket(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        bucket[i] = rows.bucket(places[i].cell[1], places[i].cell[2]);
        ++rows.at[bucket[i] + 1];
    }
    for (std::size_t b = 0; b < buckets; ++b) rows.at[b + 1] += rows.at[b];
    rows.entries.resize(places.size());
    std::vector<std::uint32_t> next(rows.at.begin(), rows.at.end() - 1);
    for (std::size_t i = 0; i < places.size(); ++i) rows.entries[next[bucket[i]]++] = places[i];
    geometry::parallel_for(buckets, 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            std::sort(rows.entries.begin() + rows.at[b], rows.entries.begin() + rows.at[b + 1],
                      [](const Entry& p, const Entry& q) {
                          if (in_front(p.cell, q.cell)) return true;
                          return !in_front(q.cell, p.cell) && p.particle < q.particle;
                      });
        }
    });
    return rows;
}

// Calls with(mine, other) for every entry `mine` of [begin, end) and every other in the cells next
// to its own, each pair once: from its own row those behind it, and all of four of the eight rows
// around. Those are swept along with its own, so each row is looked up once.
template <class With>
void for_each_near(const Rows& rows, std::size_t begin, std::size_t end, const With& with)
{
    const auto same_row = [](const Entry& e, int y, int z) {
        return e.cell[1] == y && e.cell[2] == z;
    };
    const Entry* const all = rows.entries.data() + rows.entries.size();
    const Entry* const last = rows.entries.data() + end;
    for (const Entry* first = rows.entries.data() + begin; first < last;) {
        const int y = first->cell[1], z = first->cell[2];
        const Entry* stop = first;
        for (; stop < last && same_row(*stop, y, z); ++stop) {
            for (const Entry* e = stop + 1; e < all && same_row(*e, y, z); ++e) {
                if (e->cell[0] > stop->cell[0] + 1) break;
                with(*stop, *e);
            }
        }
        constexpr int around[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}};  // y, z
        for (const auto& [dy, dz] : around) {
            const Eigen::Array3i from(first->cell[0] - 1, y + dy, z + dz);
            const std::uint32_t b = rows.bucket(from[1], from[2]);
            const Entry* const high = rows.entries.data() + rows.at[b + 1];
            const Entry* low = std::lower_bound(
                rows.entries.data() + rows.at[b], high, from,
                [](const Entry& p, const Eigen::Array3i& cell) { return in_front(p.cell, cell); });
            const auto there = [&](const Entry* e) {
                return e < high && same_row(*e, from[1], from[2]);
            };
            for (const Entry* mine = first; mine < stop && there(low); ++mine) {
                while (there(low) && low->cell[0] < mine->cell[0] - 1) ++low;
                for (const Entry* e = low; there(e) && e->cell[0] <= mine->cell[0] + 1; ++e) {
                    with(*mine, *e);
                }
            }
        }
        first = stop;
    }
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
            skin.corners.for_each(g * piece, last, [&](std::size_t c, const auto& corners) {
                look(scene, colliders, c, corners, found[g]);
            });
        }
    });
    return joined(found);
}

namespace {

// Indices of `count` things by key, those of equal key in the order that `order` has them.
std::vector<std::uint32_t> sorted_by(const std::vector<std::uint32_t>& order, std::size_t keys,
                                     const auto& key)
{
    std::vector<std::uint32_t> at(keys + 1, 0), out(order.size());
    for (const auto i : order) ++at[key(i) + 1];
    for (std::size_t k = 0; k < keys; ++k) at[k + 1] += at[k];
    for (const auto i : order) out[at[key(i)]++] = i;
    return out;
}

// Pairs into groups, groups into colours: each takes the first that neither of its bodies has yet.
PairPushes grouped(const std::vector<PairPush>& found, const std::vector<std::uint32_t>& piece)
{
    constexpr int most_colours = 63;
    PairPushes out;
    if (found.empty()) return out;
    std::uint32_t bodies = 0;
    for (const auto p : piece) bodies = std::max(bodies, p + 1);
    const auto bodies_of = [&](std::uint32_t i) {
        const std::uint32_t a = piece[found[i].a], b = piece[found[i].b];
        return std::pair(std::min(a, b), std::max(a, b));
    };
    std::vector<std::uint32_t> order(found.size());
    std::iota(order.begin(), order.end(), 0u);
    order = sorted_by(order, bodies, [&](std::uint32_t i) { return bodies_of(i).second; });
    order = sorted_by(order, bodies, [&](std::uint32_t i) { return bodies_of(i).first; });

    struct Group {
        std::uint32_t begin, end, colour;
    };
    std::vector<Group> groups;
    std::vector<std::uint64_t> taken(bodies, 0);
    std::uint32_t colours = 0;
    for (std::uint32_t begin = 0, end = 0; begin < order.size(); begin = end) {
        const auto [a, b] = bodies_of(order[begin]);
        while (end < order.size() && bodies_of(order[end]) == std::pair(a, b)) ++end;
        const auto colour =
            std::uint32_t(std::min(most_colours, std::countr_one(taken[a] | taken[b])));
        taken[a] |= std::uint64_t{1} << colour;
        taken[b] |= std::uint64_t{1} << colour;
        colours = std::max(colours, colour + 1);
        groups.push_back({begin, end, colour});
    }
    out.last_alone = colours == most_colours + 1;
    std::vector<std::uint32_t> by_colour(groups.size());
    std::iota(by_colour.begin(), by_colour.end(), 0u);
    by_colour = sorted_by(by_colour, colours, [&](std::uint32_t g) { return groups[g].colour; });
    out.push.reserve(found.size());
    out.group_at.push_back(0);
    for (std::size_t g = 0; g < by_colour.size(); ++g) {
        const Group& group = groups[by_colour[g]];
        while (out.colour_at.size() <= group.colour) out.colour_at.push_back(std::uint32_t(g));
        for (auto k = group.begin; k < group.end; ++k) out.push.push_back(found[order[k]]);
        out.group_at.push_back(std::uint32_t(out.push.size()));
    }
    out.colour_at.push_back(std::uint32_t(by_colour.size()));
    return out;
}

}  // namespace

PairPushes find_pair_pushes(const ContactScene& scene, const std::vector<std::uint32_t>& side,
                            const std::vector<std::uint32_t>& piece, double distance,
                            double friction)
{
    const double dt = scene.dt;
    constexpr std::size_t grain = 512;
    std::vector<Entry> places(side.size());
    geometry::parallel_for(side.size(), grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t k = side[i];
            const Vec3 next = scene.state.x[k] + dt * scene.state.v[k];
            const Eigen::Array3d cell = (next / distance).array().floor();
            places[i] = {cell.max(-1e9).min(1e9).cast<int>(), k, piece[k], next};
        }
    });
    const Rows rows = sort_into_rows(places);
    const auto meet = [&](const Entry& mine, const Entry& other, std::vector<PairPush>& out) {
        if (mine.piece == other.piece) return;
        const std::uint32_t i = mine.particle, j = other.particle;
        const Vec3 apart = mine.next - other.next;
        const double apart_sq = apart.squaredNorm();
        if (!(apart_sq < distance * distance)) return;
        const double inverse_a = scene.inverse_mass[i], inverse_b = scene.inverse_mass[j];
        if (!(inverse_a + inverse_b > 0)) return;
        const double length = std::sqrt(apart_sq);
        const Vec3 normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
        const double speed = (scene.state.v[i] - scene.state.v[j]).dot(normal);
        PairPush push;
        push.a = i;
        push.b = j;
        push.mass = push.mass_across = float(1 / (inverse_a + inverse_b));
        push.normal = normal.cast<float>();
        push.bias = float(bias_of(length - distance, speed, dt));
        push.friction = float(friction);
        out.push_back(push);
    };
    std::vector<std::vector<PairPush>> found((side.size() + grain - 1) / grain);
    geometry::parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t g = begin; g < end; ++g) {
            const std::size_t last = std::min(side.size(), (g + 1) * grain);
            for_each_near(rows, g * grain, last, [&](const Entry& mine, const Entry& other) {
                meet(mine, other, found[g]);
            });
        }
    });
    return grouped(joined(found), piece);
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
    skin.corners.for_each(0, skin.corners.size(), [&](std::size_t c, const auto& corners) {
        const SkinPatch& patch = skin.on(c);
        const Vec3 some = scene.state.x[corners[0]] + dt * scene.state.v[corners[0]];
        double size_sq = 0;  // of the cube, from that corner
        for (const auto k : corners) {
            size_sq =
                std::max(size_sq, (scene.state.x[k] + dt * scene.state.v[k] - some).squaredNorm());
        }
        const double reach = ball.radius + 2 * double(patch.reach) * std::sqrt(size_sq);
        if ((some - centre).squaredNorm() > reach * reach) return;
        for (std::uint32_t i = patch.point; i < patch.points_end; ++i) {
            BallPush push;
            push.ball = b;
            push.corners = corners;
            Vec3 now = Vec3::Zero(), v = now;
            double inverse = 0;
            for (std::size_t a = 0; a < 8; ++a) {
                const double weight = push.weight[a] = double(skin.point[i][a]);
                now += weight * scene.state.x[corners[a]];
                v += weight * scene.state.v[corners[a]];
                inverse += weight * weight * scene.inverse_mass[corners[a]];
            }
            const Vec3 apart = centre - (now + dt * v);
            const double length = apart.norm();
            if (!(length < ball.radius)) continue;
            push.normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
            push.mass_across = 1 / (inverse + across(ball));
            push.mass = 1 / (inverse + 1 / ball.mass);
            push.arm = -ball.radius * push.normal;
            push.friction = ball.friction;
            push.bias = bias_of(length - ball.radius, (at.v - v).dot(push.normal), dt);
            out.push_back(push);
        }
    });
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

// Groups of pairs that one thread solves: some microseconds' work.
constexpr std::size_t groups_a_task = 16;

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
    const auto solve_groups = [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = pairs.group_at[begin]; k < pairs.group_at[end]; ++k) {
            PairPush& p = pairs.push[k];
            const Eigen::Vector3f relative = (v[p.a] - v[p.b]).cast<float>();
            const float before = p.impulse;
            const Vec3 change = change_of(p, relative).cast<double>();
            if (before == 0 && p.impulse == 0) continue;  // they do not touch, and write nothing
            // The same masses on both sides as in double: momentum is kept to rounding.
            v[p.a] += scene.inverse_mass[p.a] * change;
            v[p.b] -= scene.inverse_mass[p.b] * change;
        }
    };
    for (int round = 0; round < rounds; ++round) {
        for (std::size_t c = 0; c + 1 < pairs.colour_at.size(); ++c) {
            const std::size_t first = pairs.colour_at[c], last = pairs.colour_at[c + 1];
            const bool alone = pairs.last_alone && c + 2 == pairs.colour_at.size();
            geometry::parallel_for(last - first, alone ? last - first : groups_a_task,
                                   [&](std::size_t begin, std::size_t end) {
                                       solve_groups(first + begin, first + end);
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

}  // namespace physics
