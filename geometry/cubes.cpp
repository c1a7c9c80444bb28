#include "geometry/cubes.hpp"

namespace geometry {

std::vector<Vec3> corner_positions(const Cubes& cubes)
{
    std::vector<Vec3> out(cubes.corner_count());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = cubes.corner_position(i);
    return out;
}

std::vector<double> corner_masses(const Cubes& cubes)
{
    std::vector<double> out(cubes.corner_count(), 0.0);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        for (const std::uint32_t k : cubes.corners[c]) out[k] += cubes.mass[c] / 8;
    }
    return out;
}

double total_mass(const Cubes& cubes)
{
    double sum = 0;
    for (const double m : cubes.mass) sum += m;
    return sum;
}

std::size_t component_count(const Cubes& cubes)
{
    std::uint32_t most = 0;
    for (const std::uint32_t c : cubes.component) most = std::max(most, c + 1);
    return most;
}

}  // namespace geometry
