#pragma once

// Sheets for tests of shells.

#include "geometry/cubes/plane.hpp"
#include "physics/shell/shell.hpp"
#include "physics/shell/shell_elasticity.hpp"

#include <algorithm>

namespace fixtures {

using geometry::Cubes;
using geometry::Vec3;
using geometry::Vec3i;

// ni by nj cells of edge a across y, the corner (0, 0) at the origin: u is x, v is z.
inline Cubes sheet(int ni, int nj, double a, double thickness, double nu = 0.3, double young = 1e6,
                   double density = 1000)
{
    return geometry::plane_cubes(geometry::rectangle_cells(ni, nj), {1, a, {0, 0, 0}}, thickness,
                                 {"sheet", density, young, nu, 0, 0});
}

// Corners whose lattice place passes a test.
template <class Test> std::vector<std::uint32_t> corners_where(const Cubes& cubes, const Test& test)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (test(cubes.corner[k])) out.push_back(k);
    }
    return out;
}

// Pins that hold those corners where they rest.
template <class Test> physics::Pins held_where(const Cubes& cubes, const Test& test)
{
    physics::Pins out{corners_where(cubes, test), {}};
    for (const auto k : out.corner) out.target.push_back(cubes.corner_position(k));
    return out;
}

// Within `layers` rows of corners of the border of ni by nj cells.
inline bool near_border(const Vec3i& at, int ni, int nj, int layers)
{
    return std::min({at[0], at[2], ni - at[0], nj - at[2]}) < layers;
}

// Where a shell comes to rest under loads that stay.
inline physics::State settled(const physics::ShellBody& body, const physics::Loads& loads)
{
    const physics::StepOptions still{
        .newton_iterations = 50, .tolerance = 1e-8, .solver_iterations = 20000, .leaps = true};
    return advance(body, rest_state(body), loads, 1e4, still);
}

inline physics::Force weight(const Vec3& acceleration)
{
    physics::Force out;
    out.acceleration = acceleration;
    return out;
}

}  // namespace fixtures
