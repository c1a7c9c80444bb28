#include "physics/layered_bodies/layered_loads.hpp"

#include "physics/layers/velocity_at.hpp"
#include "physics/state/gusts.hpp"
#include "physics/state/radial_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>

namespace physics {
namespace {

// Calls visit(body, skeleton, sample) for all samples of bodies that feel forces.
template <class Visit> void for_samples(const LayeredScene& scene, const Visit& visit)
{
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        if (is_told(body.base.kind)) continue;
        for (std::uint32_t s = 0; s < body.samples.skeletons(); ++s) {
            for (std::size_t i = body.samples.first[s]; i < body.samples.first[s + 1]; ++i) {
                visit(b, s, i);
            }
        }
    }
}

// A frame, or a corner of cubes, that has mass.
struct MassAt {
    std::size_t body, index;  // among the body's frames or corners
    std::size_t number;       // in the system
    Vec3 place;               // m
};

// Calls visit(mass) for all of bodies that feel forces.
template <class Visit>
void for_masses(const LayeredScene& scene, const LayeredMoment& moment, const LayeredSystem& system,
                const Visit& visit)
{
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (is_told(scene.parts[b].body->base.kind)) continue;
        const std::vector<Vec3>& corner = scene.states[b].cubes.x;
        const bool cubes = !corner.empty();
        const std::size_t begin = cubes ? system.corner(b, 0) : system.frame(b, 0);
        const std::size_t count = cubes ? corner.size() : mass_count(scene.parts[b].body->base);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3 place = cubes ? corner[i] : Vec3(moment.frames[b][i].translation());
            visit(MassAt{b, i, begin + i, place});
        }
    }
}

// Of a rigid frame about its centre of mass: a box of its mass and its inertia, by Gauss points
// that integrate polynomials of degree 9 along each of its edges.
struct BoxPoint {
    Vec3 arm;     // m, in the frame's axes
    double mass;  // kg
};

std::vector<BoxPoint> box_points(double mass, const Mat3& inertia)
{
    constexpr int n = 5;
    constexpr double at[n] = {-0.9061798459386640, -0.5384693101056831, 0, 0.5384693101056831,
                              0.9061798459386640};
    constexpr double share[n] = {0.1184634425280945, 0.2393143352496832, 0.2844444444444444,
                                 0.2393143352496832, 0.1184634425280945};
    if (!(mass > 0)) return {};
    // Of the sum of m x x^T, each eigenvalue is m a^2 / 3, with a half an edge.
    const Mat3 second = 0.5 * inertia.trace() * Mat3::Identity() - inertia;
    const Eigen::SelfAdjointEigenSolver<Mat3> own(second);
    const Vec3 half = (3 / mass * own.eigenvalues()).cwiseMax(0).cwiseSqrt();
    std::vector<BoxPoint> out;
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            for (int k = 0; k < n; ++k) {
                const Vec3 arm = half.cwiseProduct(Vec3(at[i], at[j], at[k]));
                out.push_back({own.eigenvectors() * arm, mass * share[i] * share[j] * share[k]});
            }
        }
    }
    return out;
}

void add_wind(const LayeredScene& scene, const LayeredMoment& moment, const Force& wind,
              LayeredSystem& system)
{
    const Air air(wind);
    for_samples(scene, [&](std::size_t b, std::uint32_t s, std::size_t i) {
        const SampleWalk& walk = moment.walks[b];
        const double slope = walk.gradient[i].norm();
        if (!(walk.area[i] > 0) || !(slope > 0)) return;
        const Vec3& at = walk.position[i];
        const Vec3 u = air.at(at) - velocity_at(moment.bodies[b], s, at);
        const double flow = walk.area[i] * std::abs(walk.gradient[i].dot(u)) / slope;  // m^3/s
        const double resistance = 0.25 * wind.air_density * wind.drag * flow;
        const std::uint32_t f = scene.parts[b].body->layer.frame[s];
        const Vec3 arm = at - moment.frames[b][f].translation(), force = resistance * u;
        add_force(system, system.frame(b, f), force, arm.cross(force));
        add_hold(system, system.frame(b, f), arm, resistance * Mat3::Identity(), Mat3::Zero());
        system.drag[system.frame(b, f)] += resistance;
    });
}

// m: where a sample is as its body is drawn, where that has `field`.
Vec3 drawn_sample(const LayeredBody& body, const Field& field, std::uint32_t s, std::size_t i,
                  const Mat3& turn)
{
    const Vec3& direction = body.samples.direction[i];
    const double thickness =
        body.layer.contributions[s].thickness * geometry::width_along(field, s, turn * direction);
    return body.base.frames[body.layer.frame[s]] * (body.samples.origin[i] + thickness * direction);
}

// Whether a point force has something to act on of a body that feels forces.
bool acts_near(const LayeredBody& body, const Force& force)
{
    const Field field = geometry::make_field(body.layer, body.base.frames);
    if (geometry::value_at(field, force.position).f >= field.isovalue) return true;
    const double reach = force.radius + body.sample_spacing;
    for (std::uint32_t s = 0; s < body.samples.skeletons(); ++s) {
        const Mat3 turn = body.base.frames[body.layer.frame[s]].linear();
        for (std::size_t i = body.samples.first[s]; i < body.samples.first[s + 1]; ++i) {
            const Vec3 at = drawn_sample(body, field, s, i, turn);
            if ((at - force.position).norm() <= reach) return true;
        }
    }
    return false;
}

void add_point(const LayeredScene& scene, const LayeredMoment& moment, const Force& point,
               LayeredSystem& system)
{
    const auto distance_sq = [&](std::size_t b, std::uint32_t s, std::size_t i) {
        const LayeredBody& body = *scene.parts[b].body;
        const Mat3 turn = moment.frames[b][body.layer.frame[s]].linear();
        return (drawn_sample(body, moment.fields[b], s, i, turn) - point.position).squaredNorm();
    };
    const auto weight = [&](std::size_t b, std::size_t i, double d_sq) {
        const double near = 1 - d_sq / (point.radius * point.radius);
        return near > 0 ? moment.walks[b].area[i] * near * near : 0.0;
    };
    double sum = 0, nearest_sq = std::numeric_limits<double>::infinity();
    std::size_t nearest_body = 0, nearest = 0;
    for_samples(scene, [&](std::size_t b, std::uint32_t s, std::size_t i) {
        if (!(moment.walks[b].area[i] > 0)) return;
        const double d_sq = distance_sq(b, s, i);
        sum += weight(b, i, d_sq);
        if (d_sq < nearest_sq) nearest_sq = d_sq, nearest_body = b, nearest = i;
    });
    for_samples(scene, [&](std::size_t b, std::uint32_t s, std::size_t i) {
        const double share =
            sum > 0 ? weight(b, i, distance_sq(b, s, i)) / sum
                    : static_cast<double>(b == nearest_body && i == nearest && nearest_sq < 1e300);
        if (!(share > 0)) return;
        const std::uint32_t f = scene.parts[b].body->layer.frame[s];
        const Vec3 arm = moment.walks[b].position[i] - moment.frames[b][f].translation();
        const Vec3 force = share * point.force;
        add_force(system, system.frame(b, f), force, arm.cross(force));
    });
}

}  // namespace

Vec3 free_fall(const LayeredWorld& world)
{
    Vec3 sum = world.gravity;
    for (const Force& force : world.forces) {
        if (force.kind == Force::Kind::gravity) sum += force.acceleration;
    }
    return sum;
}

std::vector<std::string> far_point_forces(std::span<const LayeredPart> parts,
                                          std::span<const Force> forces)
{
    std::vector<std::string> out;
    const auto feels = [](const LayeredPart& part) { return !is_told(part.body->base.kind); };
    if (std::none_of(parts.begin(), parts.end(), feels)) return out;
    for (std::size_t i = 0; i < forces.size(); ++i) {
        const Force& force = forces[i];
        if (force.kind != Force::Kind::point || force.force.isZero(0)) continue;
        const auto near = [&](const LayeredPart& part) {
            return feels(part) && acts_near(*part.body, force);
        };
        if (std::any_of(parts.begin(), parts.end(), near)) continue;
        out.push_back(fmt::format(
            "Point force {} of {} has no layer within its radius: all of it acts on the surface "
            "nearest to its position. Positions are those of the bodies as they are drawn; move "
            "the force there, or increase its radius.",
            i + 1, forces.size()));
    }
    return out;
}

void add_fields(const LayeredScene& scene, const LayeredMoment& moment,
                std::span<const Force> forces, LayeredSystem& system)
{
    for (const Force& force : forces) {
        switch (force.kind) {
        case Force::Kind::gravity:
            for_masses(scene, moment, system, [&](const MassAt& m) {
                add_force(system, m.number, system.mass[m.number](0, 0) * force.acceleration);
            });
            break;
        case Force::Kind::wind:
            add_wind(scene, moment, force, system);
            break;
        case Force::Kind::point:
            add_point(scene, moment, force, system);
            break;
        case Force::Kind::radial:
            break;  // add_radial_fields()
        case Force::Kind::torque:
        case Force::Kind::pressure:
            break;  // refused before
        }
    }
}

void add_radial_fields(const LayeredScene& scene, const LayeredMoment& moment,
                       std::span<const Force> forces, std::span<const Vec3> further,
                       LayeredSystem& system)
{
    std::vector<Force> radial;
    std::copy_if(forces.begin(), forces.end(), std::back_inserter(radial),
                 [](const Force& force) { return force.kind == Force::Kind::radial; });
    if (radial.empty()) return;
    const auto acceleration = [&](const Vec3& at) {
        Vec3 sum = Vec3::Zero();
        for (const Force& force : radial) sum += radial_acceleration(force, at);
        return sum;
    };
    for_masses(scene, moment, system, [&](const MassAt& m) {
        const Vec3 at = further.empty() ? m.place : Vec3(m.place + further[m.number]);
        const Base& base = scene.parts[m.body].body->base;
        if (base.kind != BaseKind::rigid) {
            add_force(system, m.number, system.mass[m.number](0, 0) * acceleration(at));
            return;
        }
        const Mat3 turn = moment.frames[m.body][m.index].linear();
        Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
        for (const BoxPoint& point : box_points(base.mass[m.index], base.inertia[m.index])) {
            const Vec3 arm = turn * point.arm, own = point.mass * acceleration(at + arm);
            force += own, torque += arm.cross(own);
        }
        add_force(system, m.number, force, torque);
    });
}

}  // namespace physics
