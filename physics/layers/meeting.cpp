#include "physics/layers/meeting.hpp"

#include <algorithm>

namespace physics {

using geometry::no_skeleton;

static Box grown(const Box& box, double by)
{
    Box result = box;
    result.lo.array() -= by;
    result.hi.array() += by;
    return result;
}

static Party& next_party(Meeting& meeting)
{
    if (meeting.other_count == meeting.others.size()) meeting.others.emplace_back();
    return meeting.others[meeting.other_count];
}

void gather(std::span<const ContactBody> bodies, std::uint32_t body, std::uint32_t skeleton,
            const Box& box, Meeting& meeting, double reach)
{
    meeting.bodies = bodies;
    meeting.other_count = 0;
    const ContactBody& own = bodies[body];
    meeting.own.body = body;
    geometry::candidates(*own.field, box, meeting.own.skeletons);
    for (std::uint32_t j = 0; j < bodies.size(); ++j) {
        if (j == body) continue;
        Party& other = next_party(meeting);
        other.body = j;
        const Field& field = *bodies[j].field;
        geometry::candidates(field, grown(box, reach * field.most_stretch), other.skeletons);
        if (!other.skeletons.empty()) ++meeting.other_count;
    }
    if (skeleton == no_skeleton || own.field->rule == geometry::BlendRule::sum) return;
    add_own_parts(meeting, skeleton, box, reach);
    std::erase_if(meeting.own.skeletons,
                  [&](std::uint32_t k) { return !(own.field->weights(skeleton, k) > 0); });
}

void add_own_parts(Meeting& meeting, std::uint32_t skeleton, const Box& box, double reach)
{
    const ContactBody& own = meeting.bodies[meeting.own.body];
    if (!own.matter.self_contact || own.field->rule == geometry::BlendRule::sum) return;
    Party& other = next_party(meeting);
    other.body = meeting.own.body;
    geometry::candidates(*own.field, grown(box, reach * own.field->most_stretch), other.skeletons);
    std::erase_if(other.skeletons,
                  [&](std::uint32_t k) { return own.field->weights(skeleton, k) > 0; });
    if (!other.skeletons.empty()) ++meeting.other_count;
}

std::uint32_t largest_at(const Field& field, std::span<const std::uint32_t> skeletons,
                         const Vec3& p)
{
    std::uint32_t largest = no_skeleton;
    double most = 0;
    for (const std::uint32_t s : skeletons) {
        const double f = profile_at(field.profile[s], geometry::distance(field, s, p)).f;
        if (f > most) {
            most = f;
            largest = s;
        }
    }
    return largest;
}

}  // namespace physics
