#include "physics/layers/deformed_layer.hpp"

#include "geometry/fields/evaluate_block.hpp"

#include <algorithm>

namespace physics {

using geometry::BlockValues;
using geometry::FieldBlock;
using geometry::FieldScratch;
using geometry::FieldValue;
using geometry::Interval;
using geometry::no_skeleton;

// G(s) and dG/ds.
static std::pair<double, double> relief(double s, double a, double h)
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

void evaluate(const Meeting& meeting, double a, double h, const FieldBlock& block,
              DeformedValues& out)
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

void ask(const DeformedLayer& layer, const FieldBlock& block, DeformedValues& out)
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
    thread_local DeformedValues out;
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
        thread_local DeformedValues out;
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

}  // namespace physics
