#pragma once

// Material that varies from cube to cube, by a function of place.

#include "geometry/cubes/cubes.hpp"

#include <functional>

namespace geometry {

enum class LocalProperty { young, density, poisson, mass_damping, stiffness_damping };

// The mean over each cube of a function of place (m), by 2 x 2 x 2 Gauss points: exact for cubic
// polynomials. C. The function is called on one thread.
std::vector<double> cube_means(const Cubes& cubes, const std::function<double(const Vec3&)>& f);

// The cubes with a property of these values, one for each. The density is that of the material: the
// mass becomes density * fill * size^3. Throws std::invalid_argument naming the first cube whose
// value cannot be (not finite; density or stiffness not above 0; a Poisson ratio outside 0 <= nu <
// 0.5; a negative damping).
Cubes with_local_values(Cubes cubes, LocalProperty property, const std::vector<double>& values);

}  // namespace geometry
