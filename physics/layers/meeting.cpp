#include "physics/layers/meeting.hpp"

#include <algorithm>

namespace physics {

using geometry::no_skeleton;

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

}  // namespace physics
