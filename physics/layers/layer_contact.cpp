#include "physics/layers/layer_contact.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "physics/layers/deformed_layer.hpp"
#include "physics/layers/drawn_samples.hpp"
#include "physics/layers/layer_contact_rim.hpp"
#include "physics/layers/layer_stops.hpp"
#include "physics/layers/ray_search.hpp"
#include "physics/layers/rigid_stops.hpp"
#include "physics/layers/velocity_at.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

using geometry::FieldBlock;
using geometry::no_skeleton;

// Up to a block of samples of one skeleton.
struct RayBatch {
    std::uint32_t body, skeleton, begin, end;
};

// What a batch finds.
struct BatchContacts {
    std::vector<LayerContact> contacts;
    std::vector<LayerStop> stops;  // one for each other body, or part of the own one
    double penetration = 0;
};

// How deep point k, on or in `own`'s deformed surface, stands inside another's: D_j > c where f_j >
// max(f_i, c), rigid j where f_j > c.
double penetration(const DeformedValues& at, std::size_t k, double c)
{
    double depth = 0;
    if (at.m[k] > std::max(at.f[k], c) && at.m_slope[k] > 0) {
        depth = (at.m[k] - std::max(at.f[k], c)) / at.m_slope[k];
    }
    if (at.q[k] > c && at.q_slope[k] > 0) depth = std::max(depth, (at.q[k] - c) / at.q_slope[k]);
    return depth;
}

// The rays of a batch in the world. Returns a box around them.
Box start_rays(const ContactBody& own, const RayBatch& batch, std::vector<SearchRay>& rays)
{
    const SurfaceSamples& samples = *own.samples;
    const Transform& frame = own.frames[samples.frame[batch.skeleton]];
    rays.clear();
    Box box;
    for (std::uint32_t i = batch.begin; i < batch.end; ++i) {
        const Vec3 origin = frame * samples.origin[i];
        box.add(origin);
        box.add(own.walk->position[i]);
        const double d = own.walk->distance[i];
        rays.push_back({i, origin, frame.linear() * samples.direction[i], d, 0, d});
    }
    return box;
}

// A ray that has arrived at point k of a block, on the surface of what it touches.
void add_contact(const Meeting& meeting, const RayBatch& batch, const SearchRay& ray,
                 const DeformedValues& at, std::size_t k, const Vec3& p,
                 std::vector<LayerContact>& contacts)
{
    const ContactBody& own = meeting.bodies[batch.body];
    const std::uint32_t party = at.fits[k] ? at.rigid[k] : at.soft[k];
    const Vec3 gradient = at.D.gradient(k);
    const double slope = gradient.norm();
    const double cosine = slope > 0 ? -ray.direction.dot(gradient) / slope : 0;
    if (party == no_party || !(cosine > 1e-6)) return;
    const Party& other = meeting.others[party];
    const std::uint32_t touched = largest_at(meeting.field(other), other.skeletons, p);
    if (touched == no_skeleton) return;
    // Pressed past three quarters, a ray's share stays what it was there: a skeleton that is pushed
    // beyond the other's surface must not lose what holds it back.
    const double t = std::max(
        ray.t, 0.25 * geometry::thickness_along(*own.field, batch.skeleton, ray.direction));
    const double pressing = at.fits[k] ? at.f[k] : at.m[k];
    contacts.push_back({batch.body, ray.sample, batch.skeleton, other.body, touched, p,
                        -gradient / slope, own.samples->crossed(ray.sample, t) / cosine,
                        std::max(0.0, pressing - own.field->isovalue), 0, ray.t, Vec3::Zero()});
}

// Moves the batch's samples that D < c at their stops inward along their rays to D = c.
void meet(std::span<const ContactBody> bodies, const RayBatch& batch, BatchContacts& met)
{
    thread_local Meeting meeting;
    thread_local FieldBlock block;
    thread_local DeformedValues at;
    thread_local std::vector<SearchRay> rays;
    thread_local std::vector<Vec3> half_pressed;  // skeleton points of rays that end near them
    const ContactBody& own = bodies[batch.body];
    const geometry::FieldProfile& profile = own.field->profile[batch.skeleton];
    const double c = own.field->isovalue, tolerance = 1e-13 * profile.R;
    const Box box = start_rays(own, batch, rays);
    gather(bodies, batch.body, batch.skeleton, box, meeting);
    if (meeting.other_count == 0) return;
    half_pressed.clear();
    for (int round = 0; round < 100 && !rays.empty(); ++round) {
        block.count = 0;
        for (const SearchRay& ray : rays) block.add(ray.point());
        block.pad();
        evaluate(meeting, {}, block, at);
        std::size_t left = 0;
        for (std::size_t k = 0; k < rays.size(); ++k) {
            SearchRay ray = rays[k];
            // Touches nothing. (Not by D: f = c only as near as the sample walked.)
            if (round == 0 && !(std::max(at.m[k], at.q[k]) > c)) continue;
            const double phi_slope = ray.direction.dot(at.D.gradient(k));
            if (step(ray, at.D.f[k] - c, phi_slope, tolerance)) {
                rays[left++] = ray;
                continue;
            }
            met.penetration = std::max(met.penetration, penetration(at, k, c));
            if (ray.t <
                0.5 * geometry::thickness_along(*own.field, batch.skeleton, ray.direction)) {
                half_pressed.push_back(ray.origin);
            }
            add_contact(meeting, batch, ray, at, k, block.point(k), met.contacts);
        }
        rays.resize(left);
    }
    if (!half_pressed.empty()) find_stops(meeting, batch.skeleton, half_pressed, met.stops);
}

Vec3 slip_at(std::span<const ContactBody> bodies, const LayerContact& contact)
{
    return velocity_at(bodies[contact.other], contact.other_skeleton, contact.position) -
           velocity_at(bodies[contact.body], contact.skeleton, contact.position);
}

Vec3 response(std::span<const ContactBody> bodies, const LayerContact& contact)
{
    const LayerContactLaw law = contact_law(bodies, contact);
    const Vec3 slip = slip_at(bodies, contact);
    const Vec3 across = slip.dot(contact.normal) * contact.normal;
    // Both objects' samples stand for the whole of a soft common surface.
    const double share = bodies[contact.other].matter.rigid ? 1 : 0.5;
    return share * (-law.stiffness * contact.load * contact.normal +
                    contact.area * (law.damping * across + law.along * (slip - across)));
}

void check(std::span<const ContactBody> bodies)
{
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const ContactBody& b = bodies[i];
        if (b.field->isovalue != bodies[0].field->isovalue) {
            throw std::invalid_argument(fmt::format(
                "layers in contact must have one isovalue: body 0 has {}, body {} has {}",
                bodies[0].field->isovalue, i, b.field->isovalue));
        }
        const bool fits = b.frame_of.size() == b.field->count() &&
                          b.twists.size() == b.frames.size() &&
                          (!b.samples || (b.walk && b.samples->skeletons() == b.field->count() &&
                                          b.walk->distance.size() == b.samples->count()));
        bool frames = true;
        for (const std::uint32_t f : b.frame_of) frames &= f < b.frames.size();
        if (!fits || !frames) {
            throw std::invalid_argument(fmt::format(
                "the arrays of body {} in contact do not match: {} skeletons, {} frame numbers, {} "
                "frames, {} twists",
                i, b.field->count(), b.frame_of.size(), b.frames.size(), b.twists.size()));
        }
    }
}

}  // namespace

Contacts find_contacts(std::span<const ContactBody> bodies)
{
    check(bodies);
    std::vector<RayBatch> batches;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        if (!bodies[b].samples || bodies[b].matter.rigid) continue;
        const SurfaceSamples& samples = *bodies[b].samples;
        constexpr auto most = static_cast<std::uint32_t>(FieldBlock::capacity);
        for (std::uint32_t s = 0; s < samples.skeletons(); ++s) {
            for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; i += most) {
                batches.push_back({b, s, i, std::min(i + most, samples.first[s + 1])});
            }
        }
    }
    std::vector<BatchContacts> found(batches.size());
    geometry::parallel_for(batches.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            geometry::stop_if_asked();
            meet(bodies, batches[b], found[b]);
        }
    });

    Contacts result;
    for (const ContactBody& body : bodies) {
        result.wrenches.emplace_back(body.frames.size());
        result.compression.push_back(0);
        result.penetration.push_back(0);
    }
    for (std::size_t batch = 0; batch < batches.size(); ++batch) {
        std::vector<LayerContact>& some = found[batch].contacts;
        double& deepest = result.penetration[batches[batch].body];
        deepest = std::max(deepest, found[batch].penetration);
        // Rays stop in the order they converge.
        std::sort(some.begin(), some.end(),
                  [](const LayerContact& a, const LayerContact& b) { return a.sample < b.sample; });
        result.contacts.insert(result.contacts.end(), some.begin(), some.end());
        for (const LayerStop& stop : found[batch].stops) add_stop(stop, result.stops);
    }
    weigh_rims(bodies, result.contacts);
    const auto press = [&](std::uint32_t body, std::uint32_t skeleton, const Vec3& p,
                           const Vec3& force) {
        const std::uint32_t f = bodies[body].frame_of[skeleton];
        Wrench& wrench = result.wrenches[body][f];
        wrench.force += force;
        wrench.torque += (p - bodies[body].frames[f].translation()).cross(force);
    };
    for (LayerContact& contact : result.contacts) {
        contact.force = response(bodies, contact);
        press(contact.body, contact.skeleton, contact.position, contact.force);
        press(contact.other, contact.other_skeleton, contact.position, -contact.force);
        for (const std::uint32_t b : {contact.body, contact.other}) {
            result.compression[b] = std::max(result.compression[b], contact.compression);
        }
    }
    find_drawn(bodies, result);
    find_rigid_stops(bodies, result.stops, result.penetration);
    return result;
}

LayerContactLaw contact_law(std::span<const ContactBody> bodies, const LayerContact& contact)
{
    const LayerMatter& own = bodies[contact.body].matter;
    const LayerMatter& other = bodies[contact.other].matter;
    const double sum = own.stiffness + other.stiffness;
    LayerContactLaw law;
    law.stiffness = other.rigid ? own.stiffness
                    : sum > 0   ? 2 * own.stiffness * other.stiffness / sum
                                : 0;
    law.damping = law.along = other.rigid ? own.friction : 0.5 * (own.friction + other.friction);
    if (other.rigid && other.grip < std::numeric_limits<double>::infinity()) {
        const Vec3 slip = slip_at(bodies, contact);
        const double along = (slip - slip.dot(contact.normal) * contact.normal).norm();
        const double most = other.grip * law.stiffness * contact.compression;
        if (law.along * along > most) law.along = most / along;
    }
    return law;
}

// How far along its ray each of a body's samples is as contacts and bulges leave it, m.
static std::vector<double> deformed_distances(const ContactBody& own, std::uint32_t body,
                                              const Contacts& contacts)
{
    std::vector<double> distance = own.walk->distance;
    for (const LayerContact& contact : contacts.contacts) {
        if (contact.body == body) distance[contact.sample] = contact.distance;
    }
    for (const DrawnSample& drawn : contacts.drawn) {
        if (drawn.body == body) distance[drawn.sample] = drawn.distance;
    }
    return distance;
}

// How much of the way `t` along a sample's ray lies before the territory of skeletons that its own
// does not blend with. (Where a third skeleton blends with both, two parts press each other at
// surfaces that differ by what it adds: what both hold must not be counted twice.)
static double way_at_home(const ContactBody& own, std::uint32_t skeleton, std::uint32_t sample,
                          std::span<const std::uint32_t> apart, double t)
{
    const Transform& frame = own.frames[own.samples->frame[skeleton]];
    const Vec3 origin = frame * own.samples->origin[sample];
    const Vec3 direction = frame.linear() * own.samples->direction[sample];
    const auto contribution = [&](std::uint32_t s, const Vec3& p) {
        return geometry::profile_at(own.field->profile[s], geometry::foot(*own.field, s, p).r).f;
    };
    const auto at_home = [&](double way) {
        const Vec3 p = origin + way * direction;
        const double mine = contribution(skeleton, p);
        return std::all_of(apart.begin(), apart.end(),
                           [&](std::uint32_t s) { return contribution(s, p) <= mine; });
    };
    if (at_home(t)) return t;
    double home = 0, abroad = t;
    for (int i = 0; i < 40; ++i) {
        const double middle = 0.5 * (home + abroad);
        (at_home(middle) ? home : abroad) = middle;
    }
    return home;
}

std::vector<double> local_volumes(std::span<const ContactBody> bodies, std::uint32_t body,
                                  const Contacts& contacts)
{
    const ContactBody& own = bodies[body];
    const SurfaceSamples& samples = *own.samples;
    const std::vector<double> distance = deformed_distances(own, body, contacts);
    const bool parts = own.field->rule != geometry::BlendRule::sum;
    std::vector<double> volumes(samples.skeletons());
    geometry::parallel_for(volumes.size(), 1, [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint32_t> apart;
        for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s) {
            geometry::stop_if_asked();
            apart.clear();
            if (parts) {
                geometry::candidates(*own.field, own.field->influence[s], apart);
                std::erase_if(apart, [&](std::uint32_t k) { return own.field->weights(s, k) > 0; });
            }
            volumes[s] = samples.core[s];
            for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; ++i) {
                const double way =
                    apart.empty() ? distance[i] : way_at_home(own, s, i, apart, distance[i]);
                volumes[s] += samples.swept(i, way);
            }
        }
    });
    return volumes;
}

SampleWalk deformed(const SampleWalk& walk, std::uint32_t body, const Contacts& contacts)
{
    SampleWalk result = walk;
    for (const LayerContact& contact : contacts.contacts) {
        if (contact.body != body) continue;
        result.position[contact.sample] = contact.position;
        result.gradient[contact.sample] = -contact.normal;
        result.area[contact.sample] = contact.area;
        result.valid[contact.sample] = 1;
    }
    for (const DrawnSample& drawn : contacts.drawn) {
        if (drawn.body != body) continue;
        result.position[drawn.sample] = drawn.position;
        result.gradient[drawn.sample] = -drawn.normal;
        result.area[drawn.sample] = drawn.area;
    }
    return result;
}

}  // namespace physics
