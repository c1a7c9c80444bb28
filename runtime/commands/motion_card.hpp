#pragma once

// The part of the accuracy card that tells how well simulations were solved: what their equations
// left over, the balance of energy, and the depth of contact.

#include "runtime/commands/command_options.hpp"
#include "runtime/cook/evaluator.hpp"

#include <string>
#include <utility>
#include <vector>

namespace runtime {

// Of the frames that were cooked; not a number where not known.
struct MotionCard {
    std::string name;
    std::size_t frames = 0;
    std::vector<std::pair<std::string, double>> lines;
};

// Cooks all nodes of type Simulate over the frames of the request. Nothing where a cook failed or
// was cancelled.
std::vector<MotionCard> motion_cards(Evaluator& evaluator, const CookRequest& request,
                                     const Console& console, Cooked& cooked);

}  // namespace runtime
