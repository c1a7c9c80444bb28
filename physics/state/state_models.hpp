#pragma once

// States of several models that are simulated together: which part of such a state is whose. A
// model is told from others by a mark of its cubes.

#include "geometry/cubes/cubes.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <memory>
#include <span>
#include <vector>

namespace physics {

// Equal for equal cubes, and in all likelihood different for others.
std::uint64_t mark_of(const geometry::Cubes& cubes);

using ModelsOfState = std::span<const std::shared_ptr<const geometry::Cubes>>;

// Their corners and cubes, one model after another. None for a single model. Throws
// std::invalid_argument when two are the same.
std::vector<StateModel> number_models(ModelsOfState models);

// Where these cubes are in a state of several models. Throws std::invalid_argument when none has
// them.
const StateModel& model_of(const State& state, const geometry::Cubes& cubes);

// The part of a state that is of these cubes; the state itself where it is of one model. Throws
// std::invalid_argument when none of its models has these cubes.
std::shared_ptr<const State> state_of(const std::shared_ptr<const State>& state,
                                      const geometry::Cubes& cubes);

// Pins of one of the models as pins of all. The pins themselves where there is one model, or none.
// Throws std::invalid_argument when they are of other cubes.
std::shared_ptr<const Pins> pins_of_all(const std::shared_ptr<const Pins>& pins,
                                        const std::vector<StateModel>& models);

}  // namespace physics
