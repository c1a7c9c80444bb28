#pragma once

// The plan of a farm as a picture: tasks as boxes in time, as they run when there is a machine for
// each, and below them how long fewer machines take.

#include "runtime/farm/farm_task.hpp"

namespace runtime {

// As SVG. Of many alike tasks the first few are drawn, and a stack stands for the others.
std::string plan_svg(const Cut& cut);

}  // namespace runtime
