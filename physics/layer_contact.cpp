#include "physics/layer_contact.hpp"

#include "geometry/parallel.hpp"
#include "physics/contact_rim.hpp"

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

constexpr std::uint32_t no_party = 0xffffffff;

// D at a block's points, and what made it so.
struct Deformed {
    BlockValues D;
    std::uint32_t soft[FieldBlock::capacity], rigid[FieldBlock::capacity];  // largest m, q
    double f[FieldBlock::capacity], m[FieldBlock::capacity], q[FieldBlock::capacity];
    double m_slope[FieldBlock::capacity], q_slope[FieldBlock::capacity];  // |grad m|, |grad q|
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
        out.soft[k] = out.rigid[k] = no_party;
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
        if (out.soft[k] == no_party && out.rigid[k] == no_party) continue;
        const double q = out.q[k], m = out.m[k];
        out.m_slope[k] = out.soft[k] == no_party ? 0 : m_gradient[k].norm();
        out.q_slope[k] = out.rigid[k] == no_party ? 0 : q_gradient[k].norm();
        const bool by_rigid = std::min(q, c) > m;
        const auto [G, slope] = relief(c - std::max(m, std::min(q, c)), a, h);
        Vec3 gradient = out.D.gradient(k);
        if (!by_rigid && out.soft[k] != no_party) gradient -= slope * m_gradient[k];
        if (by_rigid && q < c) gradient -= slope * q_gradient[k];
        set(k, out.f[k] + G, gradient);
        if (out.rigid[k] != no_party && 2 * c - q < out.D.f[k]) {
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

Vec3 velocity_at(const MovingMesh& mesh, const Vec3& p)
{
    if (!(mesh.seconds > 0)) return Vec3::Zero();
    const geometry::TriangleBvh::Hit hit = mesh.now->tree.closest(p);
    if (!hit) return Vec3::Zero();
    Vec3 moved = Vec3::Zero();
    const geometry::Triangle& t = mesh.now->mesh.triangles()[hit.triangle];
    for (std::size_t k = 0; k < 3; ++k) {
        const geometry::Vec3f way = mesh.now->mesh.positions[t[k]] - mesh.before->positions[t[k]];
        moved += hit.barycentric[static_cast<int>(k)] * way.cast<double>();
    }
    return moved / mesh.seconds;
}

Vec3 velocity_at(const ContactBody& body, std::uint32_t skeleton, const Vec3& p)
{
    if (body.moving) return velocity_at(*body.moving, p);
    const std::uint32_t f = body.frame_of[skeleton];
    return body.twists[f].linear + body.twists[f].angular.cross(p - body.frames[f].translation());
}

struct RayBatch {
    std::uint32_t body, skeleton, begin, end;
};

// What a batch finds.
struct Met {
    std::vector<LayerContact> contacts;
    std::vector<LayerStop> stops;  // one for each other body, or part of the own one
    double penetration = 0;
};

// How deep point k, on or in `own`'s deformed surface, stands inside another's: D_j > c where f_j >
// max(f_i, c), rigid j where f_j > c.
double penetration(const Deformed& at, std::size_t k, double c)
{
    double depth = 0;
    if (at.m[k] > std::max(at.f[k], c) && at.m_slope[k] > 0) {
        depth = (at.m[k] - std::max(at.f[k], c)) / at.m_slope[k];
    }
    if (at.q[k] > c && at.q_slope[k] > 0) depth = std::max(depth, (at.q[k] - c) / at.q_slope[k]);
    return depth;
}

// Keeps of two stops of one skeleton against one body the nearer.
void add_stop(const LayerStop& stop, std::vector<LayerStop>& stops)
{
    for (auto known = stops.rbegin(); known != stops.rend(); ++known) {
        if (known->body != stop.body || known->skeleton != stop.skeleton) break;
        if (known->other != stop.other) continue;
        if (stop.gap < known->gap) *known = stop;
        return;
    }
    stops.push_back(stop);
}

// How point p stands to a rigid body; the gap infinite where it has no skeleton near.
LayerStop stop_at_rigid(const Field& field, const Party& other, const Vec3& p)
{
    LayerStop stop;
    for (const std::uint32_t s : other.skeletons) {
        const geometry::Foot foot = geometry::foot(field, s, p);
        const double gap = foot.r - field.profile[s].e;
        if (gap < stop.gap && foot.n.squaredNorm() > 0) {
            stop.other_skeleton = s;
            stop.normal = foot.n;
            stop.gap = gap;
        }
    }
    return stop;
}

// Adds where `origins`, points of one skeleton, stand to what its rays meet on their inner half.
void find_stops(const Meeting& meeting, std::uint32_t skeleton, const std::vector<Vec3>& origins,
                std::vector<LayerStop>& stops)
{
    thread_local FieldScratch scratch;
    thread_local FieldBlock block;
    thread_local BlockValues own, theirs;
    block.count = 0;
    for (const Vec3& origin : origins) {
        if (block.count == 0 || origin != block.point(block.count - 1)) block.add(origin);
    }
    block.pad();
    geometry::evaluate(meeting.field(meeting.own), meeting.own.skeletons, block, scratch, own);
    for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
        const Party& other = meeting.others[o];
        const Field& field = meeting.field(other);
        const bool rigid = meeting.bodies[other.body].matter.rigid;
        geometry::evaluate(field, other.skeletons, block, scratch, theirs);
        for (std::size_t k = 0; k < block.count; ++k) {
            const Vec3 p = block.point(k), gradient = theirs.gradient(k);
            const double slope = gradient.norm(), c = field.isovalue;
            LayerStop stop;
            if (rigid) {
                stop = stop_at_rigid(field, other, p);
                // Several skeletons that blend hold more than each alone.
                if (theirs.f[k] > c && slope > 0 && (c - theirs.f[k]) / slope < stop.gap) {
                    stop.gap = (c - theirs.f[k]) / slope;
                    stop.normal = -gradient / slope;
                }
                if (!(stop.gap < meeting.field(meeting.own).profile[skeleton].e)) continue;
            } else {
                if (!(theirs.f[k] > c && slope > 0)) continue;
                stop.other_skeleton = largest_at(field, other.skeletons, p);
                stop.normal = -gradient / slope;
                stop.gap = (own.f[k] - theirs.f[k]) / slope;
            }
            stop.body = meeting.own.body;
            stop.skeleton = skeleton;
            stop.other = other.body;
            stop.position = p;
            if (const MovingMesh* mesh = meeting.bodies[other.body].moving) {
                stop.closing = velocity_at(*mesh, p).dot(stop.normal);
            }
            add_stop(stop, stops);
        }
    }
}

// Moves the batch's seeds that D < c at their stops inward along their rays to D = c.
void meet(std::span<const ContactBody> bodies, const RayBatch& batch, Met& met)
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
    thread_local std::vector<Vec3> half_pressed;  // skeleton points of rays that end near them
    rays.clear();
    half_pressed.clear();
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
            met.penetration = std::max(met.penetration, penetration(at, k, c));
            if (ray.t < 0.5 * own.field->profile[batch.skeleton].e) {
                half_pressed.push_back(ray.origin);
            }
            const std::uint32_t party = at.fits[k] ? at.rigid[k] : at.soft[k];
            const double slope = gradient.norm();
            const double cosine = slope > 0 ? -phi_slope / slope : 0;
            if (party == no_party || !(cosine > 1e-6)) continue;
            const Party& other = meeting.others[party];
            const Vec3 p = block.point(k);
            const std::uint32_t touched = largest_at(meeting.field(other), other.skeletons, p);
            if (touched == no_skeleton) continue;
            // Pressed past three quarters, a ray's share stays what it was there: a skeleton that
            // is pushed beyond the other's surface must not lose what holds it back.
            const double t = std::max(ray.t, 0.25 * own.field->profile[batch.skeleton].e);
            const double across =
                seeds.a0[ray.seed] + t * (seeds.a1[ray.seed] + t * seeds.a2[ray.seed]);
            met.contacts.push_back({batch.body, ray.seed, batch.skeleton, other.body, touched, p,
                                    -gradient / slope, across / cosine,
                                    std::max(0.0, (at.fits[k] ? at.f[k] : at.m[k]) - c), 0, ray.t,
                                    Vec3::Zero()});
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
    const ContactLaw law = contact_law(bodies, contact);
    const Vec3 slip = slip_at(bodies, contact);
    const Vec3 across = slip.dot(contact.normal) * contact.normal;
    // Both objects' seeds stand for the whole of a soft common surface.
    const double share = bodies[contact.other].matter.rigid ? 1 : 0.5;
    return share * (-law.stiffness * contact.load * contact.normal +
                    contact.area * (law.damping * across + law.along * (slip - across)));
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
    std::vector<RayBatch> batches;
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
    std::vector<Met> found(batches.size());
    geometry::parallel_for(batches.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) meet(bodies, batches[b], found[b]);
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
                  [](const LayerContact& a, const LayerContact& b) { return a.seed < b.seed; });
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
    return result;
}

ContactLaw contact_law(std::span<const ContactBody> bodies, const LayerContact& contact)
{
    const LayerMatter& own = bodies[contact.body].matter;
    const LayerMatter& other = bodies[contact.other].matter;
    const double sum = own.stiffness + other.stiffness;
    ContactLaw law;
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
    return {out.D.f[0], out.D.gradient(0), no_skeleton};
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

std::vector<double> local_volumes(std::span<const ContactBody> bodies, std::uint32_t body,
                                  const Contacts& contacts)
{
    std::vector<double> volumes = bodies[body].walk->local_volume;
    for (const LayerContact& contact : contacts.contacts) {
        if (contact.body != body) continue;
        const Seeds& seeds = *bodies[body].seeds;
        volumes[contact.skeleton] +=
            seeds.swept(contact.seed, contact.distance) -
            seeds.swept(contact.seed, bodies[body].walk->distance[contact.seed]);
    }
    return volumes;
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
