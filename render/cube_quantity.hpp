#pragma once

// Numbers to colour cubes by.

#include "physics/state/state.hpp"
#include "render/cube_shell.hpp"

namespace render {

// One number for each of the 8 S vertices that solid_cubes() makes, by its name: displacement (m),
// speed (m/s), stress (Pa), plastic_strain, fill, young (Pa), density of a cube's mass (kg/m^3),
// component, matter,
// or an attribute of the cubes' own. `state` may be null: then the cubes are at rest. Throws
// std::invalid_argument for another name, and when cubes or state do not have the numbers.
geometry::Attribute cube_quantity(const std::string& name, const geometry::Cubes& cubes,
                                  const CubeShell& shell, const physics::State* state);

// Whether a quantity counts categories, which are coloured each in its own colour, without a scale.
bool is_category(const std::string& name);

// Gives each vertex of `mesh` the colour of its category, `values` rounded towards zero.
void colour_by_category(TriMesh& mesh, const geometry::Attribute& values);

}  // namespace render
