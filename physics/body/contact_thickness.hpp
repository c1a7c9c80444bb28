#pragma once

// The thickness by which contact keeps sheets apart.

#include <algorithm>

namespace physics {

// m, of a sheet of this thickness in cells of this edge. What a cell does within a step is not
// known to a thousandth of its edge: contact springs that bear within less do not converge.
inline double contact_thickness(double thickness, double edge)
{
    return std::max(thickness, 1e-3 * edge);
}

}  // namespace physics
