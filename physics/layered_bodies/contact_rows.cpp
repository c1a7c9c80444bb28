#include "physics/layered_bodies/contact_rows.hpp"

#include <algorithm>

namespace physics {
namespace {

// Skeletons of a contact's side, and the frames that carry them.
struct BlendSide {
    const LayeredPart& part;
    const Field& field;
    std::uint32_t skeleton;

    bool blends(std::uint32_t i) const
    {
        return i == skeleton || field.rule == geometry::BlendRule::sum ||
               field.weights(skeleton, i) > 0;
    }
};

// df/df_i of all that blend with the side's skeleton at p, with their gradients.
std::vector<geometry::Contributor> contributors_at(const BlendSide& side, const Vec3& p)
{
    std::vector<geometry::Contributor> out;
    for (std::uint32_t i = 0; i < side.field.count(); ++i) {
        const Box& reach = side.field.influence[i];
        if ((p.array() < reach.lo.array()).any() || (p.array() > reach.hi.array()).any()) continue;
        if (!side.blends(i)) continue;
        const geometry::Foot foot = geometry::foot(side.field, i, p);
        const geometry::ProfileValue value = geometry::profile_at(side.field.profile[i], foot.r);
        if (!(value.f > 0)) continue;
        out.push_back({i, value.f, value.slope * foot.n});
        if (side.field.rule == geometry::BlendRule::gradient) {
            geometry::set_turning(side.field, foot, out.back());
        }
    }
    geometry::blend(side.field.rule, side.field.weights, out);
    return out;
}

// What a force of 1 along `inward` at p is to a frame of the side's body.
using FrameShare = std::pair<std::uint32_t, Vec3>;

// By frames. Together they are `inward`: f changes by -a . v with a = df/df_k grad f_k, and what
// that has across is shared so that it is nothing on the whole.
std::vector<FrameShare> frame_shares(const BlendSide& side, const Vec3& p, const Vec3& inward)
{
    const std::vector<std::uint32_t>& frame = side.part.body->layer.frame;
    const std::uint32_t own = frame[side.skeleton];
    if (side.part.body->base.kind != BaseKind::rigid || side.part.body->base.frames.size() == 1) {
        return {{own, inward}};
    }
    std::vector<FrameShare> out;
    Vec3 gradient = Vec3::Zero();
    for (const geometry::Contributor& c : contributors_at(side, p)) {
        const std::uint32_t f = frame[c.skeleton];
        auto known =
            std::find_if(out.begin(), out.end(), [&](const auto& one) { return one.first == f; });
        if (known == out.end()) known = out.insert(out.end(), {f, Vec3::Zero()});
        known->second += c.share * c.gradient;
        gradient += c.share * c.gradient;
    }
    const double slope = gradient.dot(inward);
    if (out.size() < 2 || !(slope > 0.5 * gradient.norm())) return {{own, inward}};
    const Vec3 across = gradient / slope - inward;
    for (auto& [f, share] : out) {
        share /= slope;
        share -= share.dot(inward) * across;
    }
    return out;
}

}  // namespace

ContactRows contact_rows(const LayeredScene& scene, const LayeredMoment& moment,
                         const LayeredSystem& system, const LayerContact& contact)
{
    ContactRows out;
    const auto add = [&](std::uint32_t body, std::uint32_t skeleton, const Vec3& inward) {
        const BlendSide side{scene.parts[body], moment.fields[body], skeleton};
        const auto shares = frame_shares(side, contact.position, inward);
        for (const auto& [f, share] : shares) {
            const Vec3 arm = contact.position - moment.frames[body][f].translation();
            FrameRow row{body, system.frame(body, f)};
            row.along << share, arm.cross(share);
            out.rows.push_back(row);
        }
        out.blended |=
            shares.size() > 1 || shares[0].first != side.part.body->layer.frame[skeleton];
    };
    add(contact.body, contact.skeleton, -contact.normal);
    add(contact.other, contact.other_skeleton, contact.normal);
    return out;
}

}  // namespace physics
