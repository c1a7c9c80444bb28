#include "geometry/cubes/local_matter.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace geometry {

std::vector<double> cube_means(const Cubes& cubes, const std::function<double(const Vec3&)>& f)
{
    const double off = 0.5 / std::sqrt(3.0);
    std::vector<double> out(cubes.count(), 0.0);
    for (std::size_t c = 0; c < out.size(); ++c) {
        for (unsigned a = 0; a < 8; ++a) {
            const Vec3 at((a & 1) != 0 ? off : -off, (a & 2) != 0 ? off : -off,
                          (a & 4) != 0 ? off : -off);
            const Vec3 lattice = cubes.cell[c].cast<double>() + Vec3::Constant(0.5) + at;
            out[c] += f(cubes.origin + cubes.size * lattice) / 8;
        }
    }
    return out;
}

Cubes with_local_values(Cubes cubes, LocalProperty property, const std::vector<double>& values)
{
    const bool positive = property == LocalProperty::young || property == LocalProperty::density;
    const double whole = cubes.size * cubes.size * cubes.size;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double value = values.at(c);
        const bool possible = std::isfinite(value) && (positive ? value > 0 : value >= 0) &&
                              (property != LocalProperty::poisson || value < 0.5);
        if (!possible) {
            const Vec3 at =
                cubes.origin + cubes.size * (cubes.cell[c].cast<double>() + Vec3::Constant(0.5));
            throw std::invalid_argument(fmt::format(
                "expected {}, found {:.3g} in the cube at ({:.3g}, {:.3g}, {:.3g})",
                positive                             ? "a value above 0"
                : property == LocalProperty::poisson ? "a Poisson's ratio from 0 to below 0.5"
                                                     : "a value of 0 or more",
                value, at.x(), at.y(), at.z()));
        }
        switch (property) {
        case LocalProperty::young:
            cubes.young[c] = value;
            break;
        case LocalProperty::density:
            cubes.mass[c] = value * cubes.fill[c] * whole;
            break;
        case LocalProperty::poisson:
            cubes.poisson[c] = value;
            break;
        case LocalProperty::mass_damping:
            cubes.mass_damping[c] = value;
            break;
        case LocalProperty::stiffness_damping:
            cubes.stiffness_damping[c] = value;
            break;
        }
    }
    return cubes;
}

}  // namespace geometry
