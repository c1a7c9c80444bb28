#include "physics/state/cube_mass.hpp"

#include "geometry/base/stop.hpp"

#include <bit>

namespace physics {

CubeMass cube_mass_matrix()
{
    CubeMass out{};
    for (unsigned a = 0; a < 8; ++a) {
        for (unsigned b = 0; b < 8; ++b) {
            for (unsigned m = 0; m < 8; ++m) {
                // s_a^m s_b^m is -1 for each axis of m along which the corners differ.
                const double sign = std::popcount(m & (a ^ b)) % 2 == 0 ? 1 : -1;
                out[a][b] += sign * mass_shares[std::size_t(std::popcount(m))] / 64;
            }
        }
    }
    return out;
}

CubeMass mass_of_cube(const geometry::Cubes& cubes, std::size_t c, const CubeMass& usual)
{
    if (!cubes.is_own(c)) return usual;
    CubeMass out{};
    std::size_t at = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
            out[a][b] = out[b][a] = double(cubes.elements[cubes.own[c]].mass[at++]);
        }
    }
    return out;
}

std::vector<Vec3> brick_momenta(const geometry::Cubes& cubes, const std::vector<Vec3>& v)
{
    const CubeMass usual = cube_mass_matrix();
    std::vector<Vec3> out(v.size(), Vec3::Zero());
    geometry::StopCheck stop;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        stop();
        const auto& corners = cubes.corners[c];
        const CubeMass of_one = mass_of_cube(cubes, c, usual);
        for (std::size_t a = 0; a < 8; ++a) {
            for (std::size_t b = 0; b < 8; ++b) {
                out[corners[a]] += cubes.mass[c] * of_one[a][b] * v[corners[b]];
            }
        }
    }
    return out;
}

}  // namespace physics
