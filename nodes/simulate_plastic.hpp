#pragma once

// Rest shapes that have flowed, from one frame or one node to the next.

#include "graph/types/context.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/mixed/mixed.hpp"
#include "physics/shell/shell.hpp"

#include <variant>

namespace nodes::simulate {

// What has rest shapes that a body lets flow, or keeps as they are.
inline physics::PlasticOf plastic_of(const physics::BricksBody&)
{
    return physics::PlasticOf::bricks;
}
inline physics::PlasticOf plastic_of(const physics::SpringsBody&)
{
    return physics::PlasticOf::nothing;
}
inline physics::PlasticOf plastic_of(const physics::LatticeBody& body)
{
    return body.options.plastic.yield > 0 ? physics::PlasticOf::regions
                                          : physics::PlasticOf::nothing;
}
inline physics::PlasticOf plastic_of(const physics::MixedBody&)
{
    return physics::PlasticOf::bricks;
}
inline physics::PlasticOf plastic_of(const physics::ShellBody& body)
{
    return body.triangles ? physics::PlasticOf::triangles : physics::PlasticOf::nothing;
}

// Leaves out of a state the rest shapes of another method, and tells of it.
template <class... Bodies>
void keep_own_plastic(const std::variant<Bodies...>& body, const graph::Context& context,
                      physics::State& state)
{
    using physics::PlasticOf;
    const PlasticOf own = std::visit([](const auto& of) { return plastic_of(of); }, body);
    if (state.plastic_of == PlasticOf::nothing || state.plastic_of == own) return;
    const bool same_method = (state.plastic_of == PlasticOf::regions &&
                              std::holds_alternative<physics::LatticeBody>(body)) ||
                             (state.plastic_of == PlasticOf::triangles &&
                              std::holds_alternative<physics::ShellBody>(body));
    context.warn(same_method ? "what the rest shape has changed by for good is lost: a lattice and "
                               "a plane keep that while plastic.yield is above 0. Set it to 10 "
                               "where nothing more is to yield"
                             : "what the rest shape has changed by for good is lost: each method "
                               "keeps that of its own alone. Set `method` as it was in `start`");
    state.plastic.clear();
    state.plastic_strain.clear();
    state.plastic_of = PlasticOf::nothing;
}

}  // namespace nodes::simulate
