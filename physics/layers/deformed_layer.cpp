#include "physics/layers/deformed_layer.hpp"

#include "geometry/fields/evaluate_block.hpp"

#include <algorithm>
#include <limits>

namespace physics {

using geometry::BlockValues;
using geometry::FieldBlock;
using geometry::FieldScratch;
using geometry::FieldValue;
using geometry::Interval;
using geometry::no_skeleton;

namespace {

// The fields of other parties at a block's points, as evaluate() goes on with them.
struct PartyValues {
    std::vector<BlockValues> each;  // one a party
};

// What bulges add at point k of a block, which no other party holds.
std::pair<double, Vec3> bulge_sum(const Meeting& meeting, const Bulges& bulges,
                                  const PartyValues& parties, const Vec3& p, std::size_t k)
{
    BulgeSum sum(bulges.width);
    for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
        const Party& other = meeting.others[o];
        if (!(bulges.against(other.body) > 0)) continue;
        const BlockValues& values = parties.each[o];
        sum.add(bulge_at(meeting, other, bulges, p, values.f[k], values.gradient(k)));
    }
    return sum.total();
}

void set(DeformedValues& out, std::size_t k, double f, const Vec3& g)
{
    out.D.f[k] = f;
    out.D.gx[k] = g.x();
    out.D.gy[k] = g.y();
    out.D.gz[k] = g.z();
}

}  // namespace

void evaluate(const Meeting& meeting, const Bulges& bulges, const FieldBlock& block,
              DeformedValues& out)
{
    thread_local FieldScratch scratch;
    thread_local PartyValues parties;
    thread_local Vec3 m_gradient[FieldBlock::capacity], q_gradient[FieldBlock::capacity];
    const double c = meeting.field(meeting.own).isovalue;
    geometry::evaluate(meeting.field(meeting.own), meeting.own.skeletons, block, scratch, out.D);
    for (std::size_t k = 0; k < block.count; ++k) {
        out.f[k] = out.D.f[k];
        out.m[k] = out.q[k] = out.m_slope[k] = out.q_slope[k] = 0;
        out.soft[k] = out.rigid[k] = no_party;
        out.fits[k] = false;
    }
    if (parties.each.size() < meeting.other_count) parties.each.resize(meeting.other_count);
    for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
        const Party& other = meeting.others[o];
        const bool rigid = meeting.bodies[other.body].matter.rigid;
        BlockValues& values = parties.each[o];
        geometry::evaluate(meeting.field(other), other.skeletons, block, scratch, values);
        for (std::size_t k = 0; k < block.count; ++k) {
            double& most = rigid ? out.q[k] : out.m[k];
            if (!(values.f[k] > most)) continue;
            most = values.f[k];
            (rigid ? q_gradient : m_gradient)[k] = values.gradient(k);
            (rigid ? out.rigid : out.soft)[k] = o;
        }
    }
    const double most = bulges.highest();
    for (std::size_t k = 0; k < block.count; ++k) {
        const double q = out.q[k], m = out.m[k], f = out.f[k];
        if (out.soft[k] != no_party) out.m_slope[k] = m_gradient[k].norm();
        if (out.rigid[k] != no_party) out.q_slope[k] = q_gradient[k].norm();
        if (m >= c) {
            set(out, k, f + c - m, out.D.gradient(k) - m_gradient[k]);
        } else if (q < c && most > 0 && f > c - 1.5 * most) {  // below, no bulge makes it c
            const auto [A, gradient] = bulge_sum(meeting, bulges, parties, block.point(k), k);
            set(out, k, f + A, out.D.gradient(k) + gradient);
        }
        if (out.rigid[k] != no_party && 2 * c - q < out.D.f[k]) {
            out.fits[k] = true;
            set(out, k, 2 * c - q, -q_gradient[k]);
        }
    }
}

Bulges bulges_of(std::span<const ContactBody> bodies, std::uint32_t body,
                 std::span<const LayerContact> contacts)
{
    const LayerMatter& matter = bodies[body].matter;
    Bulges bulges{std::vector<double>(bodies.size(), 0), matter.bulge_width, 0};
    if (matter.rigid || !(matter.bulge_width > 0)) return bulges;
    for (const geometry::FieldProfile& p : bodies[body].field->profile) {
        bulges.slope = std::max(bulges.slope, p.k);
    }
    for (const LayerContact& contact : contacts) {
        if (contact.body != body && contact.other != body) continue;
        double& height = bulges.height[contact.body == body ? contact.other : contact.body];
        height = std::max(height, matter.bulge_height * contact.compression);
    }
    return bulges;
}

DeformedLayer deformed(std::span<const ContactBody> bodies, std::uint32_t body,
                       const Contacts& contacts)
{
    return {bodies, body, bulges_of(bodies, body, contacts.contacts)};
}

namespace {

// As if no parts of the body itself collided.
void ask_whole(const DeformedLayer& layer, const FieldBlock& block, Meeting& meeting,
               DeformedValues& out)
{
    if (layer.bodies[layer.body].matter.rigid) meeting.other_count = 0;
    evaluate(meeting, layer.bulges, block, out);
}

// Whether parts of the body itself press each other.
bool parts_bulge(const DeformedLayer& layer)
{
    return layer.bodies[layer.body].matter.self_contact && layer.bulges.width > 0 &&
           layer.bulges.against(layer.body) > 0;
}

// Each point by the skeleton in whose territory it is; the points of one together.
void ask_parts(const DeformedLayer& layer, const FieldBlock& block, const Box& box,
               Meeting& meeting, BlockValues& D)
{
    thread_local std::vector<std::pair<std::uint32_t, std::size_t>> order;
    thread_local FieldBlock some;
    thread_local DeformedValues out;
    const Field& field = meeting.field(meeting.own);
    const std::size_t others = meeting.other_count;
    order.clear();
    for (std::size_t k = 0; k < block.count; ++k) {
        order.emplace_back(largest_at(field, meeting.own.skeletons, block.point(k)), k);
    }
    std::sort(order.begin(), order.end());
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
        const std::uint32_t skeleton = order[begin].first;
        some.count = 0;
        for (; end < order.size() && order[end].first == skeleton; ++end) {
            some.add(block.point(order[end].second));
        }
        some.pad();
        meeting.other_count = others;
        if (skeleton != no_skeleton) add_own_parts(meeting, skeleton, box, layer.bulges.width);
        evaluate(meeting, layer.bulges, some, out);
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t k = order[i].second;
            D.f[k] = out.D.f[i - begin];
            D.gx[k] = out.D.gx[i - begin];
            D.gy[k] = out.D.gy[i - begin];
            D.gz[k] = out.D.gz[i - begin];
        }
    }
    for (std::size_t k = block.count; k < (block.count + 7) / 8 * 8; ++k) {
        D.f[k] = D.gx[k] = D.gy[k] = D.gz[k] = 0;
    }
}

void ask(const DeformedLayer& layer, const FieldBlock& block, BlockValues& D)
{
    thread_local Meeting meeting;
    thread_local DeformedValues out;
    Box box;
    for (std::size_t k = 0; k < block.count; ++k) box.add(block.point(k));
    const double reach = layer.bulges.highest() > 0 ? layer.bulges.width : 0;
    gather(layer.bodies, layer.body, no_skeleton, box, meeting, reach);
    if (parts_bulge(layer)) return ask_parts(layer, block, box, meeting, D);
    ask_whole(layer, block, meeting, out);
    D = out.D;
}

}  // namespace

FieldValue value_at(const DeformedLayer& layer, const Vec3& p)
{
    if (!p.allFinite()) return {};
    thread_local FieldBlock block;
    thread_local BlockValues D;
    block.count = 0;
    block.add(p);
    block.pad();
    ask(layer, block, D);
    return {D.f[0], D.gradient(0), no_skeleton};
}

namespace {

// Whether the parts of a body may bulge before each other in a box: then the deformed field may
// jump between the territories of unlike ones. Where one skeleton's is the largest contribution,
// those that it does not blend with must come as near as bulges are wide.
bool parts_may_bulge(const DeformedLayer& layer, const Meeting& meeting, const Box& box)
{
    const Field& field = meeting.field(meeting.own);
    const Vec3 centre = box.centre();
    const double radius = 0.5 * box.diagonal();
    thread_local std::vector<Interval> range;  // of each skeleton's contribution in the box
    thread_local std::vector<std::uint32_t> near;
    Box around = box;
    around.lo.array() -= layer.bulges.width * field.most_stretch;
    around.hi.array() += layer.bulges.width * field.most_stretch;
    geometry::candidates(field, around, near);
    range.clear();
    for (const std::uint32_t s : near) {
        const double r = geometry::distance(field, s, centre);
        const double nearest =
            geometry::is_solid(field.kind[s]) ? r - radius : std::max(0.0, r - radius);
        range.push_back({geometry::profile_at(field.profile[s], r + radius).f,
                         geometry::profile_at(field.profile[s], nearest).f});
    }
    constexpr double infinity = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < near.size(); ++i) {
        if (!(range[i].hi > 0)) continue;
        bool border = false;  // of the territory of i may lie in the box
        double others = 0, enough = infinity;
        for (std::size_t j = 0; j < near.size(); ++j) {
            if (field.weights(near[i], near[j]) > 0) continue;
            const geometry::FieldProfile& p = field.profile[near[j]];
            border |= range[i].lo <= range[j].hi && range[j].lo <= range[i].hi;
            others += range[j].hi;
            enough = std::min(enough, geometry::profile_at(p, p.e + layer.bulges.width).f);
        }
        if (border && enough < infinity && others >= enough) return true;
    }
    return false;
}

}  // namespace

geometry::IsoField iso_field(const DeformedLayer& layer)
{
    geometry::IsoField iso;
    const double c = layer.bodies[layer.body].field->isovalue;
    iso.domain = geometry::influence(*layer.bodies[layer.body].field);
    const double highest = layer.bulges.highest();
    iso.bounds = [layer, highest, c](const Box& box) {
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
                        own.hi + highest - c};
    };
    iso.steepness = [layer, highest](const Box& box) {
        thread_local Meeting meeting;
        const bool bulges = highest > 0;
        gather(layer.bodies, layer.body, no_skeleton, box, meeting,
               bulges ? layer.bulges.width : 0);
        const double own =
            geometry::slope_bound(meeting.field(meeting.own), meeting.own.skeletons, box);
        if (layer.bodies[layer.body].matter.rigid) return geometry::Steepness{own};
        double soft = 0, hard = 0;
        for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
            const Party& other = meeting.others[o];
            double& most = layer.bodies[other.body].matter.rigid ? hard : soft;
            most =
                std::max(most, geometry::slope_bound(meeting.field(other), other.skeletons, box));
        }
        // A bulge rises upright beside a rigid body, and jumps between the territories of unlike
        // parts. It comes on top of what has a slope.
        const bool steep =
            meeting.other_count > 0 || (parts_bulge(layer) && parts_may_bulge(layer, meeting, box));
        const double parts = steep && parts_bulge(layer) ? own : 0;
        return geometry::Steepness{std::max(own + std::max(soft, parts), hard),
                                   bulges && steep ? highest : 0};
    };
    iso.ask = [layer, c](const FieldBlock& block, BlockValues& values) {
        ask(layer, block, values);
        for (std::size_t k = 0; k < (block.count + 7) / 8 * 8; ++k) values.f[k] -= c;
    };
    return iso;
}

}  // namespace physics
