#pragma once

// Bodies, and what several tests of hard cases of the lattice drive and measure them by.

#include "geometry/cubes/plane.hpp"
#include "physics/lattice/lattice.hpp"
#include "tests/physics/cube_fixtures.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace fixtures {

using geometry::Cubes;
using physics::LatticeBody;
using physics::LatticeOptions;
using physics::Loads;
using physics::State;
using physics::Vec3;

inline Cubes whole_sheet(int ni, int nj)
{
    return geometry::plane_cubes(geometry::rectangle_cells(ni, nj), {1, 0.1, {0, 0, 0}}, 0.02,
                                 {"sheet", 500, 1e5, 0.3, 0, 0});
}

inline double extent_in_x(const State& state)
{
    double low = 1e9, high = -1e9;
    for (const Vec3& x : state.x) low = std::min(low, x[0]), high = std::max(high, x[0]);
    return high - low;
}

inline double energy(const LatticeBody& body, const State& state)
{
    double sum = 0;
    for (std::size_t i = 0; i < state.v.size(); ++i) {
        sum += 0.5 * body.base.mass[i] * state.v[i].squaredNorm();
    }
    return sum;
}

inline void expect_sane(const State& state, const char* what)
{
    for (const Vec3& x : state.x) ASSERT_TRUE(x.allFinite()) << what;
    for (const Vec3& v : state.v) ASSERT_TRUE(v.allFinite()) << what;
}

// Both ends held, the far one moved by `motion` of the share of the way.
inline State drive(const LatticeBody& body, const Cubes& cubes, State state, int frames,
                   const LatticeOptions& options,
                   const std::function<Vec3(const Vec3&, double share)>& motion)
{
    int last = 0;
    for (const auto& at : cubes.corner) last = std::max(last, at[0]);
    for (int f = 1; f <= frames; ++f) {
        Loads loads;
        for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
            if (cubes.corner[k][0] != 0 && cubes.corner[k][0] != last) continue;
            const Vec3 rest = cubes.corner_position(k);
            loads.pins.corner.push_back(k);
            loads.pins.target.push_back(cubes.corner[k][0] == 0 ? rest
                                                                : motion(rest, double(f) / frames));
        }
        state = advance(body, std::move(state), loads, 1.0 / 24, options);
    }
    return state;
}

}  // namespace fixtures
