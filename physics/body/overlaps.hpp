#pragma once

// Parts of a body that lie in each other at rest, and sheets that cross.

#include "physics/body/corner_body.hpp"
#include "physics/state/state_models.hpp"

#include <span>
#include <string>
#include <vector>

namespace physics {

// Sentences about the parts that do not collide because they overlap at rest
// (PartShapes::overlapping): one for each two of the body's models, and for each model with itself.
// Parts that are joined may overlap. The same of sheets that cross (sheet_crossings()).
std::vector<std::string> told_of_overlaps(ModelsOfState models, const CornerBody& body,
                                          std::span<const JointPoint> joints = {});

}  // namespace physics
