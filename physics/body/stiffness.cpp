#include "physics/body/stiffness.hpp"

#include <algorithm>

namespace physics {

double stiffness_share(const geometry::Cubes& cubes, std::size_t c, Weighting weighting)
{
    return weighting == Weighting::full ? 1 : std::clamp(cubes.fill[c], 1e-3, 1.0);
}

}  // namespace physics
