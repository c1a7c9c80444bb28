#include "physics/layer_contact.hpp"

#include "geometry/parallel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

using geometry::BlockValues;
using geometry::FieldBlock;
using geometry::FieldScratch;
using geometry::FieldValue;
using geometry::Interval;
using geometry::no_skeleton;

// G(s) and dG/ds.
std::pair<double, double> relief(double s, double a, double h)
{
    if (s < 0) return {s, 1};
    if (!(s < 2 * h)) return {0, 0};
    const double u = s / h;
    if (u <= 1) {
        return {h * u * (1 - u) * (1 - u) + a * u * u * (3 - 2 * u),
                (1 - u) * (1 - 3 * u) + 6 * a / h * u * (1 - u)};
    }
    const double v = u - 1;
    return {a * (1 - v) * (1 - v) * (1 + 2 * v), -6 * a / h * v * (1 - v)};
}

// One side of a meeting: some skeletons of one body's field.
struct Party {
    std::uint32_t body = 0;
    std::vector<std::uint32_t> skeletons;
};

// A body, or one skeleton of it with those that it blends with, and all that it may touch nearby.
struct Meeting {
    std::span<const ContactBody> bodies;
    Party own;
    std::vector<Party> others;
    std::size_t other_count = 0;  // of `others`: the rest is memory to reuse

    const Field& field(const Party& party) const { return *bodies[party.body].field; }
};

// Who is near `box`. `skeleton`: no_skeleton for the body as a whole.
void gather(std::span<const ContactBody> bodies, std::uint32_t body, std::uint32_t skeleton,
            const Box& box, Meeting& meeting)
{
    meeting.bodies = bodies;
    meeting.other_count = 0;
    const ContactBody& own = bodies[body];
    meeting.own.body = body;
    geometry::candidates(*own.field, box, meeting.own.skeletons);
    const auto party = [&]() -> Party& {
        if (meeting.other_count == meeting.others.size()) meeting.others.emplace_back();
        return meeting.others[meeting.other_count];
    };
    for (std::uint32_t j = 0; j < bodies.size(); ++j) {
        if (j == body) continue;
        Party& other = party();
        other.body = j;
        geometry::candidates(*bodies[j].field, box, other.skeletons);
        if (!other.skeletons.empty()) ++meeting.other_count;
    }
    if (skeleton == no_skeleton || own.field->rule == geometry::BlendRule::sum) return;
    const auto apart = [&](std::uint32_t k) { return !(own.field->weights(skeleton, k) > 0); };
    if (own.matter.self_contact) {
        Party& other = party();
        other.body = body;
        other.skeletons.clear();
        std::copy_if(meeting.own.skeletons.begin(), meeting.own.skeletons.end(),
                     std::back_inserter(other.skeletons), apart);
        if (!other.skeletons.empty()) ++meeting.other_count;
    }
    std::erase_if(meeting.own.skeletons, apart);
}

constexpr std::uint32_t nobody = 0xffffffff;

// D at a block's points, and what made it so.
struct Deformed {
    BlockValues D;
    std::uint32_t soft[FieldBlock::capacity], rigid[FieldBlock::capacity];  // largest m, q
    double f[FieldBlock::capacity], m[FieldBlock::capacity], q[FieldBlock::capacity];
    bool fits[FieldBlock::capacity];  // to a rigid one: D = 2c - q
};

void evaluate(const Meeting& meeting, double a, double h, const FieldBlock& block, Deformed& out)
{
    thread_local FieldScratch scratch;
    thread_local BlockValues values;
    thread_local Vec3 m_gradient[FieldBlock::capacity], q_gradient[FieldBlock::capacity];
    const double c = meeting.field(meeting.own).isovalue;
    geometry::evaluate(meeting.field(meeting.own), meeting.own.skeletons, block, scratch, out.D);
    for (std::size_t k = 0; k < block.count; ++k) {
        out.f[k] = out.D.f[k];
        out.m[k] = out.q[k] = 0;
        out.soft[k] = out.rigid[k] = nobody;
        out.fits[k] = false;
    }
    for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
        const Party& other = meeting.others[o];
        const bool rigid = meeting.bodies[other.body].matter.rigid;
        geometry::evaluate(meeting.field(other), other.skeletons, block, scratch, values);
        for (std::size_t k = 0; k < block.count; ++k) {
            double& most = rigid ? out.q[k] : out.m[k];
            if (!(values.f[k] > most)) continue;
            most = values.f[k];
            (rigid ? q_gradient : m_gradient)[k] = values.gradient(k);
            (rigid ? out.rigid : out.soft)[k] = o;
        }
    }
    const auto set = [&](std::size_t k, double f, const Vec3& g) {
        out.D.f[k] = f;
        out.D.gx[k] = g.x();
        out.D.gy[k] = g.y();
        out.D.gz[k] = g.z();
    };
    for (std::size_t k = 0; k < block.count; ++k) {
        if (out.soft[k] == nobody && out.rigid[k] == nobody) continue;
        const double q = out.q[k], m = out.m[k];
        const bool by_rigid = std::min(q, c) > m;
        const auto [G, slope] = relief(c - std::max(m, std::min(q, c)), a, h);
        Vec3 gradient = out.D.gradient(k);
        if (!by_rigid && out.soft[k] != nobody) gradient -= slope * m_gradient[k];
        if (by_rigid && q < c) gradient -= slope * q_gradient[k];
        set(k, out.f[k] + G, gradient);
        if (out.rigid[k] != nobody && 2 * c - q < out.D.f[k]) {
            out.fits[k] = true;
            set(k, 2 * c - q, -q_gradient[k]);
        }
    }
}

std::uint32_t largest_at(const Field& field, std::span<const std::uint32_t> skeletons,
                         const Vec3& p)
{
    std::uint32_t largest = no_skeleton;
    double most = 0;
    for (const std::uint32_t s : skeletons) {
        const double f = profile_at(field.profile[s], geometry::foot(field, s, p).r).f;
        if (f > most) {
            most = f;
            largest = s;
        }
    }
    return largest;
}

Vec3 velocity_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p)
{
    const std::uint32_t f = body.frame_of[skeleton];
    return body.twists[f].linear + body.twists[f].angular.cross(p - body.frames[f].translation());
}

struct Batch {
    std::uint32_t body, skeleton, begin, end;
};

// Moves the batch's seeds that D < c at their stops inward along their rays to D = c.
void meet(std::span<const ContactBody> bodies, const Batch& batch,
          std::vector<LayerContact>& contacts)
{
    thread_local Meeting meeting;
    thread_local FieldBlock block;
    thread_local Deformed at;
    const ContactBody& own = bodies[batch.body];
    const Seeds& seeds = *own.seeds;
    const Transform& frame = own.frames[seeds.frame[batch.skeleton]];
    const double c = own.field->isovalue;
    const double tolerance = 1e-13 * own.field->profile[batch.skeleton].R;

    struct Ray {
        std::uint32_t seed;
        Vec3 origin, direction;
        double t, inside = 0, outside;
    };
    thread_local std::vector<Ray> rays;
    rays.clear();
    Box box;
    for (std::uint32_t i = batch.begin; i < batch.end; ++i) {
        const Vec3 origin = frame * seeds.origin[i];
        box.add(origin);
        box.add(own.walk->position[i]);
        const double d = own.walk->distance[i];
        rays.push_back({i, origin, frame.linear() * seeds.direction[i], d, 0, d});
    }
    gather(bodies, batch.body, batch.skeleton, box, meeting);
    if (meeting.other_count == 0) return;

    for (int round = 0; round < 100 && !rays.empty(); ++round) {
        block.count = 0;
        for (const Ray& ray : rays) block.add(ray.origin + ray.t * ray.direction);
        block.pad();
        evaluate(meeting, 0, 0, block, at);
        std::size_t left = 0;
        for (std::size_t k = 0; k < rays.size(); ++k) {
            Ray ray = rays[k];
            const double phi = at.D.f[k] - c;
            // Touches nothing. (Not by phi: f = c only as near as the seed walked.)
            if (round == 0 && !(std::max(at.m[k], at.q[k]) > c)) continue;
            const Vec3 gradient = at.D.gradient(k);
            const double phi_slope = ray.direction.dot(gradient);
            (phi > 0 ? ray.inside : ray.outside) = ray.t;
            double next = ray.t - phi / phi_slope;
            if (!(phi_slope < 0 && next >= ray.inside && next <= ray.outside)) {
                next = 0.5 * (ray.inside + ray.outside);
            }
            if (std::abs(next - ray.t) > tolerance && ray.outside - ray.inside > tolerance) {
                ray.t = next;
                rays[left++] = ray;
                continue;
            }
            const std::uint32_t party = at.fits[k] ? at.rigid[k] : at.soft[k];
            const double slope = gradient.norm();
            const double cosine = slope > 0 ? -phi_slope / slope : 0;
            if (party == nobody || !(cosine > 1e-6)) continue;
            const Party& other = meeting.others[party];
            const Vec3 p = block.point(k);
            const std::uint32_t touched = largest_at(meeting.field(other), other.skeletons, p);
            if (touched == no_skeleton) continue;
            // Pressed past three quarters, a ray's share stays what it was there: a skeleton that
            // is pushed beyond the other's surface must not lose what holds it back.
            const double t = std::max(ray.t, 0.25 * own.field->profile[batch.skeleton].e);
            const double across =
                seeds.a0[ray.seed] + t * (seeds.a1[ray.seed] + t * seeds.a2[ray.seed]);
            contacts.push_back({batch.body, ray.seed, batch.skeleton, other.body, touched, p,
                                -gradient / slope, across / cosine,
                                std::max(0.0, (at.fits[k] ? at.f[k] : at.m[k]) - c), Vec3::Zero()});
        }
        rays.resize(left);
    }
}

Vec3 response(std::span<const ContactBody> bodies, const LayerContact& contact)
{
    const ContactBody& own = bodies[contact.body];
    const ContactBody& other = bodies[contact.other];
    const double Ki = own.matter.stiffness, Kj = other.matter.stiffness;
    const bool rigid = other.matter.rigid;
    const double K = rigid ? Ki : Ki + Kj > 0 ? 2 * Ki * Kj / (Ki + Kj) : 0;
    const double lambda =
        rigid ? own.matter.friction : 0.5 * (own.matter.friction + other.matter.friction);
    const Vec3 slip = velocity_at(other, contact.other_skeleton, contact.position) -
                      velocity_at(own, contact.skeleton, contact.position);
    // Both objects' seeds stand for the whole of a soft common surface.
    const double share = rigid ? contact.area : 0.5 * contact.area;
    return share * (-K * contact.compression * contact.normal + lambda * slip);
}

void check(std::span<const ContactBody> bodies)
{
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const ContactBody& b = bodies[i];
        if (b.field->isovalue != bodies[0].field->isovalue) {
            throw std::invalid_argument(
                fmt::format("layers in contact must share one isovalue; body 0 has {}, body {} {}",
                            bodies[0].field->isovalue, i, b.field->isovalue));
        }
        const bool fits = b.frame_of.size() == b.field->count() &&
                          b.twists.size() == b.frames.size() &&
                          (!b.seeds || (b.walk && b.seeds->skeletons() == b.field->count() &&
                                        b.walk->distance.size() == b.seeds->count()));
        bool frames = true;
        for (const std::uint32_t f : b.frame_of) frames &= f < b.frames.size();
        if (!fits || !frames) {
            throw std::invalid_argument(fmt::format(
                "body {} in contact does not fit together: {} skeletons, {} frame numbers, {} "
                "frames, {} twists",
                i, b.field->count(), b.frame_of.size(), b.frames.size(), b.twists.size()));
        }
    }
}

}  // namespace

Contacts find_contacts(std::span<const ContactBody> bodies)
{
    check(bodies);
    std::vector<Batch> batches;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        if (!bodies[b].seeds || bodies[b].matter.rigid) continue;
        const Seeds& seeds = *bodies[b].seeds;
        constexpr auto most = static_cast<std::uint32_t>(FieldBlock::capacity);
        for (std::uint32_t s = 0; s < seeds.skeletons(); ++s) {
            for (std::uint32_t i = seeds.first[s]; i < seeds.first[s + 1]; i += most) {
                batches.push_back({b, s, i, std::min(i + most, seeds.first[s + 1])});
            }
        }
    }
    std::vector<std::vector<LayerContact>> found(batches.size());
    geometry::parallel_for(batches.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) meet(bodies, batches[b], found[b]);
    });

    Contacts result;
    for (const ContactBody& body : bodies) {
        result.wrenches.emplace_back(body.frames.size());
        result.compression.push_back(0);
    }
    const auto press = [&](std::uint32_t body, std::uint32_t skeleton, const Vec3& p,
                           const Vec3& force) {
        const std::uint32_t f = bodies[body].frame_of[skeleton];
        Wrench& wrench = result.wrenches[body][f];
        wrench.force += force;
        wrench.torque += (p - bodies[body].frames[f].translation()).cross(force);
    };
    for (std::vector<LayerContact>& some : found) {
        // Rays stop in the order they converge.
        std::sort(some.begin(), some.end(),
                  [](const LayerContact& a, const LayerContact& b) { return a.seed < b.seed; });
        for (LayerContact& contact : some) {
            contact.force = response(bodies, contact);
            press(contact.body, contact.skeleton, contact.position, contact.force);
            press(contact.other, contact.other_skeleton, contact.position, -contact.force);
            for (const std::uint32_t b : {contact.body, contact.other}) {
                result.compression[b] = std::max(result.compression[b], contact.compression);
            }
            result.contacts.push_back(contact);
        }
    }
    return result;
}

DeformedLayer deformed(std::span<const ContactBody> bodies, std::uint32_t body,
                       const Contacts& contacts)
{
    const LayerMatter& matter = bodies[body].matter;
    if (matter.rigid) return {bodies, body, 0, 0};
    double k = 0;
    for (std::uint32_t j = 0; j < bodies.size(); ++j) {
        if (j == body && bodies.size() > 1) continue;
        for (const geometry::FieldProfile& p : bodies[j].field->profile) k = std::max(k, p.k);
    }
    const double a = matter.bulge_height * contacts.compression[body];
    const double h = 0.5 * std::min({k * matter.bulge_width, bodies[body].field->isovalue, 6 * a});
    return {bodies, body, std::min(a, h), h};
}

namespace {

void ask(const DeformedLayer& layer, const FieldBlock& block, Deformed& out)
{
    thread_local Meeting meeting;
    Box box;
    for (std::size_t k = 0; k < block.count; ++k) box.add(block.point(k));
    gather(layer.bodies, layer.body, no_skeleton, box, meeting);
    if (layer.bodies[layer.body].matter.rigid) meeting.other_count = 0;
    evaluate(meeting, layer.bulge, layer.half_reach, block, out);
}

}  // namespace

FieldValue value_at(const DeformedLayer& layer, const Vec3& p)
{
    if (!p.allFinite()) return {};
    thread_local FieldBlock block;
    thread_local Deformed out;
    block.count = 0;
    block.add(p);
    block.pad();
    ask(layer, block, out);
    FieldValue value{out.D.f[0], out.D.gradient(0), no_skeleton};
    value.largest = geometry::value_at(*layer.bodies[layer.body].field, p).largest;
    return value;
}

geometry::IsoField iso_field(const DeformedLayer& layer)
{
    geometry::IsoField iso;
    const double c = layer.bodies[layer.body].field->isovalue;
    iso.domain = geometry::influence(*layer.bodies[layer.body].field);
    iso.bounds = [layer, c](const Box& box) {
        thread_local Meeting meeting;
        gather(layer.bodies, layer.body, no_skeleton, box, meeting);
        const Interval own =
            geometry::bounds(meeting.field(meeting.own), meeting.own.skeletons, box);
        double soft = 0, hard = 0;
        for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
            const Party& other = meeting.others[o];
            double& most = layer.bodies[other.body].matter.rigid ? hard : soft;
            most = std::max(most, geometry::bounds(meeting.field(other), other.skeletons, box).hi);
        }
        if (layer.bodies[layer.body].matter.rigid) soft = hard = 0;
        return Interval{std::min(own.lo + std::min(0.0, c - soft), 2 * c - hard) - c,
                        own.hi + layer.bulge - c};
    };
    iso.ask = [layer, c](const FieldBlock& block, BlockValues& values) {
        thread_local Deformed out;
        ask(layer, block, out);
        for (std::size_t k = 0; k < (block.count + 7) / 8 * 8; ++k) {
            values.f[k] = out.D.f[k] - c;
            values.gx[k] = out.D.gx[k];
            values.gy[k] = out.D.gy[k];
            values.gz[k] = out.D.gz[k];
        }
    };
    return iso;
}

SeedWalk deformed(const SeedWalk& walk, std::uint32_t body, const Contacts& contacts)
{
    SeedWalk result = walk;
    for (const LayerContact& contact : contacts.contacts) {
        if (contact.body != body) continue;
        result.position[contact.seed] = contact.position;
        result.gradient[contact.seed] = -contact.normal;
        result.area[contact.seed] = contact.area;
        result.valid[contact.seed] = 1;
    }
    return result;
}

}  // namespace physics
