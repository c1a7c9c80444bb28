// What a body takes, with all that it refers to.

#include "physics/body/corner_body.hpp"
#include "physics/body/shapes_on_demand.hpp"

namespace physics {

std::size_t CornerBody::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return sizeof *this + of(slot, mass, mass_damping, part, part_edge, rest) + skin.bytes() +
           (shapes ? shapes->bytes() : 0) + (sheets ? sheets->bytes() : 0) +
           (outlines ? outlines->bytes() : 0);
}

}  // namespace physics
