#include "physics/layered_bodies/layered_fall.hpp"

#include "geometry/base/union_find.hpp"
#include "physics/layered_bodies/layered_forces.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

bool weighs(const LayeredScene& scene, std::size_t body)
{
    return !is_told(scene.parts[body].body->base.kind);
}

// Frames and corners that move as one.
struct FallGroups {
    FallGroups(const LayeredScene& scene, const std::vector<char>& lags, const Vec3& gravity,
               const LayeredSystem& system, const std::vector<Vec6>& dv)
        : sets(system.velocity.size()), held(system.velocity.size(), 0)
    {
        for (std::size_t f = 0; f < held.size(); ++f) {
            held[f] = system.kind[f] == BaseKind::still || system.kind[f] == BaseKind::led;
        }
        for (const SystemPair& pair : system.pairs) join(pair.a, pair.b);
        for (const CarriedFrame& carried : system.carried) {
            for (const std::size_t on : carried.on) join(carried.frame, on);
        }
        for (const CubeCarrier& cubes : system.carriers) {
            for (std::size_t k = 1; k < cubes.corner_body().corners; ++k) {
                join(cubes.first_corner, cubes.first_corner + k);
            }
        }
        // What stands clear of a stop by more than the lift may make of it.
        const double clear = 0.5 * system.dt * gravity.norm();
        for (const SystemStop& stop : system.stops) {
            const double left = stop.speed(system.velocity) + stop.speed(dv) + stop.room;
            if (stop.held || left < clear) join(stop.a, stop.b);
        }
        for (std::size_t b = 0; b < scene.parts.size(); ++b) hold(scene, lags, b, system);
        for (std::uint32_t f = 0; f < held.size(); ++f) held[sets.root(f)] |= held[f];
    }

    void join(std::size_t a, std::size_t b)
    {
        sets.join(static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b));
    }

    void hold(const LayeredScene& scene, const std::vector<char>& lags, std::size_t b,
              const LayeredSystem& system)
    {
        const Base& base = scene.parts[b].body->base;
        for (const Joint& joint : base.joints) {
            if (joint.a == Joint::world) held[system.frame(b, joint.b)] = 1;
        }
        if (!lags[b]) return;
        for (std::size_t f = 0; f < base.frames.size(); ++f) held[system.frame(b, f)] = 1;
    }

    geometry::UnionFind sets;
    std::vector<char> held;
};

// What a group has gained in the step as a whole.
struct Gain {
    Vec3 impulse = Vec3::Zero();  // N s
    double mass = 0;              // kg
    double drag = 0;              // kg/s
};

}  // namespace

std::vector<char> will_lag(const LayeredScene& scene, const LayeredMoment& moment,
                           const Impacts& impacts, const Vec3& gravity, double dt)
{
    std::vector<char> out(scene.parts.size(), 0);
    for (const Impact& impact : impacts.all) {
        if (!impact.bounces()) continue;
        for (const std::uint32_t b : {impact.body, impact.bounce.other}) {
            out[b] |= !impacts.on_weight[b];
        }
    }
    for (const LayerStop& stop : moment.contacts.stops) {
        const FallTogether fall = falls_together(scene, stop, gravity, impacts.lag);
        if (bounces_off(moment, stop, fall, dt)) out[stop.body] = out[stop.other] = 1;
    }
    for (std::size_t b = 0; b < out.size(); ++b) out[b] = out[b] != 0 && weighs(scene, b);
    return out;
}

void add_lag(const LayeredScene& scene, const std::vector<char>& lags, const Vec3& gravity,
             LayeredSystem& system)
{
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const double more = 0.5 * (scene.states[b].lag - (lags[b] ? system.dt : 0)) / system.dt;
        if (more == 0 || !weighs(scene, b)) continue;
        for (std::size_t f = 0; f < mass_count(scene.parts[b].body->base); ++f) {
            const std::size_t at = system.frame(b, f);
            add_force(system, at, more * system.mass[at](0, 0) * gravity);
        }
    }
}

std::vector<Vec3> half_ways(const LayeredScene& scene, const std::vector<char>& lags,
                            const Vec3& gravity, const LayeredSystem& system)
{
    const std::size_t n = system.velocity.size();
    FallGroups groups(scene, lags, gravity, system, std::vector<Vec6>(n, Vec6::Zero()));
    std::vector<Vec3> momentum(n, Vec3::Zero());
    std::vector<double> mass(n, 0);
    for (std::uint32_t f = 0; f < n; ++f) {
        if (system.kind[f] == BaseKind::carried) continue;
        momentum[groups.sets.root(f)] += system.mass[f](0, 0) * system.velocity[f].head<3>();
        mass[groups.sets.root(f)] += system.mass[f](0, 0);
    }
    std::vector<Vec3> out(n, Vec3::Zero());
    for (std::uint32_t f = 0; f < n; ++f) {
        const std::uint32_t root = groups.sets.root(f);
        if (groups.held[root] || !(mass[root] > 0)) continue;
        out[f] = 0.5 * system.dt / mass[root] * momentum[root];
    }
    return out;
}

std::vector<Vec3> lifts(const LayeredScene& scene, const std::vector<char>& lags,
                        const Vec3& gravity, const LayeredSystem& system,
                        const std::vector<Vec6>& dv)
{
    constexpr double much = 0.25;  // of the velocity, that the air takes
    const std::size_t n = system.velocity.size();
    FallGroups groups(scene, lags, gravity, system, dv);
    std::vector<Gain> gains(n);
    for (std::size_t f = 0; f < n; ++f) {
        Gain& gain = gains[groups.sets.root(static_cast<std::uint32_t>(f))];
        gain.drag += system.drag[f];
        if (system.kind[f] == BaseKind::carried) continue;
        gain.mass += system.mass[f](0, 0);
        gain.impulse += system.mass[f](0, 0) * dv[f].head<3>();
    }
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {  // of earlier steps
        const double late = weighs(scene, b) ? 0.5 * scene.states[b].lag : 0;
        if (late == 0) continue;
        for (std::size_t f = 0; f < mass_count(scene.parts[b].body->base); ++f) {
            const auto at = static_cast<std::uint32_t>(system.frame(b, f));
            gains[groups.sets.root(at)].impulse -= late * system.mass[at](0, 0) * gravity;
        }
    }
    std::vector<Vec3> out(n, Vec3::Zero());
    for (std::uint32_t f = 0; f < n; ++f) {
        const std::uint32_t root = groups.sets.root(f);
        const Gain& gain = gains[root];
        if (groups.held[root] || !(gain.mass > 0)) continue;
        const double share = 1 - system.dt * gain.drag / gain.mass / much;
        out[f] = -0.5 * system.dt * std::max(0.0, share) * gain.impulse / gain.mass;
    }
    return out;
}

}  // namespace physics
