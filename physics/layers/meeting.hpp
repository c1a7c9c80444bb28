#pragma once

// A meeting: the skeletons of one body near a place, and those of all others that it may touch
// there. Whoever asks for a deformed field gathers one for a box first.

#include "geometry/base/no_index.hpp"
#include "physics/layers/contact_types.hpp"

namespace physics {

inline constexpr std::uint32_t no_party = geometry::no_index;

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

// Who is near `box`. `skeleton`: no_skeleton for the body as a whole. `reach`: m, how much farther
// away others are also gathered. Reuses the meeting's memory.
void gather(std::span<const ContactBody> bodies, std::uint32_t body, std::uint32_t skeleton,
            const Box& box, Meeting& meeting, double reach = 0);

// Adds to a meeting of the whole body those skeletons of it that `skeleton` does not blend with, as
// another party, where its parts collide.
void add_own_parts(Meeting& meeting, std::uint32_t skeleton, const Box& box, double reach);

// Which of these skeletons contributes most at p: whose territory it is; no_skeleton where none
// reaches it.
std::uint32_t largest_at(const Field& field, std::span<const std::uint32_t> skeletons,
                         const Vec3& p);

}  // namespace physics
