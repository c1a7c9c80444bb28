#include "physics/layered_bodies/layered_bounce.hpp"

#include "physics/layers/velocity_at.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace physics {

namespace {

constexpr double longest_swing = 0.6;  // rad, in a step
constexpr double pressing = 2.4;       // 1/s, layers in a second: slower ones press
constexpr double longest_bounce = 5;   // rad, of the way in: what takes longer is pressed

// A skeleton of a body.
struct Side {
    std::uint32_t body = 0, skeleton = 0;
    auto operator<=>(const Side&) const = default;
};

bool can_bounce(const LayeredScene& scene, std::uint32_t body)
{
    const BaseKind kind = scene.parts[body].body->base.kind;
    return kind == BaseKind::rigid || kind == BaseKind::still;
}

// Of the energy that two layers store, what they give back; a rigid one stores none. `si`, `sj`:
// the slopes of their fields.
double restitution_sq(const LayeredMoment& moment, const LayerContact& contact, double si,
                      double sj)
{
    const LayerMatter& own = moment.bodies[contact.body].matter;
    const LayerMatter& other = moment.bodies[contact.other].matter;
    const double own_sq = own.restitution * own.restitution;
    if (other.rigid) return own_sq;
    const double ki = own.stiffness * si, kj = other.stiffness * sj;
    const double other_sq = other.restitution * other.restitution;
    return ki + kj > 0 ? (own_sq * kj + other_sq * ki) / (ki + kj) : own_sq;
}

// The frame as the impact pushes it.
ImpactFrame& pushed_frame(Impact& impact, const FrameRow& row)
{
    for (ImpactFrame& known : impact.frames) {
        if (known.frame == row.frame) return known;
    }
    return impact.frames.emplace_back(ImpactFrame{row.body, row.frame});
}

// m/s, how fast a contact parts: with its frames, and as what changes its shape does.
double parting_at(const LayeredMoment& moment, const LayeredSystem& system,
                  const LayerContact& contact, const ContactRows& rows)
{
    const auto of = [&](const ContactBody& body, std::uint32_t skeleton) {
        return rows.blended ? change_at(body, skeleton, contact.position)
                            : velocity_at(body, skeleton, contact.position);
    };
    double speed = contact.normal.dot(of(moment.bodies[contact.other], contact.other_skeleton) -
                                      of(moment.bodies[contact.body], contact.skeleton));
    if (!rows.blended) return speed;
    for (const FrameRow& row : rows.rows) speed += row.along.dot(system.velocity[row.frame]);
    return speed;
}

// Adds what a sample in contact tells of its two skeletons' impact.
void add_sample(const LayeredScene& scene, const LayeredMoment& moment, const LayeredSystem& system,
                const LayerContact& contact, const ContactRows& rows, Impact& impact)
{
    const LayerContactLaw law = contact_law(moment.bodies, contact);
    const bool rigid = scene.parts[contact.other].body->matter.rigid;
    const auto [si, sj] = slopes_at(moment, contact);
    const double slope = rigid ? si : si * sj / (si + sj);
    const double share = rigid ? 1 : 0.5;
    const double force = share * law.stiffness * contact.load;
    for (const FrameRow& row : rows.rows) pushed_frame(impact, row).along += force * row.along;
    impact.force += force;
    impact.shape += force * parting_at(moment, system, contact, rows);
    impact.energy += 0.5 * force * contact.compression / slope;
    impact.depth = std::max(impact.depth, contact.compression / slope);
    impact.damping += share * law.damping * contact.area;
    impact.stiffness += share * law.stiffness * slope * contact.area;
    impact.restitution_sq = restitution_sq(moment, contact, si, sj);
}

// All contacts by their two skeletons.
void gather_impacts(const LayeredScene& scene, const LayeredMoment& moment,
                    const LayeredSystem& system, Impacts& impacts)
{
    std::map<std::pair<Side, Side>, std::uint32_t> known;
    const auto& contacts = moment.contacts.contacts;
    impacts.of_contact.assign(contacts.size(), geometry::no_index);
    for (std::size_t c = 0; c < contacts.size(); ++c) {
        const LayerContact& contact = contacts[c];
        impacts.rows.push_back(contact_rows(scene, moment, system, contact));
        if (!can_bounce(scene, contact.body) || !can_bounce(scene, contact.other)) continue;
        Side one{contact.body, contact.skeleton}, two{contact.other, contact.other_skeleton};
        if (two < one) std::swap(one, two);
        const auto [entry, anew] =
            known.try_emplace({one, two}, static_cast<std::uint32_t>(impacts.all.size()));
        if (anew) {
            Impact impact;
            impact.body = one.body;
            impact.bounce.skeleton = one.skeleton;
            impact.bounce.other = two.body;
            impact.bounce.other_skeleton = two.skeleton;
            impact.a =
                system.frame(one.body, scene.parts[one.body].body->layer.frame[one.skeleton]);
            impact.b =
                system.frame(two.body, scene.parts[two.body].body->layer.frame[two.skeleton]);
            impacts.all.push_back(impact);
        }
        add_sample(scene, moment, system, contact, impacts.rows[c], impacts.all[entry->second]);
        impacts.of_contact[c] = entry->second;
    }
}

// What a push of 1 along it gives a frame that is free to move.
Vec6 given(const LayeredSystem& system, std::size_t f, const Vec6& along)
{
    return Eigen::LDLT<Mat6>(system.mass[f]).solve(along);
}

// What was counted of this contact before.
void recall(const std::vector<LayerBounce>& before, Impact& impact)
{
    const LayerBounce& bounce = impact.bounce;
    const auto known = std::find_if(before.begin(), before.end(), [&](const LayerBounce& b) {
        return b.skeleton == bounce.skeleton && b.other == bounce.other &&
               b.other_skeleton == bounce.other_skeleton;
    });
    impact.known = known != before.end() && !(known->spent && impact.speed < 0);
    if (impact.known) impact.bounce = *known;
}

// Whether it bounces: it hit faster than `slow`, and does not press too long.
void judge(double slow, Impact& impact)
{
    LayerBounce& bounce = impact.bounce;
    if (bounce.phase > longest_bounce) bounce.struck = false;
    if (impact.speed > -slow && !bounce.struck) bounce.phase = 0;
    if (bounce.struck && bounce.turned && !bounce.spent && impact.speed < -slow) {
        bounce.turned = false;  // hit again on its way out
        bounce.arrived = 0;
    }
    // New, and on its way out: what is pressed there was pressed by others, which give it back.
    if (!impact.known && impact.speed > slow) bounce.struck = bounce.turned = bounce.spent = true;
    if (bounce.struck || bounce.phase > 0 || !(impact.speed < -slow)) return;
    bounce.struck = true;
    bounce.spent = bounce.turned = false;
    bounce.arrived = 0;
    bounce.stored = impact.known ? impact.energy : 0;
}

bool gives(const Impact& impact)
{
    return impact.bounces() && !impact.bounce.spent;
}

// 1/kg: by how much a push at j changes u at i.
double coupling(const Impact& i, const Impact& j)
{
    double sum = 0;
    for (const ImpactFrame& at : i.frames) {
        for (const ImpactFrame& by : j.frames) {
            if (by.frame == at.frame) sum += at.along.dot(by.gives);
        }
    }
    return sum;
}

// Of the mass that contacts of the same frames move together each takes as much as it is stiff:
//   m_i = k_i / sum_j k_j |g_ij|,  g: coupling(), so that for any impulses  J . g J <= sum
//   J_i^2/m_i
// and what each gives to its own mass adds up to no more than all may give.
void share_masses(Impacts& impacts)
{
    for (Impact& i : impacts.all) {
        if (!gives(i)) continue;
        double sum = 0;
        for (const Impact& j : impacts.all) {
            if (gives(j)) sum += j.stiffness * std::abs(coupling(i, j));
        }
        i.mass = i.stiffness / sum;
    }
}

// Friction takes what is damped by half of the critical damping: 5/6 of the speed at least.
void leave_damped(Impact& impact)
{
    LayerBounce& bounce = impact.bounce;
    if (!(bounce.arrived > 0)) {
        bounce.arrived = 0.5 * impact.mass * impact.speed * impact.speed;
    } else if (impact.damping > std::sqrt(impact.stiffness * impact.mass)) {
        bounce.phase = 2 * longest_bounce;
        bounce.struck = false;
    }
}

// Which bodies others bear: they do not fall freely. Of two that bounce off each other neither.
std::vector<char> borne(const LayeredScene& scene, const LayeredMoment& moment,
                        const Impacts& impacts, double slow)
{
    std::vector<char> out(scene.parts.size(), 0);
    for (std::size_t c = 0; c < moment.contacts.contacts.size(); ++c) {
        const LayerContact& contact = moment.contacts.contacts[c];
        if (contact.body == contact.other) continue;
        const Impact* const impact = impacts.of(c);
        if (impact && (!(impact->mass > 0) || impact->bounces() || impact->speed < -slow)) continue;
        out[contact.body] = out[contact.other] = 1;
    }
    for (const LayerStop& stop : moment.contacts.stops) {
        if (stop.body == stop.other) continue;
        const double thickness = moment.fields[stop.body].profile[stop.skeleton].e;
        if (!moment.bodies[stop.body].matter.rigid && stop.gap > 0.2 * thickness) continue;
        out[stop.body] = out[stop.other] = 1;
    }
    return out;
}

// m: of the layers that give.
double thinnest(const LayeredMoment& moment, const Impact& impact)
{
    double thickness = std::numeric_limits<double>::infinity();
    const auto add = [&](std::uint32_t body, std::uint32_t skeleton) {
        if (moment.bodies[body].matter.rigid) return;
        thickness = std::min(thickness, moment.fields[body].profile[skeleton].e);
    };
    add(impact.body, impact.bounce.skeleton);
    add(impact.bounce.other, impact.bounce.other_skeleton);
    return thickness;
}

}  // namespace

double Impact::parting(const std::vector<Vec6>& v) const
{
    double sum = 0;
    for (const ImpactFrame& at : frames) sum += at.along.dot(v[at.frame]);
    return sum;
}

bool Impact::held(const LayeredSystem& system) const
{
    return std::any_of(frames.begin(), frames.end(),
                       [&](const ImpactFrame& at) { return system.held[at.frame] != 0; });
}

Impacts find_impacts(const LayeredScene& scene, const LayeredMoment& moment,
                     const LayeredSystem& system, const Vec3& gravity, const BounceTimes& times)
{
    Impacts impacts;
    impacts.lag = times.lag;
    gather_impacts(scene, moment, system, impacts);
    const auto free = [&](std::uint32_t body, std::size_t f) {
        return scene.parts[body].body->base.kind == BaseKind::rigid &&
               (system.kind[f] != BaseKind::still || system.held[f]);
    };
    std::vector<double> rate_sq(system.velocity.size(), 0);
    for (Impact& impact : impacts.all) {
        if (!(impact.force > 0) || impact.a == impact.b) continue;
        double yields = 0;
        for (ImpactFrame& at : impact.frames) {
            at.along /= impact.force;
            if (free(at.body, at.frame)) at.gives = given(system, at.frame, at.along);
            yields += at.along.dot(at.gives);
        }
        if (!(yields > 0)) continue;
        impact.mass = 1 / yields;
        impact.speed = impact.shape / impact.force;
        impact.shape = impact.speed - impact.parting(system.velocity);
        for (const ImpactFrame& at : impact.frames) {
            if (free(at.body, at.frame)) rate_sq[at.frame] += impact.stiffness * yields;
        }
        recall(scene.states[impact.body].bounces, impact);
    }
    const double falls = 2 * times.asked * gravity.norm();
    impacts.on_weight = borne(scene, moment, impacts, 0.5 * falls);
    for (Impact& impact : impacts.all) {
        if (!(impact.mass > 0)) continue;
        for (const ImpactFrame& at : impact.frames) {
            impact.rate = std::max(impact.rate, std::sqrt(rate_sq[at.frame]));
            if (!free(at.body, at.frame) || impacts.on_weight[at.body]) continue;
            const double weight = at.along.head<3>().dot(gravity);
            impact.weight += weight;
            impact.speed += 0.5 * times.lag[at.body] * weight;
        }
        judge(std::max(falls, pressing * thinnest(moment, impact)), impact);
    }
    share_masses(impacts);
    for (Impact& impact : impacts.all) {
        if (gives(impact)) leave_damped(impact);
    }
    return impacts;
}

double longest_step(const Impacts& impacts)
{
    double longest = std::numeric_limits<double>::infinity();
    for (const Impact& impact : impacts.all) {
        if (!gives(impact)) continue;
        longest = std::min(longest, longest_swing / impact.rate);
    }
    return longest;
}

bool too_deep(const Impacts& impacts, double last)
{
    return std::any_of(impacts.all.begin(), impacts.all.end(), [&](const Impact& impact) {
        return gives(impact) && impact.rate * last > 2 * longest_swing;
    });
}

namespace {

// What a contact that bounces gives in dt seconds: on the way in the force of elasticity, on the
// way out what is left of it. An impulse J of m (u' - u) gives J (u + u') / 2 to a mass m, and less
// to what is held by others besides: never more than what it may.
void aim(double dt, bool held, Impact& impact)
{
    LayerBounce& bounce = impact.bounce;
    const double u = impact.speed, m = impact.mass, moves = 0.5 * m * u * u;
    double left = bounce.stored + (u < 0 ? moves : 0);
    if (!bounce.turned) {
        // Of what came on, less the work of its weight on the way in.
        const double came =
            std::max(0.0, bounce.stored + moves + std::min(0.0, m * impact.weight) * impact.depth);
        left -= (1 - impact.restitution_sq) * came;
        if (u >= 0) {
            bounce.turned = true;
            bounce.stored = left;
        }
    }
    left = std::max(0.0, left);
    const double leaves = std::sqrt((u > 0 ? u * u : 0) + 2 * left / m);
    const double most = m * (leaves - u) / dt;
    const bool out = u > 0 && u * dt * impact.force > 2 * impact.energy;  // before the next step
    if (out || impact.rate * dt > 2 * longest_swing) {
        bounce.spent = true;
        impact.push = most;
        return;
    }
    const double share = u < 0 ? 1 : std::min(2.0, left / impact.energy);
    impact.push = std::min(share * impact.force, most);
    // What little is left would hold it there: it creeps out.
    if (u > 0 && !held && left + moves < 0.03 * std::min(impact.energy, bounce.arrived)) {
        bounce.phase = 2 * longest_bounce;
    }
}

}  // namespace

void aim(Impacts& impacts, LayeredSystem& system)
{
    for (Impact& impact : impacts.all) {
        if (!gives(impact)) continue;
        aim(system.dt, impact.held(system), impact);
        for (const ImpactFrame& at : impact.frames) {
            system.right[at.frame] += system.dt * impact.push * at.along;
        }
    }
}

void keep(const Impacts& impacts, const LayeredSystem& system, const std::vector<Vec6>& dv,
          LayeredScene& scene)
{
    for (LayeredState& state : scene.states) state.bounces.clear();
    for (const Impact& impact : impacts.all) {
        if (!(impact.mass > 0)) continue;
        LayerBounce bounce = impact.bounce;
        if (bounce.struck) {
            const double after = impact.parting(system.velocity) + impact.parting(dv) -
                                 0.5 * system.dt * impact.weight + impact.shape;
            bounce.stored -= 0.5 * system.dt * impact.push * (impact.speed + after);
            // Under Bullet what has come to rest while it is pressed in stays so.
            const double slow =
                impact.held(system) ? 0.05 * std::sqrt(2 * bounce.arrived / impact.mass) : 0;
            if (impact.speed < -slow) bounce.phase += system.dt * impact.rate;
        }
        scene.states[impact.body].bounces.push_back(bounce);
    }
}

}  // namespace physics
