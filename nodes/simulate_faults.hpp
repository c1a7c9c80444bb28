#pragma once

// What Simulate says of links and parameters that do not go together.

#include <fmt/format.h>

#include <cstddef>
#include <string>

namespace nodes::simulate {

constexpr const char* no_cubes =
    "expected a link to cubes, found none: link the cubes from Voxelize, Plane or Sheet";
constexpr const char* lattice_of_several =
    "method lattice moves one model of cubes: link one, or set method = bricks "
    "(shell for planes and sheets)";

inline std::string wrong_surfaces(std::size_t found, std::size_t models)
{
    return fmt::format("`surface` has {} links, expected {}, one for each of `cubes` in the same "
                       "order: link the mesh of each, or none",
                       found, models);
}

inline std::string wrong_bodies(std::size_t found, std::size_t models)
{
    return fmt::format("`bodies` has {} entries for {} links of `cubes`: remove those beyond, as "
                       "entry i is about link i",
                       found, models);
}

constexpr const char* no_balls =
    "rigid balls need method = lattice: change the method, or unlink the input 'balls'";

constexpr const char* no_joints =
    "joints need method = bricks or springs: change the method, or unlink the input 'joints'";

constexpr const char* no_rigid =
    "rigid bodies need method = bricks: change the method, or set `rigid` of the bodies to false";
constexpr const char* rigid_step =
    "rigid bodies need step.integrator = implicit_euler: change it, or set `rigid` of the bodies "
    "to false";
constexpr const char* no_rigid_equilibrium =
    "rigid bodies have no equilibrium shape: set initial_shape = given, or set `rigid` of the "
    "bodies to false";

constexpr const char* no_equilibrium = "an equilibrium needs method = bricks and solids alone: "
                                       "change the method, unlink sheets, or set "
                                       "initial_shape = given";
constexpr const char* no_support =
    "an equilibrium needs pins or colliders, because a free body falls for ever: link a Pin node "
    "to the input 'pins' or a Ground to 'colliders', or set initial_shape = given";

}  // namespace nodes::simulate
