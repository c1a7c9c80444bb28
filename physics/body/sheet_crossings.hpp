#pragma once

// Sheets that go through each other, or through themselves, at rest.

#include "physics/body/corner_body.hpp"

#include <cstddef>
#include <utility>
#include <vector>

namespace physics {

struct SheetCrossing {
    std::pair<std::size_t, std::size_t> models;  // the lower number first; equal: with itself
    Vec3 place = Vec3::Zero();                   // m, where one side goes through a triangle
};

// One for each two models whose sheets touch each other (CornerBody::sheets) and cross at rest. A
// side that ends on a triangle counts as crossing it from one of its sides.
std::vector<SheetCrossing> sheet_crossings(const CornerBody& body);

}  // namespace physics
