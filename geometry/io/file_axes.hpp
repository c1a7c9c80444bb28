#pragma once

// The unit and the axes of a file.

#include "geometry/io/read_options.hpp"

namespace geometry {

// m, of one unit of length: as it is asked for, or `said` by the file, or else 1. Throws
// std::invalid_argument for a custom one that is no positive number.
double metres_of(LengthUnit unit, double custom, double said);

// From the file's axes and unit to y up and metres, as `options` say. Throws as metres_of() does.
Mat3 to_metres(const ImportedScene& scene, const ReadOptions& options);

}  // namespace geometry
