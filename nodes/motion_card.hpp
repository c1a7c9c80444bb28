#pragma once

// What `aspic card` says of a simulation: how well its equations were solved, how deep the body is
// in what it touches, and the energy that it has.

#include "graph/types/node_type.hpp"
#include "nodes/wire_types.hpp"
#include "physics/body/plane_touch.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/measure.hpp"
#include "physics/state/state_models.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <string_view>

namespace nodes {

// Of one state; not a number where that is not known:
//   the share of the forces at work that its frame left unbalanced
//   m, the deepest point in what it touches at the end of the frame
//   J, of motion and deformation
//   J, in the gravity of the node
using MotionFigures = std::array<double, 4>;

// The value of a node's parameter "a" or "block.a".
inline const graph::ParamValue& param_of(const std::vector<graph::Param>& all,
                                         const graph::ParamValues& values, std::string_view path)
{
    const auto name = path.substr(0, path.find('.'));
    const auto at =
        std::find_if(all.begin(), all.end(), [&](const auto& p) { return p.name == name; });
    const graph::ParamValue& value = values.at(std::size_t(at - all.begin()));
    if (name.size() == path.size()) return value;
    return param_of(at->children, std::get<graph::ParamValues>(value.is),
                    path.substr(name.size() + 1));
}

// Of a state of a Simulate node with these parameters, on the cubes that it moves: of several
// models, the energies are those of the one that has these cubes. The energy is that of bricks; of
// the other methods it is not known.
inline MotionFigures motion_figures(const graph::NodeType& type, const graph::ParamValues& params,
                                    const graph::Value& cubes_value,
                                    const graph::Value& state_value)
{
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const geometry::Cubes& cubes = *cubes_value.as<geometry::Cubes>();
    const auto whole = state_value.as<physics::State>(), own = physics::state_of(whole, cubes);
    const physics::State& state = *own;
    const auto text = [&](const char* path) {
        return std::get<std::string>(param_of(type.params, params, path).is);
    };
    const std::string method = text("method");
    if (method == "lattice") return {unknown, unknown, unknown, unknown};
    const double depth =
        std::max(physics::deepest_of(whole->holds), physics::deepest_of(whole->grips));
    if (method != "bricks") return {state.report.residual, depth, unknown, unknown};
    physics::BrickOptions options;
    if (text("bricks.element") == "trilinear") options.element = physics::BrickElement::trilinear;
    if (text("bricks.element") == "one_point") options.element = physics::BrickElement::one_point;
    if (text("bricks.weighting") == "full") options.weighting = physics::Weighting::full;
    const auto body = physics::make_bricks(cubes, options);
    const double stored =
        physics::strain(body, state).energy + physics::kinetic_energy(state, cubes);
    const auto pull = std::get<std::array<double, 3>>(param_of(type.params, params, "gravity").is);
    const auto mass = geometry::corner_masses(cubes);
    double lifted = 0;
    for (std::size_t k = 0; k < mass.size(); ++k) {
        lifted -= mass[k] * geometry::Vec3(pull[0], pull[1], pull[2]).dot(state.x[k]);
    }
    return {state.report.residual, depth, stored, lifted};
}

}  // namespace nodes
